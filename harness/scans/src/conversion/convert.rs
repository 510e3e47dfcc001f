//! Conversion of an open data set to files of another format.

use std::path::Path;

use super::kitti_writer::{KittiLayout, KittiWriter};
use super::mcap_writer::{ChunkCompression, McapWriter};
use super::output_format::OutputFormat;
use super::semantic_kitti_writer::SemanticKittiWriter;
use super::{ConversionError, ScanToWrite, ScanWriter};
use crate::annotation::ScanId;
use crate::dataset::data_sheet::{DataSheet, LabeledRegion};
use crate::dataset::{Dataset, DatasetDescription, DatasetError};

/// Scans whose times are not known are taken to be this far apart, in nanoseconds.
const SCAN_PERIOD_NS: u64 = 100_000_000;

/// How scans are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Output<'a> {
    /// The file or folder, which must not exist.
    pub path: &'a Path,
    /// Its format.
    pub format: OutputFormat,
    /// How chunks of a recording are compressed.
    pub compression: ChunkCompression,
}

/// Writes the scans of `dataset` at `scan_indices`. It calls `on_scan` after each; if a scan cannot be read, `on_damage`
/// decides whether to go on without it.
///
/// Nothing is left behind after an error.
pub fn convert<E: From<ConversionError>>(
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    output: Output<'_>,
    mut on_damage: impl FnMut(&ScanId, DatasetError) -> Result<(), DatasetError>,
    mut on_scan: impl FnMut() -> Result<(), E>,
) -> Result<(), E> {
    let mut writer = begin(output, sheet_of(dataset.description()))?;
    let times_ns = times_of(dataset, scan_indices);
    for (&scan_idx, time_ns) in scan_indices.iter().zip(times_ns) {
        let scan = match dataset.read_scan(scan_idx) {
            Ok(scan) => scan,
            Err(error) => {
                on_damage(&dataset.scan_ids()[scan_idx], error).map_err(ConversionError::from)?;
                continue;
            }
        };
        let world_from_sensor = dataset.world_from_sensor(scan_idx).map_err(ConversionError::from)?;
        writer.write(&ScanToWrite { scan: &scan, time_ns, world_from_sensor })?;
        on_scan()?;
    }
    writer.finish()?;
    Ok(())
}

fn begin(output: Output<'_>, sheet: DataSheet) -> Result<Box<dyn ScanWriter>, ConversionError> {
    let Output { path, format, compression } = output;
    if path.exists() {
        return Err(ConversionError::Occupied { path: path.to_path_buf() });
    }
    Ok(match format {
        OutputFormat::Mcap => Box::new(McapWriter::create(path, compression, sheet)?),
        OutputFormat::KittiTracking => Box::new(KittiWriter::create(path, KittiLayout::Tracking, sheet)?),
        OutputFormat::KittiObject => Box::new(KittiWriter::create(path, KittiLayout::Object, sheet)?),
        OutputFormat::SemanticKitti => Box::new(SemanticKittiWriter::create(path, sheet)?),
    })
}

/// The data sheet of a converted data set: all that is known about its source.
pub fn sheet_of(description: &DatasetDescription) -> DataSheet {
    let checksum = description.checksum.as_deref().unwrap_or("without checksum");
    DataSheet {
        annotated_classes: description.annotated.clone(),
        sensor_height_m: description.sensor_height_m,
        sensor: description.sensor.clone(),
        licence: description.licence.clone(),
        labeled_region: LabeledRegion::Everywhere,
        simulation: description.simulation.clone(),
        made_from: Some(format!("{} {checksum}", description.id)),
    }
}

/// The times of the scans: those of the data set if it has all and they ascend, else a tenth of a second apart.
pub fn times_of(dataset: &dyn Dataset, scan_indices: &[usize]) -> Vec<u64> {
    let known: Option<Vec<u64>> = scan_indices.iter().map(|it| dataset.scan_time_ns(*it)).collect();
    match known {
        Some(known) if known.is_sorted_by(|a, b| a < b) => known,
        _ => (0..scan_indices.len() as u64).map(|number| number * SCAN_PERIOD_NS).collect(),
    }
}
