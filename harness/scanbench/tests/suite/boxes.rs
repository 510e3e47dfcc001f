//! Boxes of two fits around the same clusters.

use crate::program::Workplace;
use crate::shard_folders::{check_same_bytes, check_study};

const BOXES: &str = "boxes street-narrow --simulated-scans 3 --no-rrd";

#[test]
fn every_pair_has_all_boxes_and_every_number_its_denominators() {
    let workplace = Workplace::new();
    let ended = check_study(&workplace, BOXES, &[], check_same_bytes);
    assert!(
        ended.stdout.starts_with("Box errors of matched vehicles: street-narrow (simulated)\n"),
        "{ended:#?}"
    );
    let boxes = workplace.read("in-one/boxes.csv");
    let rows: Vec<Vec<&str>> = boxes.lines().skip(1).map(|it| it.split(',').collect()).collect();
    assert!(rows.len() > 20, "{boxes}");
    let fits = ["hull box", "PCA box", "closeness box", "outline box", "reported box"];
    for same in rows.chunks(5) {
        // All columns up to the number of points say which vehicle it is.
        assert!(same.iter().all(|it| it[..8] == same[0][..8]));
        assert!(same.iter().map(|it| it[8]).eq(fits));
        assert_eq!(same[0][1], "true");
    }
    let errors = workplace.read("in-one/box_errors.csv");
    let all = errors.lines().find(|it| it.contains(",all,,centre,m,hull box,")).expect("a row");
    assert_eq!(all.split(',').nth(7), Some((rows.len() / 5).to_string().as_str()), "{errors}");
    let of_ranges = errors.lines().filter(|it| it.contains(",range,") && it.contains(",yaw,deg,PCA box,"));
    let n_in_ranges: usize =
        of_ranges.map(|it| it.split(',').nth(7).expect("a column").parse::<usize>().expect("a count")).sum();
    assert_eq!(n_in_ranges, rows.len() / 5);
    workplace.check_file("in-one/boxes_simulated.svg", &["matched vehicles, simulated: median errors"]);
    // All points of the vehicles of a class lie somewhere, once in each frame.
    let points = workplace.read("in-one/box_points.csv");
    for frame in ["annotated box", "hull box", "reported box"] {
        let of_frame = points.lines().filter(|it| it.contains(&format!(",car,{frame},")));
        let shares =
            of_frame.map(|it| it.rsplit(',').next().expect("a column").parse::<f64>().expect("a share"));
        let sum: f64 = shares.sum();
        assert!((sum - 1.0).abs() < 1e-2, "{frame}: {sum}");
    }
    let manifest = workplace.json("in-one/manifest.json");
    assert_eq!(manifest["detectors"][0]["name"], "hierarchical");
}

#[test]
fn nothing_matched_is_nothing_evaluated() {
    let workplace = Workplace::new();
    workplace.refuse(
        &(BOXES, "-P matching.min_points=100000"),
        4,
        &["no cluster matches an annotated vehicle"],
    );
}
