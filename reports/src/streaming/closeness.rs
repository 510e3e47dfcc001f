//! Which scans follow one another closely enough to be a stream.

use std::collections::BTreeMap;

use crate::rows::scan_name::ScanName;
use crate::rows::scan_row::ScanRow;

/// Scans farther apart than this are no stream, in seconds: sensors turn five times a second or more.
const LONGEST_GAP_S: f64 = 0.25;
/// The same in microseconds.
const LONGEST_GAP_US: i64 = (1e6 * LONGEST_GAP_S) as i64;

/// Scans of one drive that follow one another closely: two or more.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    /// Id of the data set.
    pub dataset: String,
    /// Name of the drive.
    pub drive: String,
    /// Each scan with its time in microseconds since the first of the drive, by time.
    pub scans: Vec<(ScanName, i64)>,
}

/// A data set without a stretch, and the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoStream {
    /// Id of the data set.
    pub dataset: String,
    /// The reason.
    pub reason: String,
}

/// The stretches of all drives, and the data sets that have none. `drive_of` gives a row the name of its drive. Scans that
/// were skipped are in no stretch.
pub fn stretches(scans: &[ScanRow], drive_of: impl Fn(&ScanRow) -> String) -> (Vec<Stretch>, Vec<NoStream>) {
    let (mut all, mut without) = (Vec::new(), Vec::new());
    for (dataset, of_drives) in timed_scans(scans, &drive_of) {
        let n_before = all.len();
        for ((drive, _), scans) in &of_drives {
            let close = scans.chunk_by(|a, b| (1..=LONGEST_GAP_US).contains(&b.1.saturating_sub(a.1)));
            all.extend(close.filter(|it| it.len() > 1).map(|it| Stretch {
                dataset: dataset.to_owned(),
                drive: drive.clone(),
                scans: it.to_vec(),
            }));
        }
        if all.len() == n_before {
            without.push(NoStream { dataset: dataset.to_owned(), reason: why_none(&of_drives) });
        }
    }
    (all, without)
}

/// Whether there is any stretch.
pub fn is_stream(scans: &[ScanRow], drive_of: impl Fn(&ScanRow) -> String) -> bool {
    !stretches(scans, drive_of).0.is_empty()
}

/// Scans with their times, by drive and sequence: a drive may have a sequence for each of its sensors.
type OfDrives = BTreeMap<(String, String), Vec<(ScanName, i64)>>;

/// The scans of each data set by time; data sets in the order of the rows.
fn timed_scans<'a>(scans: &'a [ScanRow], drive_of: &impl Fn(&ScanRow) -> String) -> Vec<(&'a str, OfDrives)> {
    let mut timed: Vec<(&str, OfDrives)> = Vec::new();
    for row in scans {
        let dataset_idx = timed.iter().position(|it| it.0 == row.dataset).unwrap_or_else(|| {
            timed.push((&row.dataset, BTreeMap::new()));
            timed.len() - 1
        });
        let (Some(time_s), Some(_)) = (row.time_s, row.numbers()) else { continue };
        let entry = (row.scan_name(), (time_s * 1e6).round() as i64);
        timed[dataset_idx].1.entry((drive_of(row), row.sequence.clone())).or_default().push(entry);
    }
    for of_drive in timed.iter_mut().flat_map(|it| it.1.values_mut()) {
        of_drive.sort_by_key(|it| (it.1, it.0.scan));
        of_drive.dedup();
    }
    timed
}

/// Why a data set has no two scans in a row.
fn why_none(of_drives: &OfDrives) -> String {
    let gaps_us = of_drives.values().flat_map(|it| it.windows(2).map(|it| it[1].1.saturating_sub(it[0].1)));
    match gaps_us.filter(|it| *it > 0).min() {
        None if of_drives.is_empty() => "has no times".to_owned(),
        None => "has no two scans of a drive".to_owned(),
        Some(gap_us) => format!(
            "has scans {} s apart or more; a stream has them {LONGEST_GAP_S} s apart or less",
            gap_us as f64 / 1e6
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::counts::Counts;
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome};
    use crate::vocabulary::task::Task;

    fn row(sequence: &str, scan: u32, time_s: f64) -> ScanRow {
        ScanRow {
            dataset: "city".to_owned(),
            sequence: sequence.to_owned(),
            scan,
            time_s: Some(time_s),
            detector: "mine".to_owned(),
            task: Task::Objects,
            outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(Counts::default())),
        }
    }

    fn by_sequence(row: &ScanRow) -> String {
        row.sequence.clone()
    }

    #[test]
    fn ten_scans_a_second_are_a_stream_and_two_are_not() {
        let rows = |step_s: f64| [0, 0, 1, 1, 2].map(|it| row("0", it, f64::from(it) * step_s));
        assert!(is_stream(&rows(0.1), by_sequence) && is_stream(&rows(0.25), by_sequence));
        assert!(!is_stream(&rows(0.5), by_sequence) && !is_stream(&rows(0.5)[..2], by_sequence));
        let (_, without) = stretches(&rows(0.5), by_sequence);
        assert!(without[0].reason.starts_with("has scans 0.5 s apart or more"), "{without:?}");
        assert!(!is_stream(&[], by_sequence));
    }

    #[test]
    fn a_drive_is_cut_at_gaps_and_sensors_are_not_mixed() {
        let times_s = [0.0, 0.1, 0.2, 0.9, 1.0, 5.0];
        let of = |name: &'static str, after_s: f64| {
            times_s.iter().zip(0..).map(move |(it, scan)| row(name, scan, it + after_s))
        };
        let rows: Vec<ScanRow> = of("front", 0.0).chain(of("rear", 0.0)).collect();
        // Both sensors are of one drive, with the same time stamps.
        let (all, without) = stretches(&rows, |_| "drive".to_owned());
        let lengths: Vec<(String, usize)> =
            all.iter().map(|it| (it.scans[0].0.sequence.clone(), it.scans.len())).collect();
        let expected = [("front", 3), ("front", 2), ("rear", 3), ("rear", 2)];
        assert_eq!(lengths, expected.map(|(name, n)| (name.to_owned(), n)));
        assert!(without.is_empty() && all.iter().all(|it| it.drive == "drive"));
        // Drives that begin at the same time, as in a sequence with many, are none.
        let picked = [0.0, 0.0, 0.1].iter().zip(0..).map(|(it, scan)| row("training", scan, *it));
        let picked: Vec<ScanRow> = picked.collect();
        assert!(!is_stream(&picked, |it| it.scan.to_string()));
    }
}
