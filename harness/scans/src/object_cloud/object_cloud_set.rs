//! Many objects, wherever they come from.

use std::path::PathBuf;

use reports::vocabulary::partial_class::PartialClass;

use super::growing_cloud::GrowingCloud;
use crate::dataset::DatasetError;
use crate::dataset::simulation::Simulation;

/// A series of objects that are read one at a time.
pub trait ObjectCloudSet: Send + Sync {
    /// What it is.
    fn description(&self) -> &ObjectSetDescription;

    /// The class of each object, in their order, known without reading them.
    fn classes(&self) -> &[PartialClass];

    /// Reads object `object_idx` of [`Self::classes`].
    fn read(&self, object_idx: usize) -> Result<GrowingCloud, DatasetError>;
}

/// What is known about a set of objects without reading one.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSetDescription {
    /// The name used in tables and files.
    pub id: String,
    /// Where it lies; `None` for what is simulated on the fly.
    pub root: Option<PathBuf>,
    /// What a simulation was asked for; `None` for what was recorded.
    pub simulation: Option<Simulation>,
}

impl ObjectSetDescription {
    /// Whether a simulator made it. Numbers measured on it are always labelled so.
    pub fn is_simulated(&self) -> bool {
        self.simulation.is_some()
    }
}
