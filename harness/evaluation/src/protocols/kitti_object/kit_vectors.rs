//! Our numbers compared with those of KITTI's development kit, on made-up scans and on a simulated street.
//!
//! `.ci/agreement/kitti_vectors.py` made the numbers, with `evaluate_object.cpp` of the kit of 2019 and later (41 recalls,
//! of which the readme averages 40; SHA-256 21738428…). The last case is a simulated street with detections of
//! `hierarchical`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use reports::protocols::kitti_object::averages::Recalls;
use reports::protocols::kitti_object::measures::Reading;
use reports::protocols::kitti_object::numbers::KittiMatches;
use reports::protocols::kitti_object::scan::KittiScan;
use scans::dataset::class_table::{ClassReader, ClassRules};
use scans::dataset::kitti::label::{KITTI_VOCABULARY, KittiLabel, KittiObject, parse_tracking_labels};

use super::label_facts::facts_of_results;

const CASES: [&str; 10] = [
    "street",
    "exact",
    "rounded-scores",
    "like-scores",
    "fed-back",
    "few",
    "no-headings",
    "no-cyclists",
    "low",
    "simulated-street",
];

/// Numbers that differ by less are equal: the files have twelve digits.
const NEGLIGIBLE: f64 = 1e-9;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/kitti_object")
}

fn labels_of(path: &Path) -> BTreeMap<u32, Vec<KittiLabel>> {
    let text = std::fs::read_to_string(path).unwrap();
    let rules = ClassRules::default();
    let mut classes = ClassReader::new(&rules, KITTI_VOCABULARY);
    parse_tracking_labels(path, &text, &mut classes).unwrap()
}

/// The scans of a case.
fn scans_of(labels: &Path, results: &Path) -> Vec<KittiScan> {
    let (labels, results) = (labels_of(labels), labels_of(results));
    let last = labels.keys().chain(results.keys()).max().copied().unwrap_or_default();
    let of =
        |labels: &BTreeMap<u32, Vec<KittiLabel>>, scan: u32| labels.get(&scan).cloned().unwrap_or_default();
    let scan = |scan: u32| {
        let found: Vec<KittiObject> =
            of(&results, scan).iter().filter_map(KittiLabel::object).cloned().collect();
        KittiScan::of(facts_of_results(&of(&labels, scan), &found)).unwrap()
    };
    (0..=last).map(scan).collect()
}

/// The kit's numbers by the names of ours; NaN where it divides zero by zero.
fn kit_numbers(path: &Path) -> BTreeMap<(String, String), f64> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut numbers = BTreeMap::new();
    for line in text.lines().skip(1) {
        let [demand, class, plane, difficulty, average, r11, r40] = line.split(',').collect::<Vec<_>>()[..]
        else {
            panic!("{line}");
        };
        let demand = if demand == "loose" { "_loose" } else { "" };
        let average = if average == "aos" { "aos".to_owned() } else { format!("ap_{plane}") };
        for (recalls, value) in [("r11", r11), ("r40", r40)] {
            let id = format!("{average}{demand}_{difficulty}_{recalls}");
            numbers.insert((class.to_owned(), id), value.trim_start_matches('-').parse().unwrap());
        }
    }
    numbers
}

/// Compares all numbers and returns how many the kit has and how many are above 0.
#[track_caller]
fn check(scans: &[KittiScan], kit: &Path) -> (usize, usize) {
    let placed: Vec<(u32, &KittiScan)> = (0..).zip(scans).collect();
    let matches = KittiMatches::of(&placed);
    let values = matches.values(&vec![1; scans.len()]);
    let kit = kit_numbers(kit);
    let (mut n_compared, mut n_above_zero) = (0, 0);
    for ((measure, n_annotations), value) in matches.measures().into_iter().zip(values) {
        if measure.reading == Reading::Sound {
            continue;
        }
        let class = measure.question.class.name().to_owned();
        let Some(&expected) = kit.get(&(class.clone(), measure.id())) else {
            // The kit leaves out classes without detections, and headings if one is unknown.
            assert!(value.is_none_or(|it| it == 0.0), "{class} {} is {value:?}", measure.id());
            continue;
        };
        n_compared += 1;
        n_above_zero += usize::from(expected > 0.0);
        match value {
            Some(value) => {
                let difference = (value - expected).abs();
                assert!(difference < NEGLIGIBLE, "{class} {}: {value}, not {expected}", measure.id());
            }
            None => assert!(expected.is_nan() || n_annotations == 0 && expected == 0.0),
        }
    }
    (n_compared, n_above_zero)
}

#[test]
fn made_up_scans_have_the_numbers_of_the_kit() {
    let (mut n_compared, mut n_above_zero) = (0, 0);
    for case in CASES {
        let file = |ending: &str| folder().join(format!("{case}.{ending}"));
        let scans = scans_of(&file("labels.txt"), &file("results.txt"));
        let (compared, above_zero) = check(&scans, &file("kit.csv"));
        (n_compared, n_above_zero) = (n_compared + compared, n_above_zero + above_zero);
    }
    assert!(n_compared > 800 && n_above_zero > 500, "{n_above_zero} of {n_compared}");
}

#[test]
fn annotations_fed_back_reach_the_maximum_of_the_sound_reading_alone() {
    let scans = scans_of(&folder().join("fed-back.labels.txt"), &folder().join("fed-back.results.txt"));
    let placed: Vec<(u32, &KittiScan)> =
        (0..).zip(&scans).filter(|(_, it)| !it.detections().is_empty()).collect();
    let matches = KittiMatches::of(&placed);
    let values = matches.values(&vec![1; scans.len()]);
    for ((measure, n_annotations), value) in matches.measures().into_iter().zip(values) {
        assert!(n_annotations > 0);
        match measure.reading {
            Reading::Sound => assert_eq!(value, Some(1.0), "{}", measure.id()),
            // The kit samples precision at no more recalls than there are annotations.
            Reading::Official if n_annotations < 41 && measure.recalls == Recalls::R40 => {
                assert!(value.is_some_and(|it| it < 1.0), "{}: {value:?}", measure.id());
            }
            Reading::Official => assert!(value.is_some_and(|it| it <= 1.0)),
        }
    }
}
