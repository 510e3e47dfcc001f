//! A run of two detectors that is accepted as a baseline, one that is worse, and scans for more of them.

use crate::program::{Ended, Prepared, Workplace};

/// As tight as can be, without times: those of short runs beside other tests say nothing.
pub const TOLERANCES: &str = r#"
[[quality]]
metrics = ["f_rate", "recall", "precision", "over_segmentation", "box_length_error_m"]
slices = ["all"]
absolute = 0.001
relative = 0.0

[[quality]]
metrics = ["recall"]
slices = ["class/*", "range/*"]
absolute = 0.001
relative = 0.0
"#;

/// Runs the hierarchical detector and `pca`.
#[track_caller]
pub fn run(workplace: &Workplace, data: &str, name: &str, options: &str) {
    let detectors = if options.contains("-d ") { "" } else { "-d hierarchical,pca" };
    let no_recording = if cfg!(feature = "viewer") { "--no-rrd" } else { "" };
    workplace.succeed(&(("run", data, "-o", name), detectors, no_recording, options));
    // Whoever changes the program runs these tests before there is a commit of it.
    edit(workplace, &format!("{name}/manifest.json"), "\"dirty\": true", "\"dirty\": false");
}

/// Replaces `from`, where it is, by `to` in a file.
pub fn edit(workplace: &Workplace, path: &str, from: &str, to: &str) {
    let text = workplace.read(path);
    workplace.write(path, &text.replacen(from, to, 1));
}

/// A workplace with a scan of each of ten narrow streets in `narrow.mcap`, seen by few beams; a run `first` on these,
/// accepted as the baseline `golden`; and one that is `worse`, in which hardly anything is an object.
pub fn accepted() -> Workplace {
    static ACCEPTED: Prepared = Prepared::new();
    ACCEPTED.workplace(|workplace| {
        // Of the seed of development: what is worse there is known.
        let streets = "street-narrow --seed 9001 --simulated-scans 20 --scans 0..20:2 --sensor vlp-16";
        workplace.succeed(&("data simulate", streets, "-o narrow.mcap"));
        workplace.write("tolerances.toml", TOLERANCES);
        run(workplace, "narrow.mcap", "first", "");
        run(workplace, "narrow.mcap", "worse", "-P hierarchical.cluster.min_points=200");
        workplace.succeed(&["baseline", "accept", "first", "-b", "golden", "--why", "the first"]);
        workplace.write("golden/tolerances.toml", TOLERANCES);
    })
}

/// The gate says `expected` of `run`, and ends with `exit_code`.
#[track_caller]
pub fn check_gate(workplace: &Workplace, run: &str, exit_code: i32, expected: &str) -> Ended {
    let ended = workplace.end_with(&["gate", run, "-b", "golden", "-o", "verdict", "--full"], exit_code, &[]);
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains(expected), "no {expected:?} in\n{said}");
    ended
}
