//! The catalogue of data sets, `datasets.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

use super::class_table::{ClassTable, class_of_word};
use super::dataset_format::DatasetFormat;
use super::download::Download;
use super::kitti::split_folder::KITTI_SENSOR;
use super::point_columns::PointColumns;
use super::root_template::RootTemplate;
use super::shown_name::{is_printable, shown};
use super::source::{ChosenParts, TopicChoice};
use super::text_file::read_text_file;
use super::{AnnotatedClasses, DatasetError};

/// Entry of a catalogue for a simulated data set, in the simulator's own words.
pub trait SimulatedEntry: DeserializeOwned {
    /// Checks that it can be simulated.
    ///
    /// # Errors
    ///
    /// The field and its value.
    fn check(&self) -> Result<(), String>;
}

/// The known data sets, by id; `S` is the entry of a simulated one.
#[derive(Debug, Clone, PartialEq)]
pub struct Catalogue<S> {
    /// Data sets on disk.
    pub recorded: BTreeMap<String, CatalogueEntry>,
    /// Data sets that are simulated when they are read.
    pub simulated: BTreeMap<String, S>,
    /// Names for several data sets that are run one after the other.
    pub groups: BTreeMap<String, Vec<String>>,
}

impl<S> Catalogue<S> {
    /// The ids of all data sets, simulated ones first.
    pub fn ids(&self) -> impl Iterator<Item = &String> {
        self.simulated.keys().chain(self.recorded.keys())
    }

    /// The data sets of the group `name`; `name` itself if it is no group.
    pub fn members<'a>(&'a self, name: &'a String) -> &'a [String] {
        self.groups.get(name).map_or(std::slice::from_ref(name), Vec::as_slice)
    }
}

/// One data set on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueEntry {
    /// Its format.
    pub format: DatasetFormat,
    /// The parts of it that are read.
    pub parts: ChosenParts,
    /// The folder that holds it.
    pub root: RootTemplate,
    /// A text file below the root that lists the numbers of the scans to read, one per line; `None` to read all.
    pub scan_list: Option<PathBuf>,
    /// The classes that its annotations cover.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor; that of KITTI unless the entry names one.
    pub sensor: String,
    /// Whether the entry names the sensor.
    pub names_sensor: bool,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// The page of its licence, where known.
    pub licence_url: Option<String>,
    /// The page to get it from, if any.
    pub url: Option<String>,
    /// The files of it that can be fetched without a login, if any.
    pub download: Option<Download>,
    /// The checksum that its files must have, as [`checksum`](super::checksum) describes it.
    pub checksum: Option<String>,
    /// The classes that names in its labels stand for.
    pub classes: ClassTable,
    /// The columns of points in files that do not name them, if given.
    pub columns: Option<PointColumns>,
}

/// Reads the catalogue at `path`.
pub fn read_catalogue<S: SimulatedEntry>(path: &Path) -> Result<Catalogue<S>, DatasetError> {
    parse_catalogue(&path.display().to_string(), &read_text_file(path)?)
}

/// Reads the catalogue in `text`; errors name it `name`.
pub fn parse_catalogue<S: SimulatedEntry>(name: &str, text: &str) -> Result<Catalogue<S>, DatasetError> {
    let source = CatalogueText { name, text };
    let written: WrittenCatalogue<S> = toml::from_str(text)
        .map_err(|error| source.error(error.span().map_or(0, |it| it.start), error.message()))?;
    let mut catalogue =
        Catalogue { recorded: BTreeMap::new(), simulated: BTreeMap::new(), groups: BTreeMap::new() };
    for (id, drive) in written.simulated {
        drive.get_ref().check().map_err(|problem| source.error(drive.span().start, &problem))?;
        let drive = drive.into_inner();
        catalogue.simulated.insert(checked_id(&id, &source)?, drive);
    }
    for (id, entry) in written.recorded {
        let checked = checked_id(&id, &source)?;
        if catalogue.simulated.contains_key(&checked) {
            let problem = format!("a simulated data set has the id {checked:?} already");
            return Err(source.error(id.span().start, &problem));
        }
        catalogue.recorded.insert(checked, entry_from_written(&id, entry, &source)?);
    }
    for (id, members) in written.groups {
        let checked = checked_id(&id, &source)?;
        if let Some(unknown) =
            members.get_ref().iter().find(|member| !catalogue.ids().any(|it| it == *member))
        {
            return Err(source.error(members.span().start, &format!("there is no data set {unknown:?}")));
        }
        if members.get_ref().is_empty() || catalogue.ids().any(|it| *it == checked) {
            let problem = format!("the group {checked:?} is empty, or a data set has this id");
            return Err(source.error(id.span().start, &problem));
        }
        catalogue.groups.insert(checked, members.into_inner());
    }
    Ok(catalogue)
}

fn checked_id(id: &Spanned<String>, source: &CatalogueText<'_>) -> Result<String, DatasetError> {
    if id.get_ref().chars().all(|it| it.is_ascii_alphanumeric() || it == '-' || it == '_') {
        return Ok(id.get_ref().clone());
    }
    let problem = format!("{:?} is not an id: use letters, digits, - and _", id.get_ref());
    Err(source.error(id.span().start, &problem))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, bound(deserialize = "S: DeserializeOwned"))]
struct WrittenCatalogue<S> {
    #[serde(default)]
    recorded: BTreeMap<Spanned<String>, WrittenEntry>,
    #[serde(default)]
    simulated: BTreeMap<Spanned<String>, Spanned<S>>,
    #[serde(default)]
    groups: BTreeMap<Spanned<String>, Spanned<Vec<String>>>,
}

/// An entry as written, which may lack fields, with the positions of the fields that can be wrong.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenEntry {
    format: Option<DatasetFormat>,
    root: Option<Spanned<String>>,
    sequences: Option<Spanned<BTreeSet<String>>>,
    scans: Option<Spanned<BTreeSet<u32>>>,
    scan_list: Option<Spanned<PathBuf>>,
    topic: Option<Spanned<String>>,
    annotation_topic: Option<Spanned<String>>,
    annotated_classes: Option<AnnotatedClasses>,
    sensor_height_m: Option<Spanned<f32>>,
    sensor: Option<String>,
    licence: Option<String>,
    licence_url: Option<String>,
    url: Option<String>,
    download: Option<Spanned<Download>>,
    checksum: Option<Spanned<String>>,
    #[serde(default)]
    classes: BTreeMap<String, Spanned<String>>,
    columns: Option<Spanned<String>>,
}

/// The text that errors point into.
struct CatalogueText<'a> {
    name: &'a str,
    text: &'a str,
}

impl CatalogueText<'_> {
    fn error(&self, byte_offset: usize, problem: &str) -> DatasetError {
        let before = self.text.as_bytes().iter().take(byte_offset);
        let line = 1 + before.filter(|byte| **byte == b'\n').count();
        DatasetError::Usage(format!("{}, line {line}: {}", shown(self.name), shown(problem)))
    }
}

/// Makes an entry of `written`; the error names all missing fields at once.
fn entry_from_written(
    id: &Spanned<String>,
    written: WrittenEntry,
    source: &CatalogueText<'_>,
) -> Result<CatalogueEntry, DatasetError> {
    let fields = [
        ("format", written.format.is_none()),
        ("root", written.root.is_none()),
        ("annotated_classes", written.annotated_classes.is_none()),
        ("sensor_height_m", written.sensor_height_m.is_none()),
    ];
    let missing: Vec<&str> = fields.into_iter().filter(|it| it.1).map(|it| it.0).collect();
    let (Some(format), Some(root), Some(annotated), Some(height_m)) =
        (written.format, &written.root, &written.annotated_classes, &written.sensor_height_m)
    else {
        let problem = format!("[recorded.{}] lacks {}", id.get_ref(), missing.join(", "));
        return Err(source.error(id.span().start, &problem));
    };
    let root_at = root.span().start;
    let root = RootTemplate::parse(root.get_ref()).map_err(|problem| source.error(root_at, &problem))?;
    let sensor_height_m = *height_m.get_ref();
    if !(sensor_height_m > 0.0 && sensor_height_m.is_finite()) {
        let problem = format!("sensor_height_m is {sensor_height_m}, but must be greater than 0");
        return Err(source.error(height_m.span().start, &problem));
    }
    if let Some(checksum) = &written.checksum
        && !is_sha256(checksum.get_ref())
    {
        let problem = format!("checksum {:?} is not 64 lower-case hexadecimal digits", checksum.get_ref());
        return Err(source.error(checksum.span().start, &problem));
    }
    check_texts(&written, root_at, source)?;
    let mut classes = ClassTable::default();
    for (name, word) in &written.classes {
        let class = class_of_word(word.get_ref()).map_err(|it| source.error(word.span().start, &it))?;
        classes.insert(name, class);
    }
    let columns = written.columns.as_ref().map(|said| {
        said.get_ref()
            .parse()
            .map_err(|it: String| source.error(said.span().start, &format!("columns: {it}")))
    });
    Ok(CatalogueEntry {
        columns: columns.transpose()?,
        format,
        parts: parts(&written, format, source)?,
        root,
        scan_list: written.scan_list.map(Spanned::into_inner),
        annotated: annotated.clone(),
        sensor_height_m,
        names_sensor: written.sensor.is_some(),
        sensor: written.sensor.unwrap_or_else(|| KITTI_SENSOR.to_owned()),
        licence: written.licence,
        licence_url: written.licence_url,
        url: written.url,
        download: written.download.map(Spanned::into_inner),
        checksum: written.checksum.map(Spanned::into_inner),
        classes,
    })
}

/// Checks that texts to show are printable, and that files to fetch are below their address.
fn check_texts(written: &WrittenEntry, at: usize, source: &CatalogueText<'_>) -> Result<(), DatasetError> {
    let texts = [
        ("sensor", written.sensor.as_ref()),
        ("licence", written.licence.as_ref()),
        ("licence_url", written.licence_url.as_ref()),
        ("url", written.url.as_ref()),
    ];
    let said = texts.into_iter().filter_map(|(field, text)| Some((field, text?)));
    if let Some((field, text)) = { said }.find(|(_, it)| !it.chars().all(is_printable)) {
        let problem = format!("{field} {text:?} has a control character");
        return Err(source.error(at, &problem));
    }
    if let Some(download) = &written.download {
        let begin = download.span().start;
        download.get_ref().check().map_err(|it| source.error(begin, &format!("download: {it}")))?;
    }
    Ok(())
}

fn parts(
    written: &WrittenEntry,
    format: DatasetFormat,
    source: &CatalogueText<'_>,
) -> Result<ChosenParts, DatasetError> {
    let WrittenEntry { sequences, scans, scan_list, topic, annotation_topic, .. } = written;
    let (is_object, is_recording) = (format == DatasetFormat::KittiObject, format == DatasetFormat::Mcap);
    let fields = [
        ("sequences", sequences.as_ref().map(Spanned::span), format.has_sequences()),
        ("scans", scans.as_ref().map(Spanned::span), is_object),
        ("scan_list", scan_list.as_ref().map(Spanned::span), is_object),
        ("topic", topic.as_ref().map(Spanned::span), is_recording),
        ("annotation_topic", annotation_topic.as_ref().map(Spanned::span), is_recording),
    ];
    for (field, span, _) in fields.into_iter().filter(|(.., exists)| !exists) {
        if let Some(span) = span {
            let problem = format!("{field} does not exist for the format {format}");
            return Err(source.error(span.start, &problem));
        }
    }
    if let Some(chosen) = sequences
        && let Some(name) = chosen.get_ref().iter().find(|name| !is_file_name(name))
    {
        let problem = format!("{name:?} is not the name of a folder");
        return Err(source.error(chosen.span().start, &problem));
    }
    if let Some(list) = scan_list {
        let path = list.get_ref();
        let is_below = path.components().all(|it| matches!(it, Component::Normal(_)));
        if scans.is_some() {
            let problem = "scans are given, and a scan_list, too".to_owned();
            return Err(source.error(list.span().start, &problem));
        }
        if !is_below || path.as_os_str().is_empty() {
            let problem = format!("scan_list {path:?} is not a file below the root");
            return Err(source.error(list.span().start, &problem));
        }
    }
    let of = |topic: &Option<Spanned<String>>| topic.as_ref().map(|it| it.get_ref().clone());
    Ok(ChosenParts {
        sequences: sequences.as_ref().map(|it| it.get_ref().clone()),
        scans: scans.as_ref().map(|it| it.get_ref().clone()),
        topics: TopicChoice { cloud: of(topic), annotations: of(annotation_topic) },
    })
}

/// Whether `name` is a single name that leads neither up nor elsewhere.
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
    use proptest::prelude::*;
    use reports::vocabulary::class::AnnotationClass;

    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Town {
        n_houses: u32,
    }

    impl SimulatedEntry for Town {
        fn check(&self) -> Result<(), String> {
            if self.n_houses == 0 { Err("n_houses is 0".to_owned()) } else { Ok(()) }
        }
    }

    fn parse(text: &str) -> Result<Catalogue<Town>, DatasetError> {
        parse_catalogue("my.toml", text)
    }

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
        let error = parse(&text).expect_err("a mistake");
        let message = error.to_string();
        assert!(
            message.starts_with(&format!("my.toml, line {line}: ")) && message.contains(problem),
            "{message}"
        );
        assert!(error.is_usage_error());
    }

    #[test]
    fn columns_are_read_or_refused() {
        let catalogue = parse(&format!("{ENTRY}columns = \"x,y,z,_,ring\"\n")).unwrap();
        let columns = catalogue.recorded["my-drive"].columns.as_ref().map(ToString::to_string);
        assert_eq!(columns.as_deref(), Some("x,y,z,_,ring"));
        check_refused("licence =", "columns = \"x,y\"\nlicence =", 8, "columns: z is missing");
    }

    #[test]
    fn an_entry_is_read() {
        let catalogue = parse(ENTRY).unwrap();
        let expected = CatalogueEntry {
            format: DatasetFormat::KittiTracking,
            parts: ChosenParts {
                sequences: Some(BTreeSet::from(["0001".to_owned(), "0003".to_owned()])),
                ..ChosenParts::default()
            },
            root: RootTemplate::parse("/data").unwrap(),
            scan_list: None,
            annotated: AnnotatedClasses::Only(vec![AnnotationClass::Car, AnnotationClass::Van]),
            sensor_height_m: 1.8,
            sensor: "hdl-64e-s2".to_owned(),
            names_sensor: false,
            licence: Some("mine".to_owned()),
            licence_url: None,
            download: None,
            url: Some("https://example.org".to_owned()),
            checksum: None,
            classes: ClassTable::default(),
            columns: None,
        };
        assert_eq!(catalogue.recorded, BTreeMap::from([("my-drive".to_owned(), expected)]));
    }

    #[test]
    fn a_data_set_may_annotate_every_object() {
        let text = ENTRY.replace(r#"["van", "car"]"#, r#""every-object""#);
        let catalogue = parse(&text).unwrap();
        assert_eq!(catalogue.recorded["my-drive"].annotated, AnnotatedClasses::EveryObject);
    }

    #[test]
    fn licence_and_url_may_be_left_out_and_all_that_is_missing_is_named_at_once() {
        let text = ENTRY.replace("licence = \"mine\"\nurl = \"https://example.org\"\n", "");
        let entry = &parse(&text).unwrap().recorded["my-drive"];
        assert_eq!((&entry.licence, &entry.url), (&None, &None));
        let error = parse("\n[recorded.mine]\nformat = \"mcap\"\n").expect_err("much is missing");
        let expected = "my.toml, line 2: [recorded.mine] lacks root, annotated_classes, sensor_height_m";
        assert_eq!(error.to_string(), expected);
    }

    #[test]
    fn mistakes_are_named_with_line_and_value() {
        check_refused("kitti-tracking", "kitty", 3, "unknown variant `kitty`");
        check_refused("sensor_height_m", "sensor_heigth_m", 7, "unknown field `sensor_heigth_m`");
        check_refused("/data", "${DATA", 4, "without");
        check_refused("1.8", "-1.8", 7, "sensor_height_m is -1.8");
        check_refused("1.8", "nan", 7, "sensor_height_m is NaN");
        check_refused("1.8", "\"high\"", 7, "high");
        check_refused("\"van\"", "\"wan\"", 6, "\"wan\" is not a class; classes are car");
        check_refused(r#"["van", "car"]"#, "\"everything\"", 6, "\"everything\"");
        check_refused(r#"["van", "car"]"#, "[]", 6, "at least one class");
        check_refused(
            "sequences = [\"0003\", \"0001\"]",
            "scans = [3]",
            5,
            "scans does not exist for the format",
        );
        check_refused("url", "checksum = \"12ab\"\nurl", 9, "checksum \"12ab\"");
        check_refused("\"0003\"", "\"../0003\"", 5, "\"../0003\" is not the name of a folder");
        check_refused("\"0003\"", "\"/etc\"", 5, "\"/etc\" is not the name of a folder");
        check_refused("\"0003\"", "\"\"", 5, "\"\" is not the name of a folder");
        check_refused("my-drive", "\"../drive\"", 2, "\"../drive\" is not an id");
        check_refused("licence = \"mine\"", "licence = \"mine", 8, "");
    }

    #[test]
    fn names_of_classes_are_mapped() {
        let text =
            format!("{ENTRY}[recorded.my-drive.classes]\nforklift = \"misc\"\n\"Big Lorry\" = \"Truck\"\n");
        let classes = &parse(&text).unwrap().recorded["my-drive"].classes;
        assert_eq!(classes.get("Forklift"), Some(AnnotationClass::Misc));
        assert_eq!(classes.get("big_lorry"), Some(AnnotationClass::Truck));
        let error = parse(&text.replace("\"misc\"", "\"mics\"")).expect_err("no class");
        assert!(
            error.to_string().starts_with("my.toml, line 11: \"mics\" is not a class; classes are car, "),
            "{error}"
        );
    }

    #[test]
    fn a_group_stands_for_its_members() {
        let text = format!("{ENTRY}\n[groups]\nmine = [\"my-drive\"]");
        let catalogue = parse(&text).unwrap();
        assert_eq!(catalogue.members(&"mine".to_owned()), ["my-drive"]);
        assert_eq!(catalogue.members(&"other".to_owned()), ["other"]);
        let refused = |group: &str, problem: &str| {
            let text = format!("{ENTRY}\n[groups]\n{group}");
            let message = parse(&text).expect_err("a mistake").to_string();
            assert!(message.starts_with("my.toml, line 12: ") && message.contains(problem), "{message}");
        };
        refused("mine = [\"your-drive\"]", "no data set \"your-drive\"");
        refused("mine = []", "the group \"mine\" is empty");
        refused("my-drive = [\"my-drive\"]", "or a data set has this id");
    }

    #[test]
    fn a_simulated_data_set_is_checked_by_its_simulator() {
        let text = format!("{ENTRY}\n[simulated.town]\nn_houses = 3");
        assert_eq!(
            parse(&text).unwrap().simulated,
            BTreeMap::from([("town".to_owned(), Town { n_houses: 3 })])
        );
        let refused = |from: &str, to: &str, line: usize, problem: &str| {
            let message = parse(&text.replace(from, to)).expect_err("a mistake").to_string();
            assert!(message.starts_with(&format!("my.toml, line {line}: ")), "{message}");
            assert!(message.contains(problem), "{message}");
        };
        refused("= 3", "= 0", 11, "n_houses is 0");
        refused("n_houses", "n_homes", 12, "unknown field `n_homes`");
        refused("simulated.town", "simulated.my-drive", 2, "a simulated data set has the id");
    }

    #[test]
    fn sequences_cannot_be_chosen_where_there_are_none() {
        check_refused("kitti-tracking", "kitti-object", 5, "sequences does not exist for the format");
    }

    #[test]
    fn a_list_of_scans_lies_below_the_root_and_is_of_single_scans() {
        let objects = ENTRY
            .replace("kitti-tracking", "kitti-object")
            .replace("sequences = [\"0003\", \"0001\"]", "scan_list = \"ImageSets/val.txt\"");
        let list = parse(&objects).unwrap().recorded["my-drive"].scan_list.clone();
        assert_eq!(list.as_deref(), Some(Path::new("ImageSets/val.txt")));
        let refused = |text: &str, line: usize, problem: &str| {
            let message = parse(text).expect_err("a mistake").to_string();
            let position = format!("my.toml, line {line}: ");
            assert!(message.starts_with(&position) && message.contains(problem), "{message}");
        };
        let elsewhere = |list: &str| objects.replace("ImageSets/val.txt", list);
        for list in ["../val.txt", "/etc/passwd", ""] {
            refused(&elsewhere(list), 5, "is not a file below the root");
        }
        refused(&objects.replace("url", "scans = [3]\nurl"), 5, "scans are given, and a scan_list, too");
        check_refused("url", "scan_list = \"a.txt\"\nurl", 9, "scan_list does not exist for the format");
    }

    #[test]
    fn topics_are_chosen_in_recordings_only() {
        let recording = ENTRY
            .replace("kitti-tracking", "mcap")
            .replace("sequences = [\"0003\", \"0001\"]", "topic = \"/top\"\nannotation_topic = \"/labels\"");
        let catalogue = parse(&recording).unwrap();
        let choice = TopicChoice { cloud: Some("/top".to_owned()), annotations: Some("/labels".to_owned()) };
        assert_eq!(catalogue.recorded["my-drive"].parts.topics, choice);
        check_refused("url", "topic = \"/top\"\nurl", 9, "topic does not exist for the format");
    }

    proptest! {
        #[test]
        fn any_text_gives_a_catalogue_or_an_error(text in "(?s).{0,200}") {
            let _ = parse(&text);
        }

        #[test]
        fn any_damage_gives_a_catalogue_or_an_error(start in 0..ENTRY.len(), replaced in "\\PC{0,5}") {
            let _ = parse(&format!("{}{replaced}{}", &ENTRY[..start], &ENTRY[start + 1..]));
        }
    }
}
