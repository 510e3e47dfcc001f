//! Objects written as a folder for each class with a `.npy` file for each object.

use std::collections::BTreeMap;
use std::path::Path;

use detector::PointCloud;

use super::ConversionError;
use super::whole_folder::WholeFolder;
use crate::dataset::scan_folder::any_scan_file::scan_extension;
use crate::object_cloud::object_cloud_set::ObjectCloudSet;
use crate::object_cloud::object_sheet::{OBJECT_SHEET, ObjectSheet, SeenObject};

/// Writes all of `objects` to the folder `target`, which must not exist: `CLASS/ID.npy`, rows of x, y, z in metres and the
/// intensity, and `objects.json`, which says whether they are simulated and how each was seen.
pub fn write_object_folder(objects: &dyn ObjectCloudSet, target: &Path) -> Result<(), ConversionError> {
    let folder = WholeFolder::create(target)?;
    let mut seen = BTreeMap::new();
    for object_idx in 0..objects.classes().len() {
        let object = objects.read(object_idx)?;
        let name = format!("{}/{}.npy", object.whole.class, file_stem(&object.whole.id));
        folder.write(&name, &npy(&object.whole.cloud))?;
        seen.insert(name, SeenObject::of(object.extents_m, &object.moments));
    }
    let sheet = ObjectSheet { simulation: objects.description().simulation.clone(), seen };
    folder.write(OBJECT_SHEET, sheet.to_json().as_bytes())?;
    folder.finish()
}

/// The name of a file without its ending. Ids that were read from a folder have a folder and an ending of their own.
fn file_stem(id: &str) -> String {
    let path = Path::new(id);
    let stem = if scan_extension(path).is_some() { path.with_extension("") } else { path.to_path_buf() };
    stem.to_string_lossy().replace('/', "-")
}

/// A file of `NumPy` with a row for each point.
fn npy(cloud: &PointCloud) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let described = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, 4), }}", cloud.len());
    // The values begin at a multiple of 64 bytes.
    let n_before = MAGIC.len() + 2 + described.len() + 1;
    let padding = " ".repeat(n_before.next_multiple_of(64) - n_before);
    let header = format!("{described}{padding}\n");
    let mut file = [MAGIC, &(header.len() as u16).to_le_bytes(), header.as_bytes()].concat();
    for ([x, y, z], intensity) in cloud.positions_m().zip(cloud.intensity()) {
        file.extend([x, y, z, *intensity].into_iter().flat_map(f32::to_le_bytes));
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object_cloud::class_folders::open_class_folders;

    #[test]
    fn folders_of_objects_are_written_again_under_the_names_of_classes() {
        let parent = tempfile::tempdir().unwrap();
        let (from, to) = (parent.path().join("from"), parent.path().join("to"));
        for (name, z_m) in [("Cars/a.bin", 1.0_f32), ("vans/a.bin", 2.0), ("hedge/a.bin", 3.0)] {
            let path = from.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            let point = [0.5, 0.25, z_m, 0.75];
            std::fs::write(path, point.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>()).unwrap();
        }
        write_object_folder(&open_class_folders(&from, None).unwrap(), &to).unwrap();
        let written = open_class_folders(&to, None).unwrap();
        let objects = (0..3).map(|it| written.read(it).unwrap().whole);
        let found: Vec<_> =
            objects.map(|it| (it.id, it.cloud.position_m(0)[2], it.cloud.intensity()[0])).collect();
        let expected = [("car/Cars-a.npy", 1.0), ("car/vans-a.npy", 2.0), ("other/hedge-a.npy", 3.0)];
        assert_eq!(found, expected.map(|(id, z_m)| (id.to_owned(), z_m, 0.75)));
        assert!(!written.description().is_simulated());
    }
}
