//! Where the real data are that some tests need and that may not be passed on with the project.

use std::path::{Path, PathBuf};

/// The environment variable that names the folder of real data, with `data/` and `oracle/` in it.
const FOLDER: &str = "SCANBENCH_TEST_DATA";

/// Where `path`, such as `data/kitti_tracking`, is in the folder of real data.
///
/// # Panics
///
/// If it is not there. So a test that calls this is `#[ignore = "needs data/kitti_tracking in SCANBENCH_TEST_DATA"]`, which
/// `cargo test` counts, and `cargo test -- --ignored` runs.
pub fn test_data(path: &str) -> PathBuf {
    let folder = std::env::var_os(FOLDER).unwrap_or_default();
    let found = Path::new(&folder).join(path);
    // Tests run in the folder of their crate, so that a relative folder would name another one in each.
    assert!(
        found.is_absolute() && found.exists(),
        "no real data: {path} is not in {folder:?}, which {FOLDER} names by an absolute path"
    );
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "no real data: data/nothing is not in ")]
    fn what_is_not_there_is_named() {
        test_data("data/nothing");
    }
}
