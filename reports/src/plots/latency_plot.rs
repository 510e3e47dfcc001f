//! The plot of the share of scans that finish within a time.

use super::figure::{Axis, Scale};
use super::marks::SeriesMark;
use super::series::{Points, Position, Series};
use super::small_panel::small_panel;
use super::themed_panel::ThemedPanel;

/// A panel called `title` with a curve for every detector. Times are in milliseconds, ascending and above zero; `None`
/// without times.
pub fn latency_plot(title: &str, of_detectors: &[(String, Vec<f64>)]) -> Option<ThemedPanel> {
    let times = || of_detectors.iter().flat_map(|(_, times)| times).copied();
    let (least, most) = (times().reduce(f64::min)?, times().reduce(f64::max)?);
    // The axis always has a power of ten.
    let from = 10_f64.powf(least.log10().floor());
    let to = (1.5 * most).max(12.0 * from);
    let series: Vec<Series> = of_detectors
        .iter()
        .zip((0..).map(SeriesMark))
        .map(|((name, times), mark)| Series { name: name.clone(), mark, positions: steps(times) })
        .collect();
    let about = "share of scans that finish within a time in milliseconds";
    let scale = Scale::Logarithmic([from, to]);
    let x = Axis { scale, ..Axis::linear("time of a scan (ms), logarithmic", [from, to], 5) };
    Some(small_panel([title, about], x, "scans (%)", &series, Points::Line))
}

/// Most steps that can be distinguished.
const MOST_STEPS: usize = 2000;

/// Positions of the share, which rises at every time, or at no more than [`MOST_STEPS`] of very many.
fn steps(times: &[f64]) -> Vec<Option<Position>> {
    let n = times.len() as f64;
    let n_at_once = times.len().div_ceil(MOST_STEPS).max(1);
    let mut n_before = 0;
    let positions = times.chunks(n_at_once).flat_map(|alike| {
        let n_done = [n_before, n_before + alike.len()];
        n_before = n_done[1];
        // The latest time of the chunk: no scan is drawn earlier than it finished.
        n_done.map(|n_done| {
            Some(Position { x: alike[alike.len() - 1], y: 100.0 * n_done as f64 / n, within: None })
        })
    });
    positions.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    #[test]
    fn shares_rise_to_all_scans() {
        let shares: Vec<_> = steps(&[1.0, 4.0]).into_iter().flatten().map(|it| (it.x, it.y)).collect();
        assert_eq!(shares, [(1.0, 0.0), (1.0, 50.0), (4.0, 50.0), (4.0, 100.0)]);
        let many = steps(&(1..=9001).map(f64::from).collect::<Vec<_>>());
        let last = many.last().and_then(Option::as_ref).map(|it| (it.x, it.y));
        assert!(many.len() <= 2 * MOST_STEPS && last == Some((9001.0, 100.0)), "{last:?}");
    }

    #[test]
    fn nothing_timed_is_no_panel() {
        assert_eq!(latency_plot("", &[("grid".to_owned(), Vec::new())]), None);
        let panel = latency_plot("", &[("grid".to_owned(), vec![3.0])]).unwrap();
        check_holds(&panel.inline(), &["time of a scan (ms)", "scans (%)", "k-d0"]);
    }
}
