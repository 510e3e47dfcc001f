//! Plots as SVG, for a page or a paper: units on every axis, legible in print and with every kind of colour vision.

mod style;
mod heading;
mod line_panel;
mod ratio_panel;
mod bar_panel;
pub mod curve_plot;
