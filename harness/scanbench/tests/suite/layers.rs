//! A crate depends only on crates below it, and inside each a module uses only modules that are declared above it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Modules of a crate by path, such as `["segment", "terrain"]`, with their index in the order of declaration.
struct Modules {
    index_of: BTreeMap<Vec<String>, usize>,
    files: Vec<(Vec<String>, PathBuf)>,
}

/// The folder of the workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn modules_of(folder: &str) -> Modules {
    let src = root().join(folder).join("src");
    let mut modules = Modules { index_of: BTreeMap::new(), files: Vec::new() };
    let files = ["lib.rs", "main.rs"].map(|it| src.join(it));
    let file = files.iter().find(|it| it.is_file()).unwrap_or_else(|| panic!("no crate in {folder}"));
    modules.declare(Vec::new(), file, &src);
    assert!(modules.files.len() > 3, "no modules found in {}", src.display());
    modules
}

impl Modules {
    fn declare(&mut self, path: Vec<String>, file: &Path, folder: &Path) {
        for name in declared_modules(&code_of(file)) {
            let mut inner = path.clone();
            inner.push(name.clone());
            let nested = folder.join(&name);
            let candidates = [folder.join(format!("{name}.rs")), nested.join("mod.rs")];
            let inner_file =
                candidates.iter().find(|it| it.is_file()).unwrap_or_else(|| panic!("no file for {inner:?}"));
            self.declare(inner, inner_file, &nested);
        }
        // A module comes after its own parts, which it may gather, and before the next one.
        self.index_of.insert(path.clone(), self.files.len());
        self.files.push((path, file.to_owned()));
    }

    /// The longest beginning of `names` that is a module.
    fn module_of<'a>(&self, names: &'a [String]) -> Option<&'a [String]> {
        (1..=names.len()).rev().map(|n| &names[..n]).find(|it| self.index_of.contains_key(*it))
    }
}

/// The code of a file without comments and without its tests.
fn code_of(file: &Path) -> String {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

fn declared_modules(code: &str) -> Vec<String> {
    let mut declared = Vec::new();
    let mut is_test_only = false;
    for line in code.lines().map(str::trim) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let [.., "mod", name] = words[..]
            && let Some(name) = name.strip_suffix(';')
            && !is_test_only
        {
            declared.push(name.to_owned());
        }
        is_test_only = line == "#[cfg(test)]";
    }
    declared
}

/// All paths in `code` that start at the crate or at a parent, as they read from the crate's root.
fn used_paths(code: &str, module: &[String]) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    for (start, root) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        let before = code[..start].chars().next_back();
        if before.is_some_and(|it| it.is_alphanumeric() || it == '_' || it == '$')
            || code[..start].ends_with("super::")
        {
            continue;
        }
        let (mut prefix, mut rest) = (Vec::new(), &code[start + root.len()..]);
        if root == "super::" {
            prefix = module[..module.len().saturating_sub(1)].to_vec();
            while let Some(after) = rest.strip_prefix("super::") {
                prefix.pop();
                rest = after;
            }
        }
        expand(rest, &prefix, &mut paths);
    }
    paths
}

/// Appends the paths of a `use` tree that begins at `rest`, and returns what follows it.
fn expand<'a>(rest: &'a str, prefix: &[String], paths: &mut Vec<Vec<String>>) -> &'a str {
    let mut path = prefix.to_vec();
    let mut rest = rest.trim_start();
    loop {
        if let Some(mut inner) = rest.strip_prefix('{') {
            loop {
                inner = expand(inner, &path, paths).trim_start();
                match inner.strip_prefix(',') {
                    Some(after) if !after.trim_start().starts_with('}') => inner = after,
                    Some(after) => return after.trim_start().trim_start_matches('}'),
                    None => return inner.strip_prefix('}').unwrap_or(inner),
                }
            }
        }
        let n_name = rest.find(|it: char| !it.is_alphanumeric() && it != '_').unwrap_or(rest.len());
        path.push(rest[..n_name].to_owned());
        rest = &rest[n_name..];
        match rest.strip_prefix("::") {
            Some(after) => rest = after,
            None => break,
        }
    }
    paths.push(path);
    rest
}

#[track_caller]
fn check(folder: &str) {
    let modules = modules_of(folder);
    let mut offences = Vec::new();
    let mut n_uses = 0;
    for (module, file) in &modules.files {
        for path in used_paths(&code_of(file), module) {
            let Some(used) = modules.module_of(&path) else { continue };
            let is_family = module.starts_with(used) || used.starts_with(module);
            n_uses += usize::from(!is_family);
            if !is_family && modules.index_of[used] > modules.index_of[module] {
                offences.push(format!(
                    "{} uses {}, which is declared below it",
                    module.join("::"),
                    used.join("::")
                ));
            }
        }
    }
    assert!(n_uses > 3, "only {n_uses} uses found in {folder}: the test sees nothing");
    assert!(offences.is_empty(), "in {folder}:\n{}", offences.join("\n"));
}

#[test]
fn modules_use_only_what_is_declared_above_them() {
    for (folder, _) in FLOORS {
        check(folder);
    }
}

#[test]
fn use_trees_are_read_to_the_last_leaf() {
    let code = "use crate::a::{b, c::{D, e}};\nfn f() -> super::g::H { crate::i() }";
    let paths: Vec<String> =
        used_paths(code, &["m".to_owned(), "n".to_owned()]).iter().map(|it| it.join("::")).collect();
    assert_eq!(paths, ["a::b", "a::c::D", "a::c::e", "i", "m::g::H"]);
}

/// The floors of the house from the ground up, and which others each one stands on.
const FLOORS: [(&str, &[&str]); 9] = [
    ("detector", &[]),
    ("baselines", &["detector"]),
    ("reports", &[]),
    ("harness/scans", &["detector", "reports"]),
    ("harness/simulator", &["detector", "reports", "scans"]),
    ("harness/evaluation", &["baselines", "detector", "reports", "scans", "simulator"]),
    ("harness/viewer", &["detector", "evaluation", "reports", "scans"]),
    ("harness/remote", &[]),
    (
        "harness/scanbench",
        &["baselines", "detector", "evaluation", "remote", "reports", "scans", "simulator", "viewer"],
    ),
];

/// Macros for tests, which no floor stands on.
const TESTS_ALONE: &str = "harness/test_data";

/// The manifest in `folder`.
fn manifest(folder: &str) -> toml::Table {
    let path = root().join(folder).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The names in a table of dependencies, which need not be there.
fn names(manifest: &toml::Table, table: &str) -> Vec<String> {
    let table = manifest.get(table).and_then(toml::Value::as_table);
    table.into_iter().flat_map(toml::Table::keys).cloned().collect()
}

#[test]
fn a_floor_stands_on_those_below_it_alone() {
    let workspace = &manifest(".")["workspace"];
    let mut members: Vec<&str> =
        workspace["members"].as_array().into_iter().flatten().filter_map(toml::Value::as_str).collect();
    members.retain(|it| *it != TESTS_ALONE);
    assert_eq!(members, FLOORS.map(|(folder, _)| folder));
    let crates = FLOORS.map(|(folder, _)| folder.rsplit('/').next().unwrap_or(folder));
    for (index, (folder, expected)) in FLOORS.into_iter().enumerate() {
        let mut used = names(&manifest(folder), "dependencies");
        used.retain(|it| crates.contains(&it.as_str()));
        assert_eq!(used, expected, "{folder}");
        assert!(expected.iter().all(|it| crates[..index].contains(it)), "{folder} stands on one above it");
    }
}

#[test]
fn rerun_and_the_network_are_known_to_one_crate_each_that_can_be_left_out() {
    const NETWORK: [&str; 4] = ["object_store", "reqwest", "rustls", "tokio"];
    for (folder, _) in FLOORS {
        let manifest = manifest(folder);
        let tables = ["dependencies", "dev-dependencies", "build-dependencies"];
        let used: Vec<String> = tables.iter().flat_map(|it| names(&manifest, it)).collect();
        let knows_rerun = used.iter().any(|it| it == "rerun" || it.starts_with("re_"));
        assert_eq!(knows_rerun, folder == "harness/viewer", "{folder}");
        let knows_the_network = used.iter().any(|it| NETWORK.contains(&it.as_str()));
        assert_eq!(knows_the_network, folder == "harness/remote", "{folder}");
        for left_out in ["viewer", "remote"] {
            let knows_it = used.iter().any(|it| it == left_out);
            assert_eq!(knows_it, folder == "harness/scanbench", "{folder}");
        }
    }
    let program = manifest("harness/scanbench");
    for left_out in ["viewer", "remote"] {
        assert_eq!(program["dependencies"][left_out]["optional"].as_bool(), Some(true));
    }
    assert_eq!(program["features"]["default"].as_array().map(Vec::len), Some(2));
}

#[test]
fn one_file_each_asks_whether_viewer_and_network_were_built_in() {
    let mut asking = Vec::new();
    for (folder, _) in FLOORS {
        let files = modules_of(folder).files;
        // Schemas add to types of `reports`, and are no part of the program.
        let asks = |file: &Path| code_of(file).replace("feature = \"schemas\"", "").contains("feature = ");
        asking.extend(files.into_iter().filter(|(_, file)| asks(file)).map(|(module, _)| module.join("::")));
    }
    assert_eq!(asking, ["plumbing::remote", "plumbing::recorder"]);
}

/// What opens files, or makes folders, without one of the doors.
const PAST_THE_DOORS: [&str; 11] = [
    "File::open(",
    "File::create(",
    "File::create_new(",
    "File::options()",
    "OpenOptions::new()",
    "fs::read(",
    "fs::read)",
    "fs::read_to_string(",
    "fs::write(",
    "fs::copy(",
    "create_dir",
];

/// The doors, and files that open what nobody else can have put there, or what the user has named.
const OPENING: [(&str, &str, &str); 20] = [
    ("reports", "files::regular_file", "the door for reading"),
    ("reports", "files::new_file", "the door for writing"),
    ("reports", "files::new_folders", "folders on the way to a result that the user names"),
    ("reports", "files::whole_set", "folders of what was just written are brought to the disk"),
    ("reports", "run_folder::manifest", "for tests"),
    ("reports", "run_folder::run_directory", "what was just written is brought to the disk"),
    ("harness/scans", "conversion::whole_folder", "in a folder that was just made"),
    ("harness/evaluation", "process::processes", "what the system says of processes"),
    ("harness/evaluation", "process::received_cloud", "memory of the program that asks"),
    ("harness/evaluation", "process::sandbox", "what the system is told of users"),
    ("harness/evaluation", "process::supervisor", "what the system says of processes; /dev/null"),
    (
        "harness/evaluation",
        "run::counter",
        "what the system says of processes; a folder that was made for valgrind's counts",
    ),
    ("harness/viewer", "recording_file", "a device or a pipe that the user names"),
    ("harness/remote", "local_file", "the door of a crate that uses no other"),
    ("harness/remote", "transfer", "folders of what is fetched"),
    ("harness/remote", "unpack", "folders of what is unpacked"),
    ("harness/scanbench", "plumbing::interruption", "what the system says of this program"),
    ("harness/scanbench", "plumbing::provenance", "this program, and what the system says of the processor"),
    ("harness/scanbench", "verbs::serve", "pipes and memory of the program that serves"),
    ("harness/scanbench", "plumbing::step_summary", "a file that the environment names"),
];

/// Whether `code` has `call`, and not as the end of a longer name.
fn calls(code: &str, call: &str) -> bool {
    let is_name = |it: char| it.is_alphanumeric() || it == '_';
    code.match_indices(call).any(|(begin, _)| !code[..begin].ends_with(is_name))
}

#[test]
fn files_are_opened_through_the_doors() {
    let mut found = Vec::new();
    for (folder, _) in FLOORS {
        for (module, file) in modules_of(folder).files {
            let code = code_of(&file);
            if PAST_THE_DOORS.iter().any(|it| calls(&code, it)) {
                found.push(format!("{folder} {}", module.join("::")));
            }
        }
    }
    let mut expected = OPENING.map(|(folder, module, _)| format!("{folder} {module}")).to_vec();
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
}
