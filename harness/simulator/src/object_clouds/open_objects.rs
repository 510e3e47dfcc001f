//! Sets of objects by the name that the user gives: simulated, a folder for each class, or cut out of a data set.

use std::path::Path;

use scans::dataset::DatasetError;
use scans::object_cloud::class_folders::{has_class_folder, open_class_folders};
use scans::object_cloud::cut_out::CutOutParams;
use scans::object_cloud::cut_out_objects::{Registration, cut_out_objects};
use scans::object_cloud::object_cloud_set::ObjectCloudSet;

use super::simulated_objects::{OBJECT_SETS, ObjectPart, open_simulated_objects};
use crate::catalogue::Catalogue;
use crate::open::{OpenOptions, open_dataset};

/// Which objects are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectOptions {
    /// Which part of simulated objects.
    pub part: ObjectPart,
    /// How many objects of each class are simulated.
    pub n_per_class: u32,
    /// Whether objects that are cut out of a data set are put together from all scans that show them.
    pub registration: Registration,
    /// How objects are cut out of a data set.
    pub cut_out: CutOutParams,
}

/// Source of objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObjectSource {
    /// One of [`OBJECT_SETS`].
    Simulated,
    /// A folder with a folder for each class.
    ClassFolders,
    /// A data set, recorded or simulated, if there is one.
    Dataset,
}

impl ObjectSource {
    /// Source of the objects called `name_or_path`, as [`open_objects`] takes it.
    pub fn of(name_or_path: &str) -> Self {
        if OBJECT_SETS.contains(&name_or_path) {
            Self::Simulated
        } else if has_class_folder(Path::new(name_or_path)) {
            Self::ClassFolders
        } else {
            Self::Dataset
        }
    }
}

/// Opens the objects called `name_or_path`: one of [`OBJECT_SETS`], a folder with a folder for each class, or else the
/// annotated objects of all scans of a data set, as [`open_dataset`] opens it.
pub fn open_objects(
    name_or_path: &str,
    options: &ObjectOptions,
    dataset_options: &OpenOptions,
    catalogue: &Catalogue,
) -> Result<Box<dyn ObjectCloudSet>, DatasetError> {
    let path = Path::new(name_or_path);
    match ObjectSource::of(name_or_path) {
        ObjectSource::Simulated => {
            let objects = open_simulated_objects(name_or_path, options.part, options.n_per_class)?;
            return Ok(Box::new(objects));
        }
        ObjectSource::ClassFolders => {
            return Ok(Box::new(open_class_folders(path, dataset_options.columns.clone())?));
        }
        ObjectSource::Dataset => {}
    }
    match open_dataset(name_or_path, dataset_options, catalogue) {
        Ok(dataset) => {
            let all: Vec<usize> = (0..dataset.scan_ids().len()).collect();
            let objects = cut_out_objects(dataset.as_ref(), &all, options.registration, &options.cut_out)?;
            Ok(Box::new(objects))
        }
        // Not a data set either: the error of its class folders says more.
        Err(DatasetError::UnrecognizedFormat { .. }) => {
            Ok(Box::new(open_class_folders(path, dataset_options.columns.clone())?))
        }
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::built_in_catalogue;
    use reports::vocabulary::partial_class::PartialClass;

    fn open(name_or_path: &str) -> Result<Box<dyn ObjectCloudSet>, DatasetError> {
        let options = ObjectOptions {
            part: ObjectPart::Development,
            n_per_class: 2,
            registration: Registration::EachScan,
            cut_out: CutOutParams::USUAL,
        };
        let scans = OpenOptions { n_simulated_scans: Some(1), ..OpenOptions::default() };
        open_objects(name_or_path, &options, &scans, &built_in_catalogue().unwrap())
    }

    #[test]
    fn simulated_objects_folders_and_streets_are_opened_by_their_names() {
        let simulated = open("objects-vlp-16").unwrap();
        assert_eq!((simulated.classes().len(), simulated.description().is_simulated()), (10, true));
        let street = open("street-main-road").unwrap();
        assert!(street.description().is_simulated() && street.description().id == "street-main-road");
        for class in [PartialClass::Tree, PartialClass::Car, PartialClass::Pole] {
            assert!(street.classes().contains(&class), "{class}");
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("cars")).unwrap();
        std::fs::write(folder.path().join("cars/1.bin"), [0; 16]).unwrap();
        let path = folder.path().to_str().unwrap();
        assert_eq!(open(path).unwrap().classes(), open_class_folders(folder.path(), None).unwrap().classes());
    }

    #[test]
    fn what_is_no_set_of_objects_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_str().unwrap();
        let message = |name: &str| open(name).err().expect("no objects").to_string();
        assert!(message("objects-everywhere").contains("objects-everywhere"));
        assert!(message(path).contains("no folders of classes"), "{}", message(path));
        std::fs::create_dir(folder.path().join("cra")).unwrap();
        std::fs::write(folder.path().join("cra/1.bin"), [0; 16]).unwrap();
        assert!(message(path).contains("called after no class: cra"), "{}", message(path));
    }
}
