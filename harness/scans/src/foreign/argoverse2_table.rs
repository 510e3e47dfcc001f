//! Argoverse 2's tables of detections: boxes in the frame of the car, by log and time.
//!
//! Columns: `log_id`, `timestamp_ns`, `category`, `score`, `tx_m`, `ty_m`, `tz_m`, `length_m`, `width_m`, `height_m`, `qw`,
//! `qx`, `qy`, `qz`. A table holds the detections of all sweeps of the logs that it names; a sweep without a row has none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nalgebra::Isometry3;
use reports::vocabulary::class::AnnotationClass;

use super::detections::{ForeignBox, ForeignDetections};
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::DatasetError;
use crate::dataset::argoverse2::log_truth::{POSE, take_poses};
use crate::dataset::class_table::ClassReader;
use crate::dataset::feather::FeatherTable;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::official::{OfficialObject, UNLIKELY};
use crate::dataset::upright_box::upright_box;
use crate::foreign::foreign_class::ForeignClass;

/// The ending of the files.
pub const ENDING: &str = ".feather";

/// The columns beside those of the pose.
pub const COLUMNS: [&str; 7] =
    ["log_id", "timestamp_ns", "category", "score", "length_m", "width_m", "height_m"];

/// The results of tables.
pub struct Argoverse2Tables {
    scan_ids: Vec<ScanId>,
    asked: BTreeMap<usize, ForeignFrame>,
    logs: BTreeSet<String>,
    found: BTreeMap<usize, Vec<CarBox>>,
}

/// A box in the frame of the car.
struct CarBox {
    category: String,
    car_from_box: Isometry3<f64>,
    length_width_height_m: [f64; 3],
    class: AnnotationClass,
    score: f64,
    is_unlikely: bool,
}

impl Argoverse2Tables {
    /// Reads the tables at `paths`; `root` is the path from the user.
    pub fn open(root: &Path, paths: &[&Path], of: ResultsOf<'_>) -> Result<OpenResults, DatasetError> {
        let say = "names scans by the logs and times of Argoverse 2";
        of.require(root, |it| matches!(it, ForeignFrame::Car { .. }), say, "has none")?;
        let ids = of.dataset.scan_ids().iter().enumerate();
        let scans: BTreeMap<(&str, u64), usize> = ids
            .filter_map(|(scan_idx, id)| {
                Some(((id.sequence.as_str(), of.dataset.scan_time_ns(scan_idx)?), scan_idx))
            })
            .collect();
        let mut tables = Self {
            scan_ids: of.dataset.scan_ids().to_vec(),
            asked: of.asked,
            logs: BTreeSet::new(),
            found: BTreeMap::new(),
        };
        let mut classes = ClassReader::new(of.classes, &[]);
        let mut left_over = BTreeSet::new();
        for path in paths {
            tables.add(path, &scans, &mut left_over, &mut classes)?;
        }
        classes.unknown().refuse_results(&root.display().to_string())?;
        Ok(OpenResults::new(tables, left_over.into_iter().collect()))
    }

    fn add(
        &mut self,
        path: &Path,
        scans: &BTreeMap<(&str, u64), usize>,
        left_over: &mut BTreeSet<String>,
        classes: &mut ClassReader<'_>,
    ) -> Result<(), DatasetError> {
        let mut table = FeatherTable::read_some(path, &[&COLUMNS[..], &POSE[..]].concat(), &[UNLIKELY])?;
        let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
        let logs = table.take_texts("log_id").map_err(damaged)?;
        let times_ns = table.take_integers("timestamp_ns").map_err(damaged)?;
        let categories = table.take_texts("category").map_err(damaged)?;
        let mut take = |name: &str| table.take_numbers(name).map_err(damaged);
        let [scores, lengths_m, widths_m, heights_m] =
            [take("score")?, take("length_m")?, take("width_m")?, take("height_m")?];
        // Only our own tables have this column.
        let unlikely = table.take_integers(UNLIKELY).ok();
        let poses = take_poses(&mut table).map_err(damaged)?;
        let n_rows = logs.len();
        let lengths = [times_ns.len(), categories.len(), scores.len(), lengths_m.len(), widths_m.len()];
        if lengths.iter().chain([&heights_m.len(), &poses.len()]).any(|it| *it != n_rows) {
            return Err(damaged(format!("has columns of {n_rows} and of {lengths:?} rows")));
        }
        for row in 0..n_rows {
            let time_ns = u64::try_from(times_ns[row]).ok();
            let Some(&scan_idx) = time_ns.and_then(|it| scans.get(&(logs[row].as_str(), it))) else {
                left_over.insert(format!("{} of {}", times_ns[row], logs[row]));
                continue;
            };
            let at = || format!("{path:?}, row {row}");
            let Some(class) = classes.class_of(&categories[row], at) else { continue };
            self.logs.insert(logs[row].clone());
            self.found.entry(scan_idx).or_default().push(CarBox {
                category: categories[row].clone(),
                car_from_box: poses[row],
                length_width_height_m: [lengths_m[row], widths_m[row], heights_m[row]],
                class,
                score: scores[row],
                is_unlikely: unlikely.as_ref().and_then(|it| it.get(row)) == Some(&1),
            });
        }
        Ok(())
    }
}

impl ResultReader for Argoverse2Tables {
    fn has(&self, scan_idx: usize) -> bool {
        self.logs.contains(&self.scan_ids[scan_idx].sequence)
    }

    fn read(&mut self, scan_idx: usize, _scan: &LabeledScan) -> FoundInScan {
        let Some(ForeignFrame::Car { car_from_sensor, .. }) = self.asked.get(&scan_idx) else {
            return Ok(None);
        };
        if !self.has(scan_idx) {
            return Ok(None);
        }
        let sensor_from_car = car_from_sensor.inverse();
        let found = self.found.get(&scan_idx).map_or(&[][..], Vec::as_slice);
        let boxes = found.iter().map(|it| ForeignBox {
            bounding_box: upright_box(&(sensor_from_car * it.car_from_box), it.length_width_height_m),
            class: Some(ForeignClass::of(&it.category, it.class)),
            score: Some(it.score as f32),
            box_score: None,
            velocity_m_per_s: None,
            is_unlikely: it.is_unlikely,
        });
        let official = found.iter().map(|it| OfficialObject {
            score: Some(it.score),
            ..OfficialObject::new(&it.category, &it.car_from_box, it.length_width_height_m)
        });
        let (boxes, official) = (boxes.collect(), official.collect());
        Ok(Some(ForeignDetections { boxes, official, ..ForeignDetections::default() }))
    }
}
