//! A detector of one's own in Rust: the trait [`Detector`], and around it a process that scanbench can start.
//!
//! ```text
//! cargo build --release -p detector --example own_detector
//! ```
//!
//! ```toml
//! # scanbench.toml
//! [detector.squares]
//! command = ["target/release/examples/own_detector"]
//! parameters = { side_m = 1.0 }
//! ```
//!
//! A copy of this file in a crate of its own needs the crates `detector` and `serde_json`. docs/protocol.md describes the
//! messages.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Read as _, Seek as _, SeekFrom, Write as _};

use detector::detector::StageClock;
use detector::stage_product::Shape;
use detector::{DetectedClass, Detection, Detector, DetectorOutput, OrientedBox, PointCloud, StageProduct};
use serde_json::{Value, json};

/// Takes what stands in a square of the ground plan for an object.
struct Squares {
    side_m: f32,
    clusters: BTreeMap<(i32, i32), Vec<u32>>,
}

impl Detector for Squares {
    fn name(&self) -> &'static str {
        "squares"
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.clusters.clear();
        for (point_idx, [x_m, y_m, z_m]) in (0..).zip(cloud.positions_m()) {
            if z_m > -1.4 {
                let square = ((x_m / self.side_m).floor() as i32, (y_m / self.side_m).floor() as i32);
                self.clusters.entry(square).or_default().push(point_idx);
            }
        }
        clock.lap("squares", &mut output.stage_times);
        for (square, point_indices) in &self.clusters {
            let middle_m = |index: i32| (index as f32 + 0.5) * self.side_m;
            output.detections.push(Detection::new(
                point_indices,
                OrientedBox {
                    center_m: [middle_m(square.0), middle_m(square.1), 0.0],
                    length_width_height_m: [self.side_m, self.side_m, 2.8],
                    yaw_rad: 0.0,
                },
                DetectedClass::Object,
                None,
            ));
        }
        clock.lap("boxes", &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let mut cluster_of_point = vec![None; cloud.len()];
        for (cluster, point_indices) in (0..).zip(self.clusters.values()) {
            for &point_idx in point_indices {
                cluster_of_point[point_idx as usize] = Some(cluster);
            }
        }
        vec![StageProduct { stage: "squares", name: "clusters", shape: Shape::Clusters(cluster_of_point) }]
    }
}

/// The detector with the user's `parameters`; fails where one is unknown or of another type.
fn configured(parameters: &Value) -> Result<Squares, String> {
    let mut squares = Squares { side_m: 1.0, clusters: BTreeMap::new() };
    for (name, value) in parameters.as_object().ok_or("`parameters` is no object")? {
        match (name.as_str(), value.as_f64()) {
            ("side_m", Some(side_m)) if side_m > 0.0 => squares.side_m = side_m as f32,
            ("side_m", _) => return Err(format!("side_m = {value} is no length above 0")),
            _ => return Err(format!("unknown parameter `{name}`; there is side_m")),
        }
    }
    Ok(squares)
}

/// What outlives a message.
#[derive(Default)]
struct Session {
    configured: Option<(Squares, File)>,
    cloud: PointCloud,
    output: DetectorOutput,
}

impl Session {
    /// The line and the payload that answer `message`.
    fn answer(&mut self, message: &Value) -> Result<(Value, Vec<u8>), String> {
        match message["message"].as_str() {
            Some("hello") if message["protocol"] == 1 => {
                Ok((json!({"message": "hello", "protocol": 1, "name": "squares"}), Vec::new()))
            }
            Some("hello") => Err(format!("protocol {} is not known, only 1", message["protocol"])),
            Some("configure") => {
                // It may come again: nothing that was configured before counts then.
                self.configured = None;
                let path = message["shared_memory"].as_str().ok_or("`shared_memory` is no text")?;
                let memory = File::open(path).map_err(|error| format!("cannot open {path}: {error}"))?;
                self.configured = Some((configured(&message["parameters"])?, memory));
                Ok((json!({"message": "configured"}), Vec::new()))
            }
            Some("scan") => self.scan(message),
            _ => Err(format!("unknown message {}", message["message"])),
        }
    }

    fn scan(&mut self, message: &Value) -> Result<(Value, Vec<u8>), String> {
        let (squares, memory) = self.configured.as_mut().ok_or("a scan before `configure`")?;
        let n_points = message["n_points"].as_u64().ok_or("`n_points` is no count")? as usize;
        let column = |name| column(memory, &message["columns"], name, n_points);
        let [x_m, y_m, z_m] = [column("x_m")?, column("y_m")?, column("z_m")?];
        self.cloud.clear();
        for point_idx in 0..n_points {
            self.cloud.push([x_m[point_idx], y_m[point_idx], z_m[point_idx]], 0.0);
        }

        squares.detect(&self.cloud, &mut self.output);

        // Ids begin at 1; 0 is no cluster.
        let mut ids = vec![0_u32; n_points];
        for detection_idx in 0..self.output.detections.len() {
            for &point_idx in self.output.detections.get(detection_idx).point_indices {
                ids[point_idx as usize] = detection_idx as u32 + 1;
            }
        }
        let stages: Vec<Value> = self
            .output
            .stage_times
            .iter()
            .map(|it| json!({"name": it.stage, "ms": 1000.0 * it.duration.as_secs_f64()}))
            .collect();
        let line =
            json!({"message": "result", "number": message["number"], "clusters": true, "stages": stages});
        Ok((line, ids.into_iter().flat_map(u32::to_le_bytes).collect()))
    }
}

/// Reads `n` numbers of the shared memory.
fn column(mut memory: &File, columns: &Value, name: &str, n: usize) -> Result<Vec<f32>, String> {
    let of_name = columns.as_array().and_then(|it| it.iter().find(|it| it["name"] == name));
    let offset =
        of_name.and_then(|it| it["offset"].as_u64()).ok_or_else(|| format!("there is no column {name}"))?;
    let mut bytes = vec![0; 4 * n];
    let read = memory.seek(SeekFrom::Start(offset)).and_then(|_| memory.read_exact(&mut bytes));
    read.map_err(|error| format!("cannot read {name}: {error}"))?;
    Ok(bytes.as_chunks().0.iter().map(|it| f32::from_le_bytes(*it)).collect())
}

/// The pipe whose number is in the environment.
fn pipe(variable: &str, how: &OpenOptions) -> io::Result<File> {
    let number = std::env::var(variable).map_err(io::Error::other)?;
    how.open(format!("/dev/fd/{number}"))
}

fn main() -> io::Result<()> {
    let mut reading = BufReader::new(pipe("SCANBENCH_READ_FD", OpenOptions::new().read(true))?);
    let mut writing = pipe("SCANBENCH_WRITE_FD", OpenOptions::new().write(true))?;
    let mut session = Session::default();
    let mut line = Vec::new();
    while reading.read_until(b'\n', &mut line)? > 0 {
        let message: Value = serde_json::from_slice(&line)?;
        if message["message"] == "quit" {
            break;
        }
        let (mut fields, payload) = session
            .answer(&message)
            .unwrap_or_else(|text| (json!({"message": "error", "text": text}), Vec::new()));
        fields["payload_bytes"] = payload.len().into();
        writing.write_all(format!("{fields}\n").as_bytes())?;
        writing.write_all(&payload)?;
        line.clear();
    }
    Ok(())
}
