//! A folder of objects: it has a folder for each class, and these have a file for each object.
//!
//! ```text
//! car/100.npy, .pcd, .ply, .bin, .las or .laz   a car; its name is car/100.npy
//! tree/…                                        trees
//! objects.json                                  optional: that they are simulated, and how each was seen
//! ```

use std::path::{Path, PathBuf};

use detector::PointCloud;
use reports::vocabulary::partial_class::PartialClass;

use super::ObjectCloud;
use super::class_of_folder::class_of_folder;
use super::growing_cloud::GrowingCloud;
use super::object_cloud_set::{ObjectCloudSet, ObjectSetDescription};
use super::object_sheet::{OBJECT_SHEET, ObjectSheet};
use crate::dataset::DatasetError;
use crate::dataset::on_disk::{entries_of, name_of, names_of};
use crate::dataset::point_columns::PointColumns;
use crate::dataset::scan_columns::ScanColumns;
use crate::dataset::scan_folder::any_scan_file::{SCAN_EXTENSIONS, read_scan_file, scan_extension};
use crate::dataset::scan_folder::scan_file::ScanPoints;
use crate::dataset::shown_name::shown;

/// Heights of the lowest point of an object that are taken as heights above the ground, in metres.
///
/// No part of an object lies deep in the ground, and no object on the ground has its lowest point high above it: other
/// heights are counted not from the ground, but from a sensor or the sea.
const LOWEST_POINTS_M: std::ops::RangeInclusive<f64> = -0.5..=6.0;

/// An open folder of objects: the names of the files are in memory.
#[derive(Debug)]
pub struct ClassFolders {
    // Invariant: `classes` and `files` have the same length and order.
    description: ObjectSetDescription,
    classes: Vec<PartialClass>,
    files: Vec<ObjectFile>,
    columns: ScanColumns,
    sheet: ObjectSheet,
}

#[derive(Debug)]
struct ObjectFile {
    name: String,
    path: PathBuf,
}

/// Whether `root` has a folder of clouds that is named after a class: folders of objects have, data sets have not.
pub fn has_class_folder(root: &Path) -> bool {
    let holds_clouds =
        |folder: &Path| entries(folder).is_ok_and(|it| it.iter().any(|(_, file)| is_cloud(file)));
    entries(root).is_ok_and(|folders| {
        folders.iter().any(|(name, path)| class_of_folder(name).is_some() && holds_clouds(path))
    })
}

/// Opens the folder of objects at `root`. Objects are in the order of the names of their folders and files. `columns` are
/// those of files that do not name them, from the user.
pub fn open_class_folders(root: &Path, columns: Option<PointColumns>) -> Result<ClassFolders, DatasetError> {
    let folders = entries(root)?.into_iter().filter(|(_, path)| path.is_dir()).collect::<Vec<_>>();
    if folders.is_empty() {
        return Err(DatasetError::damaged(root, "has no folders of classes, such as car or tree"));
    }
    let unknown: Vec<String> =
        folders.iter().map(|(name, _)| name.clone()).filter(|name| class_of_folder(name).is_none()).collect();
    if !unknown.is_empty() {
        return Err(DatasetError::Usage(format!(
            "{root:?} has folders that are called after no class: {}; classes are {}, and names of annotations",
            shown(&unknown.join(", ")),
            PartialClass::ALL.map(PartialClass::name).join(", ")
        )));
    }
    let (mut classes, mut files) = (Vec::new(), Vec::new());
    for (folder, path) in folders {
        let clouds = entries(&path)?.into_iter().filter(|(_, file)| is_cloud(file)).collect::<Vec<_>>();
        if clouds.is_empty() {
            let endings = SCAN_EXTENSIONS.join(", ");
            let problem = format!("has no clouds of objects (files that end in {endings})");
            return Err(DatasetError::damaged(path, problem));
        }
        for (file, path) in clouds {
            classes.extend(class_of_folder(&folder));
            files.push(ObjectFile { name: format!("{folder}/{file}"), path });
        }
    }
    let sheet = ObjectSheet::in_folder(root)?;
    let whole = root.canonicalize().unwrap_or_else(|_| root.to_path_buf());
    let id = shown(&name_of(&whole)).into_owned();
    let description =
        ObjectSetDescription { id, root: Some(root.to_path_buf()), simulation: sheet.simulation.clone() };
    let paths: Vec<PathBuf> = files.iter().map(|it: &ObjectFile| it.path.clone()).collect();
    let columns = ScanColumns::new(columns, PointColumns::of_kitti(), &paths);
    Ok(ClassFolders { description, classes, files, columns, sheet })
}

impl ObjectCloudSet for ClassFolders {
    fn description(&self) -> &ObjectSetDescription {
        &self.description
    }

    fn classes(&self) -> &[PartialClass] {
        &self.classes
    }

    fn read(&self, object_idx: usize) -> Result<GrowingCloud, DatasetError> {
        let ObjectFile { name, path } = &self.files[object_idx];
        let ScanPoints { points, origin_m } = read_scan_file(path, &self.columns)?;
        let cloud = above_ground(points.into_parts().0, origin_m[2]);
        let n_points = cloud.len();
        let whole = ObjectCloud { id: name.clone(), class: self.classes[object_idx], cloud };
        let Some(seen) = self.sheet.seen.get(name) else {
            return Ok(GrowingCloud::seen_at_once(whole, None, None));
        };
        let damaged = |problem: String| DatasetError::Damaged {
            path: self.description.root.clone().unwrap_or_default().join(OBJECT_SHEET),
            problem: format!("{problem}: {name}"),
        };
        let moments = seen.moments(n_points).map_err(damaged)?;
        Ok(GrowingCloud { whole, extents_m: seen.extents_m, moments })
    }
}

/// `cloud` with heights above the ground. The heights in the file, which begin at `origin_z_m`, are used if they can be
/// such; otherwise the lowest point is taken to lie on the ground.
fn above_ground(mut cloud: PointCloud, origin_z_m: f64) -> PointCloud {
    let lowest_m = cloud.z_m().iter().copied().fold(f32::INFINITY, f32::min);
    let is_above_ground = LOWEST_POINTS_M.contains(&(f64::from(lowest_m) + origin_z_m));
    let raise_m = if is_above_ground { origin_z_m as f32 } else { -lowest_m };
    if raise_m != 0.0 {
        cloud.move_points(|[x_m, y_m, z_m]| [x_m, y_m, z_m + raise_m]);
    }
    cloud
}

fn is_cloud(path: &Path) -> bool {
    scan_extension(path).is_some() && !path.is_dir()
}

/// Names and paths of the files and folders in `folder` that are not hidden, in the order of names.
fn entries(folder: &Path) -> Result<Vec<(String, PathBuf)>, DatasetError> {
    let paths = entries_of(folder)?;
    Ok(names_of(&paths, "a name in UTF-8")?.into_iter().zip(paths).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use test_data::test_data;

    /// A folder with these files.
    fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, content).unwrap();
        }
        folder
    }

    /// Points above each other at these heights, as `.bin`.
    fn column(heights_m: &[f32]) -> Vec<u8> {
        heights_m.iter().flat_map(|z_m| [1.0, 2.0, *z_m, 0.5]).flat_map(f32::to_le_bytes).collect()
    }

    fn heights_m(folder: &Path) -> Vec<f32> {
        open_class_folders(folder, None).unwrap().read(0).unwrap().whole.cloud.z_m().to_vec()
    }

    #[test]
    fn objects_follow_each_other_as_names_do_and_other_files_are_not_looked_at() {
        let bin = column(&[0.0, 1.0]);
        let text = b"about";
        let folder = folder(&[
            ("Trees/7.bin", &bin),
            ("Trees/notes.txt", text),
            ("README.md", text),
            ("fence/b.bin", &bin),
            ("fence/a.bin", &bin),
            (".git/x.bin", &bin),
        ]);
        let objects = open_class_folders(folder.path(), None).unwrap();
        assert_eq!(objects.classes(), [PartialClass::Tree, PartialClass::Other, PartialClass::Other]);
        let ids: Vec<String> = (0..3).map(|it| objects.read(it).unwrap().whole.id).collect();
        assert_eq!(ids, ["Trees/7.bin", "fence/a.bin", "fence/b.bin"]);
        let tree = objects.read(0).unwrap();
        assert_eq!((tree.moments.len(), tree.moments[0].n_points, tree.extents_m), (1, 2, None));
        assert!(!objects.description().is_simulated());
        assert!(has_class_folder(folder.path()) && !has_class_folder(&folder.path().join("fence")));
    }

    #[track_caller]
    fn check_refused(files: &[(&str, &[u8])], parts: &[&str]) {
        let folder = folder(files);
        let error = open_class_folders(folder.path(), None)
            .and_then(|it| (0..it.classes().len()).map(|idx| it.read(idx)).collect::<Result<Vec<_>, _>>())
            .expect_err("no objects");
        for part in parts {
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn folders_that_cannot_be_understood_are_named() {
        let bin = column(&[0.0]);
        check_refused(&[], &["has no folders of classes"]);
        check_refused(&[("a.bin", &bin)], &["has no folders of classes"]);
        check_refused(&[("car/a.bin", &bin), ("tree/a.txt", b"")], &["tree\" has no clouds", "npy"]);
        check_refused(
            &[("car/a.bin", &bin), ("cra/a.bin", &bin), ("tre/a.bin", &bin)],
            &["called after no class: cra, tre;", "tree, car, pole, pedestrian, other"],
        );
        check_refused(&[("car/a.bin", b"")], &["a.bin", "no points"]);
        check_refused(&[("car/a.npy", b"npy")], &["a.npy", "is not an .npy file"]);
        check_refused(&[("car/a.bin", &bin[..5])], &["a.bin", "damaged or cut off"]);
        check_refused(&[("car/a.bin", &column(&[f32::NAN]))], &["a.bin", "position"]);
        check_refused(
            &[("car/a.bin", &bin), ("objects.json", b"[]")],
            &["objects.json", "does not describe"],
        );
        assert!(open_class_folders(Path::new("/nowhere/at/all"), None).is_err());
    }

    #[test]
    fn heights_that_do_not_begin_at_the_ground_are_lowered_to_it() {
        for (written_m, expected_m) in [
            ([0.0, 1.0], [0.0, 1.0]),
            ([2.0, 5.0], [2.0, 5.0]),
            ([-0.25, 1.0], [-0.25, 1.0]),
            ([-1.75, -0.25], [0.0, 1.5]),
            ([212.0, 214.0], [0.0, 2.0]),
        ] {
            let folder = folder(&[("car/a.bin", &column(&written_m))]);
            assert_eq!(heights_m(folder.path()), expected_m);
        }
    }

    #[test]
    fn a_sheet_says_how_objects_were_seen() {
        let seen = |moments: Vec<(usize, f64, Option<f32>)>| {
            let it = super::super::object_sheet::SeenObject { extents_m: Some([4.0, 2.0, 1.5]), moments };
            let sheet =
                ObjectSheet { simulation: None, seen: BTreeMap::from([("car/a.bin".to_owned(), it)]) };
            let (bin, sheet) = (column(&[0.0, 0.5, 1.0]), sheet.to_json());
            let folder = folder(&[("car/a.bin", &bin), (OBJECT_SHEET, sheet.as_bytes())]);
            open_class_folders(folder.path(), None).unwrap().read(0)
        };
        let car = seen(vec![(1, 0.0, Some(9.0)), (3, 0.5, None)]).unwrap();
        assert_eq!((car.seen_at(&car.moments[0]).len(), car.extents_m), (1, Some([4.0, 2.0, 1.5])));
        for wrong in [vec![], vec![(2, 0.0, None)], vec![(3, 1.0, None), (2, 2.0, None), (3, 3.0, None)]] {
            let message = seen(wrong).expect_err("not its own").to_string();
            assert!(message.contains("objects.json") && message.contains("car/a.bin"), "{message}");
        }
    }

    #[test]
    #[ignore = "needs data/object_clouds in SCANBENCH_TEST_DATA"]
    fn objects_seen_from_the_air_are_read() {
        let objects = open_class_folders(&test_data("data/object_clouds"), None).unwrap();
        let n_of = |class| objects.classes().iter().filter(|it| **it == class).count();
        assert_eq!(PartialClass::ALL.map(n_of), [50, 50, 50, 0, 50]);
        for object_idx in 0..objects.classes().len() {
            let object = objects.read(object_idx).unwrap().whole;
            let lowest_m = object.cloud.z_m().iter().copied().fold(f32::INFINITY, f32::min);
            assert!(object.cloud.len() > 100 && lowest_m == 0.0, "{}", object.id);
        }
    }
}
