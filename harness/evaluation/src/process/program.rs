//! A detector that runs as a program of its own, under its [supervisor](super::supervisor).

use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant, UNIX_EPOCH};

use reports::files::unfinished::unfinished_results;
use rustix::process::{Pid, Signal};

use scans::dataset::class_table::ClassTable;

use super::last_words::LastWords;
use super::message::{PROTOCOLS, Question, line_of};
use super::pipe::Pipe;
use super::problem::Ending;
use super::processes::{cpu_time_of, descendants, start_of};
use super::supervisor::{CANNOT_START, EXIT, READ_FD, SIGNAL, TOKEN, WARNING, WRITE_FD};

/// The verb with which this program supervises the command that follows.
pub const SUPERVISE: &str = "supervise";

/// Libraries that take their number of threads from the environment.
const THREAD_VARIABLES: [&str; 3] = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"];
/// Time for a detector to end once it is asked to.
const GRACE: Duration = Duration::from_secs(2);
/// Time for a supervisor to clean up.
const LONGEST_CLEANING: Duration = Duration::from_secs(4);

/// How a detector is started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartedProgram {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// Its working folder.
    pub folder: PathBuf,
    /// Files and folders that it must not see, beside unfinished results, and without network; `None` if it may see all.
    pub hidden: Option<Vec<PathBuf>>,
    /// How many threads it should use at most.
    pub threads: u32,
    /// Time limit for its start.
    pub start_limit: Duration,
    /// The user's names of classes, which its answers may have.
    pub classes: ClassTable,
}

/// A detector that is running.
#[derive(Debug)]
pub struct Program {
    supervisor: Child,
    /// Pipe for its messages.
    pub pipe: Pipe,
    words: LastWords,
    status: Option<ExitStatus>,
    // Last known processes of the detector, with their start times, as process ids are used again.
    processes: Vec<(u32, Option<u64>)>,
}

static N_STARTED: AtomicU32 = AtomicU32::new(0);

impl StartedProgram {
    /// Starts it.
    ///
    /// # Errors
    ///
    /// If the operating system has no more processes or pipes, or if we were ourselves started by a detector.
    pub fn start(&self) -> io::Result<Program> {
        refuse_nesting()?;
        let (theirs_to_read, to) = rustix::pipe::pipe_with(rustix::pipe::PipeFlags::CLOEXEC)?;
        let (from, theirs_to_write) = rustix::pipe::pipe_with(rustix::pipe::PipeFlags::CLOEXEC)?;
        let mut command = Command::new(std::env::current_exe()?);
        command.arg(SUPERVISE);
        if let Some(hidden) = &self.hidden {
            command.arg("--sandbox");
            // Results in the making have labels as well.
            for path in hidden.iter().chain(&unfinished_results()) {
                command.arg("--hide").arg(std::path::absolute(path)?);
            }
        }
        command.arg("--").args(&self.command).current_dir(&self.folder);
        command.env("SCANBENCH_PROTOCOL", PROTOCOLS[0].to_string());
        for name in THREAD_VARIABLES.iter().filter(|name| std::env::var_os(name).is_none()) {
            command.env(name, self.threads.to_string());
        }
        let number = N_STARTED.fetch_add(1, Ordering::Relaxed);
        let started_ns = UNIX_EPOCH.elapsed().unwrap_or_default().as_nanos();
        let token = format!("scanbench-{}-{number}-{started_ns}", std::process::id());
        command.env(TOKEN, &token);
        command.stdin(theirs_to_read).stdout(theirs_to_write).stderr(Stdio::piped());
        // Ctrl-C on the terminal is for us alone.
        let mut supervisor = command.process_group(0).spawn()?;
        // Only the child may hold its ends of the pipes; `command` has them, too.
        drop(command);
        let printed = supervisor.stderr.take().ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(Program {
            supervisor,
            pipe: Pipe::new(to, from)?,
            words: LastWords::of(printed, token),
            status: None,
            processes: Vec::new(),
        })
    }
}

/// Refuses to start a detector from a detector: a script that benchmarks itself while it is imported would start itself
/// without end.
fn refuse_nesting() -> io::Result<()> {
    if [READ_FD, WRITE_FD].iter().any(|it| std::env::var_os(it).is_none()) {
        return Ok(());
    }
    Err(io::Error::other(
        "a detector starts this run, which starts detectors: it would never end; a file that is a detector must not run \
         scanbench when it is imported",
    ))
}

impl Program {
    /// The detector and all processes that it has started.
    pub fn processes(&self) -> Vec<u32> {
        descendants(self.supervisor.id())
    }

    /// Time on processors of the detector and all processes that it has started; `None` if the system does not report it.
    pub fn cpu_time(&mut self) -> Option<Duration> {
        let processes = self.processes();
        self.processes = processes.iter().map(|&pid| (pid, start_of(pid))).collect();
        cpu_time_of(&processes)
    }

    /// The last lines that the detector has printed so far.
    pub fn last_words(&self) -> Vec<String> {
        self.words.catch_up();
        self.words.lines()
    }

    /// Asks it to end, and kills it if it does not. Returns warnings.
    pub fn quit(mut self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.pipe.has_more() && !self.pipe.is_closed() {
            warnings.push("said more than it was asked".to_owned());
        }
        let line = line_of(&Question::Quit, 0).unwrap_or_default();
        let _ = self.pipe.write(&line, Instant::now() + GRACE);
        self.pipe.close();
        if self.wait(GRACE).is_none() {
            warnings
                .push(format!("did not end within {} s of being asked to, and was killed", GRACE.as_secs()));
            self.kill();
        }
        self.words.wait();
        let of_supervisor = self.words.of_supervisor();
        warnings.extend(of_supervisor.iter().filter_map(|it| it.strip_prefix(WARNING)).map(str::to_owned));
        warnings
    }

    /// Ends it, if it has not ended, and returns how it ended and its last words.
    pub fn end(mut self) -> (Ending, Vec<String>) {
        // A detector that has closed its pipe may be about to end.
        let has_ended = self.wait(Duration::from_millis(500)).is_some();
        self.kill();
        self.words.wait();
        let said = self.words.of_supervisor().into_iter().find_map(|it| ending_in(&it));
        let ending = said.filter(|_| has_ended).unwrap_or(Ending::ClosedPipe);
        (ending, self.words.lines())
    }

    /// Kills it. Returns its last words.
    pub fn kill_with_last_words(mut self) -> Vec<String> {
        self.kill();
        self.words.wait();
        self.words.lines()
    }

    fn kill(&mut self) {
        if self.status.is_some() {
            self.kill_orphans();
            return;
        }
        let _ = rustix::process::kill_process(Pid::from_child(&self.supervisor), Signal::TERM);
        if self.wait(LONGEST_CLEANING).is_none() {
            let _ = self.supervisor.kill();
            self.status = self.supervisor.wait().ok();
        }
        self.kill_orphans();
    }

    /// Kills the processes that a supervisor left behind because it was killed itself.
    fn kill_orphans(&mut self) {
        let is_clean = self.status.is_some_and(|it| it.success());
        for (pid, start) in std::mem::take(&mut self.processes) {
            let is_orphan = !is_clean && start.is_some() && start_of(pid) == start;
            if let Some(pid) = Pid::from_raw(pid as i32).filter(|_| is_orphan) {
                let _ = rustix::process::kill_process(pid, Signal::KILL);
            }
        }
    }

    /// Waits for the end of the supervisor, this long at most.
    fn wait(&mut self, longest: Duration) -> Option<ExitStatus> {
        let ends = Instant::now() + longest;
        loop {
            if self.status.is_none() {
                self.status = self.supervisor.try_wait().ok().flatten();
            }
            if self.status.is_some() || Instant::now() >= ends {
                return self.status;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// The end of the detector according to a line of the supervisor; `None` if the line is about something else.
fn ending_in(line: &str) -> Option<Ending> {
    let number = |prefix: &str| line.strip_prefix(prefix)?.parse().ok();
    let of_exit = number(EXIT).map(Ending::Exit);
    of_exit
        .or_else(|| number(SIGNAL).map(Ending::Signal))
        .or_else(|| line.strip_prefix(CANNOT_START).map(|reason| Ending::NeverBegan(reason.to_owned())))
}

impl Drop for Program {
    fn drop(&mut self) {
        self.kill();
    }
}
