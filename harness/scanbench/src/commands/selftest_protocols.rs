//! `scanbench selftest --protocol`: labels fed back under protocols of others.

use std::collections::BTreeSet;

use detector::DetectorOutput;
use evaluation::protocols::known_protocols::official_protocol;
use evaluation::protocols::official_objects::OfficialScanView;
use evaluation::protocols::official_protocol::{FoundInScan, ProtocolRows};
use evaluation::protocols::semantic_kitti::label_scores::{LabeledPoints, scores_labels};
use reports::protocols::drawn_scans::DrawnScans;
use reports::protocols::kitti_object::measures::is_sound;
use reports::protocols::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use reports::protocols::protocol_tally::{ProtocolQuestion, ProtocolTally};
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::ranked_box_row::BoxState;
use reports::rows::scan_name::ScanName;
use reports::vocabulary::metric::Direction;
use reports::vocabulary::protocol::Protocol;
use scans::dataset::source::DamagePolicy;

use crate::commands::failure::{Failure, NothingEvaluated};
use crate::commands::official_evaluation::labels_for;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::progress::progress_over_scans;

/// What the labels are said to be found by.
const ECHO: &str = "labels";

/// One data set and protocol.
pub struct CheckedProtocol {
    dataset: String,
    protocol: Protocol,
    n_numbers: usize,
    // Those that are not the best there is.
    imperfect: Vec<(ProtocolMetric, f64)>,
    // Labels that the protocol takes no more of in a scan.
    n_beyond_number: usize,
}

impl CheckedProtocol {
    /// Whether every number of classes with labels is the best there is, as far as the protocol takes the labels.
    pub fn is_perfect(&self) -> bool {
        self.imperfect.is_empty() || self.n_beyond_number > 0
    }
}

impl std::fmt::Display for CheckedProtocol {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { dataset, protocol, n_numbers, imperfect, n_beyond_number } = self;
        let verdict = if self.is_perfect() { "ok" } else { "FAILED" };
        write!(formatter, "{verdict:<6} {dataset}, protocol {protocol}: ")?;
        if *n_beyond_number > 0 {
            return write!(
                formatter,
                "takes {n_beyond_number} labels fewer than there are, so the best cannot be reached"
            );
        }
        write!(formatter, "{} of {n_numbers} numbers are the best there is", n_numbers - imperfect.len())?;
        imperfect
            .iter()
            .try_for_each(|(it, value)| write!(formatter, "; {} of {} is {value}", it.id, it.class))
    }
}

/// Feeds the labels of every scan back under each of `protocols`.
///
/// # Errors
///
/// [`NothingEvaluated`] if no label has a class of one of them; if data cannot be read.
pub fn check_protocols(
    opened: &OpenedDataset,
    policy: DamagePolicy,
    protocols: &[Protocol],
) -> Result<Vec<CheckedProtocol>, Failure> {
    if protocols.is_empty() {
        return Ok(Vec::new());
    }
    let id = &opened.dataset.description().id;
    for protocol in protocols {
        if let Some(lacks) = official_protocol(*protocol).and_then(|it| it.lacks(&*opened.dataset)) {
            return Err(Failure::usage(format!("--protocol {protocol}"), format!("{id:?} {lacks}")));
        }
    }
    let (mut tally, mut names) = (ProtocolTally::default(), Vec::new());
    let mut n_beyond_number = vec![0; protocols.len()];
    let progress = progress_over_scans(opened.scan_indices.len(), id);
    for &scan_idx in &opened.scan_indices {
        progress.inc(1);
        let scan = match opened.dataset.read_scan(scan_idx) {
            Ok(scan) => scan,
            Err(error) => {
                let scan_id = &opened.dataset.scan_ids()[scan_idx];
                progress.suspend(|| opened.on_damage(policy, scan_id, error))?;
                continue;
            }
        };
        let asked: Vec<Protocol> = protocols.iter().copied().filter(|it| scores_labels(*it)).collect();
        let name = ScanName { dataset: id.clone(), sequence: scan.id.sequence.clone(), scan: scan.id.index };
        names.push(name.clone());
        if !asked.is_empty() {
            let labels = labels_for(&asked, &*opened.dataset, (scan_idx, &scan))?;
            add_echoed_labels(&mut tally, &name, &LabeledPoints::new(&scan.cloud, labels, &asked), &asked);
        }
        let view = OfficialScanView::new(&*opened.dataset, scan_idx, &scan)?;
        let (output, objects) = (DetectorOutput::default(), view.echoed());
        let kitti_objects = view.echoed_kitti();
        let found = FoundInScan {
            name,
            detector: ECHO,
            view: &view,
            output: &output,
            objects: &objects,
            kitti_objects: Some(&kitti_objects),
        };
        for (protocol, n_beyond) in protocols.iter().zip(&mut n_beyond_number) {
            if let Some(protocol) = official_protocol(*protocol) {
                *n_beyond += add_echoed_boxes(&mut tally, &protocol.rows(&found));
            }
        }
    }
    progress.finish_and_clear();
    let scans = DrawnScans::undrawn(names);
    let checks = protocols.iter().zip(n_beyond_number);
    let checks: Vec<CheckedProtocol> =
        checks.map(|(protocol, n)| checked(id, *protocol, n, (&tally, &scans))).collect();
    if let Some(nothing) = checks.iter().find(|it| it.n_numbers == 0) {
        let reason =
            format!("no label of {id:?} that counts has a class of the protocol {}", nothing.protocol);
        return Err(NothingEvaluated { reason }.into());
    }
    Ok(checks)
}

/// Returns how many are beyond the number that a protocol evaluates.
fn add_echoed_boxes(tally: &mut ProtocolTally, rows: &ProtocolRows) -> usize {
    match rows {
        ProtocolRows::RankedBoxes(rows) => {
            for row in rows {
                tally.add_ranked_box(row);
            }
            rows.iter().filter(|it| it.ranked_box.state == BoxState::BeyondNumber).count()
        }
        ProtocolRows::KittiObjects(rows) => {
            for row in rows {
                tally.add_kitti_object(row);
            }
            0
        }
    }
}

fn add_echoed_labels(
    tally: &mut ProtocolTally,
    name: &ScanName,
    points: &LabeledPoints<'_>,
    protocols: &[Protocol],
) {
    for score in protocols.iter().flat_map(|it| points.echoed_scores(*it)) {
        tally.add_label_score(&LabelScoreRow { scan: name.clone(), detector: ECHO.to_owned(), score });
    }
}

fn checked(
    dataset: &str,
    protocol: Protocol,
    n_beyond_number: usize,
    (tally, scans): (&ProtocolTally, &DrawnScans),
) -> CheckedProtocol {
    let rows = tally.rows(ProtocolQuestion { protocol, detector: ECHO }, scans);
    let values: Vec<(ProtocolMetric, f64)> = rows.map_or_else(Vec::new, |it| {
        let values = it.values(&vec![1; scans.names().len()]);
        it.metrics().into_iter().zip(values).filter_map(|(metric, value)| Some((metric, value?))).collect()
    });
    // Of all classes together those without labels count as not found, where there is a number of the others, too.
    let of_present: BTreeSet<String> =
        values.iter().filter(|(it, _)| it.class == PRESENT_CLASSES).map(|(it, _)| it.id.clone()).collect();
    // KITTI's own reading does not give the best of few annotations; ours has to.
    let is_asked = |metric: &ProtocolMetric| match protocol {
        Protocol::KittiObject => metric.class != ALL_CLASSES && is_sound(&metric.id),
        Protocol::Nuscenes | Protocol::Argoverse2 => metric.class != ALL_CLASSES,
        Protocol::SemanticKitti | Protocol::Ground => {
            metric.class != ALL_CLASSES || !of_present.contains(&metric.id)
        }
    };
    let values: Vec<(ProtocolMetric, f64)> = values.into_iter().filter(|(it, _)| is_asked(it)).collect();
    let n_numbers = values.len();
    let is_best = |(metric, value): &(ProtocolMetric, f64)| match metric.direction {
        Direction::HigherIsBetter => *value == 1.0,
        Direction::LowerIsBetter => *value == 0.0,
        Direction::Neither => true,
    };
    let imperfect = values.into_iter().filter(|it| !is_best(it)).collect();
    CheckedProtocol { dataset: dataset.to_owned(), protocol, n_numbers, imperfect, n_beyond_number }
}
