//! `scans.csv`, `matches.csv` and `stages.csv`.

use evaluation::run::sink::{JudgedScan, RunSink};
use reports::files::csv_rows::CsvRowWriter;
use reports::rows::match_row::MatchRow;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use reports::run_folder::run_directory::{MATCHES_CSV, RunDirectory, SCANS_CSV, STAGES_CSV};

use crate::commands::failure::Failure;

/// Writes every row to its file.
pub struct CsvFiles {
    scans: CsvRowWriter<ScanRow>,
    matches: CsvRowWriter<MatchRow>,
    stages: CsvRowWriter<StageRow>,
}

impl CsvFiles {
    /// Begins the files in `directory`.
    pub fn begin(directory: &RunDirectory) -> Result<Self, Failure> {
        Ok(Self {
            scans: CsvRowWriter::new(directory.begin_file(SCANS_CSV)?)?,
            matches: CsvRowWriter::new(directory.begin_file(MATCHES_CSV)?)?,
            stages: CsvRowWriter::new(directory.begin_file(STAGES_CSV)?)?,
        })
    }
}

impl RunSink<Failure> for CsvFiles {
    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        for detector in &judged.rows {
            for task in &detector.tasks {
                self.scans.write(&task.scan)?;
                task.matches.iter().try_for_each(|it| self.matches.write(it))?;
            }
            detector.stages.iter().try_for_each(|it| self.stages.write(it))?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        self.scans.finish()?;
        self.matches.finish()?;
        Ok(self.stages.finish()?)
    }
}
