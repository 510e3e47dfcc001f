//! Inside each crate a module uses only modules that are declared above it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Modules of a crate by path, such as `["segment", "terrain"]`, with their place in the order of declaration.
struct Modules {
    place_of: BTreeMap<Vec<String>, usize>,
    files: Vec<(Vec<String>, PathBuf)>,
}

fn modules_of(crate_name: &str) -> Modules {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(crate_name).join("src");
    let mut modules = Modules { place_of: BTreeMap::new(), files: Vec::new() };
    modules.declare(Vec::new(), &src.join("lib.rs"), &src);
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
        self.place_of.insert(path.clone(), self.files.len());
        self.files.push((path, file.to_owned()));
    }

    /// The longest beginning of `names` that is a module.
    fn module_of<'a>(&self, names: &'a [String]) -> Option<&'a [String]> {
        (1..=names.len()).rev().map(|n| &names[..n]).find(|it| self.place_of.contains_key(*it))
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
fn check(crate_name: &str) {
    let modules = modules_of(crate_name);
    let mut offences = Vec::new();
    let mut n_uses = 0;
    for (module, file) in &modules.files {
        for path in used_paths(&code_of(file), module) {
            let Some(used) = modules.module_of(&path) else { continue };
            let is_family = module.starts_with(used) || used.starts_with(module);
            n_uses += usize::from(!is_family);
            if !is_family && modules.place_of[used] > modules.place_of[module] {
                offences.push(format!(
                    "{} uses {}, which is declared below it",
                    module.join("::"),
                    used.join("::")
                ));
            }
        }
    }
    assert!(n_uses > 3, "only {n_uses} uses found in {crate_name}: the test sees nothing");
    assert!(offences.is_empty(), "in {crate_name}:\n{}", offences.join("\n"));
}

#[test]
fn modules_of_the_detector_use_only_what_is_declared_above_them() {
    check("detector");
}

#[test]
fn modules_of_the_baselines_use_only_what_is_declared_above_them() {
    check("baselines");
}

#[test]
fn modules_of_the_reports_use_only_what_is_declared_above_them() {
    check("reports");
}

#[test]
fn modules_of_the_harness_use_only_what_is_declared_above_them() {
    check("harness");
}

#[test]
fn use_trees_are_read_to_the_last_leaf() {
    let code = "use crate::a::{b, c::{D, e}};\nfn f() -> super::g::H { crate::i() }";
    let paths: Vec<String> =
        used_paths(code, &["m".to_owned(), "n".to_owned()]).iter().map(|it| it.join("::")).collect();
    assert_eq!(paths, ["a::b", "a::c::D", "a::c::e", "i", "m::g::H"]);
}

#[test]
fn rerun_is_known_in_the_stream_alone() {
    let outside = modules_of("harness")
        .files
        .into_iter()
        .filter(|(module, _)| module.first().is_none_or(|it| it != "stream"));
    for (module, file) in outside {
        let code = code_of(&file);
        assert!(!code.contains("rerun::"), "{} knows Rerun", module.join("::"));
    }
}
