//! What it costs to ask a detector that is a program of its own: the way there and back for scans of some 111,000 points.
//!
//! `cargo bench -p scanbench --bench overhead`. Asks a program that reads the points and finds nothing, and one of our
//! detectors within this program and as a program of its own, in turns; fails if a program of its own, or the way there and
//! back alone, takes more than a millisecond longer (medians over scans, of detectors of the shortest of twenty).

use std::io::Write as _;
use std::process::{Command, Stdio};

/// The most that a program of its own may take longer, in milliseconds.
const MOST_MS: f64 = 1.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let program = env!("CARGO_BIN_EXE_scanbench");
    let table =
        |name: &str| format!("[detector.{name}-served]\ncommand = [{program:?}, \"serve\", {name:?}]\n");
    let tables = format!(
        "{}[detector.silent]\ncommand = [{program:?}, \"serve\", \"nothing\"]\n",
        table("hierarchical")
    );
    std::fs::write(folder.path().join("scanbench.toml"), tables)?;
    let arguments = "run street-main-road --sensor os1-128 --simulated-scans 40 --scans 0..40:4 --repeats 20 --no-rrd -o out -d";
    let mut command = Command::new(program);
    command.args(arguments.split(' ')).arg("hierarchical,hierarchical-served,silent");
    let status = command.current_dir(folder.path()).stdout(Stdio::null()).status()?;
    if !status.success() {
        return Err(format!("the run ended with {status}").into());
    }
    let mut rows = csv::Reader::from_path(folder.path().join("out/scans.csv"))?;
    let headers = rows.headers()?.clone();
    let column =
        |name: &str| headers.iter().position(|it| it == name).ok_or_else(|| format!("no column {name}"));
    let [n_points, detector, least, overhead] =
        [column("n_points")?, column("detector")?, column("least_latency_ms")?, column("overhead_ms")?];
    let rows: Vec<csv::StringRecord> = rows.records().collect::<Result<_, _>>()?;
    let mut out = std::io::stdout().lock();
    let points: Vec<f64> = rows.iter().filter_map(|it| it[n_points].parse().ok()).collect();
    writeln!(out, "{} scans, median {:.0} points", rows.len() / 6, median(points))?;
    let of = |name: &str, column: usize| {
        let of_detector = rows.iter().filter(|it| &it[detector] == name);
        median(of_detector.filter_map(|it| it[column].parse().ok()).collect())
    };
    for name in ["hierarchical", "hierarchical-served", "silent"] {
        let (ms, overhead_ms) = (of(name, least), of(name, overhead));
        writeln!(out, "{name:<20} {ms:6.3} ms, of it {overhead_ms:6.3} ms process overhead")?;
    }
    let [within, served] = ["hierarchical", "hierarchical-served"].map(|it| of(it, least));
    writeln!(out, "served / within: {:.3}, {:.3} ms longer", served / within, served - within)?;
    let overhead_ms = of("silent", overhead);
    if overhead_ms > MOST_MS {
        return Err(format!("the process overhead is more than {MOST_MS} ms").into());
    }
    if served - within > MOST_MS {
        return Err(format!("a detector that is served takes more than {MOST_MS} ms longer").into());
    }
    Ok(())
}

/// NaN of nothing.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
