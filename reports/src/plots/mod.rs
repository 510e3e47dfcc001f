//! Plots as SVG, for a page or a paper: units on every axis, legible in print and with every kind of colour vision.

pub mod palette;
mod style;
mod heading;
mod line_panel;
mod ratio_panel;
mod bar_panel;
mod series_marks;
pub mod themed_svg;
pub mod curve_plot;
pub mod gap_plot;
pub mod box_plot;
pub mod operating_plot;
pub mod plan_plot;
mod curve_panel;
pub(crate) mod small_panel;
pub mod standing_plot;
pub mod range_plot;
pub mod recall_plot;
pub mod stage_plot;
pub mod latency_plot;
pub mod scene_plot;
mod sweep_panels;
pub mod rate_plot;
pub mod fitness_plot;
pub mod pareto_plot;
pub mod partial_plot;
