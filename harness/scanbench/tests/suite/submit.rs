//! Runs as tasks of an engine: what `submit` writes.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::process::Command;

use crate::program::{Ended, Workplace};

/// A `sbatch` that runs a job at once, an array task by task; a job that depends on another only if that has succeeded.
const SBATCH: &str = r#"#!/bin/bash
set -u
count=0
for argument; do
    case $argument in
    --dependency=afterok:*) after=${argument##*:} ;;
    esac
done
script=${!#}
id=$(($(cat ids 2> /dev/null || echo 40) + 1))
echo "$id" > ids
last=$(sed -n 's/^#SBATCH --array=1-//p' "$script")
failed=0
if [[ -n ${after:-} && $(cat "failed.$after") != 0 ]]; then
    echo "cancelled" >&2
else
    for task in $(seq 1 "${last:-1}"); do
        if [[ -n $last ]]; then
            export SLURM_ARRAY_TASK_ID=$task
        fi
        bash "$script" >> log 2>&1 || failed=1
    done
fi
echo "$failed" > "failed.$id"
echo "$id;cluster"
"#;

/// The program with `arguments`, and a `sbatch` that runs jobs at once.
fn with_sbatch(workplace: &Workplace, arguments: &[&str]) -> Ended {
    use std::os::unix::fs::PermissionsExt as _;

    let programs = workplace.path("programs");
    std::fs::create_dir_all(&programs).unwrap();
    std::fs::write(programs.join("sbatch"), SBATCH).unwrap();
    std::fs::set_permissions(programs.join("sbatch"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = workplace.command(arguments);
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    Ended::from(command.env("PATH", path).output().unwrap())
}

fn no_recording() -> &'static [&'static str] {
    if cfg!(feature = "viewer") { &["--no-rrd"] } else { &[] }
}

#[test]
fn an_array_of_slurm_and_its_merge_give_the_rows_of_the_whole_run() {
    let workplace = Workplace::with_drive(40);
    let data = "it's \"a\" $(street) {{name}}";
    std::fs::rename(workplace.path("street"), workplace.path(data)).unwrap();
    let run = [&["run", data, "-d", "pca"], no_recording()].concat();
    workplace.succeed(&(&run, "-o whole"));
    let submit = [&["submit", "slurm", "--shards", "3", "--now", "-o", "my 'jobs'", "--"], &run[..]].concat();
    let ended = with_sbatch(&workplace, &submit);
    assert_eq!(ended.exit_code, Some(0), "{ended:#?}");
    ended.check_stdout(&["shards: job 41, merge: job 42, merged run: "]);
    let log = workplace.read("my 'jobs'/log");
    for shard in 1..=3 {
        assert!(
            workplace.path(&format!("my 'jobs'/shards/shard-{shard}-of-3/manifest.json")).is_file(),
            "{log}"
        );
    }
    assert_eq!(workplace.read("my 'jobs'/run/matches.csv"), workplace.read("whole/matches.csv"), "{log}");

    // Once more: what is done is left alone, and what is gone is made again.
    std::fs::remove_dir_all(workplace.path("my 'jobs'/run")).unwrap();
    std::fs::remove_dir_all(workplace.path("my 'jobs'/shards/shard-2-of-3")).unwrap();
    let first = workplace.path("my 'jobs'/shards/shard-1-of-3/manifest.json");
    let made = std::fs::metadata(&first).unwrap().modified().unwrap();
    let path = format!("{}:{}", workplace.path("programs").display(), std::env::var("PATH").unwrap());
    let again = Command::new("bash").arg(workplace.path("my 'jobs'/submit.sh")).env("PATH", path).output();
    let again = Ended::from(again.unwrap());
    assert_eq!(again.exit_code, Some(0), "{again:#?}");
    let log = workplace.read("my 'jobs'/log");
    assert_eq!(workplace.read("my 'jobs'/run/matches.csv"), workplace.read("whole/matches.csv"), "{log}");
    assert_eq!(std::fs::metadata(&first).unwrap().modified().unwrap(), made, "it was made again");
}

#[test]
fn nothing_is_merged_where_a_shard_fails() {
    let workplace = Workplace::with_drive(4);
    workplace.write("street/training/velodyne/0000/000003.bin", "damaged");
    let run = [&["run", "street", "-d", "pca"], no_recording()].concat();
    let submit = [&["submit", "slurm", "--shards", "2", "--now", "-o", "jobs", "--"], &run[..]].concat();
    let ended = with_sbatch(&workplace, &submit);
    ended.check_stderr(&["cancelled"]);
    assert!(!workplace.path("jobs/run").exists());
}

#[test]
fn where_slurm_takes_nothing_the_scripts_stay() {
    let workplace = Workplace::new();
    let mut command = workplace.command("submit slurm --now -o jobs -- run street-narrow");
    // bash, and no sbatch.
    std::fs::create_dir(workplace.path("programs")).unwrap();
    for program in ["bash", "dirname", "mkdir"] {
        let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).output().unwrap();
        let found = String::from_utf8(found.stdout).unwrap();
        std::os::unix::fs::symlink(found.trim(), workplace.path("programs").join(program)).unwrap();
    }
    let ended = Ended::from(command.env("PATH", workplace.path("programs")).output().unwrap());
    assert_eq!(ended.exit_code, Some(1), "{ended:#?}");
    ended.check_stderr(&["nothing was submitted, or not all of it"]);
    assert!(workplace.path("jobs/submit.sh").is_file());
}

#[test]
fn pods_get_the_words_of_the_run_and_the_number_of_shards() {
    let workplace = Workplace::new();
    let submit = "submit kubernetes --image a/b:1 --claim scans --shards 2 -o runs/Fleet_1 -- run";
    workplace.succeed(&(submit, ["$(HOME) {{name}}", "-d", "pca"])).check_stdout(&["runs/Fleet_1/submit.sh"]);
    let shards = workplace.read("runs/Fleet_1/shards.yaml");
    for line in [
        "  name: fleet-1-shards\n",
        "  completionMode: Indexed\n  completions: 2\n  parallelism: 2\n",
        "      automountServiceAccountToken: false\n",
        "            limits:\n              memory: \"2Gi\"\n",
        "          image: \"a/b:1\"\n",
        "$$(printf shard-%01d-of-2 $$((JOB_COMPLETION_INDEX + 1)))\n",
        "exec scanbench run --shard \"$$((JOB_COMPLETION_INDEX + 1))/2\" \"$$@\"\n",
        "            - \"$$(HOME) {{name}}\"\n            - \"-d\"\n            - \"pca\"\n          workingDir",
        "            claimName: \"scans\"\n",
    ] {
        assert!(shards.contains(line), "{line}\n{shards}");
    }
    let merge = workplace.read("runs/Fleet_1/merge.yaml");
    let words = ["merge", "fleet-1/shards/shard-1-of-2", "fleet-1/shards/shard-2-of-2", "-o", "fleet-1/run"];
    let lines: Vec<String> = words.iter().map(|it| format!("            - {it:?}\n")).collect();
    assert!(merge.contains(&lines.concat()), "{merge}");
}

#[test]
fn limits_are_those_of_shards_and_merge_and_so_many_run_at_once() {
    let workplace = Workplace::new();
    let options = "--shards 3 --at-once 2 --time 10 --memory 2G -o jobs";
    workplace.succeed(&format!("submit slurm {options} -- run street-narrow -d pca"));
    workplace.check_file("jobs/shards.sh", &["#SBATCH --array=1-3%2\n"]);
    for script in ["shards", "merge"] {
        workplace.check_file(&format!("jobs/{script}.sh"), &["#SBATCH --time=10\n#SBATCH --mem=2G\n"]);
    }
}
