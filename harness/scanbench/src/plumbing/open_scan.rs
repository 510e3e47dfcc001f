//! The single scan that the command line names.

use std::path::{Path, PathBuf};

use detector::PointCloud;
use detector::grid::density_curve::DensityCurve;
use scans::annotation::{LabeledArea, LabeledScan, PointRegion, ScanId};
use scans::dataset::class_table::ClassTable;
use scans::dataset::detect_format::folders_around;
use scans::dataset::kitti::split_folder::{KITTI_SENSOR, KITTI_SENSOR_HEIGHT_M};
use scans::dataset::mcap::mcap_dataset::is_mcap;
use scans::dataset::point_columns::PointColumns;
use scans::dataset::scan_columns::ScanColumns;
use scans::dataset::scan_folder::any_scan_file::{SCAN_EXTENSIONS, read_scan_file, scan_extension};
use scans::dataset::velodyne_capture::capture_file::is_capture;
use scans::dataset::{AnnotatedClasses, DatasetDescription};
use simulator::open::open_dataset;

use crate::cli::SourceArgs;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::frame_facts::{Stated, indices_looked_at};
use crate::plumbing::open_datasets::{open_catalogue, open_options, refuse_simulation, stated};
use crate::plumbing::remote::local_name;

/// A scan without ground truth.
pub struct OpenedScan {
    /// Its name on screens, with a word about whether it is simulated.
    pub name: String,
    /// The scan, without annotations.
    pub scan: LabeledScan,
    /// The data set that it is of, or that its file would make; with the height of the sensor as far as the files say.
    pub description: DatasetDescription,
    /// Facts about its sensor that are stated.
    pub stated: Stated,
    /// Points of the first scans of its data set; none for a file, nor for a simulated sensor that has a curve.
    pub of_data_set: Vec<PointCloud>,
    /// Folders in which its labels may lie, if it is a file.
    pub folders_around: Vec<PathBuf>,
}

/// Opens the scan in the file `input`, or scan `id` of the data set `input`; `of_config` are the names of classes in the
/// configuration.
pub fn open_scan(
    input: &str,
    id: Option<&str>,
    source: &SourceArgs,
    of_config: &ClassTable,
) -> Result<OpenedScan, Failure> {
    if source.labels_ahead.is_some() {
        return Err(Usage("--labels-ahead is for labels, and none are read".to_owned()).into());
    }
    let catalogue = open_catalogue(source.catalogue.catalogue.as_deref())?;
    let input = &*local_name(input, source.cache.as_deref())?;
    let path = Path::new(input);
    if let Some(members) = catalogue.groups.get(input) {
        let problem = format!("{input:?} is a group of data sets; choose one of {}", members.join(", "));
        return Err(Usage(problem).into());
    }
    let is_catalogued = catalogue.ids().any(|it| it == input);
    if !is_catalogued && !path.is_dir() {
        if scan_extension(path).is_some() {
            return open_file(input, id, source);
        }
        if path.is_file() && !is_mcap(path) && !is_capture(path) {
            return Err(Usage(format!(
                "cannot read {input:?} as a scan: give a file that ends in .{}, or an MCAP recording or a \
                 packet capture with --scan",
                SCAN_EXTENSIONS.join(", .")
            ))
            .into());
        }
    }
    let dataset = open_dataset(input, &open_options(source, of_config)?, &catalogue)?;
    let description = dataset.description();
    if !description.is_simulated() {
        refuse_simulation(source)?;
    }
    if source.columns.is_some() && dataset.columns()?.is_none() {
        return Err(Usage(format!("--columns is for .bin and .npy files, and {input:?} has none")).into());
    }
    let scan_idx = find_scan(id, dataset.scan_ids(), &description.id)?;
    let scan = dataset.read_scan(scan_idx)?;
    let simulated = if description.is_simulated() { " (simulated)" } else { "" };
    let name = format!("{}{simulated}, scan {}", description.id, scan.id);
    let scan = LabeledScan { annotations: Vec::new(), ..scan };
    let stated = stated(input, &catalogue, source, description)?;
    let is_known = description.is_simulated() && DensityCurve::shipped(&description.sensor).is_some();
    let of_data_set = if is_known {
        Vec::new()
    } else {
        let indices = indices_looked_at(dataset.scan_ids().len());
        let clouds = indices.filter_map(|it| dataset.read_scan(it).ok()).map(|it| it.cloud);
        clouds.filter(|it| !it.is_empty()).collect()
    };
    let (description, folders_around) = (description.clone(), Vec::new());
    Ok(OpenedScan { name, scan, description, stated, of_data_set, folders_around })
}

fn open_file(input: &str, id: Option<&str>, source: &SourceArgs) -> Result<OpenedScan, Failure> {
    let for_datasets = [("--scan", id.is_some()), ("--format", source.format.is_some())];
    if let Some((option, _)) = for_datasets.iter().find(|(_, is_given)| *is_given) {
        return Err(Usage(format!("{option} is only for data sets, but {input:?} is a scan")).into());
    }
    refuse_simulation(source)?;
    let path = Path::new(input);
    let columns = ScanColumns::new(source.columns.clone(), PointColumns::of_kitti(), &[path.to_path_buf()]);
    if source.columns.is_some() && columns.described()?.is_none() {
        return Err(
            Usage(format!("--columns is for .bin and .npy files, but {input:?} names its own")).into()
        );
    }
    let (cloud, points_left_out) = read_scan_file(path, &columns)?.points.into_parts();
    let mut scan = LabeledScan {
        id: ScanId { sequence: input.to_owned(), index: 0 },
        annotations: Vec::new(),
        point_regions: vec![PointRegion::Outside; cloud.len()],
        labeled_area: LabeledArea::AsPoints,
        points_left_out,
        cloud,
    };
    let mut description = DatasetDescription {
        id: input.to_owned(),
        format: "file".to_owned(),
        root: None,
        annotated: AnnotatedClasses::Only(Vec::new()),
        sensor_height_m: KITTI_SENSOR_HEIGHT_M,
        sensor: KITTI_SENSOR.to_owned(),
        licence: None,
        checksum: None,
        simulation: None,
    };
    let mounting = open_options(source, &ClassTable::default())?.of_files().mounting;
    mounting.describe(&mut description);
    mounting.move_scan(&mut scan);
    let stated = Stated::by_options(source);
    let (name, of_data_set, folders_around) = (input.to_owned(), Vec::new(), folders_around(path));
    Ok(OpenedScan { name, scan, description, stated, of_data_set, folders_around })
}

/// The index among `scan_ids` of the scan that is called `id`, by its drive and number or by its number alone.
fn find_scan(id: Option<&str>, scan_ids: &[ScanId], dataset: &str) -> Result<usize, Usage> {
    let extent = match scan_ids {
        [] => "it has no scans".to_owned(),
        [only] => format!("it has only {only}"),
        [first, .., last] => format!("it has {} scans from {first} to {last}", scan_ids.len()),
    };
    let Some(id) = id else {
        return Err(Usage(format!("choose a scan of {dataset:?} with --scan: {extent}")));
    };
    let (sequence, number) = match id.rsplit_once('/') {
        Some((sequence, number)) => (Some(sequence), number),
        None => (None, id),
    };
    let is_meant = |it: &ScanId| {
        number.parse() == Ok(it.index) && sequence.is_none_or(|sequence| sequence == it.sequence)
    };
    let meant: Vec<usize> = (0..scan_ids.len()).filter(|&scan_idx| is_meant(&scan_ids[scan_idx])).collect();
    match meant[..] {
        [scan_idx] => Ok(scan_idx),
        [] => Err(Usage(format!("{dataset:?} has no scan {id:?}: {extent}"))),
        [first, second, ..] => {
            let (first, second) = (&scan_ids[first], &scan_ids[second]);
            Err(Usage(format!("{dataset:?} has several scans {id:?}, such as {first} and {second}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(id: Option<&str>, expected: Result<usize, &str>) {
        let scan_id = |sequence: &str, index| ScanId { sequence: sequence.to_owned(), index };
        let scan_ids = [scan_id("0000", 0), scan_id("0000", 7), scan_id("0001", 0)];
        let found = find_scan(id, &scan_ids, "drive").map_err(|error| error.to_string());
        assert_eq!(found, expected.map_err(str::to_owned));
    }

    #[test]
    fn a_scan_is_found_by_drive_and_number_or_by_a_number_that_is_its_own() {
        check(Some("0001/000000"), Ok(2));
        check(Some("0000/7"), Ok(1));
        check(Some("000007"), Ok(1));
    }

    #[test]
    fn what_is_no_scan_or_several_is_refused() {
        check(
            None,
            Err("choose a scan of \"drive\" with --scan: it has 3 scans from 0000/000000 to 0001/000000"),
        );
        check(Some("0"), Err("\"drive\" has several scans \"0\", such as 0000/000000 and 0001/000000"));
        for id in ["8", "0001/7", "first", "", "/", "-1", "0000/"] {
            let expected =
                format!("\"drive\" has no scan {id:?}: it has 3 scans from 0000/000000 to 0001/000000");
            check(Some(id), Err(&expected));
        }
    }
}
