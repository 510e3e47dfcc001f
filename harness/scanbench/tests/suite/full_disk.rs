//! Disks that take only a part of a result: whatever a verb writes to a folder appears whole or not at all.

use std::process::Command;

use crate::accepted::accepted;
use crate::program::Workplace;

/// A limit of file systems in memory.
#[derive(Clone, Copy)]
struct Limit {
    /// The option of the mount, in front of the value.
    option: &'static str,
    /// Behind it.
    unit: &'static str,
    /// Enough for everything here.
    most: u32,
    /// So many values below the least that suffices are tried, in this step.
    below: (u32, u32),
}

const SIZE: Limit = Limit { option: "size=", unit: "k", most: 1 << 16, below: (64, 4) };
/// Each file and each folder in turn is the one for which there is no room.
const INODES: Limit = Limit { option: "nr_inodes=", unit: "", most: 4096, below: (40, 1) };

impl Limit {
    fn with(self, value: u32) -> String {
        format!("{}{value}{}", self.option, self.unit)
    }
}

/// Whether this test may mount file systems; only root may, and some containers let nobody.
fn may_mount() -> bool {
    let mounted = Command::new("unshare").args(["-m", "mount", "-t", "tmpfs", "none", "/mnt"]).output();
    let may = mounted.is_ok_and(|it| it.status.success());
    if !may {
        eprintln!("skipped: a small file system cannot be mounted here, which needs root");
    }
    may
}

/// Runs the program with `arguments`, which write to the folder `small`, on a file system with the content of `before` that
/// was mounted there with `options`: its exit code, and the checksums of all files before and afterwards. `None` if there is
/// no room for that content.
fn run_on(workplace: &Workplace, options: &str, arguments: &str) -> Option<(i32, String, String)> {
    const NO_ROOM: i32 = 77;
    let list = "(cd small && find . ! -name . -printf '%y %p\\n' | sort && find . -type f | sort | xargs -r sha256sum)";
    let script = format!(
        "mount -t tmpfs -o {options} none small && cp -a before/. small/ 2> /dev/null || exit {NO_ROOM}
        {list} > listed-before
        {} {arguments} > said 2>&1
        code=$?
        {list} > listed-after
        exit $code",
        env!("CARGO_BIN_EXE_scanbench")
    );
    let status =
        Command::new("unshare").args(["-m", "sh", "-c", &script]).current_dir(workplace.folder()).status();
    let code = status.expect("it starts").code().expect("no signal");
    (code != NO_ROOM).then(|| (code, workplace.read("listed-before"), workplace.read("listed-after")))
}

/// What is in the folder once `arguments` end with `code` on a disk with room for all.
fn whole(workplace: &Workplace, arguments: &str, code: i32) -> String {
    for folder in ["small", "before"] {
        std::fs::create_dir_all(workplace.path(folder)).expect("a folder");
    }
    let (ended, _, whole) = run_on(workplace, "size=1g", arguments).expect("it has room");
    assert!(ended == code && !whole.is_empty(), "{arguments}: {}", workplace.read("said"));
    whole
}

/// `options` leave the folder as it was or, if `arguments` end with `code`, as it is on a disk with room for all: whether
/// they do.
#[track_caller]
fn is_whole(workplace: &Workplace, options: &str, (arguments, code): (&str, i32), whole: &str) -> bool {
    let Some((ended, before, after)) = run_on(workplace, options, arguments) else { return false };
    let said = workplace.read("said");
    assert!(!said.contains("panicked"), "{options}, {arguments}: {said}");
    let expected = if ended == code { whole } else { &before };
    assert_eq!(after, expected, "{options}, {arguments}: {ended}, {said}");
    ended == code
}

/// The same on disks that are a little too small.
#[track_caller]
fn check(workplace: &Workplace, arguments: &str, code: i32) {
    let whole = whole(workplace, arguments, code);
    for limit in [SIZE, INODES] {
        let fits = |value: u32| is_whole(workplace, &limit.with(value), (arguments, code), &whole);
        let (mut too_small, mut enough) = (1, limit.most);
        while enough - too_small > 1 {
            let value = u32::midpoint(too_small, enough);
            *(if fits(value) { &mut enough } else { &mut too_small }) = value;
        }
        let (below, step) = limit.below;
        let values = (enough.saturating_sub(below).max(1)..enough).step_by(step as usize);
        let n_refused = values.filter(|it| !fits(*it)).count();
        assert!(n_refused > 1 && fits(enough), "{arguments}: {}", limit.with(enough));
    }
}

#[test]
fn baselines_and_verdicts_are_whole_or_not_there() {
    if !may_mount() {
        return;
    }
    let workplace = accepted();
    check(&workplace, "baseline init first -o small", 0);
    check(&workplace, "gate worse -b golden -o small", 100);
    // What is there is not lost either.
    workplace.succeed("baseline init first -o before");
    check(&workplace, "baseline accept worse -b small --worse --why fuller", 0);
    std::fs::remove_dir_all(workplace.path("before")).expect("it was there");
    workplace.end_with("gate first -b golden -o before", 0, &[]);
    check(&workplace, "gate worse -b golden -o small", 100);
}

#[test]
fn folders_to_start_from_are_whole_or_not_there() {
    if !may_mount() {
        return;
    }
    let workplace = Workplace::with_drive(2);
    check(&workplace, "submit slurm --shards 2 -o small -- run street -d pca", 0);
    check(&workplace, "completions --man small", 0);
    // Simulating takes a while.
    let whole = whole(&workplace, "init small", 0);
    let fits = ["size=8k", "size=40k", "size=4m", "nr_inodes=6", "nr_inodes=9", "nr_inodes=20", "size=256m"]
        .map(|it| is_whole(&workplace, it, ("init small", 0), &whole));
    assert_eq!(fits, [false, false, false, false, false, false, true]);
}

/// Without the rights of root: something is in the way of the second file.
#[test]
fn a_verdict_that_cannot_be_written_leaves_nothing_of_it() {
    let workplace = accepted();
    std::fs::create_dir_all(workplace.path("verdict/gate.md")).expect("a folder");
    let before = workplace.names();
    workplace.end_with(
        "gate first -b golden -o verdict",
        2,
        &["cannot write \"verdict/gate.md\": is a directory"],
    );
    assert_eq!(workplace.names(), before);
    std::fs::remove_dir(workplace.path("verdict/gate.md")).expect("it is empty");
    workplace.end_with("gate first -b golden -o verdict", 0, &[]);
}
