//! `scanbench detect`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use detector::DetectedClass;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::detector_list::DETECTORS;
use evaluation::run::single_scan::{SingleScan, detect_repeatedly};
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::latencies::Latencies;
use reports::rows::cluster_of_point;
use scans::conversion::results::detection_rows::{box_rows, clusters_of_points};
use scans::dataset::positioned_points::values_of_file;

use crate::cli::help_text::{DATA, DETECTORS as DETECTORS_HEADING, OUTPUT};
use crate::cli::{ConfigArgs, SourceArgs, detector_names};
use crate::plumbing::config::{chosen_detectors, warn_of_unknown_sensor};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::first_look::look_at_scan;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_scan::{OpenedScan, open_scan};
use crate::plumbing::result_file::{Destination, write_results};
use crate::plumbing::standard_streams::{print_diagnostic, print_result};

/// Arguments of `scanbench detect`.
#[derive(Debug, Args)]
#[command(after_help = DETECT_EXAMPLES)]
pub struct DetectArgs {
    /// File of a scan, such as a Velodyne `.bin`; or, with --scan, the id or path of a data set
    #[arg(value_name = "SCAN")]
    pub input: String,
    /// Scan of the data set: `0000/000110`, or `110` if only one drive has that number
    #[arg(long, value_name = "ID", help_heading = DATA)]
    pub scan: Option<String>,
    /// How the data set is opened.
    #[command(flatten)]
    pub source: SourceArgs,
    /// The detector.
    #[arg(short, long, value_name = "NAME", help = detector_help(), default_value = DETECTORS[0].name)]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub detector: String,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Detect N times, and print the shortest and the median time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub repeat: u32,
    /// File for the cluster of each point: `.csv` or `.u32`; `-` prints the CSV
    ///
    /// Rows are in the order of the points. 0 is no cluster; clusters are numbered from 1. In `.u32`, numbers have four
    /// bytes, little endian.
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
    /// CSV file for the boxes; `-` prints it
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub boxes: Option<PathBuf>,
}

const DETECT_EXAMPLES: &str = "\
Examples:
  scanbench detect 000000.bin -o clusters.csv --boxes boxes.csv
  scanbench detect 000000.bin -d kd-tree -P tolerance_m=0.5 -P foreground=all -o clusters.u32
  scanbench detect street-narrow --seed 7 --scan narrow-7/000000 --sensor vlp-16 --repeat 20
  scanbench detect ~/data/kitti_tracking --scan 0000/000110 --boxes - | head

Clusters are numbered from 1; the column id of the boxes has the same numbers. Points
of no cluster have 0. Boxes of whole vehicles have a score of their own (box_score), the
sides that are seen, and whether the front is sure.";

fn detector_help() -> String {
    format!("Detector: {}, or one of scanbench.toml", detector_names().join(", "))
}

/// Runs one detector on one scan, writes clusters and boxes where they are asked for, and prints a summary.
pub fn detect(arguments: &DetectArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let destinations = Destinations::new(arguments)?;
    let names = std::slice::from_ref(&arguments.detector);
    let (detectors, mut config) = chosen_detectors(&arguments.config, names)?;
    destinations.check()?;
    let mut scan =
        open_scan(&arguments.input, arguments.scan.as_deref(), &arguments.source, &config.classes)?;
    let stated = scan.stated;
    look_at_scan(&mut scan, stated, &mut config);
    let description = &scan.description;
    warn_of_unknown_sensor(&config, description);
    let mut detector = ComparedDetector::of(detectors[0].clone(), &config).begin(description);
    let result = detect_repeatedly(&mut *detector, &scan.scan, arguments.repeat as usize, interrupted)?;
    for warning in detector.finish() {
        print_diagnostic(format_args!("warning: {warning}"));
    }
    write_results(&destinations.contents(&scan, &result)?)?;
    let summary = summary(&scan, detectors[0].name(), &result);
    if destinations.take_stdout() {
        print_diagnostic(summary.trim_end());
        Ok(())
    } else {
        print_result(summary.trim_end())
    }
}

struct Destinations {
    clusters: Option<Destination>,
    boxes: Option<Destination>,
}

impl Destinations {
    fn new(arguments: &DetectArgs) -> Result<Self, Usage> {
        let destination = |written: &Option<_>, extensions: &[&str]| {
            written.as_deref().map(|it: &Path| Destination::new(it, extensions)).transpose()
        };
        let clusters = destination(&arguments.output, &["csv", "u32"])?;
        let boxes = destination(&arguments.boxes, &["csv"])?;
        if clusters.is_some() && clusters == boxes {
            return Err(Usage("--output and --boxes must be different files".to_owned()));
        }
        Ok(Self { clusters, boxes })
    }

    fn check(&self) -> Result<(), Failure> {
        for destination in self.clusters.iter().chain(&self.boxes) {
            destination.check()?;
        }
        Ok(())
    }

    fn take_stdout(&self) -> bool {
        self.clusters.iter().chain(&self.boxes).any(|it| *it == Destination::Stdout)
    }

    fn contents(
        &self,
        OpenedScan { scan, .. }: &OpenedScan,
        result: &SingleScan,
    ) -> Result<Vec<(Destination, Vec<u8>)>, Failure> {
        let mut contents = Vec::new();
        let detections = &result.output.detections;
        if let Some(destination) = &self.clusters {
            // One for every point of the file; those without a position are of no cluster.
            let clusters = clusters_of_points(detections, scan.cloud.len());
            let clusters: Vec<Option<u32>> =
                values_of_file(&clusters, &scan.points_left_out).into_iter().map(Option::flatten).collect();
            let is_binary =
                matches!(destination, Destination::File(path) if path.extension() == Some("u32".as_ref()));
            let content = if is_binary {
                cluster_of_point::to_u32_le(&clusters)
            } else {
                cluster_of_point::to_csv(&clusters).into_bytes()
            };
            contents.push((destination.clone(), content));
        }
        if let Some(destination) = &self.boxes {
            contents.push((
                destination.clone(),
                to_csv_bytes(&box_rows(detections.iter().map(|it| (it, false))))?,
            ));
        }
        Ok(contents)
    }
}

fn summary(opened: &OpenedScan, detector: &str, result: &SingleScan) -> String {
    let OpenedScan { name, scan, description, .. } = opened;
    let detections = &result.output.detections;
    let n_in_clusters: usize = detections.iter().map(|it| it.point_indices.len()).sum();
    let n_vehicles = detections.iter().filter(|it| it.class == DetectedClass::Vehicle).count();
    let left_out = match scan.points_left_out.len() {
        0 => String::new(),
        n => format!(" and {n} without a position, which are skipped"),
    };
    let mut text = format!(
        "{name}: {} points{left_out}, sensor {} m above the road\n\
         {detector}: {} clusters of {n_in_clusters} points, {n_vehicles} of them vehicles; {} more dropped because \
         of their size\n\n",
        scan.cloud.len(),
        description.sensor_height_m,
        detections.len(),
        result.output.dropped_clusters.len(),
    );
    write_times(&mut text, result);
    text
}

/// A line for each stage and one for all: a single time in milliseconds, or the least and the median of several.
fn write_times(text: &mut String, result: &SingleScan) {
    const STAGE: &str = "stage";
    const WHOLE: &str = "whole";
    const ENDLESS: &str = "a string takes all that is written";
    let names = result.stages.iter().map(|(stage, _)| *stage).chain([STAGE, WHOLE]);
    let width = names.map(str::len).max().unwrap_or(0);
    let mut write_line = |name: &str, cells: &[String]| {
        write!(text, "{name:<width$}").expect(ENDLESS);
        for cell in cells {
            write!(text, "  {cell:>9}").expect(ENDLESS);
        }
        text.push('\n');
    };
    let is_single = result.whole.n() == 1;
    let heads: &[&str] = if is_single { &["ms"] } else { &["min ms", "p50 ms"] };
    write_line(STAGE, &heads.iter().map(ToString::to_string).collect::<Vec<_>>());
    let text_of = |time_ms: Option<f64>| time_ms.map_or_else(String::new, |it| format!("{it:.3}"));
    let cells = |times: &Latencies| {
        let percents: &[u32] = if is_single { &[50] } else { &[0, 50] };
        percents.iter().map(|&percent| text_of(times.percentile_ms(percent))).collect::<Vec<_>>()
    };
    for (stage, times) in &result.stages {
        write_line(stage, &cells(times));
    }
    write_line(WHOLE, &cells(&result.whole));
}
