//! What `init` writes, and that it does so whole or not at all.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use crate::program::Workplace;

/// The files of a folder with their content, hidden ones too.
fn files(workplace: &Workplace, folder: &str) -> Vec<(String, Vec<u8>)> {
    let names = workplace.names().into_iter().filter(|it| workplace.folder().join(it).is_file());
    let below = names.filter_map(|it| Some(it.strip_prefix(folder).ok()?.to_str().unwrap().to_owned()));
    below.map(|it| (it.clone(), workplace.read_bytes(&format!("{folder}/{it}")))).collect()
}

#[test]
fn a_new_folder_has_a_detector_scans_with_labels_and_a_gate_that_passes_an_unchanged_detector() {
    let workplace = Workplace::new();
    workplace.succeed("init a/mine").check_stdout(&["\n  cd a/mine\n"]);
    let names: Vec<String> = files(&workplace, "a/mine").into_iter().map(|it| it.0).collect();
    let plain = names.iter().filter(|it| !it.starts_with("data/")).map(String::as_str);
    let expected =
        ".github/workflows/gate.yml .gitignore README.md detector.py scanbench.toml tolerances.toml";
    assert_eq!(plain.collect::<Vec<_>>().join(" "), expected);
    workplace.succeed("data check a/mine/data/street").check_stdout(&["20 of 10 drives"]);
    let parameters: toml::Table = toml::from_str(&workplace.read("a/mine/scanbench.toml")).unwrap();
    assert!(parameters["detector"]["cells"]["command"].is_array(), "{parameters:?}");
    workplace.check_file("a/mine/detector.py", &["\ndef cells("]);
    let workflow = workplace.read("a/mine/.github/workflows/gate.yml");
    let simulate = workflow
        .lines()
        .find_map(|it| it.trim().strip_prefix("- run: mkdir -p data && scanbench data simulate "))
        .unwrap();
    std::fs::create_dir(workplace.path("data")).unwrap();
    workplace.succeed(&("data simulate", simulate));
    let of_workflow = files(&workplace, "data");
    assert!(of_workflow.len() > 20 && of_workflow == files(&workplace, "a/mine/data"));
    for name in ["first", "again"] {
        let no_recording = if cfg!(feature = "viewer") { &["--no-rrd"][..] } else { &[] };
        workplace.succeed(&(["run", "data/street", "-d", "pca", "-o", name], no_recording));
        // Whoever changes the program runs these tests before there is a commit of it.
        let manifest = format!("{name}/manifest.json");
        let clean = workplace.read(&manifest).replacen("\"dirty\": true", "\"dirty\": false", 1);
        workplace.write(&manifest, &clean);
    }
    workplace.succeed(&["baseline", "accept", "first", "-b", "baseline", "--why", "the first"]);
    workplace
        .succeed("gate again -b baseline -t a/mine/tolerances.toml -o verdict")
        .check_stdout(&["PASSED\n"]);
}

#[test]
fn a_folder_with_something_in_it_is_left_alone() {
    let workplace = Workplace::new();
    workplace.write("note.txt", "mine");
    for (folder, why) in
        [(".", "is not empty"), ("note.txt", "cannot write"), ("note.txt/below", "cannot write")]
    {
        workplace.refuse(&("init", folder), 2, &[why]);
    }
}

/// No package index has scanbench. Whoever took the name there could run anything where it is installed by name.
#[test]
fn nothing_is_installed_by_a_name_that_anybody_may_take() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let listed =
        std::process::Command::new("git").args(["ls-files", "-z"]).current_dir(&root).output().unwrap();
    let names = String::from_utf8(listed.stdout).unwrap();
    let texts = names
        .split_terminator('\0')
        .filter_map(|name| Some((name, std::fs::read_to_string(root.join(name)).ok()?)));
    let is_bare = |word: &str| {
        word.trim_matches(|it: char| !it.is_ascii_alphanumeric()) == "scanbench" && !word.contains('/')
    };
    let is_install = |line: &str| {
        let installed = line.split_once("pip install ").or_else(|| line.split_once("WHEEL: "));
        installed.is_some_and(|(_, words)| {
            let command = words.split(['`', '#', '\\']).next().unwrap_or_default();
            !command.contains("harness/python") && command.split_whitespace().any(is_bare)
        })
    };
    let found: Vec<String> = texts
        .filter(|(name, _)| !name.ends_with("init.rs") || !name.contains("/tests/"))
        .flat_map(|(name, text)| {
            let lines = text.lines().filter(|it| is_install(it));
            lines.map(|it| format!("{name}: {it}")).collect::<Vec<_>>()
        })
        .collect();
    assert!(names.len() > 1000, "the files of the repository are looked at");
    assert!(found.is_empty(), "{found:#?}");
}
