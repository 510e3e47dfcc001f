//! `run --detections` and `--detections-out`: results that are carried from one program to another, and judged.

use test_data::test_data;

use crate::program::{Workplace, copy_folder};

/// What was counted for `detector`, scan by scan.
fn counts(workplace: &Workplace, run: &str, detector: &str) -> Vec<Vec<String>> {
    let of_detector = workplace.table(&format!("{run}/scans.csv")).into_iter();
    let of_detector = of_detector
        .filter(|it| it["detector"] == detector && ["objects", "vehicles"].contains(&it["task"].as_str()));
    let columns = ["dataset", "scan", "task", "status", "no", "tp", "mo", "fo", "ignored_detections"];
    of_detector.map(|row| columns.iter().map(|it| row[*it].clone()).collect()).collect()
}

/// Warnings are said: nothing is quiet.
const OUTPUT: &str = "--no-rrd -o";

#[test]
fn our_own_results_are_judged_as_we_are() {
    for format in ["kitti", "csv"] {
        let workplace = Workplace::with_drive(4);
        // By size, because the drawn cars are blocks, which the trained model takes for none.
        let ours = ["run", "street", "-d", "hierarchical,pca", "-P", "vehicle_model.enabled=false"];
        workplace.succeed(&(&ours, OUTPUT, ["first", "--detections-out", "found", "--as", format]));
        let theirs =
            ["--detections", "a=found/hierarchical", "--detections", "b=found/pca", "-d", "simple-grid"];
        let ended = workplace.succeed(&("run street", &theirs, OUTPUT, "second"));
        assert_eq!(ended.stderr.matches("warning").count(), 0, "{}", ended.stderr);
        for (name, known) in [("hierarchical", "a"), ("pca", "b")] {
            let (first, second) = (counts(&workplace, "first", name), counts(&workplace, "second", known));
            assert_eq!((first.len(), &first), (8, &second), "{format}");
        }
        assert!(counts(&workplace, "second", "a").iter().any(|it| it[5] == "2"), "both cars are found");
        // Nothing was timed, and nothing stands in columns of times.
        for row in workplace.table("second/scans.csv") {
            let has_time = ["latency_ms", "least_latency_ms", "cpu_ms"].iter().any(|it| !row[*it].is_empty());
            assert_eq!(has_time, row["detector"] == "simple-grid", "{row:?}");
        }
        workplace.check_file("second/manifest.json", &["\"results\": \"found/hierarchical\""]);
        workplace.check_file("second/report.html", &["simple-grid"]);
    }
}

/// Boxes of vehicles that are unlikely, and scores of boxes, are carried, too.
#[test]
fn protocols_rank_our_own_results_as_they_rank_us() {
    let workplace = Workplace::new();
    let street = ["street-intersection", "--simulated-scans", "4", "--protocol", "nuscenes"];
    let ours = [&["run"], &street[..], &["-d", "hierarchical"]].concat();
    workplace.succeed(&(&ours, OUTPUT, "first --detections-out found --as csv"));
    let files = workplace.names().into_iter().filter(|it| it.starts_with("found"));
    let csv = files.filter(|it| it.extension().is_some_and(|it| it == "csv"));
    let boxes: String = csv.map(|it| workplace.read(&it.display().to_string())).collect();
    assert!(boxes.contains(",true\n"), "{boxes}");
    let theirs = [&["run"], &street[..], &["-d", "hierarchical", "--detections", "again=found/hierarchical"]];
    workplace.succeed(&(&theirs.concat(), OUTPUT, "second"));
    assert_eq!(counts(&workplace, "second", "again"), counts(&workplace, "second", "hierarchical"));
    let report = workplace.json("second/protocols.json");
    let numbers = |detector: &str| -> Vec<f64> {
        let rows = report["rows"].as_array().unwrap().iter().filter(|it| it["detector"] == detector);
        rows.filter_map(|it| it["value"].as_f64()).collect()
    };
    let (again, ours) = (numbers("again"), numbers("hierarchical"));
    // Files have four decimals.
    assert!(again.len() > 20 && again.len() == ours.len());
    assert!(again.iter().zip(&ours).all(|(a, b)| (a - b).abs() < 1e-4), "{again:?} {ours:?}");
}

#[test]
fn several_data_sets_have_a_folder_each() {
    let workplace = Workplace::new();
    let streets = ["street-narrow", "street-intersection", "--simulated-scans", "4", "--sensor", "vlp-16"];
    let ours = [&["run"], &streets[..], &["-d", "simple-grid"]].concat();
    workplace.succeed(&(&ours, OUTPUT, "first --detections-out found --as csv"));
    assert!(workplace.path("found/simple-grid/street-narrow").is_dir());
    workplace.write("scanbench.toml", "[detector.again]\nresults = \"found/simple-grid\"\n");
    let theirs = [&["run"], &streets[..], &["-d", "again,simple-grid"]].concat();
    workplace.succeed(&(&theirs, OUTPUT, "second"));
    let again = counts(&workplace, "second", "again");
    assert!(again.len() == 16 && again == counts(&workplace, "second", "simple-grid"), "{again:?}");
}

#[test]
fn scans_without_results_count_as_nothing_found_where_that_is_asked_for() {
    let workplace = Workplace::with_drive(2);
    let boxes = "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad\n";
    workplace.write("found/0000/000000.csv", boxes);
    workplace
        .succeed("run street -d pca --detections a=found --missing-detections empty -o out --no-rrd")
        .check_stderr(&["has no results for 1 scans, which count as nothing found"]);
    let missed = counts(&workplace, "out", "a");
    assert!(missed.iter().all(|it| it[5] == "0"), "{missed:?}");
    // Other verbs need a detector that runs.
    workplace.write("scanbench.toml", "[detector.a]\nresults = \"found\"\n");
    workplace.refuse("detect street --scan 0 -d a", 2, &["which only `scanbench run` judges"]);
}

#[test]
fn what_cannot_be_written_is_reported_before_the_first_scan_is_read() {
    let workplace = Workplace::with_drive(2);
    workplace.write("street/training/velodyne/0000/000000.bin", "damaged");
    let run = |format: &str| {
        let arguments = ["run", "street", "-d", "pca", "--detections-out", "x", "--as", format];
        workplace.run(&(&arguments, OUTPUT, "out"))
    };
    let ended = run("nuscenes");
    assert_eq!(ended.exit_code, Some(2), "{ended:#?}");
    ended.check_stderr(&["its data set has no samples of nuScenes"]);
    assert_eq!(run("kitti").exit_code, Some(3));
    assert!(!workplace.path("x").exists());
}

/// They are what is under test.
#[test]
fn a_gate_judges_results_of_other_files() {
    let workplace = Workplace::with_drive(2);
    let run = |output: &str| {
        let arguments = ["run", "street", "-d", "pca", "--detections", "deep=found"];
        workplace.succeed(&(&arguments, OUTPUT, [output]));
    };
    for number in 0..2 {
        workplace.write(&format!("found/{number:06}.txt"), "");
    }
    run("first");
    run("again");
    workplace.write("found/000001.txt", "Car -1 -1 0 0 0 1 1 1.5 2 4 0 1 10 0 0.5\n");
    run("other");
    workplace.write(
        "tolerances.toml",
        "[[quality]]\nmetrics = [\"recall\"]\nslices = [\"all\"]\nabsolute = 0.02\nrelative = 0.0\n",
    );
    let gate = |run: &str, options: &str| {
        workplace.run(&(["gate", run, "-b", "golden", "-t", "tolerances.toml"], options))
    };
    // Whoever changes the program runs this before there is a commit of it.
    let clean = |run: &str| {
        let path = format!("{run}/manifest.json");
        let manifest = workplace.read(&path).replace("\"dirty\": true", "\"dirty\": false");
        workplace.write(&path, &manifest);
    };
    ["first", "other"].into_iter().for_each(clean);
    workplace.succeed(&["baseline", "accept", "first", "-b", "golden", "--why", "the first"]);
    let again = gate("again", "");
    assert!(again.exit_code == Some(0) && !again.stdout.contains("changed:"), "{again:#?}");
    let said = "Configuration changed: deep: results: 1 of 2 files changed.";
    for (option, exit_code) in [("", 101), ("--allow-drift", 0)] {
        let other = gate("other", option);
        assert!(other.exit_code == Some(exit_code) && other.stdout.contains(said), "{other:#?}");
        assert!(other.stdout.contains("2 new false detections"), "{other:#?}");
    }
    let compared = workplace.succeed("compare first other").stdout;
    assert!(compared.contains(said), "{compared}");
    workplace.succeed(&[
        "baseline",
        "accept",
        "other",
        "-b",
        "golden",
        "--why",
        "another network",
        "--worse",
    ]);
    assert_eq!(gate("other", "").exit_code, Some(0));
    assert_eq!(gate("first", "").exit_code, Some(101));
}

/// Unlike a baseline and a run, they are of one run.
#[test]
fn shards_judge_the_same_results() {
    let workplace = Workplace::with_drive(2);
    for number in 0..2 {
        workplace.write(&format!("found/{number:06}.txt"), "");
    }
    let shard = |number: &str, results: &str| {
        let results = format!("deep={results}");
        let arguments =
            ["run", "street", "-d", "pca", "--detections", &results, "--shard", number, "--overwrite"];
        workplace.succeed(&(&arguments, OUTPUT, "whole"));
    };
    shard("1/2", "found");
    shard("2/2", "found");
    workplace.succeed("merge whole -o merged --overwrite");
    copy_folder(&workplace.path("found"), &workplace.path("copied"));
    shard("2/2", "copied");
    workplace.succeed("merge whole -o merged --overwrite");
    workplace.write("copied/000000.txt", "Car -1 -1 0 0 0 1 1 1.5 2 4 0 1 10 0 0.5\n");
    shard("2/2", "copied");
    workplace.refuse("merge whole -o merged --overwrite", 5, &["deep: results: 1 of 2 files changed"]);
}

#[test]
fn results_that_are_damaged_later_are_damaged_data() {
    let workplace = Workplace::with_drive(3);
    for number in 0..3 {
        workplace.write(&format!("found/{number:06}.txt"), if number == 1 { "Car" } else { "" });
    }
    let run = ["run", "street", "-d", "pca", "--detections", "deep=found"];
    let expected = "the detector \"deep\" failed at scan 0000/000001: its results cannot be read: \"found/000001.txt\", line 1";
    workplace.run(&(&run, OUTPUT, "out")).check_refusal(3, &[expected]);
    // Of every kind of results, also of those that are looked into before the first scan.
    for (name, content) in [
        ("000001.csv", "a,b\n1,2\n"),
        ("000001.u32", "abc"),
        ("000001.label", "abc"),
        ("found.mcap", "not a recording"),
    ] {
        let folder = format!("of_{}", name.replace('.', "_"));
        for number in 0..3 {
            let of_scan = name.replace("000001", &format!("{number:06}"));
            workplace.write(&format!("{folder}/{of_scan}"), content);
        }
        let results = format!("deep={folder}");
        let run = ["run", "street", "-d", "pca", "--detections", &results];
        let output = folder.replace("of_", "out_");
        let ended = workplace.run(&(&run, OUTPUT, [output.as_str()]));
        assert_eq!(ended.exit_code, Some(3), "{name}: {ended:#?}");
    }
    workplace.succeed(&(&run, "--on-detector-failure skip", OUTPUT, "skipped"));
    let states: Vec<String> =
        counts(&workplace, "skipped", "deep").into_iter().map(|it| it[3].clone()).collect();
    assert_eq!(states.iter().filter(|it| *it == "failed").count(), 2, "{states:?}");
}

/// `PointRCNN` was trained on such scans, and sees only what the camera does.
#[test]
#[ignore = "needs data/kitti_tracking and data/kitti_tracking_results/pointrcnn in SCANBENCH_TEST_DATA"]
fn a_published_detector_is_judged_beside_ours() {
    let workplace = Workplace::new();
    let scans = test_data("data/kitti_tracking").display().to_string();
    let results = format!("pointrcnn={}", test_data("data/kitti_tracking_results/pointrcnn").display());
    let run = ["run", &scans, "-d", "simple-grid", "--detections", &results, "--criterion", "bev-iou"];
    let ended = workplace.succeed(&(&run, OUTPUT, "out"));
    assert!(!ended.stderr.contains("warning"), "{}", ended.stderr);
    let sums = |detector: &str| {
        let of_vehicles = counts(&workplace, "out", detector).into_iter().filter(|it| it[2] == "vehicles");
        of_vehicles.fold([0_u64; 3], |sums, row| {
            let of_scan = [4, 5, 7].map(|column: usize| row[column].parse::<u64>().unwrap());
            [0, 1, 2].map(|it| sums[it] + of_scan[it])
        })
    };
    let [no, tp, fo] = sums("pointrcnn");
    eprintln!(
        "pointrcnn, vehicles, bev-iou: {tp} of {no} found, {fo} false; simple-grid {:?}",
        sums("simple-grid")
    );
    assert!(no > 200 && 10 * tp > 7 * no, "{tp} of {no}");
    assert!(tp > sums("simple-grid")[1]);
}
