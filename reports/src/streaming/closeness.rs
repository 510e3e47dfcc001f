//! Whether scans follow one another closely enough to be a stream.

use std::collections::BTreeMap;

use crate::rows::scan_row::ScanRow;

/// Scans farther apart than this are no stream, in seconds: sensors turn five times a second or more.
pub const LONGEST_GAP_S: f64 = 0.25;

/// Whether any two scans of a drive are close enough.
pub fn is_stream(scans: &[ScanRow]) -> bool {
    let mut times_s: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for row in scans {
        times_s.entry((&row.dataset, &row.sequence)).or_default().extend(row.time_s);
    }
    times_s.values_mut().any(|times_s| {
        times_s.sort_by(f64::total_cmp);
        // Rows of the same scan have the same time.
        times_s.windows(2).any(|it| (1e-3..=LONGEST_GAP_S).contains(&(it[1] - it[0])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::counts::Counts;
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome};
    use crate::vocabulary::task::Task;

    #[test]
    fn ten_scans_a_second_are_a_stream_and_two_are_not() {
        let row = |scan: u32, step_s: f64| ScanRow {
            dataset: "city".to_owned(),
            sequence: "0".to_owned(),
            scan,
            time_s: Some(f64::from(scan) * step_s),
            detector: "mine".to_owned(),
            task: Task::Objects,
            outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(Counts::default())),
        };
        let rows = |step_s: f64| [0, 0, 1, 1, 2].map(|it| row(it, step_s));
        assert!(is_stream(&rows(0.1)) && is_stream(&rows(0.25)));
        assert!(!is_stream(&rows(0.5)) && !is_stream(&rows(0.5)[..2]) && !is_stream(&[]));
    }
}
