//! Pairs of scans and messages about them, by their times.
//!
//! A message belongs to the scan with the nearest time stamp, if it is within half of the time between scans; when both were
//! logged, and in which order, does not matter. Log times count only where all scans or all messages lack a stamp.

use std::collections::BTreeSet;

/// Times farther apart never belong together, in nanoseconds.
pub const MAX_OFFSET_NS: u64 = 50_000_000;

/// Stamps that stand still while messages are logged for this long are no clock, in nanoseconds.
const MAX_STANDSTILL_NS: u64 = 1_000_000_000;

/// Times of a message, in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// The time stamp within the message, if it has one.
    pub stamp_ns: Option<u64>,
    /// When the message was logged.
    pub log_time_ns: u64,
}

/// The times that scans and messages are compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Their time stamps.
    Stamps,
    /// Times when they were logged, since stamps are missing.
    LogTimes {
        /// Whether scans have no stamps.
        scans_lack_stamps: bool,
        /// Whether messages have no stamps.
        messages_lack_stamps: bool,
    },
}

/// Scans with their messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimePairs {
    // One for each scan.
    message_of_scan: Vec<Option<usize>>,
    clock: Clock,
    // First and last time of the scans and of the messages, if no message is near a scan.
    apart_ns: Option<[[u64; 2]; 2]>,
}

impl TimePairs {
    /// Pairs of `scans` and `messages`, both in any order.
    pub fn of(scans: &[Moment], messages: &[Moment]) -> Self {
        let [scans_lack_stamps, messages_lack_stamps] =
            [scans, messages].map(|it| !it.is_empty() && !has_stamps(it));
        let clock = if scans_lack_stamps || messages_lack_stamps {
            Clock::LogTimes { scans_lack_stamps, messages_lack_stamps }
        } else {
            Clock::Stamps
        };
        let [scans_ns, messages_ns] = [scans, messages].map(|it| by_clock(it, clock));
        let mut by_time: Vec<(u64, usize)> =
            scans_ns.iter().enumerate().map(|(scan_idx, at_ns)| (*at_ns, scan_idx)).collect();
        by_time.sort_unstable();
        let half_period_ns = half_period_ns(&by_time);
        // The nearest message of each scan; one without a stamp only if there is no other.
        let mut nearest: Vec<Option<(bool, u64, usize)>> = vec![None; scans.len()];
        for (message_idx, at_ns) in messages_ns.iter().enumerate() {
            let (offset_ns, of_scans) = nearest_scans(&by_time, *at_ns);
            if offset_ns > MAX_OFFSET_NS || half_period_ns.is_some_and(|it| offset_ns >= it) {
                continue;
            }
            let has_no_stamp = messages[message_idx].stamp_ns.is_none();
            let candidate = (has_no_stamp, offset_ns, message_idx);
            for (_, scan_idx) in of_scans {
                let best = nearest[*scan_idx].get_or_insert(candidate);
                *best = candidate.min(*best);
            }
        }
        let message_of_scan: Vec<Option<usize>> = nearest.into_iter().map(|it| Some(it?.2)).collect();
        let ends = |times_ns: &[u64]| Some([*times_ns.iter().min()?, *times_ns.iter().max()?]);
        let are_apart = message_of_scan.iter().all(Option::is_none);
        let apart_ns = ends(&scans_ns).zip(ends(&messages_ns)).filter(|_| are_apart).map(|(a, b)| [a, b]);
        Self { message_of_scan, clock, apart_ns }
    }

    /// The index of the message of this scan.
    pub fn message_of(&self, scan_idx: usize) -> Option<usize> {
        self.message_of_scan.get(scan_idx).copied().flatten()
    }

    /// The indices of the messages that belong to a scan.
    pub fn taken(&self) -> BTreeSet<usize> {
        self.message_of_scan.iter().flatten().copied().collect()
    }

    /// The clock that was used.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// A note for the user about pairs of clouds with `messages`, such as `labels`: that log times were used, or that no two
    /// are near each other. `None` if there is nothing to note.
    pub fn note(&self, messages: &str) -> Option<String> {
        if let Some([[first_ns, last_ns], [other_first_ns, other_last_ns]]) = self.apart_ns {
            return Some(format!(
                "no {messages} are near a cloud in time: clouds are from {first_ns} to {last_ns} ns, {messages} from \
                 {other_first_ns} to {other_last_ns} ns"
            ));
        }
        let lacking = match self.clock {
            Clock::Stamps => return None,
            Clock::LogTimes { scans_lack_stamps: true, messages_lack_stamps: true } => {
                format!("clouds and {messages}")
            }
            Clock::LogTimes { scans_lack_stamps: true, .. } => "clouds".to_owned(),
            Clock::LogTimes { .. } => messages.to_owned(),
        };
        Some(format!(
            "{messages} are paired with clouds by when they were logged, since {lacking} have no time stamps: a delay of \
             more than half of the time between clouds gives them to another scan"
        ))
    }
}

/// The times of `moments`: their stamps if there are any, else when they were logged.
///
/// Those that lack a stamp are taken to be logged with the same delay as the others.
pub fn times_ns(moments: &[Moment]) -> Vec<u64> {
    let lacks = !has_stamps(moments);
    let log_times = Clock::LogTimes { scans_lack_stamps: lacks, messages_lack_stamps: lacks };
    by_clock(moments, if lacks { log_times } else { Clock::Stamps })
}

/// How much later than their stamps messages are logged, in nanoseconds: the median over messages with a stamp, if any.
pub fn usual_delay_ns(moments: impl Iterator<Item = Moment>) -> Option<i64> {
    let delay_ns = |it: Moment| Some(it.log_time_ns.wrapping_sub(it.stamp_ns?).cast_signed());
    let mut delays_ns: Vec<i64> = moments.filter_map(delay_ns).collect();
    delays_ns.sort_unstable();
    delays_ns.get(delays_ns.len() / 2).copied()
}

/// Whether there are stamps, and they do not stand still.
fn has_stamps(moments: &[Moment]) -> bool {
    let mut stamps_ns = moments.iter().filter_map(|it| it.stamp_ns);
    let Some(first_ns) = stamps_ns.next() else { return false };
    let log_times_ns = || moments.iter().map(|it| it.log_time_ns);
    let logged_for_ns = log_times_ns().max().unwrap_or(0) - log_times_ns().min().unwrap_or(0);
    let n_with = moments.iter().filter(|it| it.stamp_ns.is_some()).count();
    n_with == 1 || logged_for_ns < MAX_STANDSTILL_NS || stamps_ns.any(|it| it != first_ns)
}

fn by_clock(moments: &[Moment], clock: Clock) -> Vec<u64> {
    let delay_ns = usual_delay_ns(moments.iter().copied()).unwrap_or(0);
    let time_ns = |it: &Moment| match clock {
        Clock::Stamps => it.stamp_ns.unwrap_or_else(|| it.log_time_ns.saturating_sub_signed(delay_ns)),
        Clock::LogTimes { .. } => it.log_time_ns,
    };
    moments.iter().map(time_ns).collect()
}

/// Half of the usual time between scans, which ascend; `None` for fewer than two moments.
fn half_period_ns(by_time: &[(u64, usize)]) -> Option<u64> {
    let pauses_ns = by_time.windows(2).map(|it| it[1].0 - it[0].0);
    let mut pauses_ns: Vec<u64> = pauses_ns.filter(|it| *it > 0).collect();
    pauses_ns.sort_unstable();
    pauses_ns.get(pauses_ns.len() / 2).map(|it| it.div_ceil(2))
}

/// Distance of `at_ns` from the nearest of the scans, which ascend, and all scans of that time; the earlier of two that are
/// as near.
fn nearest_scans(by_time: &[(u64, usize)], at_ns: u64) -> (u64, &[(u64, usize)]) {
    let n_before = by_time.partition_point(|it| it.0 < at_ns);
    let around = [n_before.checked_sub(1), Some(n_before)].into_iter().flatten();
    let times_ns = around.filter_map(|it| Some(by_time.get(it)?.0));
    let Some(nearest_ns) = times_ns.min_by_key(|it| it.abs_diff(at_ns)) else { return (u64::MAX, &[]) };
    let first = by_time.partition_point(|it| it.0 < nearest_ns);
    let end = by_time.partition_point(|it| it.0 <= nearest_ns);
    (nearest_ns.abs_diff(at_ns), &by_time[first..end])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    fn stamped(stamp_ms: u64, delay_ms: u64) -> Moment {
        Moment { stamp_ns: Some(stamp_ms * MS), log_time_ns: (stamp_ms + delay_ms) * MS }
    }

    fn unstamped(log_ms: u64) -> Moment {
        Moment { stamp_ns: None, log_time_ns: log_ms * MS }
    }

    #[track_caller]
    fn check(scans: &[Moment], messages: &[Moment], expected: &[Option<usize>]) -> TimePairs {
        let pairs = TimePairs::of(scans, messages);
        let found: Vec<Option<usize>> = (0..scans.len()).map(|it| pairs.message_of(it)).collect();
        assert_eq!(found, expected, "{pairs:?}");
        pairs
    }

    #[test]
    fn half_of_the_time_between_scans_is_near() {
        let scans = [1000, 1050, 1100].map(|it| stamped(it, 0));
        check(&scans, &[stamped(1024, 0)], &[Some(0), None, None]);
        check(&scans, &[stamped(1025, 0)], &[None; 3]);
        check(&scans, &[stamped(1026, 0), stamped(1049, 0)], &[None, Some(1), None]);
        // Slow scans: an object moves on within half a second.
        let scans = [1000, 2000].map(|it| stamped(it, 0));
        check(&scans, &[stamped(1050, 0), stamped(2051, 0)], &[Some(0), None]);
        check(&scans[..1], &[stamped(1050, 0)], &[Some(0)]);
        assert!(check(&[], &[stamped(0, 0)], &[]).note("labels").is_none());
        assert!(check(&scans, &[], &[None; 2]).note("labels").is_none());
    }

    #[test]
    fn scans_of_one_moment_share_a_message_and_of_two_messages_the_first_counts() {
        let scans = [1000, 1000, 1100].map(|it| stamped(it, 0));
        check(&scans, &[stamped(1000, 9), stamped(1000, 10)], &[Some(0), Some(0), None]);
    }

    #[test]
    fn log_times_count_only_without_stamps_and_that_is_said() {
        let scans = [1000, 1100, 1200].map(|it| stamped(it, 30));
        let logged = [1032, 1131, 1229].map(unstamped);
        let note = check(&scans, &logged, &[Some(0), Some(1), Some(2)]).note("labels").unwrap();
        assert!(note.contains("by when they were logged, since labels have no time stamps"), "{note}");
        let labels = [1000, 1100, 1200].map(|it| stamped(it, 500));
        let note = check(&logged, &labels, &[None; 3]).note("labels").unwrap();
        assert!(note.starts_with("no labels are near a cloud in time"), "{note}");
        // Stamps that stand still are not used.
        let still = [0, 700, 1400].map(|delay_ms| stamped(7, delay_ms));
        let logged = [8, 708, 1408].map(unstamped);
        let note = check(&still, &logged, &[Some(0), Some(1), Some(2)]).note("labels").unwrap();
        assert!(note.contains("since clouds and labels have no"), "{note}");
    }

    #[test]
    fn a_message_without_a_stamp_among_others_is_as_late_as_they_are() {
        let scans = [1000, 1100, 1200].map(|it| stamped(it, 200));
        let messages = [stamped(1000, 100), unstamped(1203), stamped(1200, 100)];
        let pairs = check(&scans, &messages, &[Some(0), Some(1), Some(2)]);
        assert_eq!((pairs.note("labels"), pairs.taken().len()), (None, 3));
        // A message with a stamp goes first.
        check(&scans, &[unstamped(1100), stamped(1003, 100)], &[Some(1), None, None]);
        assert_eq!(times_ns(&messages), [1000 * MS, 1103 * MS, 1200 * MS]);
    }

    proptest! {
        /// Delays, jitter and order of messages change nothing.
        #[test]
        fn pairs_are_those_of_the_stamps(
            period_ms in prop::sample::select(vec![50_u64, 100]),
            n_scans in 2_usize..30,
            delays_ms in prop::array::uniform2(0_u64..3000),
            jitters_ms in prop::collection::vec(prop::array::uniform2(0_u64..400), 30),
            offsets_ms in prop::collection::vec(0_u64..24, 30),
            is_labelled in prop::collection::vec(any::<bool>(), 30),
            order in Just((0..30_usize).collect::<Vec<_>>()).prop_shuffle(),
        ) {
            let order: Vec<usize> = order.into_iter().filter(|it| *it < n_scans).collect();
            let stamp_ms = |it: usize| 10_000 + period_ms * it as u64;
            let scan = |it: usize| stamped(stamp_ms(it), delays_ms[0] + jitters_ms[it][0]);
            let scans: Vec<Moment> = order.iter().map(|it| scan(*it)).collect();
            let labelled: Vec<usize> = (0..n_scans).filter(|it| is_labelled[*it]).collect();
            let label = |it: usize| stamped(stamp_ms(it) + offsets_ms[it], delays_ms[1] + jitters_ms[it][1]);
            let mut labels: Vec<(Moment, usize)> = labelled.iter().map(|it| (label(*it), *it)).collect();
            labels.sort_by_key(|it| it.0.log_time_ns);
            let messages: Vec<Moment> = labels.iter().map(|it| it.0).collect();
            let pairs = TimePairs::of(&scans, &messages);
            for (position, scan_idx) in order.iter().enumerate() {
                let found = pairs.message_of(position).map(|it| labels[it].1);
                prop_assert_eq!(found, is_labelled[*scan_idx].then_some(*scan_idx));
            }
            prop_assert!(labelled.is_empty() || pairs.note("labels").is_none());
        }
    }
}
