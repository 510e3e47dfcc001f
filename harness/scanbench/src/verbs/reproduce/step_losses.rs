//! Where the method loses objects, step by step.

use reports::files::archive::ArchiveError;
use reports::files::csv_rows::each_row;
use reports::numbers::tally::Tally;
use reports::plots::loss_plot::{Losses, loss_plot};
use reports::plots::themed_panel::{Arrangement, sheet};
use reports::reproduction::steps::{GOOD_FAITH, STEPS};
use reports::rows::error_row::ErrorRow;
use reports::rows::match_row::MatchRow;
use reports::run_folder::run_directory::{MATCHES_CSV, RunDirectory};
use reports::tables::error_table::ErrorTable;
use reports::verdicts::reason_gains::ReasonTally;
use reports::vocabulary::task::Task;

/// The mistakes of a run by their reasons, on all data sets of the first origin together.
pub struct StepLosses {
    rows: Vec<ErrorRow>,
}

impl StepLosses {
    /// The mistakes of the run in `directory`, which `tally` is of.
    pub fn read(directory: &RunDirectory, tally: &Tally) -> Result<Self, ArchiveError> {
        let mut reasons = ReasonTally::default();
        each_row(&directory.folder().join(MATCHES_CSV), |row: MatchRow| reasons.add_match(&row))?;
        let pool = tally.pools().into_iter().next();
        let is_here = |it: &ErrorRow| pool.as_ref().is_some_and(|pool| it.dataset == pool.extent.name());
        Ok(Self { rows: reasons.rows(tally).into_iter().filter(is_here).collect() })
    }

    /// The mistakes of the method after each step: a table for each task.
    pub fn tables(&self) -> Vec<ErrorTable<'_>> {
        Task::ALL.map(|task| self.table(task, STEPS.map(|it| it.detector).to_vec())).to_vec()
    }

    /// Losses of objects to the letter, in good faith and after the last step: a figure for each task.
    pub fn figures(&self) -> Vec<String> {
        let last = STEPS.len() - 1;
        let is_shown = |(idx, detector): &(usize, &str)| [0, last].contains(idx) || *detector == GOOD_FAITH;
        let detectors: Vec<&str> =
            STEPS.map(|it| it.detector).into_iter().enumerate().filter(is_shown).map(|it| it.1).collect();
        let figure = |task: Task| {
            let losses = Losses::of(&self.table(task, detectors.clone()), |_| 0);
            let panels: Vec<_> = losses.iter().map(loss_plot).collect();
            sheet(&panels, Arrangement::Row, &[], &format!("Where objects are lost, task {task}"))
        };
        Task::ALL.map(figure).to_vec()
    }

    fn table<'a>(&'a self, task: Task, detectors: Vec<&'a str>) -> ErrorTable<'a> {
        let is_asked = |it: &&ErrorRow| it.task == task && detectors.contains(&it.detector.as_str());
        let rows = self.rows.iter().filter(is_asked).collect();
        ErrorTable { detectors, rows }
    }
}
