//! From what the user names to an open data set.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

use reports::vocabulary::class::AnnotationClass;

use super::argoverse2::sensor_logs::{
    ARGOVERSE2_CLASSES, ARGOVERSE2_SENSOR, ARGOVERSE2_SENSOR_HEIGHT_M, open_argoverse2,
};
use super::catalogue::{Catalogue, CatalogueEntry, CataloguedParts, KITTI_SENSOR};
use super::class_table::ClassRules;
use super::data_sheet::{DataSheet, LabeledRegion};
use super::dataset_format::DatasetFormat;
use super::detect_format::{FoundDataset, detect_format};
use super::kitti::label::KITTI_CLASSES;
use super::kitti::object::open_kitti_object;
use super::kitti::scan_list::read_scan_list;
use super::kitti::split_folder::KITTI_SENSOR_HEIGHT_M;
use super::kitti::tracking::open_kitti_tracking;
use super::kitti_raw::drives::open_kitti_raw;
use super::mcap::mcap_dataset::open_mcap;
use super::mcap::topics::TopicChoice;
use super::mounting::Mounting;
use super::nuscenes::keyframes::{
    NUSCENES_CLASSES, NUSCENES_SENSOR, NUSCENES_SENSOR_HEIGHT_M, open_nuscenes,
};
use super::root_template::UnsetVariable;
use super::scan_folder::folder::open_scan_folder;
use super::semantic_kitti::sequence::open_semantic_kitti;
use super::shown_name::is_printable;
use super::source::{DamagePolicy, DatasetSource, StatedBy};
use super::velodyne_capture::revolutions::open_velodyne_capture;
use super::{AnnotatedClasses, Dataset, DatasetError};

/// How a data set is opened other than the catalogue says.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// The format of a data set at a path; the files tell otherwise.
    pub format: Option<DatasetFormat>,
    /// The topics of a recording; the catalogue's or the only ones are taken else.
    pub topics: TopicChoice,
    /// What becomes of damaged parts that others do not depend on.
    pub damage: DamagePolicy,
    /// What the names of classes in labels stand for, as the user says; has the last word over the catalogue.
    pub classes: ClassRules,
    /// How the sensor is mounted, as the user says; has the last word.
    pub mounting: Mounting,
}

impl ReadOptions {
    /// What the user says about the names of classes in the data set that is called `id_or_path`, here and in the catalogue.
    pub fn classes_of<S>(&self, id_or_path: &str, catalogue: &Catalogue<S>) -> ClassRules {
        let of_entry = catalogue.recorded.get(id_or_path).map(|entry| &entry.classes);
        let table = of_entry.map_or_else(|| self.classes.table.clone(), |it| self.classes.table.or(it));
        ClassRules { table, ..self.classes.clone() }
    }
}

/// Opens the data set on disk that the catalogue calls `id_or_path`, or else the one at that path.
///
/// A folder that has the name of a catalogued data set is reached as `./name`. At a path the format is detected unless
/// `format` says what to look for; what the files do not say (the classes and the height of the sensor) is taken to be
/// as in the benchmark of the format.
pub fn open_recorded<S>(
    id_or_path: &str,
    options: &ReadOptions,
    catalogue: &Catalogue<S>,
) -> Result<Box<dyn Dataset>, DatasetError> {
    let dataset = open_named(id_or_path, options, catalogue)?;
    check_names(&*dataset)?;
    Ok(options.mounting.clone().of(dataset))
}

/// Makes sure that scans can be told apart, and that the names of data set and drives can be shown.
fn check_names(dataset: &dyn Dataset) -> Result<(), DatasetError> {
    let description = dataset.description();
    let path = || description.root.clone().unwrap_or_default();
    let check_printable = |kind: &'static str, name: &str| {
        if name.chars().all(is_printable) {
            return Ok(());
        }
        Err(DatasetError::UnprintableName { path: path(), kind, name: name.to_owned() })
    };
    check_printable("data set", &description.id)?;
    let mut seen = BTreeSet::new();
    for id in dataset.scan_ids() {
        check_printable("drive", &id.sequence)?;
        if !seen.insert((&id.sequence, id.index)) {
            let name = id.to_string();
            return Err(DatasetError::SameName { kind: "scans", name, paths: vec![path()] });
        }
    }
    Ok(())
}

fn open_named<S>(
    id_or_path: &str,
    options: &ReadOptions,
    catalogue: &Catalogue<S>,
) -> Result<Box<dyn Dataset>, DatasetError> {
    match catalogue.recorded.get(id_or_path) {
        Some(entry) => {
            let catalogued = entry.annotated.clone();
            let classes = ClassRules { catalogued, ..options.classes_of(id_or_path, catalogue) };
            open_catalogued(id_or_path, entry, &ReadOptions { classes, ..options.clone() })
        }
        None => open_path(id_or_path, options, catalogue),
    }
}

fn open_catalogued(
    id: &str,
    entry: &CatalogueEntry,
    options: &ReadOptions,
) -> Result<Box<dyn Dataset>, DatasetError> {
    let catalogued = entry.parts.format();
    if let Some(asked_for) = options.format
        && asked_for != catalogued
    {
        return Err(DatasetError::FormatContradictsCatalogue {
            id: id.to_owned(),
            catalogued: catalogued.to_string(),
            asked_for: asked_for.to_string(),
        });
    }
    let root = entry.root.expand(|name| std::env::var_os(name)).map_err(|UnsetVariable(variable)| {
        DatasetError::UnsetVariable { id: id.to_owned(), variable, url: entry.url.clone() }
    })?;
    if !root.exists() {
        let remedy = match entry.root.variable() {
            Some(variable) => format!("set {variable} to its folder"),
            None => "correct its root in the catalogue".to_owned(),
        };
        return Err(DatasetError::MissingRoot { id: id.to_owned(), root, remedy, url: entry.url.clone() });
    }
    let source = DatasetSource {
        id: id.to_owned(),
        path: detect_format(&root, &[catalogued])?.path,
        annotated: entry.annotated.clone(),
        sensor_height_m: entry.sensor_height_m,
        sensor: entry.sensor.clone(),
        licence: entry.licence.clone(),
        stated_by: StatedBy::Catalogue,
        labeled_region: LabeledRegion::Camera,
        simulation: None,
        damage: options.damage,
        classes: options.classes.clone(),
    };
    let parts = match &entry.scan_list {
        None => entry.parts.clone(),
        Some(list) => {
            let path = root.join(list);
            if !path.exists() {
                return Err(DatasetError::MissingScanList { id: id.to_owned(), path });
            }
            CataloguedParts::KittiObject { scans: Some(read_scan_list(&path)?) }
        }
    };
    let dataset = open_parts(source, &parts, &options.topics)?;
    match (&entry.checksum, &dataset.description().checksum) {
        (Some(expected), Some(found)) if expected != found => Err(DatasetError::Checksum {
            id: id.to_owned(),
            expected: expected.clone(),
            found: found.clone(),
        }),
        _ => Ok(dataset),
    }
}

fn open_path<S>(
    path: &str,
    options: &ReadOptions,
    catalogue: &Catalogue<S>,
) -> Result<Box<dyn Dataset>, DatasetError> {
    let is_a_word = !path.contains(std::path::is_separator);
    if is_a_word && !Path::new(path).exists() {
        let known = catalogue.groups.keys().chain(catalogue.ids()).cloned().collect();
        return Err(DatasetError::UnknownDataset { name: path.to_owned(), known });
    }
    let formats = options.format.map_or_else(|| DatasetFormat::ALL.to_vec(), |format| vec![format]);
    let found = detect_format(Path::new(path), &formats)?;
    let (sensor, sensor_height_m) = match found.format {
        DatasetFormat::Argoverse2 => (ARGOVERSE2_SENSOR, ARGOVERSE2_SENSOR_HEIGHT_M),
        DatasetFormat::NuScenes => (NUSCENES_SENSOR, NUSCENES_SENSOR_HEIGHT_M),
        _ => (KITTI_SENSOR, KITTI_SENSOR_HEIGHT_M),
    };
    let source = DatasetSource {
        id: name_of(&found),
        path: found.path,
        annotated: annotated_by(found.format),
        sensor_height_m,
        sensor: sensor.to_owned(),
        licence: None,
        stated_by: StatedBy::Nobody,
        labeled_region: LabeledRegion::Camera,
        simulation: None,
        damage: options.damage,
        classes: options.classes.clone(),
    };
    open_parts(source, &CataloguedParts::all(found.format), &options.topics)
}

/// What the benchmark of the format annotates.
fn annotated_by(format: DatasetFormat) -> AnnotatedClasses {
    match format {
        DatasetFormat::KittiTracking | DatasetFormat::KittiObject | DatasetFormat::KittiRaw => {
            AnnotatedClasses::Only(KITTI_CLASSES.to_vec())
        }
        // Every point has a label, and those that leave open whether they are an object are not judged.
        DatasetFormat::SemanticKitti => AnnotatedClasses::EveryObject,
        DatasetFormat::Argoverse2 => AnnotatedClasses::Only(ARGOVERSE2_CLASSES.to_vec()),
        DatasetFormat::NuScenes => AnnotatedClasses::Only(NUSCENES_CLASSES.to_vec()),
        // Whoever labels a recording labels its vehicles; whether everything else too, nobody said.
        DatasetFormat::Mcap | DatasetFormat::VelodynePcap | DatasetFormat::ScanFolder => {
            AnnotatedClasses::Only(AnnotationClass::ALL.to_vec())
        }
    }
}

fn open_parts(
    mut source: DatasetSource,
    parts: &CataloguedParts,
    topics: &TopicChoice,
) -> Result<Box<dyn Dataset>, DatasetError> {
    if let Some(sheet) = DataSheet::in_folder(&source.path)? {
        source.take_sheet(sheet);
    }
    Ok(match parts {
        CataloguedParts::KittiTracking { sequences } => {
            Box::new(open_kitti_tracking(source, sequences.as_ref())?)
        }
        CataloguedParts::KittiObject { scans } => Box::new(open_kitti_object(source, scans.as_ref())?),
        CataloguedParts::SemanticKitti { sequences } => {
            Box::new(open_semantic_kitti(source, sequences.as_ref())?)
        }
        CataloguedParts::Argoverse2 { sequences } => Box::new(open_argoverse2(source, sequences.as_ref())?),
        CataloguedParts::KittiRaw { sequences } => Box::new(open_kitti_raw(source, sequences.as_ref())?),
        CataloguedParts::NuScenes { sequences } => Box::new(open_nuscenes(source, sequences.as_ref())?),
        CataloguedParts::VelodynePcap => Box::new(open_velodyne_capture(source)?),
        CataloguedParts::ScanFolder => Box::new(open_scan_folder(source)?),
        CataloguedParts::Mcap(catalogued) => {
            let choice = TopicChoice {
                cloud: topics.cloud.clone().or_else(|| catalogued.cloud.clone()),
                annotations: topics.annotations.clone().or_else(|| catalogued.annotations.clone()),
            };
            Box::new(open_mcap(source, &choice)?)
        }
    })
}

/// The name of the folder, or of the one above if it is only called after its split.
fn name_of(found: &FoundDataset) -> String {
    // A relative folder may end in `..` or be `.`, which is no name.
    let folder = found.path.canonicalize().unwrap_or_else(|_| found.path.clone());
    let mut names = folder.ancestors().filter_map(|it| it.file_name()).map(|name| name.to_string_lossy());
    let name = names.find(|name| name != "training" && name != "testing");
    // A recording is called after its file.
    let name = if found.path.is_file() {
        Path::new(&found.path).file_stem().map(|it| it.to_string_lossy())
    } else {
        name
    };
    name.map_or_else(|| found.format.to_string(), Cow::into_owned)
}
