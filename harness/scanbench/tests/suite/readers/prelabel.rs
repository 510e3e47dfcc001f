//! `scanbench data prelabel`: what a detector finds, written for annotation tools and read back as ground truth.

use std::collections::BTreeMap;

use reports::vocabulary::class::AnnotationClass;
use scans::annotation::LabeledScan;

use super::made::scans;
use super::open;
use crate::program::{Ended, Prepared, Workplace};

/// A workplace with two scans in `street.mcap`.
fn street() -> Workplace {
    static STREET: Prepared = Prepared::new();
    STREET.workplace(|workplace| {
        workplace.succeed("data simulate street-main-road --simulated-scans 2 -o street.mcap");
    })
}

fn prelabel(workplace: &Workplace, tool: &str, options: &[&str]) -> Ended {
    workplace.succeed(&("data prelabel street.mcap --to", tool, ["-o", tool], options))
}

/// The vehicles of `run` in `matches.csv` of the task *vehicles*, by scan: what `prelabel` has to propose.
fn vehicles(workplace: &Workplace) -> Vec<usize> {
    workplace.succeed("run street.mcap -d hierarchical --no-rrd -o run");
    let mut n_by_scan = BTreeMap::new();
    for row in workplace.table("run/matches.csv") {
        if row["task"] == "objects" && row["detection_class"] == "vehicle" {
            *n_by_scan.entry(row["scan"].parse::<u32>().unwrap()).or_default() += 1;
        }
    }
    n_by_scan.into_values().collect()
}

#[test]
fn proposals_are_read_back_as_the_same_boxes() {
    let workplace = street();
    let n_expected = vehicles(&workplace);
    let mut read: Vec<Vec<LabeledScan>> = Vec::new();
    for (tool, format) in
        [("kitti", "kitti-object"), ("labelcloud", "scan-folder"), ("sustechpoints", "scan-folder")]
    {
        let ended = prelabel(&workplace, tool, &[]);
        let n_all: usize = n_expected.iter().sum();
        ended.check_stdout(&[&format!("2 scans  {n_all} proposals  {tool}, simulated")]);
        let dataset = open(&workplace.path(tool));
        assert_eq!(dataset.description().format, format);
        assert!(dataset.description().is_simulated());
        read.push(scans(&*dataset));
        workplace.succeed(&["selftest", tool]);
    }
    for (scan_idx, n_expected) in n_expected.into_iter().enumerate() {
        let [kitti, label_cloud, sustech] = [0, 1, 2].map(|tool| &read[tool][scan_idx]);
        assert!(n_expected > 1 && kitti.annotations.len() == n_expected, "{n_expected}");
        for other in [label_cloud, sustech] {
            assert_eq!(kitti.cloud, other.cloud);
            assert_eq!(other.annotations.len(), n_expected);
            for (a, b) in kitti.annotations.iter().zip(&other.annotations) {
                assert_eq!((a.class, b.class), (AnnotationClass::Car, AnnotationClass::Car));
                let (a, b) = (a.bounding_box.unwrap(), b.bounding_box.unwrap());
                assert!((0..3).all(|axis| (a.center_m[axis] - b.center_m[axis]).abs() < 1e-4), "{a:?} {b:?}");
                assert_eq!(a.length_width_height_m, b.length_width_height_m);
                assert!((a.yaw_rad - b.yaw_rad).sin().abs() < 1e-5, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn what_finds_the_same_scores_one_on_its_own_proposals() {
    let workplace = street();
    prelabel(&workplace, "sustechpoints", &[]);
    let run = "run sustechpoints -d hierarchical --no-rrd -o run -P matching.min_points=1";
    workplace.succeed(&(run, "--criterion bev-iou"));
    for row in workplace.table("run/scans.csv").iter().filter(|it| it["task"] == "vehicles") {
        assert_eq!((row["mo"].as_str(), row["fo"].as_str()), ("0", "0"), "{row:?}");
    }
}

#[test]
fn sure_ones_alone_are_fewer() {
    let workplace = street();
    let n_boxes = |tool: &str| -> usize {
        scans(&*open(&workplace.path(tool))).iter().map(|it| it.annotations.len()).sum()
    };
    prelabel(&workplace, "kitti", &[]);
    prelabel(&workplace, "labelcloud", &["--min-score", "3"]);
    let (n_sure, n_all) = (n_boxes("labelcloud"), n_boxes("kitti"));
    assert!(0 < n_sure && n_sure < n_all, "{n_sure} of {n_all}");
}
