//! `scanbench serve`: our own detectors under the protocol for other people's.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};

use detector::{Detector, DetectorOutput, OrientedBox};
use evaluation::process::message::{
    Answer, AskedScan, Configuration, Introduction, PROTOCOLS, Question, Wishes, line_of, parse_line,
};
use evaluation::process::received_cloud::ReceivedCloud;
use evaluation::process::supervisor::{READ_FD, WRITE_FD};
use evaluation::process::written_answer::{AnswerWriter, Extent};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ListedDetector;
use evaluation::run::process_detector::NOTHING;

use crate::cli::{RESULTS, ServeArgs};
use crate::plumbing::config::{built_in_detectors, warn_of_missing_curve};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::named_box::NamedBox;

pub use evaluation::process::supervisor::supervise;

/// Answers questions until it is asked to end.
pub fn serve(arguments: &ServeArgs) -> Result<(), Failure> {
    let served = match (arguments.detector.as_str(), &arguments.results) {
        (RESULTS, Some(folder)) => Served::Results(folder.clone()),
        (_, Some(_)) => return Err(Usage(format!("--results is for `serve {RESULTS}`")).into()),
        (NOTHING, None) => Served::Nothing,
        _ => {
            let names = std::slice::from_ref(&arguments.detector);
            let (listed, config) = built_in_detectors(&arguments.config, names)?;
            Served::BuiltIn(listed[0], Box::new(config))
        }
    };
    let mut reading = BufReader::new(end_of(READ_FD, OpenOptions::new().read(true))?);
    let writing = end_of(WRITE_FD, OpenOptions::new().write(true))?;
    let mut server = Server {
        served,
        writing,
        extent: Extent::default(),
        cloud: None,
        detector: None,
        output: DetectorOutput::default(),
        answer: AnswerWriter::default(),
    };
    let mut line = Vec::new();
    loop {
        line.clear();
        let n_read = reading.read_until(b'\n', &mut line);
        if n_read.map_err(|error| Failure::internal("cannot read questions", error))? == 0 {
            return Ok(());
        }
        let answered = match parse_line::<Question>(&line) {
            Ok((Question::Quit, _)) => return Ok(()),
            Ok((question, _)) => server.answer(question),
            Err(problem) => server.say(&Answer::Error { text: problem }),
        };
        answered.map_err(|error| Failure::internal("cannot answer", error))?;
    }
}

/// The pipe whose number the variable `name` holds.
fn end_of(name: &str, how: &OpenOptions) -> Result<File, Failure> {
    let number: Option<u32> = std::env::var(name).ok().and_then(|it| it.parse().ok());
    let Some(number) = number else {
        let problem = format!("{name} is not set: serve is started by `scanbench run`, see docs/protocol.md");
        return Err(Usage(problem).into());
    };
    let opened = how.open(format!("/proc/self/fd/{number}"));
    opened.map_err(|error| Failure::usage(format!("{name} = {number} is no pipe"), error))
}

/// What answers.
enum Served {
    /// Nothing is found.
    Nothing,
    /// A detector with its parameters.
    BuiltIn(ListedDetector, Box<RunConfig>),
    /// Files of boxes, by the names of scans.
    Results(PathBuf),
}

struct Server {
    served: Served,
    writing: File,
    extent: Extent,
    cloud: Option<ReceivedCloud>,
    detector: Option<Box<dyn Detector>>,
    output: DetectorOutput,
    answer: AnswerWriter,
}

impl Server {
    fn answer(&mut self, question: Question) -> io::Result<()> {
        match question {
            Question::Hello { protocol, .. } if protocol != PROTOCOLS[0] => self
                .say(&Answer::Error { text: format!("this is protocol {}, not {protocol}", PROTOCOLS[0]) }),
            Question::Hello { extensions, .. } => {
                self.extent = Extent::of(&extensions);
                let name = match &self.served {
                    Served::Nothing => NOTHING,
                    Served::BuiltIn(listed, _) => listed.name,
                    Served::Results(_) => RESULTS,
                };
                let name = name.to_owned();
                let version = Some(env!("CARGO_PKG_VERSION").to_owned());
                self.say(&Answer::Hello(Introduction { protocol: PROTOCOLS[0], name, version }))
            }
            Question::Configure(configuration) => {
                let answer = match self.configure(&configuration) {
                    Ok(()) => Answer::Configured(Wishes::default()),
                    Err(text) => Answer::Error { text },
                };
                self.say(&answer)
            }
            Question::Scan(asked) => match self.detect(&asked) {
                Ok(()) => Ok(()),
                Err(Problem::Broken(error)) => Err(error),
                Err(Problem::Reported(text)) => self.say(&Answer::Error { text }),
            },
            Question::Quit => Ok(()),
        }
    }

    fn say(&mut self, answer: &Answer) -> io::Result<()> {
        self.writing.write_all(&line_of(answer, 0)?)
    }

    fn configure(&mut self, configuration: &Configuration) -> Result<(), String> {
        let memory = ReceivedCloud::open(Path::new(&configuration.shared_memory));
        self.cloud = Some(memory.map_err(|error| format!("{}: {error}", configuration.shared_memory))?);
        let Served::BuiltIn(listed, config) = &self.served else { return Ok(()) };
        if let Some(name) = configuration.parameters.keys().next() {
            return Err(format!(
                "no parameter {name}: parameters of {} are given to serve by -P",
                listed.name
            ));
        }
        let of_sensor = configuration.sensor.as_deref().and_then(|it| {
            let found = config.for_sensor(it);
            if found.is_none() {
                warn_of_missing_curve(it);
            }
            found
        });
        let height_m = configuration.sensor_height_m.ok_or("the height of the sensor is needed")?;
        self.detector = Some(listed.build(of_sensor.as_ref().unwrap_or(config), height_m));
        Ok(())
    }

    /// Reads the points, detects and answers.
    fn detect(&mut self, asked: &AskedScan) -> Result<(), Problem> {
        let early = || Problem::Reported("scan before configure".to_owned());
        let cloud = self.cloud.as_mut().ok_or_else(early)?.read(asked).map_err(Problem::Reported)?;
        let message = match &self.served {
            Served::Nothing => {
                self.answer.write_nothing(asked.number, cloud.len()).map_err(Problem::Broken)?
            }
            Served::Results(folder) => {
                let boxes = named_boxes(&folder.join(format!("{}.csv", asked.name)));
                let boxes = boxes.map_err(Problem::Reported)?;
                self.answer.write_boxes(asked.number, &boxes).map_err(Problem::Broken)?
            }
            Served::BuiltIn(..) => {
                self.detector.as_mut().ok_or_else(early)?.detect(cloud, &mut self.output);
                let answer = self.answer.write(asked.number, &self.output, cloud.len(), self.extent);
                answer.map_err(Problem::Reported)?
            }
        };
        self.writing.write_all(message).map_err(Problem::Broken)
    }
}

/// The boxes of a file with the columns `class`, centre, size and heading, each with the word that it has there.
fn named_boxes(path: &Path) -> Result<Vec<(OrientedBox, String)>, String> {
    let in_file = |error: csv::Error| format!("{}: {error}", path.display());
    let mut reader = csv::Reader::from_path(path).map_err(in_file)?;
    let rows = reader.deserialize::<NamedBox>().map(|row| {
        let it = row.map_err(in_file)?;
        let bounding_box = OrientedBox {
            center_m: [it.center_x_m, it.center_y_m, it.center_z_m],
            length_width_height_m: [it.length_m, it.width_m, it.height_m],
            yaw_rad: it.yaw_rad,
        };
        Ok((bounding_box, it.class))
    });
    rows.collect()
}

/// Why a scan has no result.
enum Problem {
    /// The host is told.
    Reported(String),
    /// The host cannot be told.
    Broken(io::Error),
}
