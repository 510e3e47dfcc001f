//! `scanbench view`.

use crate::program::{Prepared, Workplace};

fn small_run() -> Workplace {
    static SMALL: Prepared = Prepared::new();
    SMALL.workplace(|workplace| {
        let run = "run street-narrow --simulated-scans 4 --sensor vlp-16 -d hierarchical,pca --no-rrd -o run";
        workplace.succeed(run);
    })
}

#[test]
fn the_worst_come_first_and_can_be_chosen() {
    let workplace = small_run();
    let listed = |options: &[&str]| -> Vec<(String, u64)> {
        let ended = workplace.succeed(&("view run --task objects --no-rrd", options));
        let lines = ended.stdout.lines().skip(1).map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            // Rank, address, class, points.
            (words[1].to_owned(), words[3].parse().expect("a number of points"))
        });
        lines.collect()
    };
    let all = listed(&[]);
    assert_eq!(all.len(), 10);
    assert!(all.windows(2).all(|pair| pair[0].1 >= pair[1].1), "{all:?}");
    assert_eq!(listed(&["--worst", "3"]), all[..3]);
    assert!(listed(&["--outcome", "missed"]).iter().all(|it| it.0.contains("/missed-")));
    // An address finds its object again, and that of a scan all of its mistakes.
    assert_eq!(listed(&["--at", &all[0].0]), all[..1]);
    let scan = all[0].0.rsplit_once('/').expect("an address").0;
    let of_scan = listed(&["--at", scan, "--worst", "100"]);
    assert!(of_scan.contains(&all[0]) && of_scan.iter().all(|it| it.0.starts_with(scan)), "{of_scan:?}");
    assert_ne!(listed(&["-d", "pca"]), all);
}

#[test]
#[cfg(feature = "viewer")]
fn their_scans_are_recorded_in_the_run_directory_or_elsewhere() {
    let workplace = small_run();
    workplace.succeed("view run --task objects --worst 2").check_stderr(&["worst.rrd"]);
    assert!(workplace.path("run/worst.rrd").metadata().unwrap().len() > 100_000);
    workplace.succeed("view run --task objects --worst 1 --save-rrd=one.rrd");
    assert!(workplace.path("one.rrd").exists());
}

#[test]
fn what_cannot_be_viewed_is_said() {
    let workplace = small_run();
    for (arguments, code, message) in [
        (&["view", "nowhere"][..], 2, "there is no run directory nowhere"),
        (&["view", "."], 2, "to see scans and labels, record them: `scanbench run . --scans 0`"),
        (
            &["view", "run", "-d", "kd-tree"],
            2,
            "the run has no detector \"kd-tree\"; its detectors are hierarchical, pca",
        ),
        (&["compare", ".", "run"], 2, ". is not the directory of a run: it has no manifest.json"),
        (&["report", "."], 2, ". is not the directory of a run: it has no manifest.json"),
        (&["view", "run", "--class", "boat"], 2, "the run has no class \"boat\""),
        (&["view", "run", "--class", "tram"], 4, "the run has no mistakes of this kind"),
        (&["view", "run", "--at", "street-narrow/a/000099"], 4, "of this kind at street-narrow/a/000099"),
        (
            &["view", "run", "--task", "car"],
            2,
            "the run has no task \"car\"; its tasks are objects, vehicles",
        ),
    ] {
        workplace.end_with(arguments, code, &[message]);
    }
}

#[test]
#[cfg(feature = "viewer")]
fn scans_that_would_not_be_the_same_are_not_recorded() {
    let workplace = small_run();
    let manifest = workplace.read("run/manifest.json");
    for (from, to, message) in [
        ("\"simulator_version\": ", "\"simulator_version\": 9", "differ from those of the run"),
        ("\"cell_size_m\": 0.6", "\"cell_size_m\": 0.7", "the parameters differ from those of the run"),
    ] {
        assert!(manifest.contains(from), "{manifest}");
        workplace.write("run/manifest.json", &manifest.replace(from, to));
        // The list of mistakes does not need the scans.
        workplace.end_with("view run --task objects", 2, &[message]);
        assert!(!workplace.path("run/worst.rrd").exists());
    }
}
