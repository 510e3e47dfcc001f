//! Messages to a detector and its answers.

use std::time::{Duration, Instant};

use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::class_table::ClassTable;
use serde::Serialize;

use super::answer::Found;
use super::message::{
    Answer, AskedScan, Configuration, Introduction, PROTOCOL, Question, RANKED, line_of, parse_line,
};
use super::pipe::PipeError;
use super::problem::{DetectorProblem, Ending};
use super::program::{Program, StartedProgram};
use super::shared_cloud::SharedCloud;

/// Time limit for the first scan, unless the limit for each scan is longer.
pub const FIRST_SCAN_LIMIT: Duration = Duration::from_mins(1);
/// Least number of points to have room for, so that few scans need more.
const LEAST_ROOM: usize = 1 << 17;

/// A running detector with its configuration.
pub struct Conversation {
    program: Program,
    shared: SharedCloud,
    configuration: Configuration,
    start_limit: Duration,
    classes: ClassTable,
    introduction: Introduction,
    number: u64,
    is_configured: bool,
    // The scan in the shared memory, with the positions of its columns.
    written: Option<(ScanId, AskedScan)>,
    payload: Vec<u8>,
}

/// Answer of a detector, and the time it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Answered {
    /// Its detections.
    pub found: Found,
    /// Time from before `scan` was sent until the last byte of the answer was read.
    pub wall: Duration,
    /// Time on processors meanwhile, if the system reports it.
    pub cpu: Option<Duration>,
}

/// A problem, and the last words of the detector, which has ended.
pub type Goodbye = (DetectorProblem, Vec<String>);

impl Conversation {
    /// Starts a detector and sends it `configuration`, with room for a scan of `n_points`.
    ///
    /// # Errors
    ///
    /// Why it cannot work; the detector has ended then.
    pub fn begin(
        start: &StartedProgram,
        configuration: &Configuration,
        n_points: usize,
    ) -> Result<Self, Goodbye> {
        let deadline = Instant::now() + start.start_limit;
        let machine = |error: std::io::Error| (DetectorProblem::Machine(error.to_string()), Vec::new());
        let shared = SharedCloud::with_room(n_points.max(LEAST_ROOM)).map_err(machine)?;
        let mut program = start.start().map_err(machine)?;
        match hello(&mut program, start.start_limit, deadline) {
            Ok(introduction) => {
                let mut begun = Self {
                    program,
                    shared,
                    configuration: configuration.clone(),
                    start_limit: start.start_limit,
                    classes: start.classes.clone(),
                    introduction,
                    number: 0,
                    is_configured: false,
                    written: None,
                    payload: Vec::new(),
                };
                match begun.configure(deadline) {
                    Ok(()) => Ok(begun),
                    Err(problem) => Err(begun.end(problem)),
                }
            }
            Err(problem) => Err(goodbye(program, problem)),
        }
    }

    /// How the detector introduces itself.
    pub fn introduction(&self) -> &Introduction {
        &self.introduction
    }

    /// Whether it has `configuration`, apart from the shared memory.
    pub fn has(&self, configuration: &Configuration) -> bool {
        let Configuration { max_points, shared_memory, .. } = self.configuration.clone();
        self.configuration == Configuration { max_points, shared_memory, ..configuration.clone() }
    }

    /// Sends it `configuration`, which replaces the one before.
    ///
    /// # Errors
    ///
    /// If the detector does not accept it.
    pub fn configure_anew(&mut self, configuration: &Configuration) -> Result<(), DetectorProblem> {
        let room = self.shared.max_points();
        self.shared = SharedCloud::with_room(room).map_err(|it| DetectorProblem::Machine(it.to_string()))?;
        self.configuration = configuration.clone();
        self.configure(Instant::now() + self.start_limit)
    }

    /// Asks for the objects in `scan`, taken `time_s` seconds after the first of its drive.
    ///
    /// # Errors
    ///
    /// The problem. The detector can be asked again only after [`DetectorProblem::Reported`].
    pub fn ask(
        &mut self,
        scan: &LabeledScan,
        time_s: f64,
        limit: Duration,
    ) -> Result<Answered, DetectorProblem> {
        let n_points = scan.cloud.len();
        if !self.is_configured && n_points <= self.shared.max_points() {
            self.configure_anew(&self.configuration.clone())?;
        }
        if n_points > self.shared.max_points() {
            let room = SharedCloud::with_room(n_points + n_points / 2);
            self.shared = room.map_err(|it| DetectorProblem::Machine(it.to_string()))?;
            self.configure(Instant::now() + self.start_limit)?;
        }
        self.check_silence()?;
        let line = self.question(scan, time_s)?;
        let cpu_before = self.program.cpu_time();
        let started = Instant::now();
        let deadline = started + limit;
        self.say(&line, deadline)?;
        let answer = read_answer(&mut self.program, "scan", limit, deadline)?;
        let (Answer::Result(result), n_payload_bytes) = answer else { return Err(unasked(&answer.0)) };
        if result.number != self.number {
            let problem = format!("it is to scan number {}, not {}", result.number, self.number);
            return Err(DetectorProblem::WrongAnswer(problem));
        }
        Found::check_line(&result, n_payload_bytes, n_points).map_err(DetectorProblem::WrongAnswer)?;
        self.payload.clear();
        let read = self.program.pipe.read_payload(n_payload_bytes, &mut self.payload, deadline);
        let wall = started.elapsed();
        read.map_err(|error| problem_of(error, "scan", limit))?;
        let cpu = self.program.cpu_time().zip(cpu_before).map(|(after, before)| after.saturating_sub(before));
        let found = Found::read(&result, &self.payload, n_points, &self.classes);
        let found = found.map_err(DetectorProblem::WrongAnswer)?;
        Ok(Answered { found, wall, cpu })
    }

    /// All processes of the detector.
    pub fn processes(&self) -> Vec<u32> {
        self.program.processes()
    }

    /// Asks it to end. Returns warnings.
    pub fn quit(self) -> Vec<String> {
        self.program.quit()
    }

    /// The last lines that it printed.
    pub fn last_words(&self) -> Vec<String> {
        self.program.last_words()
    }

    /// Ends it because of `problem`.
    pub fn end(self, problem: DetectorProblem) -> Goodbye {
        goodbye(self.program, problem)
    }

    /// The line that asks for a scan. Writes its points to the shared memory, unless they are there already.
    fn question(&mut self, scan: &LabeledScan, time_s: f64) -> Result<Vec<u8>, DetectorProblem> {
        self.number += 1;
        let asked = match self.written.take() {
            Some((id, asked)) if id == scan.id && asked.n_points == scan.cloud.len() => {
                AskedScan { number: self.number, ..asked }
            }
            _ => AskedScan {
                number: self.number,
                name: scan.id.to_string(),
                time_s,
                n_points: scan.cloud.len(),
                columns: self
                    .shared
                    .write(&scan.cloud)
                    .map_err(|it| DetectorProblem::Machine(it.to_string()))?,
            },
        };
        self.written = Some((scan.id.clone(), asked.clone()));
        json(&Question::Scan(asked))
    }

    fn configure(&mut self, deadline: Instant) -> Result<(), DetectorProblem> {
        self.check_silence()?;
        (self.written, self.is_configured) = (None, false);
        self.configuration.max_points = self.shared.max_points();
        let path = self.shared.path().map(|it| it.display().to_string());
        self.configuration.shared_memory = path.unwrap_or_default();
        let line = json(&Question::Configure(self.configuration.clone()))?;
        self.say(&line, deadline)?;
        let answer = read_answer(&mut self.program, "configure", self.start_limit, deadline);
        self.shared.hide();
        match answer? {
            (Answer::Configured, 0) => {
                self.is_configured = true;
                Ok(())
            }
            (Answer::Configured, _) => {
                Err(DetectorProblem::WrongAnswer("configured has a payload".to_owned()))
            }
            (other, _) => Err(unasked(&other)),
        }
    }

    fn check_silence(&mut self) -> Result<(), DetectorProblem> {
        if !self.program.pipe.has_more() {
            return Ok(());
        }
        if self.program.pipe.is_closed() {
            return Err(DetectorProblem::Ended(Ending::ClosedPipe));
        }
        Err(DetectorProblem::WrongAnswer("it says more than it was asked".to_owned()))
    }

    fn say(&mut self, line: &[u8], deadline: Instant) -> Result<(), DetectorProblem> {
        say(&mut self.program, line, deadline)
    }
}

fn hello(program: &mut Program, limit: Duration, deadline: Instant) -> Result<Introduction, DetectorProblem> {
    let question = Question::Hello {
        protocol: PROTOCOL,
        program: concat!("scanbench ", env!("CARGO_PKG_VERSION")).to_owned(),
        extensions: vec![RANKED.to_owned()],
    };
    say(program, &json(&question)?, deadline)?;
    match read_answer(program, "hello", limit, deadline)? {
        (Answer::Hello(introduction), 0) if introduction.protocol == PROTOCOL => Ok(introduction),
        (Answer::Hello(introduction), 0) => {
            let problem = format!("it speaks protocol {}, not {PROTOCOL}", introduction.protocol);
            Err(DetectorProblem::WrongAnswer(problem))
        }
        (Answer::Hello(_), _) => Err(DetectorProblem::WrongAnswer("hello has a payload".to_owned())),
        (other, _) => Err(unasked(&other)),
    }
}

fn json(message: &impl Serialize) -> Result<Vec<u8>, DetectorProblem> {
    line_of(message, 0).map_err(|error| DetectorProblem::Machine(error.to_string()))
}

fn say(program: &mut Program, line: &[u8], deadline: Instant) -> Result<(), DetectorProblem> {
    program.pipe.write(line, deadline).map_err(|error| match error {
        PipeError::TimedOut => DetectorProblem::Deaf,
        other => problem_of(other, "", Duration::ZERO),
    })
}

/// The answer to the message `to`, and how many bytes follow. An answer that is an error is returned as an error.
fn read_answer(
    program: &mut Program,
    to: &'static str,
    limit: Duration,
    deadline: Instant,
) -> Result<(Answer, usize), DetectorProblem> {
    let line = program.pipe.read_line(deadline).map_err(|error| problem_of(error, to, limit))?;
    match parse_line(&line).map_err(DetectorProblem::WrongAnswer)? {
        (Answer::Error { text }, 0) => Err(DetectorProblem::Reported(printable(&text))),
        answer => Ok(answer),
    }
}

fn printable(text: &str) -> String {
    text.chars().take(2000).map(|it| if it.is_control() { ' ' } else { it }).collect()
}

fn problem_of(error: PipeError, to: &'static str, limit: Duration) -> DetectorProblem {
    match error {
        PipeError::Closed => DetectorProblem::Ended(Ending::ClosedPipe),
        PipeError::TimedOut => DetectorProblem::Silent { to, limit },
        PipeError::EndlessLine => DetectorProblem::WrongAnswer("a line is longer than 1 MiB".to_owned()),
        PipeError::Io(error) => DetectorProblem::Machine(error.to_string()),
    }
}

fn unasked(answer: &Answer) -> DetectorProblem {
    let name = match answer {
        Answer::Hello(_) => "hello",
        Answer::Configured => "configured",
        Answer::Result(_) => "result",
        Answer::Error { .. } => "an error with a payload",
    };
    DetectorProblem::WrongAnswer(format!("{name} was not asked for"))
}

fn goodbye(program: Program, problem: DetectorProblem) -> Goodbye {
    match problem {
        DetectorProblem::Ended(_) => {
            let (ending, words) = program.end();
            (DetectorProblem::Ended(ending), words)
        }
        problem => (problem, program.kill_with_last_words()),
    }
}
