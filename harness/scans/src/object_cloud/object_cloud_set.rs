//! Sets of objects from all sources.

use std::path::PathBuf;

use reports::vocabulary::partial_class::PartialClass;

use super::growing_cloud::GrowingCloud;
use crate::dataset::DatasetError;
use crate::dataset::simulation::Simulation;

/// A series of objects that are read one at a time.
pub trait ObjectCloudSet: Send + Sync {
    /// Its description.
    fn description(&self) -> &ObjectSetDescription;

    /// The class of each object, in their order, known without reading them.
    fn classes(&self) -> &[PartialClass];

    /// Reads object `object_idx` of [`Self::classes`].
    fn read(&self, object_idx: usize) -> Result<GrowingCloud, DatasetError>;
}

/// Facts about a set of objects that are known without reading one.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSetDescription {
    /// The name used in tables and files.
    pub id: String,
    /// Its folder; `None` if it is simulated on the fly.
    pub root: Option<PathBuf>,
    /// The request to the simulator; `None` for recorded objects.
    pub simulation: Option<Simulation>,
}

impl ObjectSetDescription {
    /// Whether a simulator made it. Results on it are always labelled as simulated.
    pub fn is_simulated(&self) -> bool {
        self.simulation.is_some()
    }
}
