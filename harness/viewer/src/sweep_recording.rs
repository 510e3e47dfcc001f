//! The Rerun recording of a sweep: one scan, and the swept parameter instead of time.

use detector::DetectorOutput;
use evaluation::matching::assign::{MatchingParams, assign};
use evaluation::matching::mistake::Evidence;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::running_detector::RunningDetector;
use evaluation::run::scan_in_drive::ScanInDrive;
use evaluation::run::side_by_side::{DetectionTimes, DetectorScan};
use evaluation::sweep::quality_pass::SweptDataset;
use evaluation::sweep::sweep_plan::SweepPlan;
use reports::numbers::sweep_score::{SweepScore, SweepScores};
use reports::rows::counts::Counts;
use reports::run_folder::run_directory::{RunDirectory, SWEEP_RRD};
use reports::run_folder::sweep_entry::SweptParameter;
use reports::vocabulary::extent::Extent;
use reports::vocabulary::task::Task;

use scans::annotation::LabeledScan;
use scans::dataset::DatasetDescription;

use super::drawn_points::PointChoice;
use super::recording_axis::RecordingAxis;
use super::run_recording::{RecordingError, task_views};
use super::scan_views::{DetectorView, ScanView};
use super::session::Stream;
use super::stream_options::{FirstTab, Opening, RecordingTarget, StreamOptions};
use super::viewer::ViewerChoice;

/// Runs the detectors once more on the middle scan of `swept`, the first data set of `plan`, at every point, and records it.
///
/// # Errors
///
/// If the scan cannot be read or the file not be written.
pub fn record_sweep(
    directory: &RunDirectory,
    plan: &SweepPlan,
    swept: &SweptDataset<'_>,
    scores: &SweepScores,
) -> Result<(), RecordingError> {
    let description = swept.dataset.description();
    let scan_idx = swept.scan_indices[swept.scan_indices.len() / 2];
    let scan = swept.dataset.read_scan(scan_idx)?;
    let asked = ScanInDrive::anywhere(&scan, 0.0, swept.dataset, scan_idx);
    let steps = Steps::of(&plan.swept);
    let shown_task = if description.annotated.covers(Task::Objects) { Task::Objects } else { Task::Vehicles };
    let options = StreamOptions {
        name: directory.target().file_name().unwrap_or_default().to_string_lossy().into_owned(),
        viewer: ViewerChoice::None,
        opening: Opening {
            shown_task,
            first_tab: FirstTab::Compare,
            has_poses: false,
            follows: false,
            figures: &[],
        },
        points: PointChoice::All,
    };
    let detectors: Vec<&str> = plan.detectors.iter().map(ChosenDetector::name).collect();
    let of_dataset = Extent::Dataset(description.id.clone());
    let at_point = |point_idx: usize| -> Vec<&SweepScore> {
        let is_there =
            |it: &&SweepScore| it.subject.point_idx == point_idx && it.subject.extent == of_dataset;
        scores.scores.iter().filter(is_there).collect()
    };
    let axis = RecordingAxis {
        timeline: steps.timeline.clone(),
        steps_per_s: steps.steps_per_s(),
        rates: format!("F-rate of {} scans", swept.scan_indices.len()),
        further_series: further(&at_point(0)).iter().map(|it| it.0).collect(),
    };
    let file = RecordingTarget::File(directory.path_of(SWEEP_RRD));
    let mut stream = Stream::open_along(&file, &options, &detectors, axis)?;
    for (index, &(step, point_idx)) in steps.ascending().iter().enumerate() {
        let there = at_point(point_idx);
        if index == 0 {
            let view = ScanView { scan: &scan, step, marks: &[], world_from_sensor: None, drive_m: &[] };
            stream.log_scan(&view)?;
        }
        let values: Vec<String> =
            plan.parameters().iter().zip(&plan.points[point_idx].values).map(of_name).collect();
        stream.log_step(step, title(&scan, &values), &further(&there))?;
        let config = &plan.points[point_idx].config;
        for chosen in &plan.detectors {
            let compared_detector = ComparedDetector::of(chosen.clone(), &plan.points[point_idx].config);
            let detector = compared_detector.begin(description);
            let of_detector = there.iter().filter(|it| it.subject.detector == compared_detector.name);
            let f_rates = of_detector.map(|it| it.counts.drawn(Counts::f_rate));
            look_again(&mut stream, &asked, description, detector, &config.matching, f_rates)?;
        }
    }
    stream.finish()?;
    Ok(())
}

/// Logs the results of `detector` on the scan of a data set, with its F-rates on all scans, in the order of the tasks.
fn look_again(
    stream: &mut Stream,
    asked: &ScanInDrive<'_>,
    dataset: &DatasetDescription,
    mut detector: Box<dyn RunningDetector>,
    matching: &MatchingParams,
    f_rates: impl Iterator<Item = Option<f64>>,
) -> Result<(), RecordingError> {
    let (scan, mut output) = (asked.scan, DetectorOutput::default());
    // Lets its buffers grow to their size before the time is taken.
    detector.detect(asked, &mut output)?;
    let latency = detector.detect(asked, &mut output)?.wall;
    let judge = |&task| assign(scan, &output.detections, task, &dataset.annotated, matching);
    let assignments = Task::ALL.iter().map(judge).collect();
    let times = DetectionTimes { first: latency, least: latency, ..DetectionTimes::default() };
    let result = DetectorScan { detector: detector.name(), output, times, failure: None, assignments };
    let products = detector.stage_products(&scan.cloud);
    let evidence = Evidence::gather(scan, &result.output.detections, &products, matching.criterion);
    let view = DetectorView {
        name: result.detector,
        output: &result.output,
        products: &products,
        tasks: &task_views(&result, dataset, &evidence, f_rates),
        latency,
    };
    Ok(stream.log_detector(scan, &view)?)
}

fn of_name((name, value): (&String, &String)) -> String {
    format!("{} = {value}", name.rsplit('.').next().unwrap_or(name))
}

fn title(scan: &LabeledScan, values: &[String]) -> String {
    format!("{}: {}", scan.id, values.join(", "))
}

/// The readings of the cell fitness, if there are any.
fn further(there: &[&SweepScore]) -> Vec<(&'static str, Option<f64>)> {
    let cells = there.iter().find_map(|it| it.cells.as_ref());
    cells.iter().flat_map(|it| &it.readings).map(|it| (it.name, it.value)).collect()
}

/// The points of a sweep on a timeline, which has whole numbers only.
struct Steps {
    timeline: String,
    /// Position of each point on the timeline.
    steps: Vec<i64>,
}

impl Steps {
    /// Values of a single parameter, lengths in millimetres, if they are whole numbers; otherwise the indices of the points.
    fn of(swept: &[SweptParameter]) -> Self {
        let n_points: usize = swept.iter().map(|it| it.values.len()).product();
        let indices = Self { timeline: "point".to_owned(), steps: (0..n_points as i64).collect() };
        let [only] = swept else { return indices };
        let name = only.name.rsplit('.').next().unwrap_or(&only.name);
        let whole = |factor: f64| -> Option<Vec<i64>> {
            let step = |value: &String| {
                let step = factor * value.parse::<f64>().ok()?;
                ((step - step.round()).abs() < 1e-6 && step.abs() < 1e12).then(|| step.round() as i64)
            };
            only.values.iter().map(step).collect()
        };
        let (timeline, steps) = match name.strip_suffix("_m") {
            Some(length) => (format!("{length}_mm"), whole(1000.0)),
            None => (name.to_owned(), whole(1.0)),
        };
        steps.map_or(indices, |steps| Self { timeline, steps })
    }

    /// Steps and points, in the order of the steps.
    fn ascending(&self) -> Vec<(i64, usize)> {
        let mut steps: Vec<(i64, usize)> = self.steps.iter().copied().zip(0..).collect();
        steps.sort_unstable();
        steps
    }

    /// Steps a second at which two points pass, at least 1.
    fn steps_per_s(&self) -> f64 {
        let ascending = self.ascending();
        let reach = ascending.last().zip(ascending.first()).map_or(1, |(last, first)| last.0 - first.0);
        (2.0 * reach as f64 / (ascending.len().max(2) - 1) as f64).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(swept: &[(&str, &[&str])], timeline: &str, steps: &[i64], steps_per_s: f64) {
        let values = |(name, values): &(&str, &[&str])| SweptParameter {
            name: (*name).to_owned(),
            values: values.iter().map(|it| (*it).to_owned()).collect(),
        };
        let found = Steps::of(&swept.iter().map(values).collect::<Vec<_>>());
        assert_eq!(
            (found.timeline.as_str(), &found.steps[..], found.steps_per_s()),
            (timeline, steps, steps_per_s)
        );
    }

    #[test]
    fn lengths_are_steps_of_a_millimetre() {
        check(
            &[("hierarchical.grid.cell_size_m", &["0.2", "0.3", "0.4"])],
            "cell_size_mm",
            &[200, 300, 400],
            200.0,
        );
        check(&[("hierarchical.grid.xi", &["3", "2"])], "xi", &[3, 2], 2.0);
    }

    #[test]
    fn what_is_no_whole_number_of_steps_is_counted() {
        check(&[("walls.min_support", &["0.5", "0.6"])], "point", &[0, 1], 2.0);
        check(&[("kd_tree.foreground", &["short", "all"])], "point", &[0, 1], 2.0);
        check(&[("a.b_m", &["1", "2"]), ("a.c", &["1", "2"])], "point", &[0, 1, 2, 3], 2.0);
    }

    #[test]
    fn a_range_that_goes_down_is_recorded_upward() {
        let swept =
            SweptParameter { name: "a.xi".to_owned(), values: ["3", "2"].map(str::to_owned).to_vec() };
        assert_eq!(Steps::of(&[swept]).ascending(), [(2, 1), (3, 0)]);
    }
}
