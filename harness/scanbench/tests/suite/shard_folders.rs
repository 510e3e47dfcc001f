//! Folders of shards, and the bytes of what is made of them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde_json::Value;

use crate::program::{Ended, Words, Workplace};

/// Makes all of `count` shards of `command` below `folder`.
pub fn make_shards(workplace: &Workplace, command: &(impl Words + ?Sized), count: u32, folder: &str) {
    for index in 1..=count {
        let shard = format!("{index}/{count}");
        workplace.succeed(&(command, ["--shard", &shard, "-o", folder]));
    }
}

/// Puts together all shards below `folder`.
pub fn merge(workplace: &Workplace, folder: &str, output: &str) -> Ended {
    let shards = std::fs::read_dir(workplace.path(folder)).unwrap().map(|it| it.unwrap().path());
    // The order on the command line does not matter.
    let mut shards: Vec<PathBuf> = shards.collect();
    shards.sort();
    shards.reverse();
    let names: Vec<&str> = shards.iter().map(|it| it.to_str().unwrap()).collect();
    workplace.run(&("merge", &names, ["-o", output]))
}

/// The same, which has to succeed.
#[track_caller]
pub fn merge_whole(workplace: &Workplace, folder: &str, output: &str) {
    let merged = merge(workplace, folder, output);
    assert_eq!(merged.exit_code, Some(0), "{merged:#?}");
}

/// The shards below `folder` are refused with this exit code and these words, and nothing is left.
#[track_caller]
pub fn check_merge_refused(workplace: &Workplace, folder: &str, exit_code: i32, words: &str) {
    let merged = merge(workplace, folder, "whole");
    assert_eq!(merged.exit_code, Some(exit_code), "{words}: {merged:#?}");
    merged.check_stderr(&[words]);
    assert!(!workplace.path("whole").exists());
}

/// The lines of a table in CSV without times.
fn untimed_lines(workplace: &Workplace, path: &str) -> Vec<String> {
    let text = workplace.read(path);
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let untimed = |line: &str| {
        let cells = line.split(',').zip(&head).filter(|(_, name)| !name.ends_with("_ms"));
        cells.map(|it| it.0).collect::<Vec<_>>().join(",")
    };
    text.lines().map(untimed).collect()
}

/// What compares two directories of results.
pub type Comparison = fn(&Workplace, &str, &str);

/// Makes `command` in `in-one`, where an earlier result is, on one thread, and again: in each number of shards of `counts`,
/// or else on three threads. Each has to be the `same`.
#[track_caller]
pub fn check_study(workplace: &Workplace, command: &str, counts: &[u32], same: Comparison) -> Ended {
    workplace.write("in-one/manifest.json", "{}");
    workplace.write("in-one/earlier.csv", "");
    workplace.refuse(&(command, "-o in-one"), 2, &["\"in-one\" exists", "--overwrite"]);
    let command = (command, "--overwrite");
    let with_threads = |n_threads: &str, output: &str| {
        let ended = workplace.run_with(&[("RAYON_NUM_THREADS", n_threads)], &(&command, "-o", output));
        assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
        ended
    };
    let whole = with_threads("1", "in-one");
    assert!(!workplace.path("in-one/earlier.csv").exists());
    check_shards(workplace, &command, counts, same);
    if counts.is_empty() {
        with_threads("3", "again");
        same(workplace, "in-one", "again");
    }
    whole
}

/// Makes `command` in each number of shards of `counts`, which have to come to the `same` as what it has left in
/// `in-one`.
#[track_caller]
fn check_shards(workplace: &Workplace, command: &(impl Words + ?Sized), counts: &[u32], same: Comparison) {
    for count in counts {
        let [shards, merged] = [format!("shards-{count}"), format!("merged-{count}")];
        make_shards(workplace, command, *count, &shards);
        merge_whole(workplace, &shards, &merged);
        same(workplace, "in-one", &merged);
        let manifest = workplace.json(&format!("{merged}/manifest.json"));
        assert_eq!(manifest["shards"].as_array().map(Vec::len), Some(*count as usize));
        assert!(manifest.get("shard").is_none());
    }
}

/// Makes `command` in `in-one` and in shards, as [`check_study`] does.
#[track_caller]
pub fn check_in_shards(
    workplace: &Workplace,
    command: &(impl Words + ?Sized),
    counts: &[u32],
    same: Comparison,
) {
    workplace.succeed(&(command, "-o in-one"));
    check_shards(workplace, command, counts, same);
}

/// The table `name` of both studies is the same but for times.
#[track_caller]
pub fn check_same_table(workplace: &Workplace, whole: &str, merged: &str, name: &str) {
    let [one, other] = [whole, merged].map(|it| untimed_lines(workplace, &format!("{it}/{name}")));
    assert!(one == other && one.len() > 10, "{name}: {other:#?}");
}

/// All files of a run but its manifest.
pub fn files_of(workplace: &Workplace, run: &str) -> BTreeSet<PathBuf> {
    let names = workplace.names().into_iter();
    let of_run = names.filter_map(|it| Some(it.strip_prefix(run).ok()?.to_owned()));
    // PDF files of the same figure differ from one time to the next.
    let is_compared =
        |it: &PathBuf| !it.ends_with("manifest.json") && it.extension().is_none_or(|it| it != "pdf");
    of_run.filter(|it| workplace.path(run).join(it).is_file() && is_compared(it)).collect()
}

/// Every file of both runs has the same bytes; only the page names its own folder.
#[track_caller]
pub fn check_same_bytes(workplace: &Workplace, whole: &str, merged: &str) {
    assert_eq!(files_of(workplace, whole), files_of(workplace, merged));
    for name in files_of(workplace, whole) {
        let [one, other] = [whole, merged].map(|it| std::fs::read(workplace.path(it).join(&name)).unwrap());
        if name.ends_with("report.html") {
            let [one, other] =
                [(whole, one), (merged, other)].map(|(run, page)| undated(workplace, run, page));
            let differing = one.lines().zip(other.lines()).find(|(one, other)| one != other);
            assert!(one == other, "{} of {merged} has other words: {differing:?}", name.display());
        } else if name.ends_with("scans.csv") {
            // The reference is timed in any case.
            let [one, other] = [whole, merged].map(|it| untimed_lines(workplace, &format!("{it}/scans.csv")));
            assert_eq!(one, other);
        } else {
            assert!(one == other, "{} of {merged} has other bytes", name.display());
        }
    }
}

/// The page of `run` without what it is called, when it began, and in how many shards it was made.
fn undated(workplace: &Workplace, run: &str, page: Vec<u8>) -> String {
    let manifest = workplace.json(&format!("{run}/manifest.json"));
    let created = manifest["created"].as_str().unwrap();
    let n_shards = manifest["shards"].as_array().map_or(0, Vec::len);
    let mut page = String::from_utf8(page).unwrap();
    let made_in = format!("<div><dt>made in</dt><dd>{n_shards} shards</dd></div>");
    let is_of_run = workplace.path(run).join("matches.csv").is_file();
    assert_eq!(page.contains(&made_in), n_shards > 0 && is_of_run);
    let in_words = created.replace('T', " ").replace('Z', " UTC");
    for (word, other) in [
        (format!("-o {run}"), "-o RUN"),
        // As the manifest on the page has it.
        (format!("&quot;{run}&quot;"), "&quot;RUN&quot;"),
        (created.to_owned(), "CREATED"),
        (in_words, "CREATED"),
        (made_in, ""),
    ] {
        page = page.replace(&word, other);
    }
    page
}

/// The rows of the report of `run`, without those that hold times.
pub fn untimed_rows(workplace: &Workplace, run: &str) -> Vec<Value> {
    let report = workplace.json(&format!("{run}/report.json"));
    let rows = ["rows", "overall"].into_iter().flat_map(|it| report[it].as_array().unwrap());
    let is_time = |row: &Value| {
        let metric = row["metric"].as_str().unwrap();
        ["fps_", "latency_", "stage_", "cpu_", "overhead_", "reference_ms", "time_over_reference"]
            .iter()
            .any(|prefix| metric.starts_with(prefix))
    };
    let (times, rest): (Vec<Value>, Vec<Value>) = rows.cloned().partition(is_time);
    assert!(!times.is_empty() && rest.len() > 20);
    rest
}

/// Everything but times is the same.
#[track_caller]
pub fn check_same_but_times(workplace: &Workplace, whole: &str, merged: &str) {
    assert_eq!(files_of(workplace, whole), files_of(workplace, merged));
    for name in ["matches.csv", "precision_recall.csv", "worst_points.json"] {
        let [one, other] = [whole, merged].map(|it| workplace.read(&format!("{it}/{name}")));
        // Where nothing is classified as a vehicle there is no row.
        let n_least = if name == "precision_recall.csv" { 1 } else { 3 };
        assert!(one == other && one.lines().count() >= n_least, "{name} of {merged}: {one}\n{other}");
    }
    let [one, other] = [whole, merged].map(|it| untimed_lines(workplace, &format!("{it}/scans.csv")));
    assert_eq!(one, other);
    assert_eq!(untimed_rows(workplace, whole), untimed_rows(workplace, merged));
    let n_stages = |run| workplace.read(&format!("{run}/stages.csv")).lines().count();
    assert_eq!(n_stages(whole), n_stages(merged));
}
