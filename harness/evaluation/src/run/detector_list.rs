//! The detectors there are.

use baselines::kd_tree_detector::KdTreeDetector;
use baselines::pca_detector::PcaDetector;
use baselines::simple_grid_detector::SimpleGridDetector;
use detector::Detector;
use detector::pipeline::hierarchical_detector::HierarchicalDetector;

use crate::run::config::RunConfig;

/// A detector that can be asked for by name.
#[derive(Debug, Clone, Copy)]
pub struct ListedDetector {
    /// The name on the command line.
    pub name: &'static str,
    /// Its table in the configuration.
    pub table: &'static str,
    build: fn(&RunConfig, f32) -> Box<dyn Detector>,
}

/// Every detector, in the order of tables and pictures.
pub const DETECTORS: &[ListedDetector] = &[
    ListedDetector {
        name: "hierarchical",
        table: "hierarchical",
        build: |config, sensor_height_m| {
            let by_size = HierarchicalDetector::new(config.hierarchical.clone(), sensor_height_m);
            match &config.vehicle_models {
                Some(models) => Box::new(by_size.with_vehicle_model(models.by_shape.clone())),
                None => Box::new(by_size),
            }
        },
    },
    ListedDetector {
        name: "kd-tree",
        table: "kd_tree",
        build: |config, sensor_height_m| {
            let params = config.baselines.kd_tree.clone();
            let by_size = KdTreeDetector::new(params, config.hierarchical.clone(), sensor_height_m);
            match &config.vehicle_models {
                Some(models) => Box::new(by_size.with_vehicle_model(models.by_shape.clone())),
                None => Box::new(by_size),
            }
        },
    },
    ListedDetector {
        name: "pca",
        table: "pca",
        build: |config, _| {
            let vehicle_size = config.hierarchical.vehicle_size.clone();
            let by_size = PcaDetector::new(config.baselines.pca.clone(), vehicle_size);
            match &config.vehicle_models {
                Some(models) => Box::new(by_size.with_vehicle_model(models.pca.clone())),
                None => Box::new(by_size),
            }
        },
    },
    // The ablation of the first has its parameters.
    ListedDetector {
        name: "simple-grid",
        table: "hierarchical",
        build: |config, sensor_height_m| {
            let by_size = SimpleGridDetector::new(config.hierarchical.clone(), sensor_height_m);
            match &config.vehicle_models {
                Some(models) => Box::new(by_size.with_vehicle_model(models.by_shape.clone())),
                None => Box::new(by_size),
            }
        },
    },
];

/// The detectors that run if none are asked for: the method and its rivals. Ablations, as cheap as they may be, would
/// crowd the papers' tables and make recordings a third larger.
pub const DEFAULT_DETECTORS: [&str; 3] = ["hierarchical", "kd-tree", "pca"];

/// A name that is no detector's.
#[derive(Debug, thiserror::Error)]
pub enum DetectorListError {
    /// No detector is called so.
    #[error("there is no detector {name:?}; there are {}", DETECTORS.iter().map(|it| it.name).collect::<Vec<_>>().join(", "))]
    Unknown {
        /// The name.
        name: String,
    },
    /// A detector is asked for twice.
    #[error("the detector {name:?} is asked for twice")]
    Twice {
        /// The name.
        name: String,
    },
}

impl ListedDetector {
    /// Builds the detector for a sensor `sensor_height_m` above the road.
    pub fn build(&self, config: &RunConfig, sensor_height_m: f32) -> Box<dyn Detector> {
        (self.build)(config, sensor_height_m)
    }
}

/// The detectors with these names, in this order.
///
/// # Errors
///
/// [`DetectorListError`] if a name is unknown or given twice.
pub fn detectors_named(names: &[String]) -> Result<Vec<ListedDetector>, DetectorListError> {
    let mut listed: Vec<ListedDetector> = Vec::new();
    for name in names {
        let unknown = || DetectorListError::Unknown { name: name.clone() };
        let found = *DETECTORS.iter().find(|it| it.name == name).ok_or_else(unknown)?;
        if listed.iter().any(|it| it.name == found.name) {
            return Err(DetectorListError::Twice { name: name.clone() });
        }
        listed.push(found);
    }
    Ok(listed)
}
