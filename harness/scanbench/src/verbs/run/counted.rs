//! Who counts the instructions of a run: the processor, or valgrind, under which the program starts itself again.

use evaluation::run::counter::Counter;

use crate::cli::{CountedBy, RunArgs};
use crate::plumbing::failure::{Failure, Usage};

/// The folder of valgrind's counts, for the program that runs under it.
const DUMPS: &str = "SCANBENCH_VALGRIND_DUMPS";

/// Who counts for the run of `arguments`, if anybody does.
pub fn counter_of(arguments: &RunArgs) -> Result<Option<Counter>, Failure> {
    match arguments.count {
        None => Ok(None),
        Some(CountedBy::Processor) => {
            let or_else = "with --count=valgrind it is counted without, 50 times as slowly";
            let counter =
                Counter::of_processor().map_err(|error| Usage(format!("--count: {error}; {or_else}")))?;
            Ok(Some(counter))
        }
        Some(CountedBy::Valgrind) => {
            let dumps = std::env::var_os(DUMPS).ok_or_else(|| {
                Usage(
                    "detectors cannot be added to a run that valgrind counted: make it again with all"
                        .to_owned(),
                )
            })?;
            Ok(Some(Counter::Valgrind(dumps.into())))
        }
    }
}

/// Starts this program again under valgrind if that is to count, and ends with it; returns if it is not.
#[cfg(target_os = "linux")]
pub fn under_valgrind(arguments: &RunArgs) -> Result<(), Failure> {
    use std::sync::atomic::Ordering;
    use std::time::Duration;

    use evaluation::run::counter::valgrind_options;

    use crate::plumbing::interruption::interruption_flag;

    if arguments.count != Some(CountedBy::Valgrind) || std::env::var_os(DUMPS).is_some() {
        return Ok(());
    }
    let about = |what: &str| {
        let what = what.to_owned();
        move |error: std::io::Error| Usage(format!("--count=valgrind: {what}: {error}"))
    };
    let dumps = tempfile::tempdir().map_err(about("no folder for its counts"))?;
    let program = std::env::current_exe().map_err(about("this program is not to be found"))?;
    let mut valgrind = std::process::Command::new("valgrind")
        .args(valgrind_options(dumps.path()))
        .arg(program)
        .args(std::env::args_os().skip(1))
        .env(DUMPS, dumps.path())
        .spawn()
        .map_err(about("valgrind does not start; `apt-get install valgrind` or the like brings it"))?;
    let status = loop {
        if interruption_flag().load(Ordering::Relaxed) {
            let _ = rustix::process::kill_process(
                rustix::process::Pid::from_child(&valgrind),
                rustix::process::Signal::TERM,
            );
        }
        if let Some(status) = valgrind.try_wait().map_err(about("valgrind is lost"))? {
            break status;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    drop(dumps);
    // Everything was written and said by the program that has just ended.
    std::process::exit(status.code().unwrap_or(1));
}

/// There is no valgrind to start.
#[cfg(not(target_os = "linux"))]
pub fn under_valgrind(_arguments: &RunArgs) -> Result<(), Failure> {
    Ok(())
}
