//! A detector that takes part in a comparison.

use std::path::Path;

use scans::dataset::DatasetDescription;
use scans::foreign::foreign_results::ForeignResults;

use super::config::{DETECTOR_TABLE, RunConfig};
use super::detector_list::ChosenDetector;
use super::foreign_detector::{ForeignDetector, ForeignProcess, ForeignWork, VehicleRule};
use super::foreign_files::{ForeignFileError, files_of};
use super::found_objects::ForeignVehicles;
#[cfg(target_os = "linux")]
use super::process_detector::ProcessDetector;
use super::results_detector::ResultsDetector;
use super::running_detector::{BegunConversation, BuiltIn, RunningDetector};
use crate::process::message::Configuration;
use crate::process::problem::DetectorFailure;

/// A detector with its parameters, under the name that it has in tables and files.
#[derive(Debug, Clone)]
pub struct ComparedDetector {
    /// The name.
    pub name: &'static str,
    /// The detector.
    pub chosen: ChosenDetector,
    /// Its parameters.
    pub config: RunConfig,
}

impl ComparedDetector {
    /// `chosen` under its own name.
    pub fn of(chosen: impl Into<ChosenDetector>, config: &RunConfig) -> Self {
        let chosen = chosen.into();
        Self { name: chosen.name(), chosen, config: config.clone() }
    }

    /// Makes the detector for scans of `dataset`. A sensor of unknown density is treated as the paper's.
    pub fn begin(&self, dataset: &DatasetDescription) -> Box<dyn RunningDetector> {
        let config = &self.config.for_scans_of(dataset);
        match &self.chosen {
            ChosenDetector::BuiltIn(listed) => {
                Box::new(BuiltIn::new(self.name, listed.build(config, dataset.sensor_height_m)))
            }
            ChosenDetector::Foreign(foreign) => foreign.begin(self.name, config, dataset),
        }
    }

    /// As [`Self::begin`], for a detector that left `results` for the scans of `dataset`.
    pub fn begin_with_results(
        &self,
        dataset: &DatasetDescription,
        results: ForeignResults,
    ) -> Box<dyn RunningDetector> {
        match &self.chosen {
            ChosenDetector::Foreign(foreign) => {
                let vehicles = foreign.vehicles_of(&self.config.for_scans_of(dataset), dataset);
                Box::new(ResultsDetector::new(self.name, Some(results), vehicles))
            }
            ChosenDetector::BuiltIn(_) => self.begin(dataset),
        }
    }

    /// Path of its results; `None` if it is a program or built in.
    pub fn results(&self) -> Option<&Path> {
        match &self.chosen {
            ChosenDetector::Foreign(ForeignDetector { work: ForeignWork::Results(path), .. }) => Some(path),
            _ => None,
        }
    }

    /// As [`Self::begin`], but reuses the program of `before`, which had other parameters: a start takes longer than a scan.
    ///
    /// # Errors
    ///
    /// [`DetectorFailure`] if the program does not accept the new parameters.
    #[cfg(target_os = "linux")]
    pub fn begin_with(
        &self,
        dataset: &DatasetDescription,
        before: Option<BegunConversation>,
    ) -> Result<Box<dyn RunningDetector>, DetectorFailure> {
        let config = &self.config.for_scans_of(dataset);
        match (&self.chosen, before) {
            (
                ChosenDetector::Foreign(
                    foreign @ ForeignDetector { work: ForeignWork::Process(process), .. },
                ),
                Some(before),
            ) => {
                let detector = foreign.begin_process(self.name, process, config, dataset);
                Ok(Box::new(detector.with_program(before)?))
            }
            _ => Ok(self.begin(dataset)),
        }
    }

    /// As [`Self::begin`]: there are no programs on this system.
    #[cfg(not(target_os = "linux"))]
    pub fn begin_with(
        &self,
        dataset: &DatasetDescription,
        _before: Option<BegunConversation>,
    ) -> Result<Box<dyn RunningDetector>, DetectorFailure> {
        Ok(self.begin(dataset))
    }
}

impl ForeignDetector {
    /// Adds the checksums of the files that it is made of with the parameters of `config`.
    ///
    /// # Errors
    ///
    /// [`ForeignFileError`] if one of them cannot be read.
    pub fn identified(mut self, config: &RunConfig) -> Result<Self, ForeignFileError> {
        let parameters = self.parameters(config);
        if let ForeignWork::Process(process) = &mut self.work {
            let texts = parameters.values().filter_map(|it| it.as_str());
            process.files = files_of(&process.command, texts, &self.folder)?;
        }
        Ok(self)
    }

    /// The detector, called `name`, for scans of `dataset`.
    fn begin(
        &self,
        name: &'static str,
        config: &RunConfig,
        dataset: &DatasetDescription,
    ) -> Box<dyn RunningDetector> {
        match &self.work {
            #[cfg(target_os = "linux")]
            ForeignWork::Process(process) => Box::new(self.begin_process(name, process, config, dataset)),
            #[cfg(not(target_os = "linux"))]
            ForeignWork::Process(_) => Box::new(super::running_detector::NotHere(name)),
            ForeignWork::Results(_) => {
                Box::new(ResultsDetector::new(name, None, self.vehicles_of(config, dataset)))
            }
        }
    }

    #[cfg(target_os = "linux")]
    fn begin_process(
        &self,
        name: &'static str,
        process: &ForeignProcess,
        config: &RunConfig,
        dataset: &DatasetDescription,
    ) -> ProcessDetector {
        let configuration = self.configuration(process, config, dataset);
        let vehicles = self.vehicles_of(config, dataset);
        ProcessDetector::new(name, process, self.folder.clone(), configuration, vehicles, config)
    }

    fn vehicles_of(&self, config: &RunConfig, dataset: &DatasetDescription) -> ForeignVehicles {
        match (self.vehicles, &config.vehicle_models) {
            (VehicleRule::Model, Some(models)) => {
                let (model, box_model) = (models.clusters(), config.box_model());
                ForeignVehicles::by_model(&config.hierarchical, model, box_model, dataset.sensor_height_m)
            }
            (VehicleRule::Size, _) | (VehicleRule::Model, None) => {
                ForeignVehicles::by_size(&config.hierarchical, config.box_model(), dataset.sensor_height_m)
            }
        }
    }

    /// Configuration for its program.
    fn configuration(
        &self,
        process: &ForeignProcess,
        config: &RunConfig,
        dataset: &DatasetDescription,
    ) -> Configuration {
        Configuration {
            dataset: dataset.id.clone(),
            sensor: Some(dataset.sensor.clone()),
            sensor_height_m: Some(dataset.sensor_height_m),
            parameters: self.parameters(config),
            threads: process.threads,
            max_points: 0,
            shared_memory: String::new(),
        }
    }

    /// Its parameters in `config`.
    pub fn parameters(&self, config: &RunConfig) -> serde_json::Map<String, serde_json::Value> {
        let written = config.resolved.get(DETECTOR_TABLE).and_then(|it| it.get(self.name));
        let written = written.and_then(|it| serde_json::to_value(it).ok());
        written.and_then(|it| it.as_object().cloned()).unwrap_or_default()
    }
}
