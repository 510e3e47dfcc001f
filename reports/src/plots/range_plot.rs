//! Rates over the range from the sensor.

use super::curve_panel::{Place, Series};
use super::small_panel::{Points, SmallPanel, Words};
use super::themed_svg::ThemedPanel;

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
    let x_text = |value: f64| names.get(value as usize).map_or_else(String::new, |it| it.replace('-', "–"));
    let detectors: Vec<&str> = series.iter().map(|it| it.name.as_str()).collect();
    let label = format!("{rate} in percent over range from the sensor, of {}", detectors.join(", "));
    SmallPanel {
        title: rate,
        x_title: "range from the sensor (m)",
        y_title: "%",
        x: Words::new(names.len()),
        y: [0.0, 100.0],
        x_text: &x_text,
        n_x_labels: names.len(),
        series: &series,
        points: Points::Marked,
    }
    .draw(label)
}
