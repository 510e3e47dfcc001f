//! Any number of threads gives the same bytes.

use crate::program::Workplace;

/// What is made, and those files of it that have neither dates nor times.
const COMMANDS: [(&str, &[&str]); 5] = [
    ("fit-density street-narrow --seed 7 --scans 0..3 --sensor vlp-16 -o out.toml", &["out.toml"]),
    (
        "data realism street-main-road --scans 0..3 --against street -o out",
        &["out/realism.csv", "out/ring_density.svg"],
    ),
    ("gaps --pairs 1 -d simple-grid --sensor vlp-16 -o out", &["out/gaps.csv", "out/gaps.svg"]),
    (
        "boxes street-narrow --simulated-scans 3 -o out",
        &[
            "out/boxes.csv",
            "out/box_errors.csv",
            "out/box_errors.md",
            "out/box_points.csv",
            "out/boxes_simulated.svg",
            "out/box_points_simulated.svg",
        ],
    ),
    (
        "train paper streets --seed 7 --simulated-scans 4 --nu 0.3 -o out",
        &["out/curves.csv", "out/curves.svg", "out/importance.csv", "out/objects.csv", "out/paper.model"],
    ),
];

#[test]
fn the_number_of_threads_changes_no_byte() {
    for (command, files) in COMMANDS {
        let [one, three] = ["1", "3"].map(|n_threads| {
            let workplace = Workplace::with_drive(3);
            let ended = workplace.run_with(&[("RAYON_NUM_THREADS", n_threads)], command);
            assert_eq!(ended.exit_code, Some(0), "{command}: {ended:#?}");
            let files = files.iter().map(|it| (*it, workplace.read_bytes(it)));
            (files.collect::<Vec<_>>(), ended.stdout)
        });
        for (one, three) in one.0.iter().zip(&three.0) {
            assert!(one == three && !one.1.is_empty(), "{}: {command}", one.0);
        }
        assert_eq!(one.1, three.1, "{command}");
    }
}
