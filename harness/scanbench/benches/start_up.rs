//! How soon the program gets to work: the time of one small scan from the start of the process to its end.
//!
//! `cargo bench -p scanbench --bench start_up` prints the least and the median of interleaved repetitions, with the shipped
//! models, with a model from files, and for a mistake on the command line, and fails if any takes more than 50 ms at least:
//! the median is that of the load of the machine. A model that is parsed as plain TOML takes several times as long.

use std::fs;
use std::io::Write as _;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

const N_REPETITIONS: usize = 30;
const MOST_MS: f64 = 50.0;

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let scan = folder.path().join("000000.bin");
    // A hundred points on a flat road.
    let point = |it: u32| [4.0 + it as f32 * 0.1, (it % 7) as f32, -1.7, 0.5];
    fs::write(&scan, (0..100).flat_map(point).flat_map(f32::to_le_bytes).collect::<Vec<u8>>())?;
    let scan = scan.to_string_lossy().into_owned();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../detector/src/params");
    let of_files = format!("vehicle_model.groupings_directory={shipped:?}");
    let commands = [
        ("hierarchical", vec!["detect", &scan, "-d", "hierarchical"]),
        ("hierarchical, model from files", vec!["detect", &scan, "-P", &of_files]),
        ("pca", vec!["detect", &scan, "-d", "pca"]),
        ("no such detector", vec!["detect", &scan, "-d", "nonsense"]),
    ];
    let mut times = vec![Vec::new(); commands.len()];
    for _ in 0..N_REPETITIONS {
        for ((_, arguments), times) in commands.iter().zip(&mut times) {
            times.push(time_of(arguments)?);
        }
    }
    let mut out = std::io::stdout().lock();
    let mut is_fast = true;
    for ((name, _), times) in commands.iter().zip(&mut times) {
        times.sort_unstable();
        let [least_ms, median_ms] = [0, N_REPETITIONS / 2].map(|it| 1e3 * times[it].as_secs_f64());
        writeln!(out, "{name:<32} least {least_ms:6.1} ms, median {median_ms:6.1} ms")?;
        is_fast &= least_ms <= MOST_MS;
    }
    if is_fast {
        return Ok(ExitCode::SUCCESS);
    }
    writeln!(out, "FAILED: more than {MOST_MS} ms from the start to the end of a first scan")?;
    Ok(ExitCode::FAILURE)
}

fn time_of(arguments: &[&str]) -> std::io::Result<Duration> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scanbench"));
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    let started = Instant::now();
    command.status()?;
    Ok(started.elapsed())
}
