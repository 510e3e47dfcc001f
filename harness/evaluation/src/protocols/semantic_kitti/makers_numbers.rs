//! Numbers of the makers' own programs for made-up scans: `made_up_scans.json`, which names programs and versions.

use std::collections::HashMap;

use detector::PointCloud;
use reports::rows::label_score_row::{GroundCounts, InstanceScore};
use reports::vocabulary::ground_definition::GroundDefinition;
use serde::Deserialize;

use super::ground_points::ground_counts;
use super::instance_scores::instance_scores;
use super::same_label_clusters::same_label_clusters;
use super::segmentation_entropies::segmentation_entropies;
use super::thing_counts::thing_counts;

/// Greatest allowed difference between numbers of a program and ours.
const TOLERANCE: f64 = 1e-9;

#[derive(Deserialize)]
struct MadeUpScans {
    scans: Vec<MadeUpScan>,
}

#[derive(Deserialize)]
struct MadeUpScan {
    name: String,
    labels: Vec<u32>,
    found: Vec<u32>,
    found_labels: Vec<u32>,
    ground: Vec<u8>,
    positions_m: Vec<[f32; 3]>,
    /// Of all instances, and of those with more than 50 points; `None` where the program divides by zero.
    s_assoc: [Option<f64>; 2],
    /// Quality and recall.
    unknown: [Option<f64>; 2],
    /// Matched, missed, false, overlaps of each class.
    things: [(u64, u64, u64, f64); 8],
    clusters: Vec<u32>,
    /// OSE and USE.
    entropies_nats: [f64; 2],
    /// Found, false, missed and other points.
    continuous_clustering_ground: [u64; 4],
    /// Precision, recall, accuracy.
    patchwork_ground_percent: [Option<f64>; 3],
    groundgrid_ground: Option<[u64; 4]>,
}

/// All made-up scans.
fn made_up_scans() -> Vec<MadeUpScan> {
    let scans: MadeUpScans = serde_json::from_str(include_str!("made_up_scans.json")).unwrap();
    assert_eq!(scans.scans.len(), 14);
    scans.scans
}

#[track_caller]
fn check(scan: &MadeUpScan, ours: Option<f64>, theirs: Option<f64>) {
    let is_same = match (ours, theirs) {
        (Some(a), Some(b)) => (a - b).abs() <= TOLERANCE,
        (a, b) => a == b,
    };
    assert!(is_same, "{}: {ours:?}, but the maker's program says {theirs:?}", scan.name);
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[test]
fn instances_have_the_scores_of_the_makers() {
    for scan in made_up_scans() {
        let scores = instance_scores(&scan.labels, &scan.found);
        let associations = |least: u64| -> Vec<f64> {
            scores.iter().filter(|it| it.n_points >= least).map(|it| it.association).collect()
        };
        check(&scan, mean(&associations(0)), scan.s_assoc[0]);
        check(&scan, mean(&associations(51)), scan.s_assoc[1]);
        let ious = |of: fn(&InstanceScore) -> f64| scores.iter().map(of).collect::<Vec<f64>>();
        check(&scan, mean(&ious(|it| it.matched_iou.unwrap_or_default())), scan.unknown[0]);
        check(&scan, mean(&ious(|it| f64::from(it.matched_iou.is_some()))), scan.unknown[1]);
    }
}

#[test]
fn things_are_counted_as_the_makers_count_them() {
    for scan in made_up_scans() {
        for (ours, theirs) in thing_counts(&scan.labels, &scan.found_labels).iter().zip(scan.things) {
            assert_eq!(
                (ours.n_matched, ours.n_missed, ours.n_false),
                (theirs.0, theirs.1, theirs.2),
                "{}",
                scan.name
            );
            check(&scan, Some(ours.iou_sum), Some(theirs.3));
        }
    }
}

/// The clusters, renumbered in the order of their first points.
fn renumbered(clusters: &[u32]) -> Vec<usize> {
    let mut numbers = HashMap::from([(0, 0)]);
    clusters
        .iter()
        .map(|it| {
            let next = numbers.len();
            *numbers.entry(*it).or_insert(next)
        })
        .collect()
}

#[test]
fn objects_and_entropies_are_those_of_the_makers() {
    for scan in made_up_scans() {
        let cloud: PointCloud = scan.positions_m.iter().copied().collect();
        let objects = same_label_clusters(&cloud, &scan.labels);
        assert_eq!(renumbered(&objects), renumbered(&scan.clusters), "{}", scan.name);
        let entropies = segmentation_entropies(&objects, &scan.found);
        check(&scan, Some(entropies.over_nats), Some(scan.entropies_nats[0]));
        check(&scan, Some(entropies.under_nats), Some(scan.entropies_nats[1]));
    }
}

#[test]
fn ground_is_counted_as_the_makers_count_it() {
    for scan in made_up_scans() {
        let z_m: Vec<f32> = scan.positions_m.iter().map(|it| it[2]).collect();
        let predicted: Vec<bool> = scan.ground.iter().map(|it| *it != 0).collect();
        let counts = |definition| ground_counts(definition, &scan.labels, &z_m, &predicted);
        let of = |it: GroundCounts| [it.n_found, it.n_false, it.n_missed, it.n_others];
        let ours = of(counts(GroundDefinition::ContinuousClustering));
        assert_eq!(ours, scan.continuous_clustering_ground, "{}", scan.name);
        if let Some(theirs) = scan.groundgrid_ground {
            assert_eq!(of(counts(GroundDefinition::GroundGrid)), theirs, "{}", scan.name);
        }
        let [n_found, n_false, n_missed, n_others] =
            of(counts(GroundDefinition::Patchwork)).map(|it| it as f64);
        let percent = |part: f64, whole: f64| (whole > 0.0).then(|| 100.0 * part / whole);
        let n_all = n_found + n_false + n_missed + n_others;
        check(&scan, percent(n_found, n_found + n_false), scan.patchwork_ground_percent[0]);
        check(&scan, percent(n_found, n_found + n_missed), scan.patchwork_ground_percent[1]);
        check(&scan, percent(n_found + n_others, n_all), scan.patchwork_ground_percent[2]);
    }
}
