//! Opens the data set that the user names.

use std::collections::BTreeSet;
use std::path::Path;

use super::catalogue::{Catalogue, CatalogueEntry};
use super::class_table::ClassRules;
use super::data_sheet::{DataSheet, LabeledRegion};
use super::dataset_format::DatasetFormat;
use super::detect_format::{FoundDataset, detect_format};
use super::formats::entry_of;
use super::kitti::scan_list::read_scan_list;
use super::mounting::Mounting;
use super::on_disk::stem_of;
use super::point_columns::PointColumns;
use super::root_template::UnsetVariable;
use super::shown_name::is_printable;
use super::source::{ChosenParts, DamagePolicy, DatasetSource, StatedBy, TopicChoice};
use super::{Dataset, DatasetError};
use reports::run_folder::command_line::shell_word;

/// How to open a data set, beyond the settings of the catalogue.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// The format of a data set at a path; without it, the files show the format.
    pub format: Option<DatasetFormat>,
    /// The topics of a recording; without them, those of the catalogue, or the only ones.
    pub topics: TopicChoice,
    /// Handling of damaged parts that others do not depend on.
    pub damage: DamagePolicy,
    /// Classes of the names in labels, from the user; they override the catalogue.
    pub classes: ClassRules,
    /// The columns of points in files that do not name them, from the user; they override the catalogue.
    pub columns: Option<PointColumns>,
    /// The mounting of the sensor, from the user; it overrides all others.
    pub mounting: Mounting,
}

impl ReadOptions {
    /// The user's classes of names for the data set `id_or_path`, from these options and from the catalogue.
    pub fn classes_of<S>(&self, id_or_path: &str, catalogue: &Catalogue<S>) -> ClassRules {
        let of_entry = catalogue.recorded.get(id_or_path).map(|entry| &entry.classes);
        let table = of_entry.map_or_else(|| self.classes.table.clone(), |it| self.classes.table.or(it));
        ClassRules { table, ..self.classes.clone() }
    }
}

/// Opens the data set `id_or_path` of the catalogue or, if it has none, the one at this path.
///
/// A folder with the name of a catalogued data set is reached as `./name`. At a path the format is detected, among all or
/// only `format`; properties that the files do not state (the classes and the height of the sensor) are taken from the
/// benchmark of the format.
pub fn open_recorded<S>(
    id_or_path: &str,
    options: &ReadOptions,
    catalogue: &Catalogue<S>,
) -> Result<Box<dyn Dataset>, DatasetError> {
    let dataset = open_named(id_or_path, options, catalogue)?;
    check_names(&*dataset)?;
    Ok(options.mounting.clone().of(dataset))
}

/// Makes sure that no two scans have the same name, and that the names of data set and drives can be shown.
fn check_names(dataset: &dyn Dataset) -> Result<(), DatasetError> {
    let description = dataset.description();
    let path = || description.root.clone().unwrap_or_default();
    let check_printable = |kind: &'static str, name: &str| {
        if name.chars().all(is_printable) {
            return Ok(());
        }
        let path = path();
        let message = format!("{path:?}: the {kind} {name:?} has a control character in its name; rename it");
        Err(DatasetError::Unsound(message))
    };
    check_printable("data set", &description.id)?;
    let mut seen = BTreeSet::new();
    for id in dataset.scan_ids() {
        check_printable("drive", &id.sequence)?;
        if !seen.insert((&id.sequence, id.index)) {
            return Err(DatasetError::same_name("scans", &id.to_string(), &[&path()]));
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
    if let Some(asked_for) = options.format.filter(|it| *it != entry.format) {
        return Err(DatasetError::other_format(id, entry.format.name(), asked_for.name()));
    }
    let by_us = entry.download.as_ref().map(|_| format!(", or scanbench data get {}", shell_word(id)));
    let by_us = by_us.unwrap_or_default();
    let download = entry.url.as_ref().map_or_else(String::new, |it| format!(" (download: {it}{by_us})"));
    let root = entry.root.expand(|name| std::env::var_os(name)).map_err(|UnsetVariable(variable)| {
        DatasetError::Unsound(format!("the folder of {id:?} is not known: set {variable} to it{download}"))
    })?;
    if !root.exists() {
        let remedy = match entry.root.variable() {
            Some(variable) => format!("set {variable} to its folder"),
            None => "correct its root in the catalogue".to_owned(),
        };
        return Err(DatasetError::Unsound(format!("{id:?} is not at {root:?}: {remedy}{download}")));
    }
    refuse_two_of_a_name(id, &root)?;
    let path = detect_format(&root, &[entry.format])?.path;
    let mut parts = entry.parts.clone();
    if let Some(list) = &entry.scan_list {
        let list = root.join(list);
        if !list.exists() {
            return Err(DatasetError::Unsound(format!(
                "the data set {id:?} reads the numbers of its scans, one a line, from {list:?}, which does not exist; put the list \
                 there"
            )));
        }
        parts.scans = Some(read_scan_list(&list)?);
    }
    let source = DatasetSource {
        id: id.to_owned(),
        path,
        parts,
        annotated: entry.annotated.clone(),
        sensor_height_m: entry.sensor_height_m,
        sensor: entry.sensor.clone(),
        licence: entry.licence.clone(),
        stated_by: StatedBy::Catalogue,
        labeled_region: LabeledRegion::Camera,
        simulation: None,
        damage: options.damage,
        classes: options.classes.clone(),
        columns: options.columns.clone().or_else(|| entry.columns.clone()),
    };
    let dataset = open_source(source, entry.format, options)?;
    match (&entry.checksum, &dataset.description().checksum) {
        (Some(expected), Some(found)) if expected != found => {
            let message = format!("{id:?} has checksum {found}, the catalogue says {expected}");
            Err(DatasetError::Unsound(message))
        }
        _ => Ok(dataset),
    }
}

/// Fails if a folder here has the name of the data set, since the user may mean the folder.
fn refuse_two_of_a_name(id: &str, root: &Path) -> Result<(), DatasetError> {
    let here = Path::new(id);
    let is_another = here.is_dir() && here.canonicalize().ok() != root.canonicalize().ok();
    if is_another { Err(DatasetError::two_of_a_name(id, root)) } else { Ok(()) }
}

fn open_path<S>(
    path: &str,
    options: &ReadOptions,
    catalogue: &Catalogue<S>,
) -> Result<Box<dyn Dataset>, DatasetError> {
    let is_a_word = !path.contains(std::path::is_separator);
    if is_a_word && !Path::new(path).exists() {
        let known: Vec<String> = catalogue.groups.keys().chain(catalogue.ids()).cloned().collect();
        return Err(DatasetError::unknown_dataset(path, &known));
    }
    let formats = options.format.map_or_else(|| DatasetFormat::ALL.to_vec(), |format| vec![format]);
    let found = detect_format(Path::new(path), &formats)?;
    let benchmark = entry_of(found.format).benchmark;
    let source = DatasetSource {
        id: name_of(&found),
        path: found.path,
        parts: ChosenParts::default(),
        annotated: benchmark.annotated(),
        sensor_height_m: benchmark.sensor_height_m,
        sensor: benchmark.sensor.to_owned(),
        licence: None,
        stated_by: StatedBy::Nobody,
        labeled_region: LabeledRegion::Camera,
        simulation: None,
        damage: options.damage,
        classes: options.classes.clone(),
        columns: options.columns.clone(),
    };
    open_source(source, found.format, options)
}

fn open_source(
    mut source: DatasetSource,
    format: DatasetFormat,
    options: &ReadOptions,
) -> Result<Box<dyn Dataset>, DatasetError> {
    source.parts.topics = options.topics.or(&source.parts.topics);
    if let Some(sheet) = DataSheet::in_folder(&source.path)? {
        source.take_sheet(sheet);
    }
    (entry_of(format).open)(source)
}

/// The name of the folder, or of the one above if it is named after its split.
fn name_of(found: &FoundDataset) -> String {
    // A recording is named after its file.
    if found.path.is_file() {
        return stem_of(&found.path);
    }
    // A relative folder may end in `..` or be `.`, which is no name.
    let folder = found.path.canonicalize().unwrap_or_else(|_| found.path.clone());
    let mut names = folder.ancestors().filter_map(|it| it.file_name()).map(|name| name.to_string_lossy());
    let name = names.find(|name| name != "training" && name != "testing");
    name.map_or_else(|| found.format.to_string(), Into::into)
}
