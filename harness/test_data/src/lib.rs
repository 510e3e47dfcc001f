//! Tests on real data, which may not be passed on with the project.
//!
//! `SCANBENCH_TEST_DATA` names the folder where they are, with `data/` and `oracle/` in it. A test that needs what is not there is
//! ignored, so that `cargo test` counts it; with `SCANBENCH_REQUIRE_TEST_DATA=1` it is not, and fails.

use std::ffi::OsStr;
use std::path::Path;

use proc_macro::{TokenStream, TokenTree};

const FOLDER: &str = "SCANBENCH_TEST_DATA";
const REQUIRED: &str = "SCANBENCH_REQUIRE_TEST_DATA";

/// Makes a function a test that is ignored unless all these paths are in the folder of real data, such as
/// `#[needs_test_data("data/kitti_tracking")]`.
#[proc_macro_attribute]
pub fn needs_test_data(paths: TokenStream, test: TokenStream) -> TokenStream {
    let folder = std::env::var_os(FOLDER).filter(|it| !it.is_empty());
    let is_required = std::env::var_os(REQUIRED).is_some_and(|it| !it.is_empty() && it != "0");
    let expanded = texts(paths).and_then(|paths| {
        let reason = missing(folder.as_deref(), &paths)?.filter(|_| !is_required);
        let ignored = reason.map(|it| format!("#[ignore = {it:?}]")).unwrap_or_default();
        // Naming the variables lets cargo compile again when they change.
        let watched =
            format!("const _: [Option<&str>; 2] = [option_env!({FOLDER:?}), option_env!({REQUIRED:?})];");
        parsed(&format!("{watched} #[test] {ignored}"))
    });
    match expanded {
        Ok(mut expanded) => {
            expanded.extend(test);
            expanded
        }
        Err(problem) => parsed(&format!("compile_error!({problem:?});")).unwrap_or_default(),
    }
}

/// The place of a path in the folder of real data, such as `test_data!("data/kitti_tracking")`; a panic that says what is missing if
/// it is not there.
#[proc_macro]
pub fn test_data(path: TokenStream) -> TokenStream {
    let call = format!(
        "{{
            let path: &str = {path};
            let folder = ::std::env::var_os({FOLDER:?}).unwrap_or_default();
            let found = ::std::path::Path::new(&folder).join(path);
            assert!(found.exists(), \"no real data: {{path}} is not in {{folder:?}}, which {FOLDER} names\");
            found
        }}"
    );
    parsed(&call).unwrap_or_default()
}

fn parsed(code: &str) -> Result<TokenStream, String> {
    code.parse().map_err(|error| format!("{error}: {code}"))
}

/// The texts of a list of literals.
fn texts(list: TokenStream) -> Result<Vec<String>, String> {
    let is_comma = |token: &TokenTree| matches!(token, TokenTree::Punct(it) if it.as_char() == ',');
    let literals = list.into_iter().filter(|it| !is_comma(it)).map(|it| text(&it.to_string()));
    let texts: Vec<String> = literals.collect::<Result<_, _>>()?;
    if texts.is_empty() { Err("which real data are needed?".to_owned()) } else { Ok(texts) }
}

/// What stands between the quotes of a literal.
fn text(literal: &str) -> Result<String, String> {
    let inner = literal.strip_prefix('"').and_then(|it| it.strip_suffix('"'));
    let inner = inner.filter(|it| !it.is_empty() && !it.contains('\\'));
    Ok(inner.ok_or_else(|| format!("{literal} is no path in quotes"))?.to_owned())
}

/// Why a test cannot run that needs `paths` of `folder`; `None` if it can.
fn missing(folder: Option<&OsStr>, paths: &[String]) -> Result<Option<String>, String> {
    let Some(folder) = folder.map(Path::new) else {
        return Ok(Some(format!("no real data: {FOLDER} is not set")));
    };
    // Tests run in other folders than the compiler.
    if !folder.is_absolute() {
        return Err(format!("{FOLDER} is {folder:?}, and has to be an absolute path"));
    }
    let missing = paths.iter().find(|it| !folder.join(it).exists());
    Ok(missing.map(|it| format!("no real data: {it} is not in {}", folder.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_runs_if_all_it_needs_is_there() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let missing = |paths: &[&str]| {
            let paths: Vec<String> = paths.iter().map(|&it| it.to_owned()).collect();
            missing(Some(folder.as_os_str()), &paths).expect("an absolute path")
        };
        assert_eq!(missing(&["src", "Cargo.toml"]), None);
        let expected = format!("no real data: data/nothing is not in {}", folder.display());
        assert_eq!(missing(&["src", "data/nothing"]), Some(expected));
    }

    #[test]
    fn without_a_folder_nothing_is_there_and_a_relative_one_is_refused() {
        let paths = ["data".to_owned()];
        let expected = "no real data: SCANBENCH_TEST_DATA is not set";
        assert_eq!(missing(None, &paths), Ok(Some(expected.to_owned())));
        let error = missing(Some(OsStr::new("here")), &paths);
        assert_eq!(error, Err("SCANBENCH_TEST_DATA is \"here\", and has to be an absolute path".to_owned()));
    }

    #[test]
    fn paths_stand_in_quotes() {
        assert_eq!(text("\"data/a\""), Ok("data/a".to_owned()));
        for wrong in ["data", "\"\"", "7", "\"a"] {
            assert!(text(wrong).is_err(), "{wrong}");
        }
    }
}
