//! A detector that misbehaves in every way that the protocol names.
//!
//! It is this test program itself: asked for the one test [`as_a_detector`], it behaves as its arguments say.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use evaluation::process::message::{
    Answer, AskedScan, Introduction, Question, ResultLine, Wishes, line_of, parse_line,
};

/// The scan at which it misbehaves, from 1: warmed up on the first before.
const GUILTY: u64 = 5;

/// Behaviours of version 2 of the protocol.
const KNOWS_DRIVES: [&str; 3] = ["remembers", "looks-back", "looks-far-back"];

/// Not a test unless somebody started it as a detector.
#[test]
fn as_a_detector() {
    let Some(behaviour) =
        std::env::args().next_back().filter(|_| std::env::var_os("SCANBENCH_READ_FD").is_some())
    else {
        return;
    };
    let mut odd = Odd::begin(&behaviour);
    while odd.answer() {}
    std::process::exit(0);
}

/// A detector that takes the first points for small objects, and misbehaves.
struct Odd {
    behaviour: String,
    reading: BufReader<File>,
    writing: File,
    most: usize,
    n_asked: u64,
    n_remembered: usize,
}

impl Odd {
    fn begin(behaviour: &str) -> Self {
        let end = |name: &str, how: &OpenOptions| {
            how.open(format!("/proc/self/fd/{}", std::env::var(name).unwrap())).unwrap()
        };
        Self {
            behaviour: behaviour.to_owned(),
            reading: BufReader::new(end("SCANBENCH_READ_FD", OpenOptions::new().read(true))),
            writing: end("SCANBENCH_WRITE_FD", OpenOptions::new().write(true)),
            most: 1,
            n_asked: 0,
            n_remembered: 0,
        }
    }

    fn say(&mut self, bytes: &[u8]) {
        self.writing.write_all(bytes).unwrap();
    }

    /// Answers one question; false at the end.
    fn answer(&mut self) -> bool {
        let mut line = Vec::new();
        if self.reading.read_until(b'\n', &mut line).unwrap() == 0 {
            return self.outlive();
        }
        match parse_line::<Question>(&line).unwrap().0 {
            Question::Hello { .. } => self.hello(),
            Question::Configure(_) if self.behaviour == "error-configure" => {
                let answer = Answer::Error { text: "never heard of it".to_owned() };
                self.say(&line_of(&answer, 0).unwrap());
            }
            Question::Configure(configuration) => {
                let most = configuration.parameters.get("most").and_then(serde_json::Value::as_u64);
                self.most = most.unwrap_or(1) as usize;
                let wishes = match self.behaviour.as_str() {
                    "remembers" => Wishes { earlier_scans: 2, in_order: true },
                    "looks-back" => Wishes { earlier_scans: 2, in_order: false },
                    "looks-far-back" => Wishes { earlier_scans: 101, in_order: false },
                    _ => Wishes::default(),
                };
                self.say(&line_of(&Answer::Configured(wishes), 0).unwrap());
            }
            Question::Scan(scan) if KNOWS_DRIVES.contains(&self.behaviour.as_str()) => self.remember(&scan),
            Question::Scan(scan) => {
                self.n_asked += 1;
                let is_first_life = !Path::new("misbehaved").exists();
                let guilty = if self.behaviour == "exit-at-first" { 1 } else { GUILTY };
                let is_guilty = self.behaviour == "always" || (self.n_asked == guilty && is_first_life);
                let line = ResultLine { number: scan.number, clusters: true, ..ResultLine::default() };
                let ids: Vec<u8> = (1..=scan.n_points)
                    .flat_map(|it| if it <= self.most { it as u32 } else { 0 }.to_le_bytes())
                    .collect();
                let has =
                    |name: &str, kind: &str| scan.columns.iter().any(|it| it.name == name && it.kind == kind);
                if self.behaviour == "by-ring-and-time"
                    && !(has("ring", "u16") && has("time_offset_s", "f32"))
                {
                    self.say(&line_of(&Answer::Error { text: format!("{:?}", scan.columns) }, 0).unwrap());
                    return true;
                }
                let behaviour = self.behaviour.clone();
                if is_guilty
                    && !["fine", "peek", "child", "deaf-to-quit", "by-ring-and-time"]
                        .contains(&behaviour.as_str())
                {
                    let _ = File::create("misbehaved");
                    self.misbehave(&behaviour, line, &ids);
                    // A run that stops leaves the next one as guilty as it was.
                    return true;
                }
                self.say(&message(line, &ids));
            }
            Question::Quit => return self.outlive(),
        }
        true
    }

    #[expect(clippy::zombie_processes, reason = "a child is left behind on purpose")]
    fn hello(&mut self) {
        if self.behaviour == "silent-start" {
            std::thread::sleep(Duration::from_secs(100));
        }
        if self.behaviour == "peek" {
            peek();
        }
        if self.behaviour == "child" {
            let mut child = Command::new("sleep");
            child.args(["100"]).env("LC_ALL", "C").stdin(Stdio::null());
            child.spawn().unwrap();
        }
        let protocol = match self.behaviour.as_str() {
            "another-protocol" => 99,
            it if KNOWS_DRIVES.contains(&it) => 2,
            _ => 1,
        };
        let answer = Answer::Hello(Introduction { protocol, name: "odd".to_owned(), version: None });
        self.say(&line_of(&answer, 0).unwrap());
    }

    /// As many clusters as scans of the drive are remembered, each a point. The velocity says how many scans came along, and
    /// how many seconds ago the latest of them was; the track how many scans are remembered.
    fn remember(&mut self, scan: &AskedScan) {
        self.n_remembered = if scan.begins_drive { 1 } else { self.n_remembered + 1 };
        let n = if self.behaviour == "remembers" { self.n_remembered } else { 1 };
        let ids = (1..=scan.n_points as u32).map(|it| if it as usize <= n { it } else { 0 });
        assert!(scan.world_from_sensor.is_some() && scan.earlier.iter().all(|it| it.time_s < scan.time_s));
        let before_s = scan.earlier.first().map_or(0.0, |it| scan.time_s - it.time_s) as f32;
        let velocity = [scan.earlier.len() as f32, before_s];
        let payload: Vec<u8> = ids
            .flat_map(u32::to_le_bytes)
            .chain((0..n).flat_map(|_| velocity).flat_map(f32::to_le_bytes))
            .chain((0..n).flat_map(|_| (self.n_remembered as u32).to_le_bytes()))
            .collect();
        let line = ResultLine { number: scan.number, clusters: true, ..ResultLine::default() };
        self.say(&message(ResultLine { velocities: true, tracks: true, ..line }, &payload));
    }

    fn misbehave(&mut self, behaviour: &str, line: ResultLine, ids: &[u8]) {
        let boxed = |numbers: [f32; 7]| {
            let payload: Vec<u8> = numbers.iter().flat_map(|it| it.to_le_bytes()).collect();
            message(ResultLine { clusters: false, n_boxes: 1, ..line.clone() }, &payload)
        };
        match behaviour {
            "exit-255" => std::process::exit(255),
            "exit-126" => std::process::exit(126),
            "kill-supervisor" => {
                let parent = std::os::unix::process::parent_id().to_string();
                Command::new("kill").args(["-s", "KILL", &parent]).status().unwrap();
                std::thread::sleep(Duration::from_secs(100));
            }
            "exit" | "exit-at-first" | "always" => {
                say_aloud("my last words\n");
                std::process::exit(3);
            }
            "abort" => std::process::abort(),
            "error" => self.say(&line_of(&Answer::Error { text: "out of ideas".to_owned() }, 0).unwrap()),
            "end" => std::process::exit(0),
            "silent" => std::thread::sleep(Duration::from_secs(100)),
            "half" => {
                let whole = message(line, ids);
                self.say(&whole[..whole.len() / 2]);
                std::thread::sleep(Duration::from_secs(100));
            }
            "half-and-end" => {
                let whole = message(line, ids);
                self.say(&whole[..whole.len() / 2]);
                std::process::exit(4);
            }
            "stdout" => {
                say_aloud("result to the wrong place\n");
                std::thread::sleep(Duration::from_secs(100));
            }
            "too-few-ids" => self.say(&message(line, &ids[4..])),
            "nan" => self.say(&boxed([8.0, f32::NAN, 0.0, 4.0, 2.0, 1.5, 0.0])),
            "huge" => self.say(&boxed([8.0, 0.0, 0.0, 1e5, 2.0, 1.5, 0.0])),
            "another-number" => self.say(&message(ResultLine { number: 4711, ..line }, ids)),
            "no-json" => self.say(b"here you are\n"),
            "endless-line" => {
                let _ = self.writing.write_all(&vec![b'x'; 3 << 20]);
            }
            "too-much" => self.say(&[message(line, ids), b"more".to_vec()].concat()),
            _ => {
                // Immortal: deaf to the end of its pipe.
                File::create("asked").unwrap();
                loop {
                    std::thread::sleep(Duration::from_secs(100));
                }
            }
        }
    }

    /// What comes after the last question.
    fn outlive(&self) -> bool {
        if self.behaviour == "deaf-to-quit" {
            std::thread::sleep(Duration::from_secs(100));
        }
        false
    }
}

/// Looks for what it must not see, tries to get it back, and writes down what it has found: what is in the data set, where the
/// labels really lie, in an earlier run and in the one that is made, and whether the port that it knows of answers.
fn peek() {
    let port = std::fs::read_to_string("port").unwrap();
    let answers = std::net::TcpStream::connect(format!("127.0.0.1:{port}")).is_ok();
    let mut found = vec![format!("network {answers}\n")];
    for path in ["street/training/label_02/0000.txt", "elsewhere/0000.txt", "runs/earlier/matches.csv"] {
        for folder in Path::new(path).ancestors().filter(|it| it.components().next().is_some()) {
            let _ = Command::new("umount").arg(folder).stderr(Stdio::null()).status();
        }
        found.push(format!("{path} {}\n", std::fs::read(path).is_ok()));
    }
    let names = std::fs::read_dir(".").unwrap().map(|it| it.unwrap().file_name().into_string().unwrap());
    let mut outputs = names.filter(|it| it.starts_with("out") || it.starts_with('.'));
    found.push(format!("out {}\n", outputs.any(|it| has_content(Path::new(&it)))));
    std::fs::write("found", found.concat()).unwrap();
}

/// Whether a byte can be read at `path` or below.
fn has_content(path: &Path) -> bool {
    match path.read_dir() {
        Ok(mut entries) => entries.any(|it| has_content(&it.unwrap().path())),
        Err(_) => std::fs::read(path).is_ok_and(|it| !it.is_empty()),
    }
}

fn say_aloud(words: &str) {
    std::io::stdout().write_all(words.as_bytes()).unwrap();
}

fn message(line: ResultLine, payload: &[u8]) -> Vec<u8> {
    let mut message = line_of(&Answer::Result(line), payload.len()).unwrap();
    message.extend_from_slice(payload);
    message
}
