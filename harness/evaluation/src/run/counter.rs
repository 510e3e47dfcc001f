//! Instructions and memory of a detection: they are counted, and so hardly depend on what else a machine does.

use std::io;
use std::path::{Path, PathBuf};

#[cfg(target_os = "linux")]
use perf_event::events::{Event, Hardware};

/// Who counts instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Counter {
    /// The processor; the kernel hands its counts out as `perf_event`.
    Processor,
    /// valgrind, which this program runs under. It leaves a file in this folder after each `counted_detection`.
    Valgrind(PathBuf),
}

/// Why instructions cannot be counted here.
#[derive(Debug, thiserror::Error)]
#[error("{}", .0)]
pub struct NoCounter(&'static str);

/// What a detection took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    /// Instructions in user mode, on all threads and in all processes of the detector; `None` if nobody counted them.
    pub n_instructions: Option<u64>,
    /// The most memory at once, in bytes. Of a built-in detector it is what its detections have allocated, buffers that it
    /// keeps among it; of a program it is what all its processes have in memory. `None` if the system does not report it.
    pub peak_bytes: Option<u64>,
}

impl Counter {
    /// The counter of the processor.
    ///
    /// # Errors
    ///
    /// [`NoCounter`] if the system does not let this program count, with what would help.
    #[cfg(target_os = "linux")]
    pub fn of_processor() -> Result<Self, NoCounter> {
        match thread_counter(Hardware::INSTRUCTIONS, 0) {
            Ok(_) => Ok(Self::Processor),
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => Err(NoCounter(
                "the kernel does not let this user count instructions; `sudo sysctl kernel.perf_event_paranoid=2` does, and \
                 in a container its seccomp profile has to allow perf_event_open",
            )),
            Err(_) => Err(NoCounter(
                "this machine has no counter of instructions, as most virtual machines have none",
            )),
        }
    }

    /// The counter of the processor: this system has none that this program could ask.
    ///
    /// # Errors
    ///
    /// Always.
    #[cfg(not(target_os = "linux"))]
    pub fn of_processor() -> Result<Self, NoCounter> {
        Err(NoCounter("instructions can be counted on Linux only"))
    }

    /// Its name, as in a manifest.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Processor => "perf_event",
            Self::Valgrind(_) => "valgrind",
        }
    }
}

/// Counts what the detections of a built-in detector take, all on one thread.
pub struct OwnMeter {
    counter: Counter,
    #[cfg(target_os = "linux")]
    of_thread: Option<perf_event::Counter>,
    held_bytes: i64,
}

impl OwnMeter {
    /// Counts by `counter`.
    pub fn new(counter: Counter) -> Self {
        Self {
            counter,
            #[cfg(target_os = "linux")]
            of_thread: None,
            held_bytes: 0,
        }
    }

    /// Whether the time of what it counts says nothing.
    pub fn is_slow(&self) -> bool {
        matches!(self.counter, Counter::Valgrind(_))
    }

    /// What `detect` takes.
    pub fn measure(&mut self, detect: &mut dyn FnMut()) -> Count {
        let before = self.of_thread_so_far();
        let memory = allocation_counter::measure(|| {
            std::hint::black_box(counted_detection(detect));
        });
        let n_instructions = match &self.counter {
            Counter::Processor => self.of_thread_so_far().zip(before).map(|(after, before)| after - before),
            Counter::Valgrind(dumps) => taken_from_dump(dumps),
        };
        let peak_bytes = self.held_bytes + memory.bytes_max as i64;
        self.held_bytes += memory.bytes_current;
        Count { n_instructions, peak_bytes: u64::try_from(peak_bytes).ok() }
    }

    /// The instructions of this thread since it was first asked.
    #[cfg(target_os = "linux")]
    fn of_thread_so_far(&mut self) -> Option<u64> {
        if self.counter == Counter::Processor && self.of_thread.is_none() {
            self.of_thread = thread_counter(Hardware::INSTRUCTIONS, 0).ok();
        }
        self.of_thread.as_mut()?.read().ok()
    }

    #[cfg(not(target_os = "linux"))]
    fn of_thread_so_far(&mut self) -> Option<u64> {
        None
    }
}

/// A detection that is counted. valgrind knows it by its name, and by what it returns as something else than a jump to
/// `detect`.
#[inline(never)]
fn counted_detection(detect: &mut dyn FnMut()) -> bool {
    detect();
    std::hint::black_box(true)
}

/// Options of valgrind for a program that counts by `Counter::Valgrind` with this folder.
pub fn valgrind_options(dumps: &Path) -> Vec<String> {
    let file = dumps.join("dump");
    let function = "evaluation::run::counter::counted_detection";
    vec![
        "--quiet".to_owned(),
        "--tool=callgrind".to_owned(),
        format!("--callgrind-out-file={}", file.display()),
        "--collect-atstart=no".to_owned(),
        format!("--toggle-collect={function}"),
        format!("--dump-after={function}"),
    ]
}

/// Reads the sum of the only numbered file of callgrind in `dumps`, and removes it. The one without a number is for the end.
fn taken_from_dump(dumps: &Path) -> Option<u64> {
    let path =
        std::fs::read_dir(dumps).ok()?.flatten().map(|it| it.path()).find(|it| it.extension().is_some())?;
    let text = std::fs::read_to_string(&path).ok()?;
    std::fs::remove_file(path).ok()?;
    text.lines().find_map(|it| it.strip_prefix("totals:"))?.trim().parse().ok()
}

/// Counts the instructions of the processes of a detector, and looks at their memory.
#[cfg(target_os = "linux")]
#[derive(Default)]
pub struct ProcessMeter {
    counters: std::collections::BTreeMap<u32, perf_event::Counter>,
}

#[cfg(target_os = "linux")]
impl ProcessMeter {
    /// Begins to count `event` on all threads of the processes `pids` that it does not count yet, and forgets the most
    /// memory that they have had. Threads and processes that these start are counted with them.
    pub fn begin<E: Event + Clone>(&mut self, event: &E, pids: &[u32]) {
        for pid in pids {
            // A process of somebody else, or one that has ended, is looked at as it is.
            let _ = std::fs::write(format!("/proc/{pid}/clear_refs"), "5");
        }
        if self.counters.is_empty() {
            let threads = pids.iter().flat_map(|it| threads_of(*it));
            let counted = threads.filter_map(|it| Some((it, thread_counter(event.clone(), it).ok()?)));
            self.counters.extend(counted);
        }
    }

    /// Events since the beginning; `None` if nothing is counted.
    pub fn n_so_far(&mut self) -> Option<u64> {
        let counts: Vec<u64> = self.counters.values_mut().filter_map(|it| it.read().ok()).collect();
        (!counts.is_empty()).then(|| counts.iter().sum())
    }
}

/// The most that the processes `pids` have had in memory, in bytes; `None` if the system does not report it.
#[cfg(target_os = "linux")]
pub fn peak_bytes_of(pids: &[u32]) -> Option<u64> {
    let of_process = |pid: &u32| {
        let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        let line = status.lines().find_map(|it| it.strip_prefix("VmHWM:"))?;
        Some(1024 * line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?)
    };
    pids.iter().filter_map(of_process).reduce(|sum, it| sum + it)
}

/// A running counter of what the thread `tid` does in user mode, and all that it starts; 0 is this thread.
#[cfg(target_os = "linux")]
fn thread_counter(event: impl Event, tid: u32) -> io::Result<perf_event::Counter> {
    let mut builder = perf_event::Builder::new(event);
    builder.observe_pid(tid as i32).enabled(true);
    // What this program starts is not a part of its own detectors.
    builder.inherit(tid != 0).build()
}

#[cfg(target_os = "linux")]
fn threads_of(pid: u32) -> Vec<u32> {
    let Ok(threads) = std::fs::read_dir(format!("/proc/{pid}/task")) else { return Vec::new() };
    threads.flatten().filter_map(|it| it.file_name().to_str()?.parse().ok()).collect()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use perf_event::events::Software;
    use std::process::Command;

    #[test]
    fn memory_is_what_detections_keep_and_the_most_of_this_one() {
        let mut meter = OwnMeter::new(Counter::Valgrind(PathBuf::new()));
        let mut kept: Vec<u8> = Vec::new();
        let mut peak = |n_kept: usize, n_passing: usize| {
            let mut detect = || {
                kept.reserve_exact(n_kept.saturating_sub(kept.len()));
                std::hint::black_box(vec![0_u8; n_passing]);
            };
            meter.measure(&mut detect).peak_bytes.unwrap()
        };
        assert_eq!([peak(1000, 500), peak(1000, 0), peak(1000, 70)], [1500, 1000, 1070]);
    }

    #[test]
    fn a_dump_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("dump"), "").unwrap();
        std::fs::write(folder.path().join("dump.3"), "desc: x\nfn=(1) f\n12 34\ntotals: 567\n").unwrap();
        assert_eq!([taken_from_dump(folder.path()), taken_from_dump(folder.path())], [Some(567), None]);
    }

    // Counters of the kernel work where those of the processor are not to be had.
    #[test]
    fn what_a_process_and_its_children_do_is_counted_together() {
        let script = "read go; sh -c 'i=0; while [ $i -lt 20000 ]; do i=$((i+1)); done'; echo; read end";
        let mut child = Command::new("sh")
            .args(["-c", script])
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let pids = [child.id()];
        let mut meter = ProcessMeter::default();
        meter.begin(&Software::TASK_CLOCK, &pids);
        let Some(before) = meter.n_so_far() else {
            // Not even those, as in most containers.
            child.kill().unwrap();
            child.wait().unwrap();
            return;
        };
        let mut stdin = child.stdin.take().unwrap();
        io::Write::write_all(&mut stdin, b"go\n").unwrap();
        io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut [0]).unwrap();
        let after = meter.n_so_far().unwrap();
        assert!(peak_bytes_of(&pids).is_some_and(|it| it > 100_000));
        drop(stdin);
        child.wait().unwrap();
        // The shell itself only waits; the loop of its child takes milliseconds.
        assert!(after - before > 5_000_000, "{before} to {after} ns");
    }
}
