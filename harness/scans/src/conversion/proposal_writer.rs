//! Scans with boxes to be corrected, as the projects of annotation tools, whose corrected files are read as ground truth.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use detector::{OrientedBox, PointCloud};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::named::named;
use serde::Serialize;
use serde_json::json;

use super::ConversionError;
use super::kitti_label_line::{CALIBRATION, class_word, label_line};
use super::kitti_writer::{bin_bytes, bin_file};
use super::whole_folder::WholeFolder;
use crate::annotation::{Annotation, LabeledScan};
use crate::dataset::AnnotatedClasses;
use crate::dataset::data_sheet::{DATA_SHEET, DataSheet, LabeledRegion};
use crate::dataset::folder_name::folder_name;
use crate::dataset::proposal_list::{PROPOSALS_CSV, ProposalList};
use crate::dataset::scan_folder::label_cloud::{LabelCloudFile, LabelCloudObject};
use crate::dataset::scan_folder::listed_box::ListedBox;
use crate::dataset::scan_folder::sustech_points::SustechObject;

named! {
    /// The tool that is to open them, by the files it reads.
    pub enum ProposalFormat {
        /// KITTI's object benchmark: `velodyne/*.bin`, `label_2/*.txt`.
        Kitti = "kitti",
        /// labelCloud: `pointclouds/*.bin`, `labels/*.json` in its format `centroid_rel`.
        Labelcloud = "labelcloud",
        /// `SUSTechPOINTS`: a scene with `lidar/*.pcd` and `label/*.json`.
        Sustechpoints = "sustechpoints",
    }
}

/// A box of a project.
#[derive(Debug, Clone, PartialEq)]
pub struct ProjectBox {
    /// What is labelled, or proposed, without its points.
    pub annotation: Annotation,
    /// The box, in the frame of the sensor.
    pub bounding_box: OrientedBox,
    /// Where it comes from.
    pub origin: BoxOrigin,
}

/// Where a box of a project comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BoxOrigin {
    /// Somebody has labelled it.
    Labelled,
    /// A detector proposes it.
    Proposed {
        /// How sure the detector is.
        score: Option<f32>,
    },
}

impl ProjectBox {
    fn score(&self) -> Option<f32> {
        match self.origin {
            BoxOrigin::Labelled => None,
            BoxOrigin::Proposed { score } => score,
        }
    }
}

/// The data sheet of scans of which only proposals are known: people who correct these look all round, for objects of all
/// classes.
pub fn sheet_of_proposals(sheet: DataSheet) -> DataSheet {
    let annotated_classes = AnnotatedClasses::Only(AnnotationClass::ALL.to_vec());
    DataSheet { labeled_region: LabeledRegion::Everywhere, annotated_classes, ..sheet }
}

/// A project that is being written.
#[must_use = "a project that is not finished is thrown away"]
pub struct ProposalWriter {
    format: ProposalFormat,
    folder: WholeFolder,
    sheet: DataSheet,
    proposed: ProposalList,
    classes: BTreeSet<&'static str>,
    n_written: u32,
}

impl ProposalWriter {
    /// Begins the folder `path`, with the data sheet `sheet`.
    pub fn create(path: &Path, format: ProposalFormat, sheet: DataSheet) -> Result<Self, ConversionError> {
        let (folder, proposed) = (WholeFolder::create(path)?, ProposalList::default());
        Ok(Self { format, folder, sheet, proposed, classes: BTreeSet::new(), n_written: 0 })
    }

    /// Appends a scan with its boxes, and returns the name of the file that these are in.
    pub fn write(&mut self, scan: &LabeledScan, boxes: &[ProjectBox]) -> Result<String, ConversionError> {
        let name = match self.format {
            ProposalFormat::Kitti => format!("{:06}", self.n_written),
            _ => format!("{}-{:06}", folder_name(&scan.id.sequence), scan.id.index),
        };
        self.n_written += 1;
        for it in boxes {
            self.classes.insert(class_word(it.annotation.class));
            if it.origin != BoxOrigin::Labelled {
                self.proposed.add(&it.bounding_box);
            }
        }
        let folder = &self.folder;
        let labels = match self.format {
            ProposalFormat::Kitti => format!("label_2/{name}.txt"),
            ProposalFormat::Labelcloud => format!("labels/{name}.json"),
            ProposalFormat::Sustechpoints => format!("label/{name}.json"),
        };
        match self.format {
            ProposalFormat::Kitti => {
                folder.write(&format!("velodyne/{name}.bin"), &bin_file(scan)?)?;
                folder.write(&labels, kitti_labels(boxes).as_bytes())?;
                folder.write(&format!("calib/{name}.txt"), CALIBRATION.as_bytes())?;
            }
            ProposalFormat::Labelcloud => {
                let filename = format!("{name}.bin");
                folder.write(&format!("pointclouds/{filename}"), &bin_file(scan)?)?;
                let objects = boxes.iter().map(|it| LabelCloudObject::new(&listed(it, None), it.score()));
                let file = LabelCloudFile {
                    folder: "pointclouds".to_owned(),
                    path: format!("pointclouds/{filename}"),
                    filename,
                    objects: objects.collect(),
                };
                folder.write(&labels, &json_bytes(&file))?;
            }
            ProposalFormat::Sustechpoints => {
                folder.write(&format!("lidar/{name}.pcd"), &pcd_bytes(&scan.cloud))?;
                // What is not yet tracked gets numbers that are free in this scan.
                let mut free =
                    1 + boxes.iter().filter_map(|it| it.annotation.track).max().unwrap_or_default();
                let track = |it: &ProjectBox| {
                    it.annotation.track.unwrap_or_else(|| {
                        free += 1;
                        free - 1
                    })
                };
                let tracks: Vec<u32> = boxes.iter().map(track).collect();
                let objects: Vec<SustechObject> = boxes
                    .iter()
                    .zip(tracks)
                    .map(|(it, track)| SustechObject::new(&listed(it, Some(track)), it.score()))
                    .collect();
                folder.write(&labels, &json_bytes(&objects))?;
            }
        }
        Ok(labels)
    }

    /// Adds the file `name` beside the data sheet.
    pub fn add(&self, name: &str, content: &[u8]) -> Result<(), ConversionError> {
        self.folder.write(name, content)
    }

    /// Ends the project, which appears under its name now.
    pub fn finish(self) -> Result<(), ConversionError> {
        self.folder.write(DATA_SHEET, self.sheet.to_json().as_bytes())?;
        self.folder.write(PROPOSALS_CSV, self.proposed.to_csv().as_bytes())?;
        if self.format == ProposalFormat::Labelcloud {
            // Without this file, the tool asks for the classes.
            let class = |(id, name)| json!({"name": name, "id": id, "color": COLORS[id % COLORS.len()]});
            let classes = json!({
                "classes": self.classes.iter().enumerate().map(class).collect::<Vec<_>>(),
                "default": 0,
                "type": "object_detection",
                "format": "centroid_rel",
                "created_with": {"name": "scanbench", "version": env!("CARGO_PKG_VERSION")},
            });
            self.folder.write("labels/_classes.json", &json_bytes(&classes))?;
        }
        self.folder.finish()
    }
}

/// Colours of classes in labelCloud, in turn.
const COLORS: [&str; 6] = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#d55e00"];

fn listed(it: &ProjectBox, track: Option<u32>) -> ListedBox {
    let OrientedBox { center_m, length_width_height_m, yaw_rad } = it.bounding_box;
    let class = class_word(it.annotation.class).to_owned();
    ListedBox { class, center_m: center_m.map(f64::from), length_width_height_m, yaw_rad, track }
}

/// A line for each box, with the score at the end as in results of the benchmark.
fn kitti_labels(boxes: &[ProjectBox]) -> String {
    let mut labels = String::new();
    for it in boxes {
        let truncation = it.annotation.truncation.map_or("-1".to_owned(), |share| share.to_string());
        let line = label_line(&it.annotation, &it.bounding_box, &truncation);
        let score = it.score().map(|it| format!(" {it}")).unwrap_or_default();
        writeln!(labels, "{line}{score}").expect("a string takes all that is written");
    }
    labels
}

fn json_bytes(value: &impl Serialize) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(value).expect("labels have text keys only");
    bytes.push(b'\n');
    bytes
}

/// The points as a binary PCD file.
fn pcd_bytes(cloud: &PointCloud) -> Vec<u8> {
    let points = bin_bytes(cloud);
    let n_points = points.len() / 16;
    let header = format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {n_points}\n\
         HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n_points}\nDATA binary\n"
    );
    [header.into_bytes(), points].concat()
}
