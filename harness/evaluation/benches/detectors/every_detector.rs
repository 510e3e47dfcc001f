//! All detectors of the list, and the stages of the default one.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use detector::detector::StageTime;
use detector::{DetectorOutput, PointCloud};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{DEFAULT_DETECTORS, DETECTORS};

use crate::rows::print_rows;
use crate::{N_ROUNDS, N_WARMUP_ROUNDS};

/// Measures and prints.
pub fn measure(clouds: &[PointCloud], config: &RunConfig, sensor_height_m: f32) {
    let mut detectors: Vec<_> = DETECTORS.iter().map(|it| it.build(config, sensor_height_m)).collect();
    let mut latencies: BTreeMap<usize, Vec<Duration>> = BTreeMap::new();
    let mut stages: Vec<(&'static str, Vec<Duration>)> = Vec::new();
    let mut output = DetectorOutput::default();
    for round in 0..N_WARMUP_ROUNDS + N_ROUNDS {
        for cloud in clouds {
            for (detector_idx, detector) in detectors.iter_mut().enumerate() {
                let started = Instant::now();
                detector.detect(cloud, &mut output);
                let latency = started.elapsed();
                if round >= N_WARMUP_ROUNDS {
                    latencies.entry(detector_idx).or_default().push(latency);
                    if detector.name() == DEFAULT_DETECTORS[0] {
                        add_stages(&mut stages, &output.stage_times);
                    }
                }
            }
        }
    }
    let all = latencies.into_iter().map(|(idx, durations)| (DETECTORS[idx].name, durations));
    print_rows("detector", all);
    print_rows(&format!("stage of {}", DEFAULT_DETECTORS[0]), stages.into_iter());
}

fn add_stages(stages: &mut Vec<(&'static str, Vec<Duration>)>, stage_times: &[StageTime]) {
    for it in stage_times {
        match stages.iter_mut().find(|(stage, _)| *stage == it.stage) {
            Some((_, durations)) => durations.push(it.duration),
            None => stages.push((it.stage, vec![it.duration])),
        }
    }
}
