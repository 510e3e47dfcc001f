//! `scanbench selftest --protocol`: labels fed back under protocols of others.

use std::collections::BTreeSet;

use evaluation::protocols::chosen_protocols::{ChosenProtocols, ScanUnderProtocols, n_taken_once};
use reports::protocols::drawn_scans::DrawnScans;
use reports::protocols::kitti_object::measures::is_sound;
use reports::protocols::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use reports::protocols::protocol_tally::{ProtocolQuestion, ProtocolTally};
use reports::rows::scan_name::ScanName;
use reports::vocabulary::metric::Direction;
use reports::vocabulary::protocol::{Protocol, ProtocolFamily};
use scans::dataset::source::DamagePolicy;

use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::progress::progress_over_scans;
use crate::verbs::selftest_doors::Doors;

/// Name of the detector that labels are said to be of which are read as results of others are.
const AS_RESULTS: &str = "labels";
/// The same of those that count as detections with classes of a detector that runs here: without velocities and attributes.
const AS_DETECTIONS: &str = "a detector's classes";

/// One data set and protocol.
pub struct CheckedProtocol {
    dataset: String,
    protocol: Protocol,
    // How the labels are fed back.
    echo: &'static str,
    n_numbers: usize,
    // Numbers that are not the best there is.
    imperfect: Vec<(ProtocolMetric, f64)>,
    // Number of labels that the protocol takes only as annotations or only as detections.
    n_taken_once: usize,
}

impl CheckedProtocol {
    /// Whether every number of classes with labels is the best there is, as far as the protocol takes the labels.
    pub fn is_perfect(&self) -> bool {
        self.imperfect.is_empty() || self.n_taken_once > 0
    }
}

impl std::fmt::Display for CheckedProtocol {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { dataset, protocol, echo, n_numbers, imperfect, n_taken_once } = self;
        let verdict = match (self.is_perfect(), *n_taken_once) {
            (true, 0) => "ok",
            (true, _) => "unsure",
            (false, _) => "FAILED",
        };
        let way = match *echo {
            AS_RESULTS => String::new(),
            AS_DETECTIONS => format!(", as {AS_DETECTIONS}"),
            door => format!(", through {door}"),
        };
        write!(formatter, "{verdict:<6} {dataset}, protocol {protocol}{way}: ")?;
        if *n_taken_once > 0 {
            return write!(
                formatter,
                "takes {n_taken_once} labels as annotations or as detections only, so the best cannot be reached"
            );
        }
        write!(formatter, "{} of {n_numbers} numbers are the best there is", n_numbers - imperfect.len())?;
        imperfect
            .iter()
            .try_for_each(|(it, value)| write!(formatter, "; {} of {} is {value}", it.id, it.class))
    }
}

/// Feeds the labels of every scan back under each of `protocols`.
pub fn check_protocols(
    opened: &OpenedDataset,
    policy: DamagePolicy,
    protocols: &[Protocol],
    doors: Option<&mut Doors>,
) -> Result<Vec<CheckedProtocol>, Failure> {
    let Some(chosen) = ChosenProtocols::of(protocols) else { return Ok(Vec::new()) };
    chosen.check(&*opened.dataset)?;
    let id = &opened.dataset.description().id;
    let echoes = EchoedLabels::of(opened, policy, &chosen, protocols, doors)?;
    let checks = echoes.checked(id, protocols);
    if let Some(nothing) = checks.iter().find(|it| it.n_numbers == 0 && it.echo == AS_RESULTS) {
        let reason =
            format!("no label of {id:?} that counts has a class of the protocol {}", nothing.protocol);
        return Err(NothingEvaluated { reason }.into());
    }
    // Protocols of labels of points do not look at boxes.
    Ok(checks.into_iter().filter(|it| it.n_numbers > 0).collect())
}

/// Tally of the echoed labels of some scans.
struct EchoedLabels {
    tally: ProtocolTally,
    names: Vec<ScanName>,
    // By protocol.
    n_taken_once: Vec<usize>,
    // All ways in which labels are fed back.
    echoes: Vec<&'static str>,
}

impl EchoedLabels {
    fn of(
        opened: &OpenedDataset,
        policy: DamagePolicy,
        chosen: &ChosenProtocols,
        protocols: &[Protocol],
        mut doors: Option<&mut Doors>,
    ) -> Result<Self, Failure> {
        let of_doors = doors.iter().flat_map(|it| it.names());
        let mut echoes = Self {
            tally: ProtocolTally::default(),
            names: Vec::new(),
            n_taken_once: vec![0; protocols.len()],
            echoes: [AS_RESULTS, AS_DETECTIONS].into_iter().chain(of_doors).collect(),
        };
        let id = &opened.dataset.description().id;
        let progress = progress_over_scans(opened.scan_indices.len(), id);
        for &scan_idx in &opened.scan_indices {
            progress.inc(1);
            match opened.dataset.read_scan(scan_idx) {
                Ok(scan) => {
                    let under = chosen.scan(&*opened.dataset, scan_idx, &scan)?;
                    echoes.add(&under, protocols);
                    let of_doors = doors.as_mut().map(|it| it.rows(&scan, &under)).transpose()?;
                    of_doors.iter().flatten().for_each(|it| echoes.tally.add(it));
                }
                Err(error) => {
                    let scan_id = &opened.dataset.scan_ids()[scan_idx];
                    progress.suspend(|| opened.on_damage(policy, scan_id, error))?;
                }
            }
        }
        progress.finish_and_clear();
        Ok(echoes)
    }

    fn add(&mut self, scan: &ScanUnderProtocols<'_>, protocols: &[Protocol]) {
        let rows = scan.echoed_rows(AS_RESULTS);
        self.tally.add(&rows);
        self.tally.add(&scan.echoed_detections(AS_DETECTIONS));
        self.names.push(scan.name().clone());
        for (protocol, n) in protocols.iter().zip(&mut self.n_taken_once) {
            *n += n_taken_once(&rows, *protocol);
        }
    }

    fn checked(self, id: &str, protocols: &[Protocol]) -> Vec<CheckedProtocol> {
        let scans = DrawnScans::undrawn(self.names);
        let checks = protocols.iter().zip(self.n_taken_once);
        let checks =
            checks.flat_map(|(protocol, n)| self.echoes.iter().map(move |echo| (protocol, n, *echo)));
        checks.map(|(protocol, n, echo)| checked(id, *protocol, echo, n, &self.tally, &scans)).collect()
    }
}

/// Whether labels that are fed back in this way give the best value of `metric`: velocities and attributes are in results
/// alone, and the rest is as good as files have decimals.
fn gives(echo: &str, metric: &ProtocolMetric) -> bool {
    echo == AS_RESULTS || metric.id.split('_').any(|it| it == "ap")
}

fn checked(
    dataset: &str,
    protocol: Protocol,
    echo: &'static str,
    n_taken_once: usize,
    tally: &ProtocolTally,
    scans: &DrawnScans,
) -> CheckedProtocol {
    let rows = tally.rows(ProtocolQuestion { protocol, detector: echo }, scans);
    let values: Vec<(ProtocolMetric, f64)> = rows.map_or_else(Vec::new, |it| {
        let values = it.values(&vec![1; scans.names().len()]);
        it.metrics().into_iter().zip(values).filter_map(|(metric, value)| Some((metric, value?))).collect()
    });
    // Numbers of all classes count those without labels as not found: numbers of the present classes stand in, if any.
    let of_present: BTreeSet<String> =
        values.iter().filter(|(it, _)| it.class == PRESENT_CLASSES).map(|(it, _)| it.id.clone()).collect();
    // KITTI's own reading does not give the best of few annotations; ours has to.
    let is_asked = |metric: &ProtocolMetric| match protocol.family() {
        ProtocolFamily::KittiObjects => metric.class != ALL_CLASSES && is_sound(&metric.id),
        ProtocolFamily::RankedBoxes => metric.class != ALL_CLASSES,
        ProtocolFamily::Instances | ProtocolFamily::Ground => {
            metric.class != ALL_CLASSES || !of_present.contains(&metric.id)
        }
    };
    let is_given = |metric: &ProtocolMetric| is_asked(metric) && gives(echo, metric);
    let values: Vec<(ProtocolMetric, f64)> = values.into_iter().filter(|(it, _)| is_given(it)).collect();
    let n_numbers = values.len();
    let is_best = |(metric, value): &(ProtocolMetric, f64)| match metric.direction {
        Direction::HigherIsBetter => *value == 1.0,
        Direction::LowerIsBetter => *value == 0.0,
        Direction::Neither => true,
    };
    let imperfect = values.into_iter().filter(|it| !is_best(it)).collect();
    CheckedProtocol { dataset: dataset.to_owned(), protocol, echo, n_numbers, imperfect, n_taken_once }
}
