//! `scanbench serve`: our own detectors under the protocol for other people's.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::os::unix::fs::FileExt as _;

use detector::{DetectedClass, Detector, DetectorOutput, PointCloud};
use evaluation::process::message::{
    Answer, AskedScan, Configuration, Introduction, PROTOCOL, Question, ReportedStage, ResultLine, line_of,
    parse_line,
};
use evaluation::process::supervisor::{READ_FD, WRITE_FD};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ListedDetector;
use evaluation::run::process_detector::NOTHING;
use reports::vocabulary::class::AnnotationClass;

use crate::cli::ServeArgs;
use crate::commands::config::{built_in_detectors, warn_of_missing_curve};
use crate::commands::failure::{Failure, Usage};

pub use evaluation::process::supervisor::supervise;

/// Answers until it is asked to end.
pub fn serve(arguments: &ServeArgs) -> Result<(), Failure> {
    let served = if arguments.detector == NOTHING {
        None
    } else {
        let names = std::slice::from_ref(&arguments.detector);
        let (listed, config) = built_in_detectors(&arguments.config, names)?;
        Some((listed[0], config))
    };
    let mut reading = BufReader::new(end_of(READ_FD, OpenOptions::new().read(true))?);
    let writing = end_of(WRITE_FD, OpenOptions::new().write(true))?;
    let mut server = Server { served, writing, memory: None, detector: None, cloud: PointCloud::default() };
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
            Err(problem) => server.say(&Answer::Error { text: problem }, &[]),
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

struct Server {
    /// `None` answers nothing.
    served: Option<(ListedDetector, RunConfig)>,
    writing: File,
    memory: Option<File>,
    detector: Option<Box<dyn Detector>>,
    cloud: PointCloud,
}

impl Server {
    fn answer(&mut self, question: Question) -> io::Result<()> {
        match question {
            Question::Hello { protocol, .. } if protocol != PROTOCOL => {
                self.say(&Answer::Error { text: format!("this is protocol {PROTOCOL}, not {protocol}") }, &[])
            }
            Question::Hello { .. } => {
                let name = self.served.as_ref().map_or(NOTHING, |(listed, _)| listed.name).to_owned();
                let version = Some(env!("CARGO_PKG_VERSION").to_owned());
                self.say(&Answer::Hello(Introduction { protocol: PROTOCOL, name, version }), &[])
            }
            Question::Configure(configuration) => {
                let answer = match self.configure(&configuration) {
                    Ok(()) => Answer::Configured,
                    Err(text) => Answer::Error { text },
                };
                self.say(&answer, &[])
            }
            Question::Scan(asked) => match self.detect(&asked) {
                Ok((line, payload)) => self.say(&Answer::Result(line), &payload),
                Err(text) => self.say(&Answer::Error { text }, &[]),
            },
            Question::Quit => Ok(()),
        }
    }

    fn say(&mut self, answer: &Answer, payload: &[u8]) -> io::Result<()> {
        let mut message = line_of(answer, payload.len())?;
        message.extend_from_slice(payload);
        self.writing.write_all(&message)
    }

    fn configure(&mut self, configuration: &Configuration) -> Result<(), String> {
        let memory = File::open(&configuration.shared_memory);
        self.memory = Some(memory.map_err(|error| format!("{}: {error}", configuration.shared_memory))?);
        let Some((listed, config)) = &self.served else { return Ok(()) };
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

    fn detect(&mut self, asked: &AskedScan) -> Result<(ResultLine, Vec<u8>), String> {
        let nothing = ResultLine { number: asked.number, ..ResultLine::default() };
        if self.served.is_none() {
            return Ok((nothing, Vec::new()));
        }
        self.read_cloud(asked)?;
        let detector = self.detector.as_mut().ok_or("scan before configure")?;
        let mut output = DetectorOutput::default();
        detector.detect(&self.cloud, &mut output);
        let (line, payload) = result_of(&output, self.cloud.len())?;
        Ok((ResultLine { number: asked.number, ..line }, payload))
    }

    fn read_cloud(&mut self, asked: &AskedScan) -> Result<(), String> {
        let memory = self.memory.as_ref().ok_or("scan before configure")?;
        let mut columns = Vec::new();
        for name in ["x_m", "y_m", "z_m", "intensity"] {
            let column = asked.columns.iter().find(|it| it.name == name);
            let mut bytes = vec![0; 4 * asked.n_points];
            match column {
                Some(column) => memory
                    .read_exact_at(&mut bytes, column.offset as u64)
                    .map_err(|error| format!("{name} cannot be read: {error}"))?,
                None if name == "intensity" => {}
                None => return Err(format!("there is no column {name}")),
            }
            columns.push(bytes);
        }
        self.cloud.clear();
        let number = |column: &Vec<u8>, idx: usize| {
            let bytes = &column[4 * idx..4 * idx + 4];
            f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        };
        for idx in 0..asked.n_points {
            let [x_m, y_m, z_m, intensity] = [0, 1, 2, 3].map(|column| number(&columns[column], idx));
            self.cloud.push([x_m, y_m, z_m], intensity);
        }
        Ok(())
    }
}

/// What was found, as an answer has it. It is an error if detections share points or have none: an answer with clusters
/// cannot express that.
fn result_of(output: &DetectorOutput, n_points: usize) -> Result<(ResultLine, Vec<u8>), String> {
    let detections = &output.detections;
    let mut ids = vec![0_u32; n_points];
    let mut boxes = Vec::new();
    let mut scores = Vec::new();
    let mut classes = Vec::new();
    for (detection, id) in detections.iter().zip(1..) {
        if detection.point_indices.is_empty() {
            return Err("a detection has no point, which an answer with clusters cannot express".to_owned());
        }
        for &point_idx in detection.point_indices {
            if std::mem::replace(&mut ids[point_idx as usize], id) != 0 {
                return Err(
                    "detections share a point, which an answer with clusters cannot express".to_owned()
                );
            }
        }
        let [x_m, y_m, z_m] = detection.bounding_box.center_m;
        let [length_m, width_m, height_m] = detection.bounding_box.length_width_height_m;
        boxes.extend([x_m, y_m, z_m, length_m, width_m, height_m, detection.bounding_box.yaw_rad]);
        scores.extend(detection.score);
        // Any class that is no vehicle's.
        let class = match detection.class {
            DetectedClass::Vehicle => AnnotationClass::Car,
            DetectedClass::Object => AnnotationClass::Misc,
        };
        classes.push(Some(class.name().to_owned()));
    }
    let has_scores = !detections.is_empty() && scores.len() == detections.len();
    let numbers = boxes.iter().chain(scores.iter().filter(|_| has_scores));
    let payload = ids.iter().flat_map(|it| it.to_le_bytes()).chain(numbers.flat_map(|it| it.to_le_bytes()));
    let stages = output
        .stage_times
        .iter()
        .map(|it| ReportedStage { name: it.stage.to_owned(), ms: 1e3 * it.duration.as_secs_f64() });
    let line = ResultLine {
        number: 0,
        clusters: true,
        n_boxes: detections.len(),
        scores: has_scores,
        classes: Some(classes),
        stages: stages.collect(),
        products: Vec::new(),
    };
    Ok((line, payload.collect()))
}
