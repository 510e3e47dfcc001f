//! Runs as streams: what their answers are worth at every moment, and how a gate holds that.

use std::collections::BTreeMap;
use std::path::Path;

use crate::program::{Workplace, copy_folder};

/// Twelve drives of four scans each, a tenth of a second apart, seen by few beams.
const CATALOGUE: &str = "\
[simulated.stream]
street = \"street-main-road\"
seed = 9001
n_scans = 48
turns_per_scan = 1
scans_per_drive = 4
sensor = \"vlp-16\"
";

/// A run of two detectors by the criterion `centre`.
fn with_run() -> Workplace {
    let workplace = Workplace::new();
    workplace.write("mine.toml", CATALOGUE);
    workplace.succeed(
        "run stream --catalogue mine.toml -d pca,hierarchical --criterion centre --repeats 2 --no-rrd -o run",
    );
    workplace
}

type Rows = Vec<BTreeMap<String, String>>;

fn rows(workplace: &Workplace, name: &str) -> Rows {
    let mut reader = csv::Reader::from_path(workplace.path(name)).expect("the file is there");
    reader.deserialize().map(|it| it.expect("a row is text by column")).collect()
}

/// The rows of `streaming.csv` with these values.
fn select<'a>(rows: &'a Rows, values: &[(&str, &str)]) -> Vec<&'a BTreeMap<String, String>> {
    rows.iter().filter(|row| values.iter().all(|(name, value)| row[*name] == *value)).collect()
}

fn counts(row: &BTreeMap<String, String>) -> [u64; 3] {
    ["no", "tp", "fo"].map(|it| row[it].parse().expect("a count"))
}

/// Writes a table again, with another value in every row of a column.
fn rewrite(path: &Path, column: &str, value: impl Fn(&str) -> String) {
    let mut reader = csv::Reader::from_path(path).expect("the table can be opened");
    let head = reader.headers().expect("it has a head").clone();
    let records: Vec<csv::StringRecord> = reader.records().map(|it| it.expect("a row is text")).collect();
    let column_idx = head.iter().position(|it| it == column).expect("it has the column");
    let mut writer = csv::Writer::from_path(path).expect("the table can be opened");
    writer.write_record(&head).expect("it can be written");
    for record in records {
        let changed = |(idx, it): (usize, &str)| if idx == column_idx { value(it) } else { it.to_owned() };
        writer.write_record(record.iter().enumerate().map(changed)).expect("it can be written");
    }
    writer.flush().expect("it can be written");
}

#[test]
fn per_scan_it_is_what_the_run_says_and_without_lateness_it_streams_so() {
    let workplace = with_run();
    let latencies = "--latency pca=0ms --latency hierarchical=0s --clock 100ms";
    let shown = workplace.succeed(&format!("streaming run {latencies} -o study"));
    shown.check_stdout(&[
        "Task vehicles, streaming on stream (simulated). Rates in %. Matched by centre",
        "The time of pca is set to 0 ms.",
        "Drives: 12; scans: 48; a moment every 100 ms.",
        "A clock of 100 ms is too coarse",
        "resamples of whole drives",
    ]);
    let streamed = rows(&workplace, "study/streaming.csv");
    let scans = rows(&workplace, "run/scans.csv");
    for task in ["objects", "vehicles"] {
        for detector in ["pca", "hierarchical"] {
            let mut expected = [0; 3];
            for row in select(&scans, &[("task", task), ("detector", detector)]) {
                let of_scan = counts(row);
                expected = [0, 1, 2].map(|it| expected[it] + of_scan[it]);
            }
            let subject = [("task", task), ("detector", detector), ("slice", "all")];
            let of = |more: &[(&str, &str)]| select(&streamed, &[&subject[..], more].concat());
            let per_scan = of(&[("judged", "scans")]);
            assert_eq!(
                per_scan.iter().map(|it| counts(it)).collect::<Vec<_>>(),
                [expected],
                "{task} {detector}"
            );
            // A moment is a scan here, and every answer is known at once: forecasts have nothing to do.
            for forecast in ["hold", "car-motion", "constant-velocity"] {
                let at_once =
                    of(&[("judged", "streams"), ("forecast", forecast), ("machine_speed", "1.0000")]);
                assert_eq!(counts(at_once[0]), expected, "{task} {detector} {forecast}");
            }
            let truth = counts(of(&[("judged", "late-truth")])[0]);
            assert_eq!(truth, [expected[0], expected[0], 0]);
        }
    }
    workplace.check_file("study/streaming.html", &["Streaming: run", "<svg", "Which detector is best"]);
    workplace.check_file("study/figures/streaming.svg", &["hierarchical", "speed of the computer"]);
}

#[test]
fn a_late_answer_is_worth_less_and_the_same_twice() {
    let workplace = with_run();
    let f_rate = |latency: &str| {
        let latencies = format!("--latency pca={latency} --latency hierarchical={latency}");
        workplace.succeed(&format!("streaming run {latencies} --criterion bev-iou -o {latency}"));
        let rows = rows(&workplace, &format!("{latency}/streaming.csv"));
        let subject = [
            ("task", "vehicles"),
            ("detector", "hierarchical"),
            ("slice", "all"),
            ("judged", "streams"),
            ("forecast", "hold"),
        ];
        select(&rows, &subject)[0]["f_rate"].parse::<f64>().unwrap()
    };
    let [prompt, late] = ["0ms", "150ms"].map(f_rate);
    assert!(late < prompt - 0.05, "{prompt} {late}");
    // Measured times, into the run itself; and those of another run of the same scans.
    let first = workplace.succeed("streaming run");
    let before = workplace.read("run/streaming.csv");
    copy_folder(&workplace.path("run"), &workplace.path("elsewhere"));
    let second = workplace.succeed("streaming run --latencies-of elsewhere");
    assert_eq!(workplace.read("run/streaming.csv"), before);
    let other_lines = |stdout: &str| -> Vec<String> {
        stdout.lines().filter(|it| !it.starts_with("Times of detection")).map(str::to_owned).collect()
    };
    second.check_stdout(&["Times of detection are those of elsewhere."]);
    assert_eq!(other_lines(&second.stdout), other_lines(&first.stdout));
    assert_eq!(workplace.succeed("streaming run -q").stdout.trim(), "run/streaming.html");
}

#[test]
fn what_is_no_stream_is_refused_by_name() {
    let workplace = with_run();
    workplace.refuse("streaming run --latency net=10ms", 2, &["no detector \"net\"", "pca, hierarchical"]);
    workplace.refuse("streaming run --latency pca=1ms --latency pca=2ms", 2, &["pca is given twice"]);
    workplace.refuse("streaming run --latency pca=ten", 2, &["\"ten\" is no time", "120ms"]);
    workplace.refuse("streaming run --clock 0ms", 2, &["not from 1 ms to 1 s"]);
    workplace.refuse("streaming run --criterion points", 2, &["points", "bev-iou"]);
    workplace.refuse("streaming run --task trams", 2, &["trams"]);
    workplace.refuse("streaming gone", 2, &["there is no run directory gone"]);
    workplace.succeed("run street-narrow --scans 0..2 --sensor vlp-16 -d pca --no-rrd -o apart");
    workplace.refuse(
        "streaming apart",
        4,
        &[
            "street-narrow has scans 20 s apart or more; a stream has them 0.25 s apart or less",
            "streaming-streets",
        ],
    );
    workplace.refuse("streaming run -o apart", 2, &["apart is the directory of another run"]);
    std::fs::remove_file(workplace.path("run/poses.csv")).unwrap();
    workplace.succeed("streaming run").check_stdout(&["The car's motion is unknown on stream"]);
}

#[test]
fn a_gate_holds_rates_as_they_stream() {
    let workplace = with_run();
    copy_folder(&workplace.path("run"), &workplace.path("slow"));
    // A third of a second later, whatever it was.
    rewrite(&workplace.path("slow/scans.csv"), "latency_ms", |it| {
        it.parse::<f64>().map_or(String::new(), |ms| format!("{:.3}", ms + 333.0))
    });
    let rules = "\
[[quality]]
metrics = [\"f_rate\"]
slices = [\"all\"]
absolute = 0.01
relative = 0.0

[[streaming]]
criterion = \"centre\"
latency_ms = 100
absolute = 0.01
relative = 0.0
";
    workplace.write("fixed.toml", rules);
    workplace.succeed("gate slow --baseline run -t fixed.toml").check_stdout(&["PASSED"]);
    workplace
        .write("measured.toml", &rules.replace("latency_ms = 100\n", "detectors = [\"hierarchical\"]\n"));
    let late = workplace.end_with("gate slow --baseline run -t measured.toml", 100, &[]);
    late.check_stdout(&["FAILED: worse", "vehicles, streaming by centre, as late as measured"]);
    for (wrong, parts) in [
        (rules.replace("\"centre\"", "\"points\""), "there is no criterion by boxes \"points\""),
        (
            rules.replace("latency_ms = 100", "latency_ms = -1"),
            "latency_ms = -1 is no time from 0 to 60000 ms",
        ),
        (rules.replace("latency_ms", "latency"), "unknown field `latency`"),
    ] {
        workplace.write("wrong.toml", &wrong);
        workplace.refuse("gate run --baseline run -t wrong.toml", 2, &["[[streaming]] 1", parts]);
    }
    workplace.write("unknown.toml", &rules.replace("latency_ms = 100", "detectors = [\"net\"]"));
    workplace.refuse("gate run --baseline run -t unknown.toml", 2, &["the baseline has no detector \"net\""]);
    std::fs::remove_file(workplace.path("slow/poses.csv")).unwrap();
    workplace.refuse(
        "gate slow --baseline run -t fixed.toml",
        5,
        &["poses are known of 12 drives in the baseline and of 0 in the run"],
    );
    // Results of others have no times: they stream at a fixed latency, and a rule on measured ones leaves them out.
    workplace.write(
        "untimed.toml",
        &rules.replace("latency_ms = 100\n", "").replace("criterion = \"centre\"", "criterion = \"bev-iou\""),
    );
    rewrite(&workplace.path("run/scans.csv"), "latency_ms", |_| String::new());
    copy_folder(&workplace.path("run"), &workplace.path("again"));
    workplace.succeed("gate again --baseline run -t fixed.toml").check_stdout(&["PASSED"]);
    workplace.refuse("gate again --baseline run -t untimed.toml", 2, &["no time of detection"]);
}
