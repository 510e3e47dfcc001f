//! The catalogue of data sets, `datasets.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path};

use serde::Deserialize;
use toml::Spanned;

use super::class_table::{ClassTable, class_of_word};
use super::dataset_format::DatasetFormat;
use super::mcap::topics::TopicChoice;
use super::root_template::RootTemplate;
use super::shown_name::is_printable;
use super::simulated_street::StreetDrive;
use super::text_file::read_text_file;
use super::{AnnotatedClasses, DatasetError};
use crate::simulator::rain::RAIN_RATES_MM_PER_H;

/// How high a simulated sensor may be mounted above the road, in metres.
const SENSOR_HEIGHTS_M: std::ops::RangeInclusive<f32> = 0.3..=5.0;

/// The catalogue that is part of the program.
const BUILT_IN: &str = include_str!("../../../datasets.toml");

/// The sensor of the KITTI recordings.
pub const KITTI_SENSOR: &str = "hdl-64e-s2";

/// What data sets there are, by id.
#[derive(Debug, Clone, PartialEq)]
pub struct Catalogue {
    /// Data sets on disk.
    pub recorded: BTreeMap<String, CatalogueEntry>,
    /// Drives through simulated streets.
    pub simulated: BTreeMap<String, StreetDrive>,
    /// Names for several data sets that are run one after the other.
    pub groups: BTreeMap<String, Vec<String>>,
}

impl Catalogue {
    /// The ids of all data sets, simulated ones first.
    pub fn ids(&self) -> impl Iterator<Item = &String> {
        self.simulated.keys().chain(self.recorded.keys())
    }

    /// The data sets that `name` stands for: those of a group, else itself.
    pub fn members<'a>(&'a self, name: &'a String) -> &'a [String] {
        self.groups.get(name).map_or(std::slice::from_ref(name), Vec::as_slice)
    }
}

/// One data set on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueEntry {
    /// Its format, and which part of it is meant.
    pub parts: CataloguedParts,
    /// Where it lies.
    pub root: RootTemplate,
    /// What its annotations cover.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor; that of KITTI unless the entry names one.
    pub sensor: String,
    /// Its licence.
    pub licence: String,
    /// Where to get it.
    pub url: String,
    /// The checksum its files must have, as [`checksum`](super::checksum) describes it.
    pub checksum: Option<String>,
    /// What names of classes in its labels stand for.
    pub classes: ClassTable,
}

/// Which part of a data set is meant, in terms of its format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CataloguedParts {
    /// KITTI tracking.
    KittiTracking {
        /// These drives, or all.
        sequences: Option<BTreeSet<String>>,
    },
    /// KITTI object.
    KittiObject {
        /// The scans of these numbers, or all.
        scans: Option<BTreeSet<u32>>,
    },
    /// SemanticKITTI.
    SemanticKitti {
        /// These drives, or all that have labels.
        sequences: Option<BTreeSet<String>>,
    },
    /// A recording.
    Mcap(TopicChoice),
    /// A folder of scans.
    ScanFolder,
    /// Argoverse 2.
    Argoverse2 {
        /// These logs, or all that have annotations.
        sequences: Option<BTreeSet<String>>,
    },
    /// KITTI raw.
    KittiRaw {
        /// These drives, such as `2011_09_26_drive_0001_sync`, or all.
        sequences: Option<BTreeSet<String>>,
    },
    /// nuScenes.
    NuScenes {
        /// These scenes, such as `scene-0061`, or all.
        sequences: Option<BTreeSet<String>>,
    },
    /// A capture of packets.
    VelodynePcap,
}

impl CataloguedParts {
    /// All of a data set in this format.
    pub fn all(format: DatasetFormat) -> Self {
        match format {
            DatasetFormat::KittiTracking => Self::KittiTracking { sequences: None },
            DatasetFormat::KittiObject => Self::KittiObject { scans: None },
            DatasetFormat::SemanticKitti => Self::SemanticKitti { sequences: None },
            DatasetFormat::Mcap => Self::Mcap(TopicChoice::default()),
            DatasetFormat::Argoverse2 => Self::Argoverse2 { sequences: None },
            DatasetFormat::KittiRaw => Self::KittiRaw { sequences: None },
            DatasetFormat::NuScenes => Self::NuScenes { sequences: None },
            DatasetFormat::VelodynePcap => Self::VelodynePcap,
            DatasetFormat::ScanFolder => Self::ScanFolder,
        }
    }

    /// The format in whose terms this is.
    pub fn format(&self) -> DatasetFormat {
        match self {
            Self::KittiTracking { .. } => DatasetFormat::KittiTracking,
            Self::KittiObject { .. } => DatasetFormat::KittiObject,
            Self::SemanticKitti { .. } => DatasetFormat::SemanticKitti,
            Self::Mcap(_) => DatasetFormat::Mcap,
            Self::ScanFolder => DatasetFormat::ScanFolder,
            Self::Argoverse2 { .. } => DatasetFormat::Argoverse2,
            Self::KittiRaw { .. } => DatasetFormat::KittiRaw,
            Self::NuScenes { .. } => DatasetFormat::NuScenes,
            Self::VelodynePcap => DatasetFormat::VelodynePcap,
        }
    }
}

/// The catalogue that is part of the program.
///
/// # Errors
///
/// [`DatasetError::Catalogue`] if its file was broken when the program was compiled.
pub fn built_in_catalogue() -> Result<Catalogue, DatasetError> {
    parse_catalogue("built-in datasets.toml", BUILT_IN)
}

/// Reads the catalogue at `path`.
///
/// # Errors
///
/// [`DatasetError::Io`], [`DatasetError::NotText`], or [`DatasetError::Catalogue`] with the line of the first mistake.
pub fn read_catalogue(path: &Path) -> Result<Catalogue, DatasetError> {
    parse_catalogue(&path.display().to_string(), &read_text_file(path)?)
}

/// Reads the catalogue in `text`, which errors call `name`.
///
/// # Errors
///
/// [`DatasetError::Catalogue`] with the line of the first mistake.
pub fn parse_catalogue(name: &str, text: &str) -> Result<Catalogue, DatasetError> {
    let source = CatalogueText { name, text };
    let written: WrittenCatalogue = toml::from_str(text)
        .map_err(|error| source.error(error.span().map_or(0, |it| it.start), error.message().to_owned()))?;
    let mut catalogue =
        Catalogue { recorded: BTreeMap::new(), simulated: BTreeMap::new(), groups: BTreeMap::new() };
    for (id, drive) in written.simulated {
        check_drive(drive.get_ref()).map_err(|problem| source.error(drive.span().start, problem))?;
        let drive = drive.into_inner();
        catalogue.simulated.insert(checked_id(&id, &source)?, drive);
    }
    for (id, entry) in written.recorded {
        let checked = checked_id(&id, &source)?;
        if catalogue.simulated.contains_key(&checked) {
            return Err(source.error(id.span().start, format!("{checked:?} is a simulated data set already")));
        }
        catalogue.recorded.insert(checked, entry_from_written(entry, &source)?);
    }
    for (id, members) in written.groups {
        let checked = checked_id(&id, &source)?;
        if let Some(unknown) =
            members.get_ref().iter().find(|member| !catalogue.ids().any(|it| it == *member))
        {
            return Err(source.error(members.span().start, format!("there is no data set {unknown:?}")));
        }
        if members.get_ref().is_empty() || catalogue.ids().any(|it| *it == checked) {
            let problem = format!("{checked:?} is empty, or a data set already");
            return Err(source.error(id.span().start, problem));
        }
        catalogue.groups.insert(checked, members.into_inner());
    }
    Ok(catalogue)
}

fn checked_id(id: &Spanned<String>, source: &CatalogueText<'_>) -> Result<String, DatasetError> {
    if id.get_ref().chars().all(|it| it.is_ascii_alphanumeric() || it == '-' || it == '_') {
        return Ok(id.get_ref().clone());
    }
    let problem = format!("{:?} is no id: only letters, digits, - and _ may be in it", id.get_ref());
    Err(source.error(id.span().start, problem))
}

fn check_drive(drive: &StreetDrive) -> Result<(), String> {
    let &StreetDrive { n_scans, turns_per_scan, scans_per_drive, .. } = drive;
    if scans_per_drive == Some(0) {
        return Err("0 scans per drive is no drive".to_owned());
    }
    if n_scans == 0 || turns_per_scan == 0 || n_scans.checked_mul(turns_per_scan).is_none() {
        return Err(format!("{n_scans} scans, {turns_per_scan} turns each, is no drive"));
    }
    if let Some(mm_per_h) = drive.rain_mm_per_h
        && !RAIN_RATES_MM_PER_H.contains(&mm_per_h)
    {
        let (least, most) = (RAIN_RATES_MM_PER_H.start(), RAIN_RATES_MM_PER_H.end());
        return Err(format!("rain_mm_per_h is {mm_per_h}, which is not within {least} to {most}"));
    }
    if let Some(height_m) = drive.sensor_height_m
        && !SENSOR_HEIGHTS_M.contains(&height_m)
    {
        let (least, most) = (SENSOR_HEIGHTS_M.start(), SENSOR_HEIGHTS_M.end());
        return Err(format!("sensor_height_m is {height_m}, which is not within {least} to {most}"));
    }
    drive.conditions.check()?;
    if let Some(limit_deg) = drive.labeled_to_either_side_deg
        && !(0.0..=180.0).contains(&limit_deg)
    {
        return Err(format!("labeled_to_either_side_deg is {limit_deg}, but a turn has 180 to either side"));
    }
    Ok(())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenCatalogue {
    #[serde(default)]
    recorded: BTreeMap<Spanned<String>, WrittenEntry>,
    #[serde(default)]
    simulated: BTreeMap<Spanned<String>, Spanned<StreetDrive>>,
    #[serde(default)]
    groups: BTreeMap<Spanned<String>, Spanned<Vec<String>>>,
}

/// An entry as it is written, with the positions of what can be wrong.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenEntry {
    format: DatasetFormat,
    root: Spanned<String>,
    sequences: Option<Spanned<BTreeSet<String>>>,
    scans: Option<Spanned<BTreeSet<u32>>>,
    topic: Option<Spanned<String>>,
    annotation_topic: Option<Spanned<String>>,
    annotated_classes: AnnotatedClasses,
    sensor_height_m: Spanned<f32>,
    #[serde(default = "kitti_sensor")]
    sensor: String,
    licence: String,
    url: String,
    checksum: Option<Spanned<String>>,
    #[serde(default)]
    classes: BTreeMap<String, Spanned<String>>,
}

fn kitti_sensor() -> String {
    KITTI_SENSOR.to_owned()
}

/// The text errors point into.
struct CatalogueText<'a> {
    name: &'a str,
    text: &'a str,
}

impl CatalogueText<'_> {
    fn error(&self, byte_offset: usize, problem: String) -> DatasetError {
        let before = self.text.as_bytes().iter().take(byte_offset);
        let line = 1 + before.filter(|byte| **byte == b'\n').count();
        DatasetError::Catalogue { catalogue: self.name.to_owned(), line, problem }
    }
}

fn entry_from_written(
    written: WrittenEntry,
    source: &CatalogueText<'_>,
) -> Result<CatalogueEntry, DatasetError> {
    let root = RootTemplate::parse(written.root.get_ref())
        .map_err(|problem| source.error(written.root.span().start, problem))?;
    let sensor_height_m = *written.sensor_height_m.get_ref();
    if !(sensor_height_m > 0.0 && sensor_height_m.is_finite()) {
        let problem = format!("sensor_height_m is {sensor_height_m}, but a sensor is above the road");
        return Err(source.error(written.sensor_height_m.span().start, problem));
    }
    if let Some(checksum) = &written.checksum
        && !is_sha256(checksum.get_ref())
    {
        let problem = format!("checksum {:?} is not 64 lower-case hexadecimal digits", checksum.get_ref());
        return Err(source.error(checksum.span().start, problem));
    }
    let texts = [("sensor", &written.sensor), ("licence", &written.licence), ("url", &written.url)];
    if let Some((field, text)) = texts.into_iter().find(|(_, it)| !it.chars().all(is_printable)) {
        let problem = format!("{field} {text:?} holds a control character");
        return Err(source.error(written.root.span().start, problem));
    }
    let mut classes = ClassTable::default();
    for (name, word) in &written.classes {
        let class = class_of_word(word.get_ref()).map_err(|it| source.error(word.span().start, it))?;
        classes.insert(name, class);
    }
    Ok(CatalogueEntry {
        parts: parts(&written, source)?,
        root,
        annotated: written.annotated_classes,
        sensor_height_m,
        sensor: written.sensor,
        licence: written.licence,
        url: written.url,
        checksum: written.checksum.map(Spanned::into_inner),
        classes,
    })
}

fn parts(written: &WrittenEntry, source: &CatalogueText<'_>) -> Result<CataloguedParts, DatasetError> {
    let format = written.format;
    let misplaced = |field: &str, byte_offset: usize| {
        source.error(byte_offset, format!("{field} cannot be chosen in the format {format}"))
    };
    let mut parts = CataloguedParts::all(format);
    if let Some(chosen) = &written.sequences {
        let (CataloguedParts::KittiTracking { sequences }
        | CataloguedParts::SemanticKitti { sequences }
        | CataloguedParts::Argoverse2 { sequences }
        | CataloguedParts::KittiRaw { sequences }
        | CataloguedParts::NuScenes { sequences }) = &mut parts
        else {
            return Err(misplaced("sequences", chosen.span().start));
        };
        if let Some(name) = chosen.get_ref().iter().find(|name| !is_file_name(name)) {
            let problem = format!("{name:?} is not the name of a folder");
            return Err(source.error(chosen.span().start, problem));
        }
        *sequences = Some(chosen.get_ref().clone());
    }
    if let Some(chosen) = &written.scans {
        let CataloguedParts::KittiObject { scans } = &mut parts else {
            return Err(misplaced("scans", chosen.span().start));
        };
        *scans = Some(chosen.get_ref().clone());
    }
    for (field, chosen) in [("topic", &written.topic), ("annotation_topic", &written.annotation_topic)] {
        let Some(chosen) = chosen else { continue };
        let CataloguedParts::Mcap(choice) = &mut parts else {
            return Err(misplaced(field, chosen.span().start));
        };
        let slot = if field == "topic" { &mut choice.cloud } else { &mut choice.annotations };
        *slot = Some(chosen.get_ref().clone());
    }
    Ok(parts)
}

/// Whether `name` is one name, that leads neither up nor elsewhere.
fn is_file_name(name: &str) -> bool {
    let mut components = Path::new(name).components();
    matches!((components.next(), components.next()), (Some(Component::Normal(only)), None) if only == name)
}

fn is_sha256(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::kitti::label::KITTI_CLASSES;
    use proptest::prelude::*;
    use reports::vocabulary::class::AnnotationClass;

    const ENTRY: &str = r#"
[recorded.my-drive]
format = "kitti-tracking"
root = "/data"
sequences = ["0003", "0001"]
annotated_classes = ["van", "car"]
sensor_height_m = 1.8
licence = "mine"
url = "https://example.org"
"#;

    #[track_caller]
    fn check_refused(from: &str, to: &str, line: usize, problem: &str) {
        let text = ENTRY.replace(from, to);
        assert_ne!(text, ENTRY, "nothing replaced");
        let error = parse_catalogue("my.toml", &text).expect_err("a mistake");
        let message = error.to_string();
        assert!(
            message.starts_with(&format!("my.toml, line {line}: ")) && message.contains(problem),
            "{message}"
        );
        assert!(error.is_usage_error());
    }

    #[test]
    fn an_entry_is_read() {
        let catalogue = parse_catalogue("my.toml", ENTRY).unwrap();
        let expected = CatalogueEntry {
            parts: CataloguedParts::KittiTracking {
                sequences: Some(BTreeSet::from(["0001".to_owned(), "0003".to_owned()])),
            },
            root: RootTemplate::parse("/data").unwrap(),
            annotated: AnnotatedClasses::Only(vec![AnnotationClass::Car, AnnotationClass::Van]),
            sensor_height_m: 1.8,
            sensor: "hdl-64e-s2".to_owned(),
            licence: "mine".to_owned(),
            url: "https://example.org".to_owned(),
            checksum: None,
            classes: ClassTable::default(),
        };
        assert_eq!(catalogue.recorded, BTreeMap::from([("my-drive".to_owned(), expected)]));
    }

    #[test]
    fn a_data_set_may_annotate_every_object() {
        let text = ENTRY.replace(r#"["van", "car"]"#, r#""every-object""#);
        let catalogue = parse_catalogue("my.toml", &text).unwrap();
        assert_eq!(catalogue.recorded["my-drive"].annotated, AnnotatedClasses::EveryObject);
    }

    #[test]
    fn the_built_in_catalogue_knows_what_kitti_annotates() {
        let catalogue = built_in_catalogue().unwrap();
        let ids: Vec<&String> = catalogue.recorded.keys().collect();
        let expected =
            ["argoverse2", "kitti-object", "kitti-raw", "kitti-tracking", "nuscenes", "semantic-kitti"];
        assert_eq!(ids, expected);
        for id in &ids[1..4] {
            let entry = &catalogue.recorded[*id];
            assert_eq!(entry.annotated, AnnotatedClasses::Only(KITTI_CLASSES.to_vec()));
        }
    }

    #[test]
    fn mistakes_are_named_with_line_and_value() {
        check_refused("kitti-tracking", "kitty", 3, "unknown variant `kitty`");
        check_refused("sensor_height_m", "sensor_heigth_m", 7, "unknown field `sensor_heigth_m`");
        check_refused("/data", "${DATA", 4, "without");
        check_refused("1.8", "-1.8", 7, "sensor_height_m is -1.8");
        check_refused("1.8", "nan", 7, "sensor_height_m is NaN");
        check_refused("1.8", "\"high\"", 7, "high");
        check_refused("\"van\"", "\"wan\"", 6, "unknown variant `wan`");
        check_refused(r#"["van", "car"]"#, "\"everything\"", 6, "\"everything\"");
        check_refused(r#"["van", "car"]"#, "[]", 6, "at least one class");
        check_refused("sequences = [\"0003\", \"0001\"]", "scans = [3]", 5, "scans cannot be chosen");
        check_refused("url", "checksum = \"12ab\"\nurl", 9, "checksum \"12ab\"");
        check_refused("\"0003\"", "\"../0003\"", 5, "\"../0003\" is not the name of a folder");
        check_refused("\"0003\"", "\"/etc\"", 5, "\"/etc\" is not the name of a folder");
        check_refused("\"0003\"", "\"\"", 5, "\"\" is not the name of a folder");
        check_refused("my-drive", "\"../drive\"", 2, "\"../drive\" is no id");
        check_refused("licence = \"mine\"", "licence = \"mine", 8, "");
    }

    #[test]
    fn names_of_classes_are_mapped() {
        let text =
            format!("{ENTRY}[recorded.my-drive.classes]\nforklift = \"misc\"\n\"Big Lorry\" = \"Truck\"\n");
        let classes = &parse_catalogue("my.toml", &text).unwrap().recorded["my-drive"].classes;
        assert_eq!(classes.get("Forklift"), Some(AnnotationClass::Misc));
        assert_eq!(classes.get("big_lorry"), Some(AnnotationClass::Truck));
        let error = parse_catalogue("my.toml", &text.replace("\"misc\"", "\"mics\"")).expect_err("no class");
        assert!(
            error.to_string().starts_with("my.toml, line 11: \"mics\" is no class; there are car, "),
            "{error}"
        );
    }

    #[test]
    fn a_group_stands_for_its_members() {
        let text = format!("{ENTRY}\n[groups]\nmine = [\"my-drive\"]");
        let catalogue = parse_catalogue("my.toml", &text).unwrap();
        assert_eq!(catalogue.members(&"mine".to_owned()), ["my-drive"]);
        assert_eq!(catalogue.members(&"other".to_owned()), ["other"]);
        let refused = |group: &str, problem: &str| {
            let text = format!("{ENTRY}\n[groups]\n{group}");
            let message = parse_catalogue("my.toml", &text).expect_err("a mistake").to_string();
            assert!(message.starts_with("my.toml, line 12: ") && message.contains(problem), "{message}");
        };
        refused("mine = [\"your-drive\"]", "no data set \"your-drive\"");
        refused("mine = []", "\"mine\" is empty");
        refused("my-drive = [\"my-drive\"]", "a data set already");
    }

    #[test]
    fn it_rains_as_hard_as_it_can() {
        let parse = |rain: &str| {
            let text = format!(
                "[simulated.wet]\nstreet = \"street-narrow\"\nseed = 1\nn_scans = 1\nturns_per_scan = 1\n\
                 sensor = \"vlp-16\"\n{rain}"
            );
            parse_catalogue("my.toml", &text).map(|it| it.simulated["wet"].rain_mm_per_h)
        };
        assert_eq!(parse("rain_mm_per_h = 10.0").unwrap(), Some(10.0));
        assert_eq!(parse("").unwrap(), None);
        for refused in ["0.0", "-1.0", "nan", "1000.0"] {
            let message = parse(&format!("rain_mm_per_h = {refused}")).expect_err("no rain").to_string();
            assert!(message.contains("0.1 to 150"), "{message}");
        }
    }

    #[test]
    fn a_drive_may_have_conditions_that_can_be() {
        let parse = |conditions: &str| {
            let text = format!(
                "[simulated.steep]\nstreet = \"street-narrow\"\nseed = 1\nn_scans = 1\nturns_per_scan = 1\n\
                 sensor = \"vlp-16\"\n{conditions}"
            );
            parse_catalogue("my.toml", &text).map(|it| it.simulated["steep"].clone())
        };
        let steep = parse("sensor_height_m = 2.5\n[simulated.steep.conditions]\ngradient = 0.1").unwrap();
        assert_eq!((steep.sensor_height_m, steep.conditions.gradient), (Some(2.5), Some(0.1)));
        for (refused, part) in [
            ("sensor_height_m = 0.0", "0.3 to 5"),
            ("[simulated.steep.conditions]\ngradient = 1.0", "-0.2 to 0.2"),
            ("[simulated.steep.conditions]\nslope = 0.1", "unknown field `slope`"),
        ] {
            let message = parse(refused).expect_err("no such street").to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn sequences_cannot_be_chosen_where_there_are_none() {
        check_refused("kitti-tracking", "kitti-object", 5, "sequences cannot be chosen");
    }

    #[test]
    fn topics_are_chosen_in_recordings_only() {
        let recording = ENTRY
            .replace("kitti-tracking", "mcap")
            .replace("sequences = [\"0003\", \"0001\"]", "topic = \"/top\"\nannotation_topic = \"/labels\"");
        let catalogue = parse_catalogue("my.toml", &recording).unwrap();
        let choice = TopicChoice { cloud: Some("/top".to_owned()), annotations: Some("/labels".to_owned()) };
        assert_eq!(catalogue.recorded["my-drive"].parts, CataloguedParts::Mcap(choice));
        check_refused("url", "topic = \"/top\"\nurl", 9, "topic cannot be chosen");
    }

    #[test]
    fn a_missing_field_is_named() {
        check_refused("licence = \"mine\"\n", "", 2, "missing field `licence`");
    }

    proptest! {
        #[test]
        fn any_text_gives_a_catalogue_or_an_error(text in "(?s).{0,200}") {
            let _ = parse_catalogue("my.toml", &text);
        }

        #[test]
        fn any_damage_gives_a_catalogue_or_an_error(start in 0..ENTRY.len(), replaced in "\\PC{0,5}") {
            let _ = parse_catalogue("my.toml", &format!("{}{replaced}{}", &ENTRY[..start], &ENTRY[start + 1..]));
        }
    }
}
