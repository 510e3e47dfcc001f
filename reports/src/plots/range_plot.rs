//! Rates over the range from the sensor.

use super::figure::{Axis, Labels};
use super::series::{Points, Series};
use super::small_panel::small_panel;
use super::themed_panel::ThemedPanel;

/// A panel with a rate of every detector, in percent, over the bins of range; `names` are those of the bins, in metres.
pub(crate) fn range_plot(rate: &str, names: &[String], series: &[Series]) -> ThemedPanel {
    let ends = [-0.5, names.len().max(1) as f64 - 0.5];
    let words = names.iter().map(|it| it.replace('-', "–")).collect();
    let x = Axis::linear("range from the sensor (m)", ends, names.len()).labelled(Labels::Words(words));
    let about = format!("{rate} in percent over range from the sensor");
    small_panel([rate, &about], x, "%", series, Points::Marked { apart: 0.09 })
}
