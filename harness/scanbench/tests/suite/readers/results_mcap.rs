//! `scanbench run --mcap`: the recording says what the CSV files say, and is a data set itself.

use std::collections::BTreeMap;

use mcap::MessageStream;

use crate::program::Workplace;

/// The rows of a CSV file of a run for each detector and task.
fn rows(workplace: &Workplace, file: &str) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for row in workplace.table(file) {
        *counts.entry(format!("/{}/{}", row["detector"], row["task"])).or_default() += 1;
    }
    counts
}

#[test]
fn a_recording_of_results_says_what_the_rows_say() {
    let workplace = Workplace::new();
    let street = ["run", "street-narrow", "--simulated-scans", "2", "--sensor", "vlp-16", "--no-rrd"];
    workplace.succeed(&(&street, "-d hierarchical,pca --mcap -o run"));
    let bytes = std::fs::read(workplace.path("run/run.mcap")).unwrap();
    let (mut n_numbers, mut n_outcomes) = (BTreeMap::new(), BTreeMap::new());
    let mut most_tp = 0;
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = message.channel.topic.clone();
        if let Some(of) = topic.strip_suffix("/numbers") {
            let numbers: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
            assert_eq!(format!("/{}/{}", numbers["detector"], numbers["task"]).replace('"', ""), of);
            assert!(numbers["stage_ms"].as_object().unwrap().len() > 1, "{numbers}");
            let rate = numbers["f_rate_so_far"].as_f64();
            let is_of_class = ![Some("objects"), Some("vehicles")].contains(&numbers["task"].as_str());
            assert!(rate.map_or(is_of_class, |it| (0.0..=1.0).contains(&it)), "{numbers}");
            most_tp = most_tp.max(numbers["tp"].as_u64().unwrap());
            *n_numbers.entry(of.to_owned()).or_default() += 1;
        }
        if let Some(of) = topic.strip_suffix("/outcomes") {
            use scans::dataset::mcap::foxglove_messages::decode;
            use scans::dataset::mcap::foxglove_scene::SceneUpdate;
            let scene: SceneUpdate = decode("protobuf", &message.data).unwrap();
            assert!(scene.entities.iter().all(|it| it.metadata[0].key == "outcome"));
            *n_outcomes.entry(of.to_owned()).or_default() += scene.entities.len();
        }
    }
    assert!(most_tp > 0);
    assert_eq!(n_numbers, rows(&workplace, "run/scans.csv"));
    assert_eq!(n_outcomes, rows(&workplace, "run/matches.csv"));

    // It holds the scans as well.
    workplace.succeed("run run/run.mcap -d hierarchical,pca --no-rrd -o again");
    assert_eq!(rows(&workplace, "again/matches.csv"), rows(&workplace, "run/matches.csv"));
}

#[test]
fn several_data_sets_have_a_recording_each_and_none_is_written_unasked() {
    let workplace = Workplace::new();
    let run = ["run", "street-narrow", "street-intersection", "-d", "pca", "--no-rrd", "--sensor", "vlp-16"];
    workplace.succeed(&(&run, "--simulated-scans 1 --mcap -o two"));
    for name in ["two/run-street-narrow.mcap", "two/run-street-intersection.mcap"] {
        assert!(workplace.path(name).is_file(), "{:?}", workplace.names());
    }
    workplace.succeed(&(&run[..2], &run[3..], "--simulated-scans 1 -o none"));
    assert!(!workplace.path("none/run.mcap").exists());
}
