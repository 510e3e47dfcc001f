//! `--protocol semantic-kitti,ground`: scores of labels of points.

use std::path::Path;

use evaluation::protocols::semantic_kitti::ground_points::ground_counts;
use evaluation::protocols::semantic_kitti::instance_scores::instance_scores;
use evaluation::protocols::semantic_kitti::same_label_clusters::same_label_clusters;
use evaluation::protocols::semantic_kitti::segmentation_entropies::segmentation_entropies;
use evaluation::protocols::semantic_kitti::thing_counts::thing_counts;
use reports::protocols::protocol_report::ProtocolReport;
use reports::rows::label_score_row::{GroundCounts, InstanceScore, ThingCounts};
use reports::vocabulary::ground_definition::GroundDefinition;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};
use test_data::test_data;

use crate::program::Workplace;

/// A simulated drive in SemanticKITTI's format, in the folder `drive`.
fn simulate(workplace: &Workplace) {
    let street = ["data", "simulate", "street-narrow", "--sensor", "vlp-16", "--simulated-scans", "3"];
    workplace.succeed(&(&street, "--to semantic-kitti -o drive"));
}

fn numbers_of(run: &Path) -> ProtocolReport {
    ProtocolReport::read(&run.join("protocols.json")).expect("a run leaves it")
}

/// The value of a metric of a detector.
fn value(report: &ProtocolReport, detector: &str, class: &str, id: &str) -> Option<f64> {
    let mut rows = report.rows.iter();
    let is_asked = rows.find(|it| it.detector == detector && it.metric.class == class && it.metric.id == id);
    is_asked.unwrap_or_else(|| panic!("no {id} of {class} by {detector}")).value
}

#[test]
fn labels_of_results_are_scored_and_the_truth_is_perfect() {
    let workplace = Workplace::new();
    simulate(&workplace);
    let run =
        ["run", "drive", "-d", "hierarchical,pca", "--detections", "truth=drive", "--no-rrd", "-o", "run"];
    let ended = workplace.succeed(&(&run, "--protocol semantic-kitti,ground"));
    ended.check_stderr(&["\"pca\" does not predict which points are ground"]);
    ended.check_stdout(&["s_assoc_over_50_points"]);
    let report = numbers_of(&workplace.path("run"));
    for (class, id) in
        [("all", "s_assoc"), ("all", "unknown_quality"), ("present", "pq"), ("groundgrid", "f1")]
    {
        assert_eq!(value(&report, "truth", class, id), Some(1.0), "{class} {id}");
    }
    let of_ours =
        ["s_assoc", "s_assoc_over_50_points"].map(|id| value(&report, "hierarchical", "all", id).unwrap());
    assert!(of_ours.iter().all(|it| (0.1..1.0).contains(it)), "{of_ours:?}");
    assert!(value(&report, "hierarchical", "groundgrid", "precision").is_some_and(|it| it > 0.5));
    assert!(report.rows.iter().all(|it| it.detector != "pca" || it.metric.id != "f1"));
    let selftest = workplace.succeed("selftest drive --protocol semantic-kitti,ground");
    assert_eq!(selftest.stdout.matches("numbers are the best there is").count(), 2, "{}", selftest.stdout);
}

#[test]
fn without_labels_of_points_there_is_nothing_to_score() {
    let workplace = Workplace::new();
    let run =
        ["run", "street-narrow", "--simulated-scans", "1", "--sensor", "vlp-16", "--protocol", "ground"];
    let ended = workplace.refuse(&run, 2, &[]);
    let expected =
        "--protocol ground needs labels of points, as semantic-kitti has them; \"street-narrow\" has none";
    ended.check_stderr(&[expected]);
    assert_eq!(workplace.top_names(), Vec::<String>::new());
}

/// What the makers' programs say of the shared scans where whatever stands higher than 1.5 m below the sensor is found in
/// columns of 2 m, and all below is classified as ground; versions as in `docs/protocols.md`.
#[test]
#[ignore = "needs data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn real_scans_have_the_numbers_of_the_makers() {
    let source = test_data("data/semantic_kitti").display().to_string();
    let dataset = open_dataset(&source, &OpenOptions::default(), &built_in_catalogue().unwrap()).unwrap();
    let (mut instances, mut cars) = (Vec::new(), ThingCounts::default());
    let (mut nats, mut ground) = (Vec::new(), [[0_u64; 4]; 3]);
    for scan_idx in 0..3 {
        let scan = dataset.read_scan(scan_idx).unwrap();
        let labels = dataset.point_labels(scan_idx, &scan).unwrap().unwrap();
        let column_of = |[x_m, y_m, z_m]: [f32; 3]| {
            let [x, y] = [x_m, y_m].map(|it| (it / 2.0).floor() as i64);
            if z_m > -1.5 { ((x + 512) * 1024 + y + 513) as u32 } else { 0 }
        };
        let found: Vec<u32> = scan.cloud.positions_m().map(column_of).collect();
        instances.extend(instance_scores(&labels, &found));
        let found_labels: Vec<u32> =
            found.iter().map(|it| if *it == 0 { 0 } else { 10 + ((it % 65536) << 16) }).collect();
        let of_cars = thing_counts(&labels, &found_labels)[0];
        cars.n_matched += of_cars.n_matched;
        cars.n_missed += of_cars.n_missed;
        cars.n_false += of_cars.n_false;
        cars.iou_sum += of_cars.iou_sum;
        let objects = same_label_clusters(&scan.cloud, &labels);
        let entropies = segmentation_entropies(&objects, &found);
        nats.push((entropies.n_objects, entropies.over_nats, entropies.under_nats));
        let predicted: Vec<bool> = found.iter().map(|it| *it == 0).collect();
        for (sums, definition) in ground.iter_mut().zip(GroundDefinition::ALL) {
            let GroundCounts { n_found, n_false, n_missed, n_others } =
                ground_counts(definition, &labels, scan.cloud.z_m(), &predicted);
            sums.iter_mut().zip([n_found, n_false, n_missed, n_others]).for_each(|(sum, it)| *sum += it);
        }
    }
    let close = |ours: f64, theirs: f64| assert!((ours - theirs).abs() < 1e-9, "{ours} {theirs}");
    let mean = |least: u64, of: fn(&InstanceScore) -> f64| {
        let large: Vec<f64> = instances.iter().filter(|it| it.n_points >= least).map(of).collect();
        large.iter().sum::<f64>() / large.len() as f64
    };
    close(mean(0, |it| it.association), 0.362_078_374_838_178);
    close(mean(51, |it| it.association), 0.323_670_087_378_880_8);
    close(mean(0, |it| it.matched_iou.unwrap_or_default()), 0.350_767_050_309_292_9);
    close(mean(0, |it| f64::from(it.matched_iou.is_some())), 0.476_190_476_190_476_2);
    assert_eq!((cars.n_matched, cars.n_missed, cars.n_false), (17, 21, 440));
    close(cars.iou_sum, 12.574_374_741_107_835);
    let theirs = [
        (104, 89.607_696_955_911_62, 63.667_143_460_799_47),
        (103, 88.098_967_542_866_57, 67.600_857_418_585_9),
        (101, 82.334_557_594_662_85, 56.181_572_263_528_52),
    ];
    for (ours, theirs) in nats.iter().zip(theirs) {
        assert_eq!(ours.0, theirs.0);
        close(ours.1, theirs.1);
        close(ours.2, theirs.2);
    }
    let [_, of_groundgrid, of_continuous_clustering] = ground;
    assert_eq!(of_groundgrid, [190_857, 6359, 9371, 79_463]);
    assert_eq!(of_continuous_clustering, [190_857, 16_532, 9371, 150_543]);
}
