//! `manifest.json`: how a run came about, so that it can be made again.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::files::archive::{ArchiveError, pretty_json, read_json};
use crate::files::shown_text::printable_name;
use crate::numbers::pools::{Pool, pools};
use crate::numbers::tally::{Processors, Tally};
use crate::rows::scan_row::ScanRow;
use crate::run_folder::partial_entry::PartialEntry;
use crate::run_folder::seen_labels::SeenLabels;
use crate::run_folder::shard_record::{ShardRecord, processors_of};
use crate::run_folder::sweep_entry::SweepEntry;
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::own_slice::{OwnSlice, SliceBounds};
use crate::vocabulary::protocol::Protocol;

/// Everything that decides the numbers of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Layout of the files of the run, [`SCHEMA`](crate::files::archive::SCHEMA).
    pub schema: u32,
    /// Version of the rules by which the detections were judged: the highest of those of its detectors.
    pub scoring_version: u32,
    /// Version of the program.
    pub scanbench_version: String,
    /// When the run began, in UTC as RFC 3339 writes it.
    pub created: String,
    /// The command line, the program's name first.
    pub argv: Vec<String>,
    /// The configuration after files, defaults and command line were put together.
    pub config: Value,
    /// The seeds of everything random, by what they are for.
    pub seeds: BTreeMap<String, u64>,
    /// Detections of the first scan, for each detector, that were thrown away before anything was timed.
    pub n_warmup_detections: u32,
    /// How often each detector looked at each scan.
    #[serde(default = "once")]
    pub n_repeats: u32,
    /// Who counted instructions and memory, such as `valgrind`; `None` if nobody did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted_by: Option<String>,
    /// The protocols of others that it was evaluated under, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub protocols: Vec<Protocol>,
    /// By what a detection was matched with an annotation, in words, such as `points, Jaccard at least 0.5`.
    pub matching_criterion: String,
    /// Which annotations do not count.
    pub ignored: IgnoreRule,
    /// Slices of the user, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub slices: BTreeMap<String, SliceBounds>,
    /// The data sets, in the order of the tables.
    pub datasets: Vec<DatasetEntry>,
    /// The detectors, in the order of the tables.
    pub detectors: Vec<DetectorEntry>,
    /// The state of the source that the program was built from, where it is known.
    pub git: Option<GitState>,
    /// The state of the repository of the user in which the command ran, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub project: Option<GitState>,
    /// The compiler.
    pub rustc_version: String,
    /// The Rerun library, if the program was built with it.
    pub rerun_version: Option<String>,
    /// The machine that all times are for.
    pub machine: Machine,
    /// What an experiment put up, as it describes it; `None` for a run over data sets that were named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub experiment: Option<Value>,
    /// What was swept; `None` for all but sweeps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepEntry>,
    /// What objects were judged of which a part was seen; `None` for all but `partial`, which has no data sets of scans and
    /// no detectors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub partial: Option<PartialEntry>,
    /// Which part of a run it is; `None` of a whole one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardRecord>,
    /// The parts that it was put together of; none of a run in one piece.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shards: Vec<ShardRecord>,
}

/// Which annotations of any data set do not count, whatever the detector.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct IgnoreRule {
    /// Those with fewer points than this.
    pub min_points: u32,
    /// Those farther from the sensor than this, in metres.
    pub max_range_m: f64,
}

/// A data set of the run.
#[cfg_attr(test, derive(Default))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DatasetEntry {
    /// The name used in tables and files.
    #[serde(deserialize_with = "printable_name")]
    pub id: String,
    /// The format's name, such as `kitti-tracking`.
    pub format: String,
    /// Where it lies; `None` for what is simulated on the fly.
    pub root: Option<String>,
    /// Whether a simulator made it. Numbers measured on it are always labelled so.
    pub simulated: bool,
    /// What its annotations cover.
    pub annotated: AnnotatedClasses,
    /// SHA-256 of what the scans are made of, where it is known.
    pub checksum: Option<String>,
    /// Number of scans that were selected.
    pub n_scans: u64,
    /// Those of them that were left out because they are damaged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub skipped_scans: Vec<SkippedScan>,
    /// Points without a position in the scans that were read; they are left out.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub n_points_left_out: u64,
    /// What the user said names of classes in the labels stand for.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub classes: BTreeMap<String, AnnotationClass>,
    /// How far to either side of forward the labels reach, in degrees, as the user said; `None` for as the files say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels_ahead_deg: Option<f32>,
    /// Which scans were selected, as the command line writes it; `None` for all.
    pub selection: Option<String>,
    /// What is known better than drives say of which scans are drawn together: names of blocks, or of the drives that scans
    /// come from, each with its scans.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub blocks: BTreeMap<String, Vec<String>>,
    /// SHA-256 of the file that the user gave for that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blocks_checksum: Option<String>,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor: its id, or the file that describes it.
    pub sensor: String,
    /// What the scans themselves say of the sensor; `None` where nobody asked them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<SeenMounting>,
    /// Where points lie in the frames of labelled boxes, as the first scans show it; `None` where nobody asked them, or
    /// vehicles are few.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label_points: Option<SeenLabels>,
    /// Why the frame of the scans or their labels are suspect, a sentence each. No verdict rests on such a data set.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// Why its labels are suspect although the user says that they are right (`--labels-are-right`). Verdicts rest on them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overruled_doubts: Vec<String>,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// What a simulation was asked for besides its seed; `None` for what was recorded.
    pub simulation: Option<Simulation>,
}

/// Sensor and mounting as the first scans show them. Of what is simulated only the density may be taken from them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SeenMounting {
    /// Beams, and the elevations of the lowest and the highest in degrees.
    pub n_beams: Option<u32>,
    /// The lowest and the highest.
    pub elevations_deg: Option<[f64; 2]>,
    /// The known sensor that has such beams.
    pub sensor: Option<String>,
    /// The axis that points up: `z` as it should be.
    pub up_axis: Option<String>,
    /// Height of the origin above the ground in metres.
    pub height_m: Option<f64>,
    /// Angle between the ground's upright and the axis z, in degrees.
    pub tilt_deg: Option<f64>,
    /// Which of it the run went by, since nobody said otherwise: `sensor`, `density`, `height`, `tilt`.
    pub taken: Vec<String>,
}

impl DatasetEntry {
    /// Where its scans come from.
    pub fn origin(&self) -> Origin {
        if self.simulated { Origin::Simulated } else { Origin::Recorded }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// A scan that was left out because it is damaged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SkippedScan {
    /// Which it is.
    pub scan: String,
    /// What is wrong with it.
    pub reason: String,
}

/// A drive through a simulated street.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// Bumped whenever the same street gives other scans.
    pub simulator_version: u32,
    /// The kind of street.
    pub street: String,
    /// Length of the drive in scans, of which a selection may have taken some.
    pub n_drive_scans: u32,
    /// Turns of the sensor from one scan to the next.
    pub turns_per_scan: u32,
    /// Scans of a street, after which the drive went on in that of the next seed; `None` for as many as it has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scans_per_drive: Option<u32>,
    /// The sensor: its id, or the file that describes it.
    pub sensor: String,
    /// `instant` or `rolling`.
    pub shutter: String,
    /// How hard it rains, in millimetres per hour; `None` if it is dry.
    pub rain_mm_per_h: Option<f32>,
    /// Height of the sensor above the road in metres, if it is not as its description has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor_height_m: Option<f32>,
    /// What was set about the street instead of drawn; `None` if nothing was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conditions: Option<Value>,
    /// How far to either side of forward the labels reach, in degrees; `None` for all around.
    pub labeled_to_either_side_deg: Option<f32>,
}

/// Which objects of the street a data set annotates.
#[cfg_attr(test, derive(Default))]
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AnnotatedClasses {
    /// Every free-standing object.
    #[cfg_attr(test, default)]
    EveryObject,
    /// Objects of these classes only.
    Only(Vec<AnnotationClass>),
}

/// A detector of the run.
#[cfg_attr(test, derive(Default))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DetectorEntry {
    /// The name used in tables and files.
    #[serde(deserialize_with = "printable_name")]
    pub name: String,
    /// Every parameter with its value.
    pub parameters: serde_json::Value,
    /// What it does beside finding clusters, which others may not.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<String>,
    /// By what its vehicles are classified, in words; `None` in manifests from before this was said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vehicles: Option<String>,
    /// SHA-256 of its trained models that did not come with the program, by the names of their files.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub models: BTreeMap<String, String>,
    /// Why its boxes are suspect, a sentence for each reason and data set: they do not lie where the points are, all in the
    /// same way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// Version of the rules by which its detections were judged; `None` in manifests from before this was said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scoring_version: Option<u32>,
    /// Where it comes from if it is not built in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreign: Option<ForeignEntry>,
}

/// A detector that is not built in.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ForeignEntry {
    /// The program and its arguments.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub command: Vec<String>,
    /// Where its results were read, if it ran somewhere else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub results: Option<String>,
    /// SHA-256 of these results.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub results_checksum: Option<String>,
    /// The files with these results, by data set and name: the first digits of their SHA-256, or of recordings the size.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub result_files: BTreeMap<String, String>,
    /// What it calls itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reported_name: Option<String>,
    /// Its version, as it says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// SHA-256 of the files that its command and its parameters name, by these names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    /// How long it may take from its start until it can be asked, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_limit_s: Option<f64>,
    /// How long it may take for a scan, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
    /// How many threads it should use at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threads: Option<u32>,
    /// Whether it had no network, and saw neither data sets nor runs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub sandbox: bool,
    /// What classifies vehicles among its objects where it does not: their size, or our model.
    pub vehicles: String,
}

/// The state of a git repository.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GitState {
    /// Hash of the commit.
    pub commit: String,
    /// Whether there were changes beyond the commit.
    pub dirty: bool,
}

impl GitState {
    /// The beginning of the commit, with a `+` if there were changes beyond it.
    pub fn in_short(&self) -> String {
        let short: String = self.commit.chars().take(8).collect();
        format!("{short}{}", if self.dirty { "+" } else { "" })
    }
}

/// A computer.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// The processor's own name.
    pub cpu_model: String,
    /// Number of logical cores.
    pub n_cores: u32,
    /// The operating system.
    pub os: String,
}

fn once() -> u32 {
    1
}

impl Manifest {
    /// The data sets whose numbers are put together.
    pub fn pools(&self) -> Vec<Pool> {
        pools(self.datasets.iter().map(|it| (it.id.as_str(), it.origin())))
    }

    /// Doubts about data sets and detectors, and those that the user overruled, a sentence each.
    pub fn doubts_in_words(&self) -> Vec<String> {
        let of_dataset = |it: &DatasetEntry| {
            let doubts =
                it.doubts.iter().map(|doubt| format!("Frame or labels of {} are suspect: {doubt}.", it.id));
            let overruled = it.overruled_doubts.iter().map(|doubt| {
                format!(
                    "The labels of {} are right, says the user (--labels-are-right), though {doubt}.",
                    it.id
                )
            });
            let ahead = it.labels_ahead_deg.map(|limit_deg| {
                format!(
                    "The labels of {} reach {limit_deg} degrees to either side of forward, says the user (--labels-ahead).",
                    it.id
                )
            });
            doubts.chain(overruled).chain(ahead).collect::<Vec<_>>()
        };
        let of_detector = |it: &DetectorEntry| {
            let doubts = it.doubts.iter();
            doubts.map(|doubt| format!("The boxes of {} are suspect: {doubt}.", it.name)).collect::<Vec<_>>()
        };
        let of_datasets = self.datasets.iter().flat_map(of_dataset);
        of_datasets.chain(self.detectors.iter().flat_map(of_detector)).collect()
    }

    /// The repository whose commits tell runs apart: that of the project of the user or, without one, of the program.
    pub fn versioned_by(&self) -> Option<&GitState> {
        self.project.as_ref().or(self.git.as_ref())
    }

    /// Name of a unit that is judged by itself, for people.
    pub fn unit(&self) -> &'static str {
        if self.partial.is_some() { "partial cloud" } else { "scan" }
    }

    /// Whether all its scans were timed on processors of one kind. Times on unlike processors are never put together.
    pub fn is_of_like_processors(&self) -> bool {
        processors_of(&self.shards).len() < 2
    }

    /// An empty tally for rows of this run.
    pub fn tally(&self) -> Tally {
        let of_dataset = |it: &DatasetEntry| {
            let of_scans = it
                .blocks
                .iter()
                .flat_map(|(block, scans)| scans.iter().map(move |scan| (scan.clone(), block.clone())));
            (it.id.clone(), of_scans.collect())
        };
        self.tally_of_moments().with_blocks(self.datasets.iter().map(of_dataset).collect())
    }

    /// An empty tally for rows that are about the drives of this run, but not about its scans.
    pub fn tally_of_moments(&self) -> Tally {
        let processors = if self.is_of_like_processors() { Processors::Alike } else { Processors::Unlike };
        let simulated = self.datasets.iter().filter(|it| it.simulated).map(|it| it.id.clone());
        let slice = |(name, bounds): (&String, &SliceBounds)| Some((OwnSlice::named(name)?, bounds.clone()));
        Tally::of_run(processors, simulated.collect())
            .with_slices(self.slices.iter().filter_map(slice).collect())
    }

    /// A function that gives a scan the name of its drive: its sequence, unless something better is known.
    pub fn drive_of(&self) -> impl Fn(&ScanRow) -> String + use<'_> {
        let mut drives = BTreeMap::new();
        for dataset in &self.datasets {
            for (drive, scans) in &dataset.blocks {
                drives.extend(scans.iter().map(|scan| ((dataset.id.as_str(), scan.clone()), drive.as_str())));
            }
        }
        move |row| {
            let name = format!("{}/{:06}", row.sequence, row.scan);
            let drive = drives.get(&(row.dataset.as_str(), name)).copied();
            drive.unwrap_or(&row.sequence).to_owned()
        }
    }

    /// The content of `manifest.json`.
    pub fn to_json(&self) -> String {
        pretty_json(self)
    }

    /// Reads a `manifest.json`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if the file cannot be read, has another schema, misses a field that cannot be null, or has
    /// an unknown one.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        read_json(path).or_else(|error| read_json(path).ok().and_then(Self::of_old_partial).ok_or(error))
    }

    /// The manifest of `partial` from before its results had the manifest of all others.
    fn of_old_partial(mut old: serde_json::Map<String, Value>) -> Option<Self> {
        let of_partial = ["sets", "peers", "settings"].into_iter();
        let of_partial = of_partial.filter_map(|it| Some((it.to_owned(), old.remove(it)?)));
        let partial = Value::Object(of_partial.collect());
        let mut manifest = serde_json::to_value(Self { n_repeats: once(), ..Self::default() }).ok()?;
        manifest.as_object_mut()?.extend(old);
        manifest["partial"] = partial;
        serde_json::from_value(manifest).ok()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::files::archive::SCHEMA;
    use crate::run_folder::partial_entry::tests::entry;

    /// The manifest of a result of `scanbench partial`.
    pub(crate) fn partial_manifest() -> Manifest {
        Manifest {
            schema: SCHEMA,
            scanbench_version: "0.1.0".to_owned(),
            created: "2026-01-01T00:00:00Z".to_owned(),
            argv: ["scanbench", "partial", "it's <here>"].map(str::to_owned).to_vec(),
            n_repeats: 1,
            rustc_version: "rustc".to_owned(),
            partial: Some(entry()),
            ..Manifest::default()
        }
    }

    fn manifest() -> Manifest {
        Manifest {
            schema: SCHEMA,
            scoring_version: 1,
            scanbench_version: "0.1.0".to_owned(),
            created: "2026-03-02T09:30:00Z".to_owned(),
            argv: vec!["scanbench".to_owned(), "run".to_owned()],
            config: serde_json::json!({"run": {"n_jobs": 1}}),
            seeds: BTreeMap::from([("simulator".to_owned(), u64::MAX)]),
            n_warmup_detections: 2,
            n_repeats: 3,
            matching_criterion: "points, Jaccard at least 0.5".to_owned(),
            ignored: IgnoreRule { min_points: 20, max_range_m: 80.0 },
            datasets: vec![DatasetEntry {
                id: "drive".to_owned(),
                format: "kitti-tracking".to_owned(),
                root: Some("/data/kitti".to_owned()),
                annotated: AnnotatedClasses::Only(vec![AnnotationClass::Car]),
                n_scans: 40,
                selection: Some("0..80:2".to_owned()),
                sensor_height_m: 1.73,
                sensor: "hdl-64e-s2".to_owned(),
                ..DatasetEntry::default()
            }],
            detectors: vec![DetectorEntry {
                name: "kd-tree".to_owned(),
                parameters: serde_json::json!({"tolerance_m": 0.5}),
                rules: vec!["completion".to_owned()],
                ..DetectorEntry::default()
            }],
            git: Some(GitState { commit: "c0ffee".to_owned(), dirty: true }),
            rustc_version: "1.95.0".to_owned(),
            machine: Machine { cpu_model: "some processor".to_owned(), n_cores: 2, os: "linux".to_owned() },
            ..Manifest::default()
        }
    }

    fn read_back(manifest: &Manifest) -> Result<Manifest, ArchiveError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("manifest.json");
        std::fs::write(&path, manifest.to_json()).unwrap();
        Manifest::read(&path)
    }

    #[test]
    #[expect(clippy::too_many_lines, reason = "most of it is a snapshot")]
    fn a_manifest_reads_back_as_it_was_and_can_be_read_by_people() {
        assert_eq!(read_back(&manifest()).unwrap(), manifest());
        insta::assert_snapshot!(manifest().to_json(), @r#"
        {
          "schema": 1,
          "scoring_version": 1,
          "scanbench_version": "0.1.0",
          "created": "2026-03-02T09:30:00Z",
          "argv": [
            "scanbench",
            "run"
          ],
          "config": {
            "run": {
              "n_jobs": 1
            }
          },
          "seeds": {
            "simulator": 18446744073709551615
          },
          "n_warmup_detections": 2,
          "n_repeats": 3,
          "matching_criterion": "points, Jaccard at least 0.5",
          "ignored": {
            "min_points": 20,
            "max_range_m": 80.0
          },
          "datasets": [
            {
              "id": "drive",
              "format": "kitti-tracking",
              "root": "/data/kitti",
              "simulated": false,
              "annotated": {
                "only": [
                  "car"
                ]
              },
              "checksum": null,
              "n_scans": 40,
              "selection": "0..80:2",
              "sensor_height_m": 1.73,
              "sensor": "hdl-64e-s2",
              "licence": null,
              "simulation": null
            }
          ],
          "detectors": [
            {
              "name": "kd-tree",
              "parameters": {
                "tolerance_m": 0.5
              },
              "rules": [
                "completion"
              ]
            }
          ],
          "git": {
            "commit": "c0ffee",
            "dirty": true
          },
          "rustc_version": "1.95.0",
          "rerun_version": null,
          "machine": {
            "cpu_model": "some processor",
            "n_cores": 2,
            "os": "linux"
          }
        }
        "#);
    }

    #[test]
    fn a_manifest_of_another_schema_is_refused() {
        let error = read_back(&Manifest { schema: SCHEMA + 1, ..manifest() }).unwrap_err();
        assert!(matches!(error, ArchiveError::Schema { found: 2, expected: 1, .. }), "{error}");
    }

    #[test]
    fn a_result_of_partial_is_read_in_both_layouts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("manifest.json");
        assert_eq!(read_back(&partial_manifest()).unwrap(), partial_manifest());
        let sets = serde_json::to_value(entry().sets).unwrap();
        let old = serde_json::json!({
            "schema": 1, "scanbench_version": "0.1.0", "created": "2026-01-01T00:00:00Z",
            "argv": ["scanbench", "partial", "it's <here>"], "sets": sets, "peers": {}, "git": null,
            "rustc_version": "rustc",
        });
        std::fs::write(&path, old.to_string()).unwrap();
        assert_eq!(Manifest::read(&path).unwrap(), partial_manifest());
        std::fs::write(&path, r#"{"schema": 1}"#).unwrap();
        assert!(Manifest::read(&path).is_err());
    }
}
