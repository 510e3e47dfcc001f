//! `run --add-to`: a detector that joins a finished run.

use crate::program::Workplace;

/// What a run leaves that has no times.
const TIMELESS: [&str; 5] =
    ["matches.csv", "errors.csv", "precision_recall.csv", "worst_points.json", "protocol_boxes.csv"];

#[test]
fn a_detector_that_is_added_has_the_rows_that_it_would_have_had_from_the_start() {
    let workplace = Workplace::with_drive(6);
    let run = ["run", "street", "--protocol", "nuscenes", "--no-rrd"];
    workplace.succeed(&(&run, "-d pca,simple-grid -o whole"));
    workplace.succeed(&(&run, "-d pca -o part"));
    workplace.write("part/verdict/notes.txt", "of the user");
    let added = workplace.succeed("run --add-to part -d simple-grid");
    workplace.check_file("part/verdict/notes.txt", &["of the user"]);
    added.check_stdout(&["pca", "simple-grid"]);
    for name in TIMELESS {
        assert_eq!(
            workplace.read(&format!("part/{name}")),
            workplace.read(&format!("whole/{name}")),
            "{name}"
        );
    }
    let counts = |run: &str| -> Vec<String> {
        let rows = workplace.table(&format!("{run}/scans.csv"));
        rows.iter()
            .map(|it| format!("{} {} {} {} {}", it["detector"], it["task"], it["no"], it["tp"], it["fo"]))
            .collect()
    };
    assert_eq!(counts("part"), counts("whole"));
    workplace.check_file("part/manifest.json", &["\"-d\",\n    \"pca,simple-grid\""]);
    workplace.succeed("report part");
    workplace.succeed("gate part --baseline whole");
    let entries = std::fs::read_dir(workplace.path(".")).expect("it is there");
    let hidden =
        entries.filter_map(Result::ok).filter(|it| it.file_name().to_string_lossy().starts_with(".part"));
    assert_eq!(hidden.count(), 0);
}

#[test]
fn what_was_judged_otherwise_is_not_added() {
    let workplace = Workplace::with_drive(3);
    workplace.succeed("run street -d pca --no-rrd -o part");
    let before = workplace.read("part/manifest.json");
    workplace.refuse("run --add-to part", 2, &["name the detectors that join the run"]);
    workplace.refuse("run --add-to part -d pca", 2, &["has the detector pca already"]);
    workplace.refuse("run --add-to nowhere -d simple-grid", 2, &["there is no run directory nowhere"]);
    workplace.refuse("run --add-to part -d simple-grid --repeats 5", 2, &["cannot be used with"]);
    workplace.refuse("run street --add-to part -d simple-grid", 2, &["cannot be used with"]);
    workplace.write("scanbench.toml", "[matching]\nmin_points = 30\n");
    workplace.refuse(
        "run --add-to part -d simple-grid",
        5,
        &["the ignored annotations changed from fewer than 20 points"],
    );
    workplace.write("scanbench.toml", "[hierarchical.grid]\ncell_size_m = 0.7\n");
    workplace.refuse(
        "run --add-to part -d simple-grid",
        5,
        &["the parameter hierarchical.grid.cell_size_m changed from 0.6 to 0.7"],
    );
    std::fs::remove_file(workplace.path("scanbench.toml")).expect("it is there");
    let labels = workplace.read("street/training/label_02/0000.txt");
    workplace.write("street/training/label_02/0000.txt", &labels.replace("Car", "Van"));
    workplace.refuse(
        "run --add-to part -d simple-grid",
        5,
        &["the data of street changed: their checksums differ"],
    );
    assert_eq!(workplace.read("part/manifest.json"), before);
}

#[cfg(feature = "viewer")]
#[test]
fn a_detector_that_is_added_joins_the_recording() {
    let workplace = Workplace::with_drive(2);
    workplace.succeed("run street -d pca -o run");
    let layers = || -> Vec<String> {
        let entries = std::fs::read_dir(workplace.path("run/recording")).expect("it is there");
        let mut names: Vec<String> =
            entries.map(|it| it.expect("it is read").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(layers(), ["detector-pca.rrd", "layout.rrd", "scans.rrd"]);
    let before = ["detector-pca", "layout", "scans"].map(|it| {
        std::fs::read(workplace.path("run/recording").join(format!("{it}.rrd"))).expect("it is there")
    });
    // What shows the old mistakes is not that of the new page.
    workplace.write("run/recording/marks.rrd", "old");
    workplace.write("run/viewer/places.json", "old");
    workplace.succeed("run --add-to run -d simple-grid");
    let added = ["detector-pca.rrd", "detector-simple-grid.rrd", "layout.rrd", "scans.rrd"];
    assert_eq!(layers(), added);
    let after = ["detector-pca", "layout", "scans"].map(|it| {
        std::fs::read(workplace.path("run/recording").join(format!("{it}.rrd"))).expect("it is there")
    });
    assert_eq!([0, 1, 2].map(|it| before[it] == after[it]), [true, false, true]);
    assert!(!workplace.path("run/viewer/places.json").exists());

    workplace.write("run/recording/layout.rrd", "theirs");
    let joined = "no detector can join the recording with the layout";
    workplace.end_with("run --add-to run -d hierarchical", 3, &[joined]);
    assert_eq!(layers(), added);
    workplace.succeed("run --add-to run -d hierarchical --no-rrd");
    std::fs::remove_dir_all(workplace.path("run/recording")).expect("it is there");
    let said = "run is recorded: it has no recording in layers";
    workplace.succeed("run --add-to run -d kd-tree").check_stderr(&[said]);
}

#[cfg(feature = "viewer")]
#[test]
fn layers_of_a_run_that_failed_are_not_those_of_the_next_one() {
    let workplace = Workplace::with_drive(2);
    workplace.write("out.unfinished/recording/detector-old.rrd", "cut off");
    workplace.write("out.unfinished/recording/notes.txt", "of the user");
    workplace.succeed("run street -d pca -o out");
    assert!(!workplace.path("out/recording/detector-old.rrd").exists());
    workplace.check_file("out.unfinished/recording/notes.txt", &["of the user"]);
}
