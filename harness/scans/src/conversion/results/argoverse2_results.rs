//! A table of detections of Argoverse 2: `detections.feather`, boxes in the frame of the car.
//!
//! Detections have the category for the class that their detector gives. Vehicles without one are `REGULAR_VEHICLE`. Other
//! objects have no category there and are left out. The score is that of the box. A detection without one has 1. A column of
//! ours is 1 for unlikely vehicles, else 0.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_ipc::writer::FileWriter;
use arrow_schema::ArrowError;
use detector::DetectorOutput;
use reports::vocabulary::protocol::Protocol;

use super::class_words::word_among;
use super::detection_rows::SCORE_OF_NONE;
use super::{CompleteFiles, ResultFile, ResultWriter, ranked, unwritable};
use crate::annotation::LabeledScan;
use crate::conversion::ConversionError;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::official::UNLIKELY;
use crate::dataset::upright_box::pose_of_box;

/// The name of the file.
const NAME: &str = "detections.feather";

/// The columns that hold numbers.
const NUMBERS: [&str; 11] =
    ["tx_m", "ty_m", "tz_m", "length_m", "width_m", "height_m", "qw", "qx", "qy", "qz", "score"];

/// A table that is being filled.
#[derive(Default)]
pub struct Argoverse2Results {
    logs: Vec<String>,
    times_ns: Vec<i64>,
    categories: Vec<&'static str>,
    unlikely: Vec<i64>,
    numbers: [Vec<f64>; NUMBERS.len()],
}

impl ResultWriter for Argoverse2Results {
    fn add(&mut self, scan: &LabeledScan, frame: &ForeignFrame, output: &DetectorOutput) -> CompleteFiles {
        let ForeignFrame::Car { log_id, timestamp_ns, car_from_sensor } = frame else {
            return Err(unwritable(scan, "argoverse2", "its data set has no logs of Argoverse 2"));
        };
        let words = Protocol::Argoverse2.ranked_classes();
        for (detection, is_unlikely) in ranked(output) {
            let Some(category) = word_among(&detection, words, |it| it.argoverse2.as_deref()) else {
                continue;
            };
            self.categories.push(category);
            let car_from_box = car_from_sensor * pose_of_box(&detection.bounding_box);
            let (at, turn) = (car_from_box.translation.vector, car_from_box.rotation);
            let [length_m, width_m, height_m] = detection.bounding_box.length_width_height_m.map(f64::from);
            let score = f64::from(detection.box_score().unwrap_or(SCORE_OF_NONE));
            let row = [at.x, at.y, at.z, length_m, width_m, height_m, turn.w, turn.i, turn.j, turn.k, score];
            self.logs.push(log_id.clone());
            self.times_ns.push(*timestamp_ns);
            self.unlikely.push(is_unlikely.into());
            self.numbers.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
        Ok(Vec::new())
    }

    fn finish(self: Box<Self>) -> CompleteFiles {
        let content = self.table().and_then(|it| file_of(&it)).map_err(|error| ConversionError::Write {
            path: NAME.into(),
            source: std::io::Error::other(error),
        })?;
        Ok(vec![ResultFile { name: NAME.to_owned(), content }])
    }

    fn has_objects(&self) -> bool {
        false
    }
}

impl Argoverse2Results {
    fn table(&self) -> Result<RecordBatch, ArrowError> {
        let categories = StringArray::from(self.categories.clone());
        let mut columns: Vec<(&str, ArrayRef)> = vec![
            ("log_id", Arc::new(StringArray::from(self.logs.clone()))),
            ("timestamp_ns", Arc::new(Int64Array::from(self.times_ns.clone()))),
            ("category", Arc::new(categories)),
        ];
        for (name, numbers) in NUMBERS.iter().zip(&self.numbers) {
            columns.push((name, Arc::new(Float64Array::from(numbers.clone()))));
        }
        columns.push((UNLIKELY, Arc::new(Int64Array::from(self.unlikely.clone()))));
        RecordBatch::try_from_iter(columns)
    }
}

fn file_of(table: &RecordBatch) -> Result<Vec<u8>, ArrowError> {
    let mut writer = FileWriter::try_new(Vec::new(), &table.schema())?;
    writer.write(table)?;
    writer.finish()?;
    writer.into_inner()
}
