//! Who takes part in a run.

use detector::stage_product::StageProduct;
use detector::{Detector, DetectorOutput, PointCloud, Rule};
use scans::dataset::DatasetDescription;

use super::config::RunConfig;
use super::detector_list::ListedDetector;

/// A detector with its parameters, under the name that it has in tables and files.
#[derive(Debug, Clone)]
pub struct Entrant {
    /// The name.
    pub name: &'static str,
    /// The detector.
    pub listed: ListedDetector,
    /// Its parameters.
    pub config: RunConfig,
}

impl Entrant {
    /// `listed` under its own name.
    pub fn of(listed: ListedDetector, config: &RunConfig) -> Self {
        Self { name: listed.name, listed, config: config.clone() }
    }

    /// The detector for scans of `dataset`. A sensor whose density is not known is taken for the paper's.
    pub fn build(&self, dataset: &DatasetDescription) -> Box<dyn Detector> {
        let of_sensor = self.config.for_sensor(&dataset.sensor);
        let config = of_sensor.as_ref().unwrap_or(&self.config);
        let detector = self.listed.build(config, dataset.sensor_height_m);
        Box::new(Renamed { name: self.name, detector })
    }
}

struct Renamed {
    name: &'static str,
    detector: Box<dyn Detector>,
}

impl Detector for Renamed {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        self.detector.detect(cloud, output);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        self.detector.stage_products(cloud)
    }

    fn rules(&self) -> Vec<Rule> {
        self.detector.rules()
    }
}
