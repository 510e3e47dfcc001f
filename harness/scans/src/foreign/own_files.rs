//! The files of `scanbench detect`: the cluster of every point of a scan's file, and boxes.
//!
//! ```text
//! NNNNNN.u32   four bytes a point, little endian: 0 is no cluster, others begin at 1
//! NNNNNN.csv   point,cluster: the same as text
//! NNNNNN.csv   id,class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad,…: boxes
//! ```
//!
//! A scan has clusters, boxes, or both; if both are in CSV, one is called `NNNNNN.clusters.csv` or `NNNNNN.boxes.csv`. The
//! columns `id`, `class`, `score`, `box_score` and `unlikely` of boxes may be left out, and there may be others. The class
//! is any name; `object` is no vehicle, and an empty class is unknown. Unlikely vehicles, with `true` in `unlikely`, count
//! only in protocols that rank boxes. If there are clusters, the box in row *k* is that of cluster *k*.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use detector::OrientedBox;
use reports::vocabulary::class::AnnotationClass;

use super::detections::{ForeignBox, ForeignDetections};
use super::result_files::ResultFiles;
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use crate::annotation::LabeledScan;
use crate::dataset::DatasetError;
use crate::dataset::class_table::{ClassReader, ClassRules, Vocabulary};
use crate::dataset::on_disk::bytes_of;
use crate::dataset::positioned_points::values_of_kept;
use crate::dataset::semantic_kitti::label_file::parse_label_file;
use crate::foreign::foreign_class::ForeignClass;

/// The endings of the files. A file with the last one may be of either kind.
pub const ENDINGS: [&str; 4] = [".u32", ".clusters.csv", ".boxes.csv", ".csv"];

/// Name in files of `detect` for an object that is no vehicle.
pub const VOCABULARY: &Vocabulary = &[("object", AnnotationClass::Misc)];

/// The columns that boxes need.
const BOX_COLUMNS: [&str; 7] =
    ["center_x_m", "center_y_m", "center_z_m", "length_m", "width_m", "height_m", "yaw_rad"];

/// The results of a folder.
pub struct OwnFiles {
    files: BTreeMap<usize, Vec<PathBuf>>,
    classes: ClassRules,
}

impl OwnFiles {
    /// Finds the files of the scans.
    pub fn open(files: &ResultFiles, of: &ResultsOf<'_>) -> OpenResults {
        let mut by_scan: BTreeMap<usize, Vec<PathBuf>> = BTreeMap::new();
        for ending in ENDINGS {
            for (scan_idx, path) in files.of_scans(of.dataset, ending) {
                by_scan.entry(scan_idx).or_default().push(path);
            }
        }
        let taken: BTreeSet<&Path> = by_scan.values().flatten().map(PathBuf::as_path).collect();
        let left_over = [".u32", ".csv"].iter().flat_map(|ending| files.left_over(ending, &taken)).collect();
        OpenResults::new(Self { files: by_scan, classes: of.classes.clone() }, left_over)
    }
}

impl ResultReader for OwnFiles {
    fn has(&self, scan_idx: usize) -> bool {
        self.files.contains_key(&scan_idx)
    }

    fn read(&mut self, scan_idx: usize, scan: &LabeledScan) -> FoundInScan {
        let Some(paths) = self.files.get(&scan_idx) else { return Ok(None) };
        let n_in_file = scan.cloud.len() + scan.points_left_out.len();
        let (mut clusters, mut boxes) = (None, None);
        for path in paths {
            let is_second = match read_file(path, n_in_file, &self.classes)? {
                Part::Clusters(of_file) => clusters.replace(of_file).is_some(),
                Part::Boxes(of_file) => boxes.replace(of_file).is_some(),
            };
            if is_second {
                let problem = format!("says the same of the scan as another: {paths:?}");
                return Err(DatasetError::Damaged { path: path.clone(), problem });
            }
        }
        Ok(Some(ForeignDetections {
            clusters: clusters.map(|it| values_of_kept(&it, &scan.points_left_out)),
            boxes: boxes.unwrap_or_default(),
            ..ForeignDetections::default()
        }))
    }
}

/// Content of a file.
#[derive(Debug, PartialEq)]
enum Part {
    /// The cluster of each point of the scan's file.
    Clusters(Vec<u32>),
    /// The boxes in order.
    Boxes(Vec<ForeignBox>),
}

fn read_file(path: &Path, n_in_file: usize, rules: &ClassRules) -> Result<Part, DatasetError> {
    let bytes = bytes_of(path)?;
    let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
    if path.extension().is_some_and(|it| it == "u32") {
        let clusters = parse_label_file(path, &bytes, n_in_file)?;
        refuse_old_numbers(&clusters).map_err(damaged)?;
        return Ok(Part::Clusters(clusters));
    }
    let mut classes = ClassReader::new(rules, VOCABULARY);
    let part = parse_csv(&bytes, path, &mut classes).map_err(damaged)?;
    classes.unknown().refuse_results(&path.display().to_string())?;
    match &part {
        Part::Clusters(clusters) if clusters.len() != n_in_file => {
            Err(DatasetError::label_count(path, clusters.len(), n_in_file))
        }
        _ => Ok(part),
    }
}

/// Errors, here and below, are the rest of a sentence about the file.
fn refuse_old_numbers(clusters: &[u32]) -> Result<(), String> {
    match clusters.iter().position(|it| *it == u32::MAX) {
        Some(index) => Err(format!("has the cluster {} at point {index}; 0 is no cluster", u32::MAX)),
        None => Ok(()),
    }
}

fn parse_csv(bytes: &[u8], path: &Path, classes: &mut ClassReader<'_>) -> Result<Part, String> {
    let mut reader = csv::Reader::from_reader(bytes);
    let not_csv = |error: csv::Error| format!("is not CSV: {error}");
    let header = reader.headers().map_err(not_csv)?.clone();
    let column_of = |name: &str| header.iter().position(|it| it.trim() == name);
    if let (Some(point), Some(cluster)) = (column_of("point"), column_of("cluster")) {
        let mut clusters = Vec::new();
        for record in reader.records() {
            let record = record.map_err(not_csv)?;
            clusters.push(cluster_of(&record, [point, cluster], clusters.len())?);
        }
        refuse_old_numbers(&clusters)?;
        return Ok(Part::Clusters(clusters));
    }
    let columns = BoxColumns {
        numbers: BOX_COLUMNS.iter().map(|name| column_of(name)).collect::<Option<Vec<_>>>().ok_or_else(
            || format!("has neither the columns point,cluster nor those of boxes, {}", BOX_COLUMNS.join(",")),
        )?,
        id: column_of("id"),
        class: column_of("class"),
        score: column_of("score"),
        box_score: column_of("box_score"),
        unlikely: column_of("unlikely"),
    };
    let mut boxes = Vec::new();
    for (row, record) in (1..).zip(reader.records()) {
        boxes.extend(columns.foreign_box(&record.map_err(not_csv)?, row, path, classes)?);
    }
    Ok(Part::Boxes(boxes))
}

fn cluster_of(record: &csv::StringRecord, [point, cluster]: [usize; 2], index: usize) -> Result<u32, String> {
    let cell = |column: usize| record.get(column).unwrap_or_default().trim();
    if cell(point).parse() != Ok(index) {
        return Err(format!("has the point {:?} in place of {index}", cell(point)));
    }
    cell(cluster).parse().map_err(|_| {
        format!(
            "has the cluster {:?} at point {index}: it has to be a number, and 0 is no cluster",
            cell(cluster)
        )
    })
}

/// Columns of the values of a box.
struct BoxColumns {
    numbers: Vec<usize>,
    id: Option<usize>,
    class: Option<usize>,
    score: Option<usize>,
    box_score: Option<usize>,
    unlikely: Option<usize>,
}

impl BoxColumns {
    /// The box of row `row`, from 1; `None` if its class is unknown, which is noted.
    fn foreign_box(
        &self,
        record: &csv::StringRecord,
        row: usize,
        path: &Path,
        classes: &mut ClassReader<'_>,
    ) -> Result<Option<ForeignBox>, String> {
        let cell = |column: usize| record.get(column).unwrap_or_default().trim();
        let number = |column: usize| {
            let text = cell(column);
            text.parse::<f32>().map_err(|_| format!("has {text:?} in place of a number in row {row}"))
        };
        if let Some(id) = self.id.map(cell)
            && id.parse() != Ok(row)
        {
            return Err(format!("has the id {id:?} in row {row}: ids are the numbers of the rows, from 1"));
        }
        let mut numbers = [0.0; BOX_COLUMNS.len()];
        for (value, column) in numbers.iter_mut().zip(&self.numbers) {
            *value = number(*column)?;
        }
        let [x_m, y_m, z_m, length_m, width_m, height_m, yaw_rad] = numbers;
        let given = |column: Option<usize>| column.filter(|it| !cell(*it).is_empty());
        let score = given(self.score).map(number).transpose()?;
        let box_score = given(self.box_score).map(number).transpose()?;
        let is_unlikely = match given(self.unlikely).map(cell) {
            None | Some("false") => false,
            Some("true") => true,
            Some(other) => return Err(format!("has {other:?} in place of true or false in row {row}")),
        };
        let class = match self.class.map(cell).filter(|it| !it.is_empty()) {
            None => None,
            Some(name) => {
                let Some(class) = classes.class_of(name, || format!("{path:?}, row {row}")) else {
                    return Ok(None);
                };
                Some(ForeignClass::of(name, class))
            }
        };
        let bounding_box = OrientedBox {
            center_m: [x_m, y_m, z_m],
            length_width_height_m: [length_m, width_m, height_m],
            yaw_rad,
        };
        Ok(Some(ForeignBox { bounding_box, class, score, box_score, velocity_m_per_s: None, is_unlikely }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Part, String> {
        let rules = ClassRules::default();
        parse_csv(text.as_bytes(), Path::new("a.csv"), &mut ClassReader::new(&rules, VOCABULARY))
    }

    #[test]
    fn clusters_are_read_in_the_order_of_the_points() {
        assert_eq!(parse("point,cluster\n0,7\n1,0\n2,1\n"), Ok(Part::Clusters(vec![7, 0, 1])));
        for (text, part) in [
            ("point,cluster\n0,7\n2,0\n", "the point \"2\" in place of 1"),
            ("point,cluster\n0,\n", "the cluster \"\" at point 0"),
            ("point,cluster\n0,-1\n", "the cluster \"-1\" at point 0"),
            ("point,cluster\n0,4294967295\n", "has the cluster 4294967295 at point 0"),
            ("point,cluster\n0,1,1\n", "is not CSV"),
            ("a,b\n0,1\n", "neither the columns point,cluster nor those of boxes"),
            ("", "neither the columns"),
        ] {
            let problem = parse(text).expect_err(text);
            assert!(problem.contains(part), "{problem}");
        }
    }

    const HEADER: &str =
        "id,class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad,n_points";

    #[test]
    fn boxes_are_those_of_detect_or_have_only_what_they_need() {
        let text = format!(
            "{HEADER}\n1,vehicle,0.5,10,-3,-0.9,4.2,1.8,1.5,0.5,12\n2,object,,1,2,3,1,1,1,0,0\n3,,,1,2,3,1,1,1,0,0\n"
        );
        let Ok(Part::Boxes(boxes)) = parse(&text) else { panic!("{:?}", parse(&text)) };
        let vehicle = Some(ForeignClass::of("vehicle", AnnotationClass::Car));
        assert_eq!(boxes[0], ForeignBox { class: vehicle, ..crate::foreign::detections::tests::car() });
        assert_eq!((boxes[1].class, boxes[1].score), (Some(AnnotationClass::Misc.into()), None));
        assert_eq!(boxes[2].class, None);
        let least = format!("{}\n10,-3,-0.9,4.2,1.8,1.5,0.5\n", BOX_COLUMNS.join(","));
        let Ok(Part::Boxes(least)) = parse(&least) else { panic!("{:?}", parse(&least)) };
        assert_eq!((least[0].bounding_box, least[0].class), (boxes[0].bounding_box, None));
        for (row, part) in [
            ("2,car,,1,2,3,1,1,1,0,0", "has the id \"2\" in row 1"),
            ("1,car,x,1,2,3,1,1,1,0,0", "has \"x\" in place of a number in row 1"),
            ("1,car,,1,2,3,1,1,1,,0", "has \"\" in place of a number in row 1"),
        ] {
            let problem = parse(&format!("{HEADER}\n{row}\n")).expect_err(row);
            assert!(problem.contains(part), "{problem}");
        }
    }
}
