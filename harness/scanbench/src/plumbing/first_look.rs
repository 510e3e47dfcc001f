//! A look at the first scans, before anything is run on them: how densely does the sensor sample the street, and if they are
//! recorded, is the frame as it should be, and which sensor took them?

use std::borrow::Cow;

use detector::PointCloud;
use detector::grid::density_curve::{CurveOrigin, DensityCurve};
use detector::grid::ring_density::RingCounts;
use evaluation::run::config::RunConfig;
use nalgebra::Isometry3;
use reports::run_folder::manifest::SeenMounting;
use reports::run_folder::seen_labels::SeenLabels;
use scans::annotation::LabeledScan;
use scans::data_check::empty_boxes::EmptyBoxes;
use scans::data_check::frame_suspicion::FrameSuspicion;
use scans::data_check::label_look::{LabelLook, proposed_suspicion};
use scans::data_check::label_suspicion::LabelSuspicion;
use scans::data_check::same_position::SamePosition;
use scans::data_check::seen_ground::{SeenGround, UpAxis};
use scans::dataset::dataset_format::DatasetFormat;
use scans::dataset::mounting::Mounting;
use scans::dataset::proposal_list::ProposalList;
use scans::dataset::{DatasetDescription, DatasetError};
use simulator::recognised_sensor::SeenBeams;

use crate::plumbing::frame_facts::{FirstLook, Stated, indices_looked_at};
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::open_scan::OpenedScan;
use crate::plumbing::standard_streams::{print_detail, print_diagnostic};

/// Largest number of points of a scan that are looked at.
const ENOUGH_POINTS: usize = 300_000;
/// A seen height that differs by more than this from that of the data set is suspect, in metres.
const SUSPECT_HEIGHT_M: f64 = 0.5;
/// A height is taken from the scans if it differs by more than this, in metres; in the format of a benchmark, whose height
/// is known, only if it is suspect.
const OTHER_HEIGHT_M: f64 = 0.25;
/// A steeper tilt is of the sensor and not of the street, in degrees. It is levelled unless the transform of the sensor is
/// stated, and suspect if it is. In front of crossings and on crowned roads, sensors that stand upright see up to 2.2 degrees.
const STEEP_TILT_DEG: f64 = 4.0;
/// The first part of the name of a sensor with unknown beams; the name of its data set follows.
pub const UNKNOWN_SENSOR: &str = "unknown sensor of ";
/// An origin that is less than this above the ground lies on it, in metres.
const ON_GROUND_M: f64 = 0.2;

/// Looks at `opened`, and prints what was seen and what is suspect. Unless the user has given other values, the run uses
/// what was seen: the sensor with its density curve, its height and its tilt. Of a simulated sensor only the density curve
/// may be unknown.
///
/// From then on, detectors that must not see labels know where these are.
pub fn look_first(opened: OpenedDataset, config: &mut RunConfig) -> OpenedDataset {
    hide_labels_of(opened.dataset.description(), config);
    let proposed = suspicion_of_proposals(&opened);
    let mut opened = look_at_scans(opened, config);
    opened.first_look.suspicions.extend(proposed);
    for suspicion in &opened.first_look.suspicions {
        warn_of(&opened.dataset.description().id, suspicion);
    }
    opened
}

fn hide_labels_of(description: &DatasetDescription, config: &mut RunConfig) {
    config.places_of_labels.extend(description.root.clone());
}

fn look_at_scans(opened: OpenedDataset, config: &mut RunConfig) -> OpenedDataset {
    let description = opened.dataset.description();
    if description.is_simulated() && config.for_dataset(&description.id, &description.sensor).is_some() {
        return opened;
    }
    let scans = first_scans(&opened);
    let clouds: Vec<&PointCloud> = scans.iter().map(|it| &it.cloud).collect();
    if description.is_simulated() {
        let seen = take_simulated_density(description, config, &clouds);
        return OpenedDataset { first_look: FirstLook { seen, ..FirstLook::default() }, ..opened };
    }
    // The run itself reports why nothing can be read.
    if scans.is_empty() {
        return opened;
    }
    let mut look = Look::new(description, opened.stated, &clouds);
    look.take(config, &clouds);
    look.suspect_labels(&opened, &scans);
    let (mounting, first_look) = look.reported();
    OpenedDataset { dataset: mounting.of(opened.dataset), first_look, ..opened }
}

/// As [`look_first`], for all of `opened`.
pub fn look_first_at_all(opened: Vec<OpenedDataset>, config: &mut RunConfig) -> Vec<OpenedDataset> {
    opened.into_iter().map(|it| look_first(it, config)).collect()
}

/// As [`look_first`], for a single scan without labels.
pub fn look_at_scan(opened: &mut OpenedScan, stated: Stated, config: &mut RunConfig) {
    hide_labels_of(&opened.description, config);
    config.places_of_labels.append(&mut opened.folders_around);
    let clouds: Vec<&PointCloud> = match &opened.of_data_set[..] {
        [] => vec![&opened.scan.cloud],
        of_data_set => of_data_set.iter().collect(),
    };
    if opened.description.is_simulated() {
        take_simulated_density(&opened.description, config, &clouds);
        return;
    }
    let mut look = Look::new(&opened.description, stated, &clouds);
    look.take(config, &clouds);
    let id = opened.description.id.clone();
    let (mounting, first_look) = look.reported();
    for suspicion in &first_look.suspicions {
        warn_of(&id, suspicion);
    }
    mounting.describe(&mut opened.description);
    mounting.move_scan(&mut opened.scan);
}

/// The look of `data check` at the first scans.
#[derive(Default)]
pub struct CheckedLook {
    /// Reasons why frame and labels are suspect, also those that a run would mend from the scans.
    pub suspicions: Vec<FrameSuspicion>,
    /// The look at the labels; `None` if the scans are simulated or cannot be read.
    pub labels: Option<LabelLook>,
    /// The sensor that a run takes, and why; `None` if the user or the format states it.
    pub sensor: Option<String>,
}

/// Looks at the first scans of `opened` for `data check`.
pub fn check_first_scans(opened: &OpenedDataset) -> CheckedLook {
    let scans = first_scans(opened);
    let proposed = suspicion_of_proposals(opened);
    if opened.dataset.description().is_simulated() || scans.is_empty() {
        return CheckedLook { suspicions: proposed.into_iter().collect(), ..CheckedLook::default() };
    }
    let clouds: Vec<&PointCloud> = scans.iter().map(|it| &it.cloud).collect();
    let mut look = Look::new(opened.dataset.description(), Stated::ALL, &clouds);
    look.take_ground();
    look.suspect_labels(opened, &scans);
    look.suspicions.extend(proposed);
    let sensor = if opened.stated.sensor { None } else { look.unstated_sensor() };
    CheckedLook { suspicions: look.suspicions, labels: Some(look.labels), sensor }
}

/// The suspicion that most labels are as a detector proposed them, if so. A list of proposals that cannot be read does not
/// stop a run.
fn suspicion_of_proposals(opened: &OpenedDataset) -> Option<FrameSuspicion> {
    let list = ProposalList::in_folder(opened.dataset.description().root.as_deref()?).ok().flatten()?;
    proposed_suspicion(&first_scans(opened), &list).map(FrameSuspicion::Labels)
}

fn warn_of(id: &str, suspicion: &FrameSuspicion) {
    let (subject, are) = match suspicion {
        FrameSuspicion::Labels(_) => ("labels", "are"),
        FrameSuspicion::SamePosition(_) => ("points", "are"),
        _ => ("frame", "is"),
    };
    print_diagnostic(format_args!("warning: the {subject} of {id:?} {are} suspect: {suspicion}"));
}

/// Takes the density of a simulated sensor from `clouds` if it has no curve, and says so; returns what was seen by it.
fn take_simulated_density(
    description: &DatasetDescription,
    config: &mut RunConfig,
    clouds: &[&PointCloud],
) -> Option<SeenMounting> {
    let DatasetDescription { id, sensor, .. } = description;
    take_density(config, [id, sensor], clouds).then(|| {
        print_diagnostic(format_args!("{id}: density of the sensor {sensor} taken from the scans"));
        SeenMounting { taken: vec!["density".to_owned()], ..SeenMounting::default() }
    })
}

/// Takes the density of `sensor` in the data set `id` from `clouds` if it has no curve, and if they are enough. Returns
/// whether it did.
fn take_density(config: &mut RunConfig, [id, sensor]: [&str; 2], clouds: &[&PointCloud]) -> bool {
    if config.for_dataset(id, sensor).is_some() {
        return false;
    }
    let (datasets, seeds, command) = (vec![id.to_owned()], Vec::new(), String::new());
    let origin = CurveOrigin { sensor: sensor.to_owned(), datasets, seeds, command };
    let counts: Vec<RingCounts> = clouds.iter().map(|it| RingCounts::of(it)).collect();
    let fitted = DensityCurve::fit(&counts, origin);
    let is_taken = fitted.is_ok();
    config.own_curves.extend(fitted.map(|it| ((id.to_owned(), sensor.to_owned()), it)));
    is_taken
}

/// `cloud`, or of a larger one every second point, or third, and so on, so that at most `ENOUGH_POINTS` are left.
pub fn thinned(cloud: &PointCloud) -> Cow<'_, PointCloud> {
    if cloud.len() <= ENOUGH_POINTS {
        return Cow::Borrowed(cloud);
    }
    let step = cloud.len().div_ceil(ENOUGH_POINTS);
    Cow::Owned(cloud.positions_m().step_by(step).collect())
}

/// Some scans from first to last; none if the name of a class is unknown. The run reports that, and scans it cannot read.
fn first_scans(opened: &OpenedDataset) -> Vec<LabeledScan> {
    let indices = indices_looked_at(opened.dataset.scan_ids().len());
    let read: Vec<_> = indices.map(|it| opened.dataset.read_scan(it)).collect();
    if read.iter().any(|it| it.as_ref().is_err_and(DatasetError::is_usage_error)) {
        return Vec::new();
    }
    // A scan without points says nothing about frame and labels.
    read.into_iter().filter_map(Result::ok).filter(|it| !it.cloud.is_empty()).collect()
}

/// The scans that follow those of `scans` in their drives, each with the index of the one that it follows.
fn next_scans(opened: &OpenedDataset, scans: &[LabeledScan]) -> Vec<(usize, LabeledScan)> {
    let ids = opened.dataset.scan_ids();
    let next = |(scan_idx, scan): (usize, &LabeledScan)| {
        let index = ids.iter().position(|it| *it == scan.id)? + 1;
        let is_of_drive = ids.get(index)?.sequence == scan.id.sequence;
        is_of_drive.then(|| opened.dataset.read_scan(index).ok()).flatten().map(|it| (scan_idx, it))
    };
    scans.iter().enumerate().filter_map(next).collect()
}

/// The beams in the frame of the scans, which is the sensor's. If no known sensor has these, it may be that the points were
/// turned after they were taken, and the sensor stood upright.
fn seen_beams(clouds: &[&PointCloud], ground: Option<&(UpAxis, SeenGround)>) -> Option<SeenBeams> {
    let seen = SeenBeams::of(clouds.iter().copied(), &Isometry3::identity())?;
    let upright = || SeenBeams::of(clouds.iter().copied(), &ground?.1.levelling());
    match seen.sensor() {
        None => upright().filter(|it| it.sensor().is_some()).or(Some(seen)),
        Some(_) => Some(seen),
    }
}

/// Facts that the first scans of a data set show, and values that a run takes from them.
struct Look {
    id: String,
    is_benchmark: bool,
    /// Whether the beams are surely not of the sensor that the format has.
    is_other_sensor: bool,
    stated: Stated,
    sensor: String,
    said_height_m: f64,
    ground: Option<(UpAxis, SeenGround)>,
    seen: SeenMounting,
    mounting: Mounting,
    suspicions: Vec<FrameSuspicion>,
    labels: LabelLook,
}

impl Look {
    fn new(description: &DatasetDescription, stated: Stated, clouds: &[&PointCloud]) -> Self {
        let at_one_position = SamePosition::of(clouds.iter().copied());
        let thinned: Vec<Cow<'_, PointCloud>> = clouds.iter().map(|it| thinned(it)).collect();
        let clouds: Vec<&PointCloud> = thinned.iter().map(|it| &**it).collect();
        let ground = SeenGround::with_axis(&clouds);
        let beams = seen_beams(&clouds, ground.as_ref());
        // Not minus zero.
        let round = |value: f64, unit: f64| (value / unit).round() * unit + 0.0;
        Self {
            id: description.id.clone(),
            is_benchmark: description.format.parse().is_ok_and(DatasetFormat::is_of_benchmark),
            is_other_sensor: beams.is_some_and(|it| it.contradict(&description.sensor)),
            stated,
            sensor: description.sensor.clone(),
            said_height_m: description.sensor_height_m.into(),
            ground,
            seen: SeenMounting {
                n_beams: beams.and_then(|it| it.n_beams).map(|it| it as u32),
                elevations_deg: beams.map(|it| it.elevations_deg.map(|it| round(it.into(), 0.1))),
                sensor: beams.and_then(|it| it.sensor()).map(str::to_owned),
                up_axis: ground.map(|(axis, _)| axis.name().to_owned()),
                height_m: ground.map(|(_, it)| round(it.height_m, 0.01)),
                tilt_deg: ground.filter(|it| it.0 == UpAxis::Z).map(|(_, it)| round(it.tilt_deg(), 0.1)),
                taken: Vec::new(),
            },
            mounting: Mounting::default(),
            suspicions: at_one_position.map(FrameSuspicion::SamePosition).into_iter().collect(),
            labels: LabelLook::default(),
        }
    }

    fn take(&mut self, config: &mut RunConfig, clouds: &[&PointCloud]) {
        self.take_sensor(config, clouds);
        self.take_ground();
    }

    /// Takes the known sensor with such beams, and the density of these very scans for a sensor that has no curve.
    fn take_sensor(&mut self, config: &mut RunConfig, clouds: &[&PointCloud]) {
        let mut sensor = self.sensor.clone();
        if !self.stated.sensor {
            match &self.seen.sensor {
                Some(seen) => sensor.clone_from(seen),
                None if self.is_of_format() || self.seen.elevations_deg.is_none() => {}
                None => sensor = format!("{UNKNOWN_SENSOR}{}", self.id),
            }
        }
        if take_density(config, [&self.id, &sensor], clouds) {
            self.seen.taken.push("density".to_owned());
        }
        if sensor != self.sensor {
            self.mounting.sensor = Some(sensor);
            self.seen.taken.insert(0, "sensor".to_owned());
        }
    }

    /// Whether the sensor is that of the format: those of benchmarks are known, but others write the same format.
    fn is_of_format(&self) -> bool {
        self.is_benchmark && !self.is_other_sensor
    }

    /// The sensor that a run takes if none is stated; `None` if it is that of the format.
    fn unstated_sensor(&self) -> Option<String> {
        match (&self.seen.sensor, self.seen.n_beams, self.seen.elevations_deg) {
            (Some(sensor), ..) => Some(format!("{sensor} (by its beams)")),
            _ if self.is_of_format() => None,
            (None, Some(n), _) => Some(format!("unknown, with {n} beams (density from the scans)")),
            (None, None, Some(_)) => Some(
                "unknown, with beams too close to each other to be counted (density from the scans)"
                    .to_owned(),
            ),
            (None, None, None) => Some(format!("not stated and not recognised; a run takes {}", self.sensor)),
        }
    }

    /// Takes height and tilt, or adds why they are suspect.
    fn take_ground(&mut self) {
        let Some((axis, ground)) = self.ground else {
            self.suspicions.push(FrameSuspicion::NoGround);
            return;
        };
        let height_m = ground.height_m;
        if axis != UpAxis::Z {
            self.suspicions.push(FrameSuspicion::Axis(axis));
            return;
        }
        let off_m = (height_m - self.said_height_m).abs();
        let is_as_said = self.stated.height && off_m <= SUSPECT_HEIGHT_M;
        if height_m < ON_GROUND_M && !is_as_said {
            self.suspicions.push(FrameSuspicion::OnGround(self.seen.height_m.unwrap_or(0.0)));
            return;
        }
        let other_m = if self.is_benchmark { SUSPECT_HEIGHT_M } else { OTHER_HEIGHT_M };
        if !self.stated.height && off_m > other_m {
            self.mounting.sensor_height_m = self.seen.height_m.map(|it| it as f32);
            self.seen.taken.push("height".to_owned());
        } else if off_m > SUSPECT_HEIGHT_M {
            self.suspicions.push(FrameSuspicion::Height { seen_m: height_m, said_m: self.said_height_m });
        }
        let tilt_deg = ground.tilt_deg();
        if tilt_deg <= STEEP_TILT_DEG {
            return;
        }
        if self.stated.transform {
            self.suspicions.push(FrameSuspicion::Tilt(tilt_deg));
        } else {
            self.mounting.sensor_from_file = Some(ground.levelling());
            self.seen.taken.push("tilt".to_owned());
        }
    }

    /// Compares labels with what stands on the ground, and adds why they are suspect.
    fn suspect_labels(&mut self, opened: &OpenedDataset, scans: &[LabeledScan]) {
        if self.ground.is_some_and(|(axis, _)| axis == UpAxis::Z) {
            self.labels = LabelLook::of(scans, || next_scans(opened, scans));
        }
        let suspicions = &self.labels.suspicions;
        let is_known = |it: &LabelSuspicion| {
            matches!(it, LabelSuspicion::Position { .. } | LabelSuspicion::Holes { .. })
        };
        let boxes = EmptyBoxes::of(scans);
        // Known reasons for empty boxes are enough.
        let are_empty = boxes.are_most() && !suspicions.iter().any(is_known);
        self.suspicions.extend(suspicions.iter().copied().map(FrameSuspicion::Labels));
        self.suspicions.extend(are_empty.then_some(FrameSuspicion::EmptyBoxes(boxes)));
    }

    /// Prints what is used and what was seen, and returns both.
    fn reported(self) -> (Mounting, FirstLook) {
        let sentence = format!("{}: {}", self.id, self.sentence());
        if self.seen.taken.is_empty() && self.suspicions.is_empty() {
            print_detail(sentence);
        } else {
            print_diagnostic(sentence);
        }
        let label_points = self.labels.points().map(SeenLabels::of);
        let (seen, suspicions) = (Some(self.seen), self.suspicions);
        (self.mounting, FirstLook { seen, label_points, suspicions, ..FirstLook::default() })
    }

    /// A sentence about the facts that were seen, and those of them that the run uses.
    fn sentence(&self) -> String {
        let seen = &self.seen;
        let beams = seen.elevations_deg.map_or_else(
            || "too few points to count beams".to_owned(),
            |[low, high]| {
                let sensor = seen.sensor.as_deref().map_or_else(String::new, |it| format!(" as {it} has"));
                let beams = seen.n_beams.map_or_else(
                    || "beams too close to each other to be counted".to_owned(),
                    |n| format!("{n} beams"),
                );
                format!("{beams} from {low:.1} to {high:.1} degrees{sensor}")
            },
        );
        let ground = match (seen.height_m, seen.tilt_deg) {
            (Some(height_m), Some(tilt_deg)) => {
                format!(", {height_m:.2} m above ground that is tilted by {tilt_deg:.1} degrees")
            }
            _ => String::new(),
        };
        let taken = match seen.taken.split_last() {
            None => String::new(),
            Some((only, [])) => format!("; {only} taken from the scans"),
            Some((last, rest)) => format!("; {} and {last} taken from the scans", rest.join(", ")),
        };
        format!("{beams}{ground}{taken}")
    }
}
