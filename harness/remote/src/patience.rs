//! How long a silent or slow server is waited for.
//!
//! A server may send a byte a second, or the same beginning again and again. Only answers, and bytes that were never there
//! before, count as progress. Too little of it ends the wait; the user is told before.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Fewer bytes in a second are no progress.
const LEAST_BYTES_PER_S: f64 = 1000.0;
/// The user is told of little progress after this part of the time.
const SAID_AFTER: f64 = 1.0 / 6.0;

/// How long too little progress is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patience {
    /// An answer has to come within this time, or a thousand bytes for each of its seconds.
    pub limit: Duration,
}

impl Patience {
    /// This many bytes, or an answer, are enough for another wait.
    fn n_least_bytes(self) -> u64 {
        (LEAST_BYTES_PER_S * self.limit.as_secs_f64()) as u64
    }
}

/// Bytes and answers that have come so far, and the number of tasks on this machine.
#[derive(Debug, Default)]
pub struct Progress {
    n_bytes: AtomicU64,
    n_answers: AtomicU64,
    tasks_here: AtomicUsize,
}

/// A task on this machine; it lasts as long as this value.
#[derive(Debug)]
pub(crate) struct Busy<'a>(&'a Progress);

impl Progress {
    /// An answer has come, or a file is whole.
    pub(crate) fn answer(&self) {
        self.n_answers.fetch_add(1, Ordering::Relaxed);
    }

    /// Bytes have come that were never there before.
    pub(crate) fn bytes(&self, n_bytes: u64) {
        self.n_bytes.fetch_add(n_bytes, Ordering::Relaxed);
    }

    /// The server is not waited for meanwhile.
    pub(crate) fn busy(&self) -> Busy<'_> {
        self.tasks_here.fetch_add(1, Ordering::Relaxed);
        Busy(self)
    }
}

impl Drop for Busy<'_> {
    fn drop(&mut self) {
        self.0.tasks_here.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Result of a look at the progress.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Look {
    /// There is progress.
    Well,
    /// Progress is slow, and the user has not been told: a sentence.
    Slow(String),
    /// The wait is over: the reason.
    Over(String),
}

/// A wait for a server.
#[derive(Debug)]
pub(crate) struct Wait<'a> {
    progress: &'a Progress,
    patience: Patience,
    since: Instant,
    n_bytes_then: u64,
    n_answers_then: u64,
    is_said: bool,
}

impl<'a> Wait<'a> {
    /// Begins at `now`.
    pub(crate) fn begin(progress: &'a Progress, patience: Patience, now: Instant) -> Self {
        let n_bytes_then = progress.n_bytes.load(Ordering::Relaxed);
        let n_answers_then = progress.n_answers.load(Ordering::Relaxed);
        Self { progress, patience, since: now, n_bytes_then, n_answers_then, is_said: false }
    }

    /// Looks at the progress at `now`.
    pub(crate) fn look(&mut self, now: Instant) -> Look {
        let n_bytes = self.progress.n_bytes.load(Ordering::Relaxed);
        let n_new_bytes = n_bytes - self.n_bytes_then;
        let has_answer = self.progress.n_answers.load(Ordering::Relaxed) > self.n_answers_then;
        let is_busy = self.progress.tasks_here.load(Ordering::Relaxed) > 0;
        if is_busy || has_answer || n_new_bytes >= self.patience.n_least_bytes() {
            *self = Self::begin(self.progress, self.patience, now);
            return Look::Well;
        }
        let waited = now - self.since;
        let Patience { limit } = self.patience;
        let came = || match n_new_bytes {
            0 => format!("no answer has come for {} s", waited.as_secs()),
            n => format!("{n} new bytes have come in {} s", waited.as_secs()),
        };
        if waited >= limit {
            return Look::Over(came());
        }
        if !self.is_said && waited >= limit.mul_f64(SAID_AFTER) {
            self.is_said = true;
            let left = limit.saturating_sub(waited).as_secs_f64().ceil();
            return Look::Slow(format!("{}; waiting {left} s more", came()));
        }
        Look::Well
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Patience = Patience { limit: Duration::from_mins(1) };

    fn over(wait: &mut Wait<'_>, begin: Instant, n_seconds: u64) -> Option<u64> {
        (1..=n_seconds).find(|it| matches!(wait.look(begin + Duration::from_secs(*it)), Look::Over(_)))
    }

    #[test]
    fn silence_is_said_once_and_ends() {
        let (progress, begin) = (Progress::default(), Instant::now());
        let mut wait = Wait::begin(&progress, PATIENCE, begin);
        let looks: Vec<Look> = (1..=60)
            .map(|it| wait.look(begin + Duration::from_secs(it)))
            .filter(|it| *it != Look::Well)
            .collect();
        let said = "no answer has come for 10 s; waiting 50 s more".to_owned();
        assert_eq!(looks, [Look::Slow(said), Look::Over("no answer has come for 60 s".to_owned())]);
    }

    #[test]
    fn a_byte_a_second_is_no_progress_and_a_thousand_are() {
        for (n_bytes, expected) in [(0, Some(60)), (1, Some(60)), (900, Some(60)), (1000, None)] {
            let (progress, begin) = (Progress::default(), Instant::now());
            let mut wait = Wait::begin(&progress, PATIENCE, begin);
            let over = (1..=300).find(|it| {
                progress.bytes(n_bytes);
                matches!(wait.look(begin + Duration::from_secs(*it)), Look::Over(_))
            });
            assert_eq!(over, expected, "{n_bytes}");
        }
    }

    #[test]
    fn answers_and_work_of_our_own_begin_another_wait() {
        let (progress, begin) = (Progress::default(), Instant::now());
        let mut wait = Wait::begin(&progress, PATIENCE, begin);
        wait.look(begin + Duration::from_secs(50));
        progress.answer();
        wait.look(begin + Duration::from_secs(55));
        assert_eq!(over(&mut wait, begin, 200), Some(115));
        let busy = progress.busy();
        assert_eq!(over(&mut wait, begin, 2000), None);
        drop(busy);
        assert_eq!(over(&mut wait, begin + Duration::from_secs(2000), 200), Some(60));
    }
}
