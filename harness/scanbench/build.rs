//! Records where the program was built from, for the manifests of its runs.

use std::process::Command;

/// What the program is built from. The rest of the repository need not be there, as in the image.
const SOURCES: [&str; 7] =
    ["Cargo.lock", "Cargo.toml", "baselines", "datasets.toml", "detector", "harness", "reports"];

fn main() {
    // Any of these changing may change the commit or whether there are changes beyond it.
    for path in SOURCES {
        println!("cargo:rerun-if-changed=../../{path}");
    }
    for file in ["HEAD", "index"] {
        // In a work tree these are elsewhere.
        if let Some(path) = output_of("git", &["rev-parse", "--path-format=absolute", "--git-path", file]) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    let rustc = std::env::var("RUSTC").expect("cargo sets RUSTC");
    let rustc_version = output_of(&rustc, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo:rustc-env=SCANBENCH_RUSTC_VERSION={rustc_version}");
    // Empty outside of a checkout, such as in a source archive.
    let commit = output_of("git", &["rev-parse", "HEAD"]).unwrap_or_default();
    // Git would write its index anew, and the next build would begin again for that.
    let mut status =
        vec!["--no-optional-locks", "-C", "../..", "status", "--porcelain", "--untracked-files=no", "--"];
    status.extend(SOURCES);
    let changes = output_of("git", &status).unwrap_or_default();
    println!("cargo:rustc-env=SCANBENCH_GIT_COMMIT={commit}");
    println!("cargo:rustc-env=SCANBENCH_GIT_DIRTY={}", !changes.is_empty());
}

fn output_of(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
