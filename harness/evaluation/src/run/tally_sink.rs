//! The sums of a run, which are lent to it.

use reports::numbers::tally::Tally;

use super::sink::{JudgedScan, RunSink};

impl<E> RunSink<E> for &mut Tally {
    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), E> {
        for detector in &judged.rows {
            for task in &detector.tasks {
                Tally::add_scan(self, &task.scan);
                task.matches.iter().for_each(|it| self.add_match(it));
            }
            detector.stages.iter().for_each(|it| self.add_stage(it));
        }
        Ok(())
    }
}
