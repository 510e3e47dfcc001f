//! An MCAP recording as a data set: every message of one topic of clouds is a scan.
//!
//! Scans are read one at a time, with the annotations of the nearest time stamp. For the rest of the recording only the
//! positions and times of messages are kept, 56 bytes each.

use std::path::Path;
use std::sync::OnceLock;

use nalgebra::Isometry3;
use reports::files::regular_file::RegularFile;
use reports::vocabulary::class::AnnotationClass;

use super::frame_tree::FrameTree;
use super::mcap_file::McapFile;
use super::mcap_index::{McapIndex, MessagePosition, index_mcap};
use super::recorded_cloud::RecordedCloud;
use super::recorded_messages::{Channel, RecordedMessages};
use super::scene_objects::SceneObject;
use super::topics::{ChosenChannel, MessageKind, choose_channels};
use crate::annotation::{Annotation, LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::class_table::{ClassReader, ClassRules, UnknownClasses};
use crate::dataset::data_sheet::DataSheet;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::on_disk::stem_of;
use crate::dataset::points_of_boxes::assign_points_in_boxes;
use crate::dataset::source::{DamagePolicy, DatasetSource};
use crate::dataset::time_pairs::{Moment, TimePairs, times_ns};
use crate::dataset::{Dataset, DatasetError, Listing, labels_without_scan};

/// The metadata record in which scanbench writes values that the messages have no place for, and the names in it.
pub mod own_metadata {
    /// The name of the record.
    pub const RECORD: &str = "scanbench";
    /// A data sheet, as JSON.
    pub const DATA_SHEET: &str = "data_sheet";
    /// The ids of the scans, in order: a JSON list of pairs of a sequence and a number.
    pub const SCAN_IDS: &str = "scan_ids";
}

/// An open recording.
#[derive(Debug)]
struct McapDataset {
    // Invariant: `scan_ids` and `clouds.positions` have the same length and order.
    listing: Listing,
    messages: RecordedMessages,
    clouds: Channel,
    annotations: Option<Channel>,
    // Read from all messages once times are needed.
    times: OnceLock<RecordedTimes>,
    cut_off: Option<String>,
    classes: ClassRules,
    names_not_taken: Option<String>,
}

/// Times of the scans, and the annotations that belong to them.
#[derive(Debug)]
struct RecordedTimes {
    scans_ns: Vec<u64>,
    pairs: TimePairs,
}

/// Whether the file at `path` is MCAP, by its first bytes.
pub fn is_mcap(path: &Path) -> bool {
    use std::io::Read as _;
    let mut magic = [0; 8];
    path.is_file()
        && RegularFile::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok()
        && magic == mcap::MAGIC
}

/// Opens the recording of `source`.
///
/// No cloud is read.
pub fn open_mcap(mut source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let path = source.path.clone();
    let mut index = index_mcap(&path, own_metadata::RECORD, |channel| MessageKind::of(channel).is_some())?;
    let damaged = |problem: String| DatasetError::Damaged { path: path.clone(), problem };
    if let (Some(problem), DamagePolicy::Refuse) = (&index.cut_off, source.damage) {
        return Err(damaged(problem.clone()));
    }
    if let Some(sheet) = index.metadata.get(own_metadata::DATA_SHEET) {
        let sheet = DataSheet::from_json(sheet)
            .map_err(|problem| damaged(format!("has a data sheet that cannot be read: {problem}")))?;
        source.take_sheet(sheet);
    }
    let chosen = choose_channels(&path, &index, &source.parts.topics)?;
    let checksum = checksum_of(&path, &index)?;
    let own_ids = index.metadata.get(own_metadata::SCAN_IDS);
    let own_ids: Option<Vec<(String, u32)>> =
        own_ids.map(|ids| serde_json::from_str(ids).unwrap_or_default());
    let chunks = std::mem::take(&mut index.chunks);
    let mut channel = |chosen: ChosenChannel| Channel::take(&mut index, chosen);
    let clouds = channel(chosen.cloud);
    let n_scans = clouds.positions.len();
    let names_not_taken = own_ids.as_ref().filter(|own| own.len() != n_scans).map(|own| {
        format!(
            "has names of {} scans in its metadata, but {n_scans} scans: they are numbered instead",
            own.len()
        )
    });
    let annotations = chosen.annotations.map(&mut channel);
    let transforms = chosen.transforms.into_iter().map(&mut channel).collect();
    let recording = McapDataset {
        classes: source.classes.clone(),
        names_not_taken,
        listing: Listing {
            scan_ids: scan_ids(&path, n_scans, own_ids),
            description: source.describe(DatasetFormat::Mcap, checksum),
        },
        annotations,
        clouds,
        times: OnceLock::new(),
        messages: RecordedMessages::new(McapFile::new(&path, chunks), transforms)?,
        cut_off: index.cut_off.take(),
    };
    if recording.listing.scan_ids.is_empty() {
        return Err(DatasetError::no_scans(path));
    }
    Ok(Box::new(recording))
}

fn checksum_of(path: &Path, index: &McapIndex) -> Result<String, DatasetError> {
    let mut checksum = DatasetChecksum::default();
    // Not its name: a renamed recording is the same.
    checksum.add_file("recording", path)?;
    let crcs: Vec<String> = index.chunks.iter().map(|chunk| format!("{:08x}\n", chunk.crc)).collect();
    checksum.add_text("chunks", crcs.concat());
    Ok(checksum.finish())
}

fn scan_ids(path: &Path, n_scans: usize, own: Option<Vec<(String, u32)>>) -> Vec<ScanId> {
    match own {
        Some(own) if own.len() == n_scans => {
            own.into_iter().map(|(sequence, index)| ScanId { sequence, index }).collect()
        }
        _ => {
            let stem = stem_of(path);
            (0..n_scans as u32).map(|index| ScanId { sequence: stem.clone(), index }).collect()
        }
    }
}

impl Dataset for McapDataset {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let position = self.clouds.positions[scan_idx];
        let recorded = self.read_cloud(position)?;
        let annotations = self.annotations_of(scan_idx, &recorded)?;
        let is_annotated = annotations.is_some();
        let mut annotations = annotations.unwrap_or_default();
        match &recorded.objects {
            Some(_) => recorded.assign_points(&mut annotations),
            None => assign_points_in_boxes(&recorded.cloud, &mut annotations),
        }
        let n_points = recorded.cloud.len();
        let (point_regions, labeled_area) = match &recorded.regions {
            Some(regions) => {
                let region_of = |it: &f64| PointRegion::of_number(*it as u8).unwrap_or(PointRegion::Outside);
                (regions.iter().map(region_of).collect(), LabeledArea::AsPoints)
            }
            None if is_annotated => (vec![PointRegion::Labeled; n_points], LabeledArea::Everywhere),
            None => (vec![PointRegion::Outside; n_points], LabeledArea::AsPoints),
        };
        let id = self.listing.scan_ids[scan_idx].clone();
        let RecordedCloud { cloud, points_left_out, .. } = recorded;
        Ok(LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out })
    }

    fn left_out(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        let without_scan = self.positions_without_scan()?;
        let names: Vec<String> = without_scan.iter().map(ToString::to_string).collect();
        let mut oddities = labels_without_scan(&names);
        oddities.extend(self.names_not_taken.clone());
        oddities.extend(self.note_of_labels());
        Ok(oddities)
    }

    fn note_of_labels(&self) -> Option<String> {
        self.annotations.as_ref()?;
        self.times().pairs.note("labels")
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        Some(self.times().scans_ns[scan_idx])
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        if !self.messages.has_transforms() {
            return Ok(None);
        }
        let recorded = self.read_cloud(self.clouds.positions[scan_idx])?;
        let tree = self.messages.frames_at(self.moment_of(scan_idx, &recorded))?;
        Ok(Some(tree.root_from(&recorded.frame) * recorded.sensor_from_frame.inverse()))
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let recorded = self.read_cloud(self.clouds.positions[scan_idx])?;
        let moment = self.moment_of(scan_idx, &recorded);
        let RecordedCloud { frame, sensor_from_frame, .. } = recorded;
        Ok(ForeignFrame::Recording { moment, frame, sensor_from_frame })
    }
}

impl McapDataset {
    fn read_cloud(&self, position: MessagePosition) -> Result<RecordedCloud, DatasetError> {
        let message = self.messages.message(position)?;
        let recorded = RecordedCloud::read(self.clouds.kind, &self.clouds.encoding, message.as_slice());
        recorded.map_err(|problem| self.messages.damaged_at(position, &problem))
    }

    /// Time stamp and log time of the cloud of scan `scan_idx`, which is `recorded`.
    fn moment_of(&self, scan_idx: usize, recorded: &RecordedCloud) -> Moment {
        let stamp_ns = (recorded.stamp_ns > 0).then_some(recorded.stamp_ns);
        Moment { stamp_ns, log_time_ns: self.clouds.positions[scan_idx].log_time_ns }
    }

    fn times(&self) -> &RecordedTimes {
        self.times.get_or_init(|| {
            let [clouds, annotations] = if let Some(annotations) = &self.annotations {
                self.messages.moments([&self.clouds, annotations])
            } else {
                let [clouds] = self.messages.moments([&self.clouds]);
                [clouds, Vec::new()]
            };
            RecordedTimes { scans_ns: times_ns(&clouds), pairs: TimePairs::of(&clouds, &annotations) }
        })
    }

    /// The annotations of scan `scan_idx`, which is `recorded`, without their points; `None` if no message belongs to it.
    fn annotations_of(
        &self,
        scan_idx: usize,
        recorded: &RecordedCloud,
    ) -> Result<Option<Vec<Annotation>>, DatasetError> {
        let Some(channel) = &self.annotations else { return Ok(None) };
        let Some(message_idx) = self.times().pairs.message_of(scan_idx) else { return Ok(None) };
        let logged = channel.positions[message_idx];
        let (_, objects) = self.messages.read_objects(channel, logged)?;
        let mut reader = ClassReader::new(&self.classes, &[]);
        let mut classes = Vec::with_capacity(objects.len());
        for object in &objects {
            classes.push(reader.class_of(&object.class_name, || logged.to_string()));
        }
        if !reader.unknown().is_empty() {
            self.all_unknown_classes().refuse(&self.listing.description.id)?;
        }
        let is_elsewhere = |it: &SceneObject| !it.frame.is_empty() && it.frame != recorded.frame;
        let tree = if objects.iter().any(is_elsewhere) {
            self.messages.frames_at(self.moment_of(scan_idx, recorded))?
        } else {
            FrameTree::default()
        };
        let annotation =
            |(object, class): (&SceneObject, AnnotationClass)| -> Result<Annotation, DatasetError> {
                let frame = if object.frame.is_empty() { &recorded.frame } else { &object.frame };
                let cloud_from_frame = tree.to_from(&recorded.frame, frame).ok_or_else(|| {
                    self.messages.damaged(format!(
                        "has annotations in the frame {frame:?}, but no transform from it to {:?}",
                        recorded.frame
                    ))
                })?;
                let sensor_from_frame = recorded.sensor_from_frame * cloud_from_frame;
                object.annotation(class, &sensor_from_frame).map_err(|problem| self.messages.damaged(problem))
            };
        // Unknown names were refused above.
        let known = objects.iter().zip(classes).filter_map(|(object, class)| Some((object, class?)));
        known.map(annotation).collect::<Result<_, _>>().map(Some)
    }

    /// The unknown classes of all annotations that can be read, so that one error names them all.
    fn all_unknown_classes(&self) -> UnknownClasses {
        let mut classes = ClassReader::new(&self.classes, &[]);
        if let Some(channel) = &self.annotations {
            for &position in &channel.positions {
                // A message that cannot be read fails when its scan is read.
                let (_, objects) = self.messages.read_objects(channel, position).unwrap_or_default();
                for object in objects {
                    classes.class_of(&object.class_name, || position.to_string());
                }
            }
        }
        classes.unknown().clone()
    }

    /// The positions of annotations that belong to no scan.
    fn positions_without_scan(&self) -> Result<Vec<MessagePosition>, DatasetError> {
        let Some(channel) = &self.annotations else { return Ok(Vec::new()) };
        let taken = self.times().pairs.taken();
        let mut without_scan = Vec::new();
        for (message_idx, &position) in channel.positions.iter().enumerate() {
            if !taken.contains(&message_idx) && !self.messages.read_objects(channel, position)?.1.is_empty() {
                without_scan.push(position);
            }
        }
        Ok(without_scan)
    }
}
