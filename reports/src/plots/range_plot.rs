//! Rates over the range from the sensor.

use super::figure::{Axis, Labels};
use super::series::{Place, Points, Series};
use super::small_panel::small_panel;
use super::themed_panel::ThemedPanel;

/// A rate with its interval, in percent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateInRange {
    /// The rate.
    pub percent: f64,
    /// Lower and upper end of its 95 % interval.
    pub interval_percent: Option<[f64; 2]>,
}

/// A rate of one detector over range.
#[derive(Debug, Clone, PartialEq)]
pub struct RatesOverRange {
    /// Name of the detector.
    pub detector: String,
    /// One for every bin; `None` where the rate is undefined.
    pub rates: Vec<Option<RateInRange>>,
}

/// A panel with a rate of every detector in every bin of range; `names` are those of the bins, in metres.
pub fn range_plot(rate: &str, names: &[String], of_detectors: &[RatesOverRange]) -> ThemedPanel {
    let series = |of_detector: &RatesOverRange| {
        let place = |(bin, rate): (usize, &Option<RateInRange>)| {
            let RateInRange { percent, interval_percent } = (*rate)?;
            Some(Place { x: bin as f64, y: percent, within: interval_percent })
        };
        let RatesOverRange { detector, rates } = of_detector;
        Series { name: detector.clone(), places: rates.iter().enumerate().map(place).collect() }
    };
    let series: Vec<Series> = of_detectors.iter().map(series).collect();
    let detectors: Vec<&str> = series.iter().map(|it| it.name.as_str()).collect();
    let label = format!("{rate} in percent over range from the sensor, of {}", detectors.join(", "));
    let x = Axis {
        labels: Labels::Words(names.iter().map(|it| it.replace('-', "–")).collect()),
        ..Axis::linear("range from the sensor (m)", [-0.5, names.len().max(1) as f64 - 0.5], names.len())
    };
    small_panel(rate, x, "%", &series, Points::Marked { apart: 0.09 }).panel(label)
}
