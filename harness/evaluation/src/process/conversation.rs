//! Messages to a detector and its answers.

use std::time::{Duration, Instant};

use detector::PointCloud;
use nalgebra::Isometry3;
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::class_table::ClassTable;
use scans::dataset::earlier_scans::EarlierScan;
use serde::Serialize;

use super::answer::Found;
use super::message::{
    Answer, AskedEarlierScan, AskedScan, Column, Configuration, Introduction, MOST_EARLIER_SCANS, PROTOCOLS,
    Question, RANKED, Wishes, line_of, parse_line,
};
use super::pipe::PipeError;
use super::problem::{DetectorProblem, Ending};
use super::program::{Program, StartedProgram};
use super::shared_cloud::{SharedCloud, room_for};

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
    wishes: Wishes,
    number: u64,
    is_configured: bool,
    // The scan in the shared memory, with the positions of its columns.
    written: Option<(ScanId, AskedScan)>,
    payload: Vec<u8>,
}

/// What a detector is asked.
pub struct Asked<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    /// Seconds from the first scan of its drive.
    pub time_s: f64,
    /// Where it stands in its drive; only for detectors that speak version 2 of the protocol.
    pub in_drive: Option<InDrive>,
}

/// Where a scan stands in its drive.
#[derive(Debug, Default)]
pub struct InDrive {
    /// Whether what the detector knows is of no use for it.
    pub begins_drive: bool,
    /// Pose of the sensor in a frame that rests, if known.
    pub world_from_sensor: Option<Isometry3<f64>>,
    /// The scans before it, the latest first.
    pub earlier: Vec<EarlierScan>,
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
                    wishes: Wishes::default(),
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

    /// Whether it takes what stands in [`Asked::in_drive`].
    pub fn knows_drives(&self) -> bool {
        self.introduction.protocol > 1
    }

    /// What it asks for with every scan.
    pub fn wishes(&self) -> Wishes {
        self.wishes
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

    /// Asks for the objects in a scan.
    ///
    /// # Errors
    ///
    /// The problem. The detector can be asked again only after [`DetectorProblem::Reported`].
    pub fn ask(&mut self, asked: &Asked<'_>, limit: Duration) -> Result<Answered, DetectorProblem> {
        let n_points = asked.scan.cloud.len();
        let room = room_for(asked.clouds());
        if !self.is_configured && room <= self.shared.max_points() {
            self.configure_anew(&self.configuration.clone())?;
        }
        if room > self.shared.max_points() {
            // At the beginning of a drive there are fewer earlier scans than later on.
            let of_all = n_points * (1 + self.wishes.earlier_scans);
            let room = SharedCloud::with_room(room.max(of_all) + n_points / 2);
            self.shared = room.map_err(|it| DetectorProblem::Machine(it.to_string()))?;
            self.configure(Instant::now() + self.start_limit)?;
        }
        self.check_silence()?;
        let line = self.question(asked)?;
        let cpu_before = self.program.cpu_time();
        let started = Instant::now();
        let deadline = started + limit;
        self.say(&line, deadline)?;
        let answer = read_answer(&mut self.program, "scan", limit, deadline)?;
        let (Answer::Result(mut result), n_payload_bytes) = answer else { return Err(unasked(&answer.0)) };
        // In version 1 these are unknown fields.
        (result.velocities, result.tracks) =
            (result.velocities && self.knows_drives(), result.tracks && self.knows_drives());
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
    fn question(&mut self, asked: &Asked<'_>) -> Result<Vec<u8>, DetectorProblem> {
        self.number += 1;
        let Asked { scan, time_s, in_drive } = asked;
        let begins_drive = in_drive.as_ref().is_some_and(|it| it.begins_drive);
        let question = match self.written.take() {
            Some((id, before)) if id == scan.id && before.n_points == scan.cloud.len() => {
                AskedScan { number: self.number, begins_drive, ..before }
            }
            _ => {
                let written = self.shared.write(asked.clouds());
                let written = written.map_err(|it| DetectorProblem::Machine(it.to_string()))?;
                let mut columns = written.into_iter();
                AskedScan {
                    number: self.number,
                    name: scan.id.to_string(),
                    time_s: *time_s,
                    n_points: scan.cloud.len(),
                    columns: columns.next().unwrap_or_default(),
                    begins_drive,
                    world_from_sensor: in_drive.as_ref().and_then(|it| it.world_from_sensor).map(rows_of),
                    earlier: asked
                        .earlier()
                        .iter()
                        .zip(columns)
                        .map(|it| asked_earlier(it, *time_s))
                        .collect(),
                }
            }
        };
        self.written = Some((scan.id.clone(), question.clone()));
        json(&Question::Scan(question))
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
            (Answer::Configured(wishes), 0) => {
                // In version 1 these are unknown fields.
                self.wishes = if self.knows_drives() { wishes } else { Wishes::default() };
                if self.wishes.earlier_scans > MOST_EARLIER_SCANS {
                    let n = self.wishes.earlier_scans;
                    let problem = format!("it asks for {n} earlier scans, more than {MOST_EARLIER_SCANS}");
                    return Err(DetectorProblem::WrongAnswer(problem));
                }
                self.is_configured = true;
                Ok(())
            }
            (Answer::Configured(_), _) => {
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

impl Asked<'_> {
    fn earlier(&self) -> &[EarlierScan] {
        self.in_drive.as_ref().map_or(&[], |it| &it.earlier)
    }

    /// The points of the scan, then those of the scans before it.
    fn clouds(&self) -> impl Iterator<Item = &PointCloud> {
        std::iter::once(&self.scan.cloud).chain(self.earlier().iter().map(|it| &it.cloud))
    }
}

/// The turn and the position in three rows.
fn rows_of(pose: Isometry3<f64>) -> [f64; 12] {
    let matrix = pose.to_homogeneous();
    std::array::from_fn(|it| matrix[(it / 4, it % 4)])
}

fn asked_earlier((earlier, columns): (&EarlierScan, Vec<Column>), time_s: f64) -> AskedEarlierScan {
    // In whole microseconds, which no clock of a sensor is better than.
    let time_s = ((time_s - earlier.before_s) * 1e6).round() / 1e6;
    AskedEarlierScan { name: earlier.name.clone(), time_s, n_points: earlier.cloud.len(), columns }
}

fn hello(program: &mut Program, limit: Duration, deadline: Instant) -> Result<Introduction, DetectorProblem> {
    let question = Question::Hello {
        protocol: PROTOCOLS[0],
        protocols: PROTOCOLS.to_vec(),
        program: concat!("scanbench ", env!("CARGO_PKG_VERSION")).to_owned(),
        extensions: vec![RANKED.to_owned()],
    };
    say(program, &json(&question)?, deadline)?;
    match read_answer(program, "hello", limit, deadline)? {
        (Answer::Hello(introduction), 0) if PROTOCOLS.contains(&introduction.protocol) => Ok(introduction),
        (Answer::Hello(introduction), 0) => {
            let [oldest, newest] = PROTOCOLS;
            let problem = format!("it speaks protocol {}, not {oldest} or {newest}", introduction.protocol);
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
        Answer::Configured(_) => "configured",
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
