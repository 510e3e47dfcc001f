//! Which scans a detector takes that works on one at a time, and from when on its answers are known.

use super::moving::TimeUs;

/// An answer of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    /// Index of its scan in the drive.
    pub scan_idx: usize,
    /// From when on it is known.
    pub known_from_us: TimeUs,
}

/// The answers to scans that are taken at `times_us`, ascending, where a scan takes `latency_us` of its index.
///
/// As a node in a car does: when it is free it takes the newest scan that is there, and those before it are dropped; if all
/// have been taken it waits for the next.
pub fn answers(times_us: &[TimeUs], latency_us: impl Fn(usize) -> TimeUs) -> Vec<Answer> {
    let mut answers: Vec<Answer> = Vec::new();
    let mut next_idx = 0;
    let mut free_from_us = TimeUs::MIN;
    while next_idx < times_us.len() {
        let n_there = times_us.partition_point(|it| *it <= free_from_us);
        let scan_idx = next_idx.max(n_there.saturating_sub(1));
        let known_from_us = free_from_us.max(times_us[scan_idx]).saturating_add(latency_us(scan_idx).max(0));
        answers.push(Answer { scan_idx, known_from_us });
        (next_idx, free_from_us) = (scan_idx + 1, known_from_us);
    }
    answers
}

/// Index of the newest of `answers` at a time; `None` before the first.
pub fn newest(answers: &[Answer], at_us: TimeUs) -> Option<usize> {
    answers.partition_point(|it| it.known_from_us <= at_us).checked_sub(1)
}

/// The moments of a clock that ticks every `step_us`, from the first to the last of `times_us`.
pub fn moments(times_us: &[TimeUs], step_us: TimeUs) -> impl Iterator<Item = TimeUs> {
    let (first, last) = (times_us.first().copied().unwrap_or(0), times_us.last().copied().unwrap_or(-1));
    (first..=last).step_by(step_us.max(1) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Scan and time of every answer in milliseconds, to six scans a tenth of a second apart.
    #[track_caller]
    fn check(latency_ms: i64, expected_ms: &[(usize, i64)]) {
        let times_us: Vec<i64> = (0..6).map(|it| it * 100_000).collect();
        let of_scans = answers(&times_us, |_| latency_ms * 1000).into_iter();
        let found: Vec<(usize, i64)> = of_scans.map(|it| (it.scan_idx, it.known_from_us / 1000)).collect();
        assert_eq!(found, expected_ms, "{latency_ms} ms");
    }

    #[test]
    fn a_fast_detector_waits_and_a_slow_one_drops_scans() {
        check(0, &[(0, 0), (1, 100), (2, 200), (3, 300), (4, 400), (5, 500)]);
        check(40, &[(0, 40), (1, 140), (2, 240), (3, 340), (4, 440), (5, 540)]);
        // It is free just when the next scan is there.
        check(100, &[(0, 100), (1, 200), (2, 300), (3, 400), (4, 500), (5, 600)]);
        // Free at 150, 300, 450 ms: the newest is then scan 1, 3, 4.
        check(150, &[(0, 150), (1, 300), (3, 450), (4, 600), (5, 750)]);
        check(250, &[(0, 250), (2, 500), (5, 750)]);
        check(900, &[(0, 900), (5, 1800)]);
    }

    #[test]
    fn nothing_is_known_before_the_first_answer() {
        let all = answers(&[0, 100], |_| 70);
        assert_eq!([69, 70, 169, 170].map(|it| newest(&all, it)), [None, Some(0), Some(0), Some(1)]);
        assert_eq!(moments(&[0, 100_000, 250_000], 100_000).collect::<Vec<_>>(), [0, 100_000, 200_000]);
        assert_eq!(moments(&[], 10).count(), 0);
    }

    proptest! {
        #[test]
        fn every_answer_is_of_the_newest_scan_when_it_was_begun(
            gaps_us in prop::collection::vec(1_i64..300, 1..40),
            latencies_us in prop::collection::vec(0_i64..900, 40),
        ) {
            let times_us: Vec<i64> = gaps_us.iter().scan(0, |at, gap| { *at += gap; Some(*at) }).collect();
            let all = answers(&times_us, |it| latencies_us[it]);
            let mut free_us = i64::MIN;
            let mut next_idx = 0;
            for it in &all {
                let begun_us = it.known_from_us - latencies_us[it.scan_idx];
                prop_assert!(begun_us >= free_us && begun_us >= times_us[it.scan_idx]);
                // It neither idles while a new scan is there nor takes an older one.
                prop_assert!(begun_us == free_us || begun_us == times_us[it.scan_idx]);
                let newer = times_us[it.scan_idx + 1..].iter().any(|time_us| *time_us <= begun_us);
                prop_assert!(!newer && it.scan_idx >= next_idx);
                (free_us, next_idx) = (it.known_from_us, it.scan_idx + 1);
            }
            prop_assert_eq!(all.last().unwrap().scan_idx, times_us.len() - 1);
        }
    }
}
