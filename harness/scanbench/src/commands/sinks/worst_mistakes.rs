//! `worst_points.json`: what the sensor saw around the worst mistakes.

use evaluation::run::sink::{JudgedScan, RunSink};
use reports::run_folder::run_directory::{RunDirectory, WORST_POINTS_JSON};
use reports::worst::places::WorstPlaces;
use reports::worst::points::{PlanCells, WorstPoints};

use super::plan_cells::plan_cells;
use crate::commands::failure::Failure;

/// Keeps the worst mistakes with the points around them, while the run has these.
pub struct WorstMistakes<'a> {
    directory: &'a RunDirectory,
    places: WorstPlaces<PlanCells>,
}

impl<'a> WorstMistakes<'a> {
    /// None yet; `directory` gets the file.
    pub fn new(directory: &'a RunDirectory) -> Self {
        Self { directory, places: WorstPlaces::default() }
    }
}

impl RunSink<Failure> for WorstMistakes<'_> {
    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        let cloud = &judged.results.scan.cloud;
        let sensor_height_m = judged.dataset().sensor_height_m;
        let tasks = judged.rows.iter().flat_map(|it| &it.tasks);
        for row in tasks.flat_map(|it| &it.matches) {
            self.places.add(row, |window| plan_cells(cloud, window, sensor_height_m));
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Failure> {
        let json = WorstPoints::new(&self.places).to_json();
        Ok(self.directory.write_file(WORST_POINTS_JSON, json.as_bytes())?)
    }
}
