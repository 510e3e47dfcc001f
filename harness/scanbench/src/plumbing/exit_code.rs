//! The exit code of the program for the result of a verb.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_exit_code;
use crate::plumbing::standard_streams::print_error;

/// Exit code after a panic, which is a bug; left alone it would end the program with 101, which means something else.
const PANICKED: u8 = 1;

/// Does `work` and returns the exit code; if it is not 0, stderr has the reason.
pub fn exit_code_of(work: impl FnOnce() -> Result<(), Failure>) -> u8 {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => 0,
        Ok(Err(failure)) => {
            print_error(format_args!("error: {failure}"));
            exit_code(&failure)
        }
        // The panic has been reported where it happened.
        Err(_) => PANICKED,
    }
}

/// The exit codes that `--help` documents.
fn exit_code(failure: &Failure) -> u8 {
    match failure {
        Failure::Internal(_) => 1,
        Failure::Usage(_) => 2,
        Failure::Data(_) => 3,
        Failure::NothingEvaluated(_) => 4,
        Failure::NotComparable(_) => 5,
        Failure::Detector(_) => 6,
        Failure::Unwritten(_) => 7,
        Failure::Regression(_) => 100,
        Failure::Drift(_) => 101,
        Failure::Interrupted(_) => interruption_exit_code(),
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use evaluation::run::side_by_side::RunError;
    use evaluation::run::single_scan::SingleScanError;
    use evaluation::scan_pass::ScanPassError;
    use reports::files::archive::ArchiveError;
    use reports::run_folder::run_target::RunDirectoryError;
    use scans::dataset::DatasetError;

    use super::*;
    use crate::plumbing::failure::NothingEvaluated;

    #[track_caller]
    fn check(error: impl Into<Failure>, expected: u8) {
        let failure = error.into();
        assert_eq!(exit_code(&failure), expected, "{failure}");
        assert_eq!(exit_code_of(|| Err(failure)), expected);
    }

    fn not_written(kind: ErrorKind) -> RunDirectoryError {
        RunDirectoryError::Io { path: "runs".into(), source: kind.into() }
    }

    #[test]
    fn a_full_disk_is_not_the_users_mistake_and_a_bad_path_is() {
        check(not_written(ErrorKind::StorageFull), 7);
        check(not_written(ErrorKind::NotADirectory), 2);
        let table = |kind: ErrorKind| ArchiveError::Write { path: "a.csv".into(), source: kind.into() };
        check(table(ErrorKind::StorageFull), 7);
        check(RunDirectoryError::from(table(ErrorKind::PermissionDenied)), 2);
    }

    #[test]
    fn data_that_are_missing_and_data_that_do_not_exist_differ() {
        let missing = || DatasetError::no_scans("velodyne");
        let unknown = || DatasetError::unknown_dataset("kity", &[]);
        check(missing(), 3);
        check(RunError::from(missing()), 3);
        check(unknown(), 2);
        check(RunError::from(unknown()), 2);
        check(ScanPassError::from(missing()), 3);
        let bad_catalogue = Failure::usage("bad catalogue".to_owned(), missing());
        assert_eq!(bad_catalogue.to_string(), "bad catalogue: \"velodyne\" has no scans");
        check(bad_catalogue, 2);
    }

    #[test]
    fn interrupted_and_empty_runs_have_codes_of_their_own() {
        check(RunError::Interrupted { n_done: 1, n_scans: 2 }, 130);
        check(ScanPassError::Interrupted { dataset: "street".to_owned(), n_scans: 2 }, 130);
        check(SingleScanError::Interrupted { n_done: 1, n_repeats: 2 }, 130);
        check(NothingEvaluated { reason: "no cars".to_owned() }, 4);
    }

    #[test]
    fn a_panic_is_an_internal_error() {
        assert_eq!(exit_code_of(|| panic!("on purpose")), 1);
        assert_eq!(exit_code_of(|| Ok(())), 0);
    }
}
