//! A folder with the results of all detectors of a run.
//!
//! ```text
//! DETECTOR/…             what the format has, if there is one data set
//! DETECTOR/DATASET/…     if there are several
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use detector::{DetectedClass, DetectorOutput};

use super::argoverse2_results::Argoverse2Results;
use super::kitti_results::KittiResults;
use super::nuscenes_results::NuScenesResults;
use super::own_results::OwnResults;
use super::{ResultFile, ResultWriter};
use crate::annotation::{LabeledScan, ScanId};
use crate::conversion::ConversionError;
use crate::conversion::kitti_writer::KittiLayout;
use crate::conversion::whole_folder::WholeFolder;
use crate::dataset::DatasetDescription;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::folder_name::folder_name;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::positioned_points::PositionedPoints;

/// The formats of results that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResultOutput {
    /// KITTI's text files.
    Kitti,
    /// A submission of nuScenes.
    NuScenes,
    /// A table of Argoverse 2.
    Argoverse2,
    /// The files of `detect`.
    Csv,
}

impl ResultOutput {
    /// Makes sure that results of this scan can be written, before a detector runs.
    pub fn check(self, id: &ScanId, frame: &ForeignFrame) -> Result<(), ConversionError> {
        let nothing = PositionedPoints::default().labeled_everywhere(id.clone(), Vec::new());
        writer_of(self, KittiLayout::Tracking).add(&nothing, frame, &DetectorOutput::default()).map(drop)
    }
}

/// A folder that is being written, and appears when it is complete.
#[must_use = "a folder that is not finished is thrown away"]
pub struct ResultFolder {
    folder: WholeFolder,
    output: ResultOutput,
    has_several_datasets: bool,
    dataset: Option<(String, KittiLayout)>,
    // By name of the detector.
    writers: BTreeMap<String, Box<dyn ResultWriter>>,
    n_left_out: u64,
}

impl ResultFolder {
    /// Begins the folder `path`, for one data set or for several.
    pub fn create(
        path: &Path,
        output: ResultOutput,
        has_several_datasets: bool,
    ) -> Result<Self, ConversionError> {
        let folder = WholeFolder::create(path)?;
        let writers = BTreeMap::new();
        Ok(Self { folder, output, has_several_datasets, dataset: None, writers, n_left_out: 0 })
    }

    /// Begins a data set.
    pub fn begin_dataset(&mut self, dataset: &DatasetDescription) {
        let layout = if dataset.format == DatasetFormat::KittiObject.name() {
            KittiLayout::Object
        } else {
            KittiLayout::Tracking
        };
        self.dataset = Some((folder_name(&dataset.id), layout));
    }

    /// Takes the output of `detector` for a scan of the data set.
    pub fn add(
        &mut self,
        detector: &str,
        scan: &LabeledScan,
        frame: &ForeignFrame,
        output: &DetectorOutput,
    ) -> Result<(), ConversionError> {
        let layout = self.dataset.as_ref().map_or(KittiLayout::Tracking, |(_, layout)| *layout);
        let format = self.output;
        let writer = self.writers.entry(detector.to_owned()).or_insert_with(|| writer_of(format, layout));
        if !writer.has_objects() {
            let left_out = output.detections.iter().filter(|it| it.class != DetectedClass::Vehicle);
            self.n_left_out += left_out.count() as u64;
        }
        let files = writer.add(scan, frame, output)?;
        self.write(detector, &files)
    }

    /// Ends the data set.
    pub fn end_dataset(&mut self) -> Result<(), ConversionError> {
        for (detector, writer) in std::mem::take(&mut self.writers) {
            let files = writer.finish()?;
            self.write(&detector, &files)?;
        }
        self.dataset = None;
        Ok(())
    }

    /// Gives the folder its name, and returns how many detections were left out since the format has no class for them.
    pub fn finish(self) -> Result<u64, ConversionError> {
        self.folder.finish()?;
        Ok(self.n_left_out)
    }

    fn write(&self, detector: &str, files: &[ResultFile]) -> Result<(), ConversionError> {
        let detector = folder_name(detector);
        let below = match &self.dataset {
            Some((dataset, _)) if self.has_several_datasets => format!("{detector}/{dataset}"),
            _ => detector,
        };
        files.iter().try_for_each(|it| self.folder.write(&format!("{below}/{}", it.name), &it.content))
    }
}

fn writer_of(output: ResultOutput, layout: KittiLayout) -> Box<dyn ResultWriter> {
    match output {
        ResultOutput::Kitti => Box::new(KittiResults::new(layout)),
        ResultOutput::NuScenes => Box::<NuScenesResults>::default(),
        ResultOutput::Argoverse2 => Box::<Argoverse2Results>::default(),
        ResultOutput::Csv => Box::new(OwnResults),
    }
}
