//! The worst mistakes and a few of the best matches, drawn from above.

use maud::{Markup, PreEscaped, html};

use super::document::Section;
use super::markup::key;
use crate::facts::gathered_run::Surroundings;
use crate::facts::run_facts::RunFacts;
use crate::facts::seen_boxes::{SeenBox, scan_name};
use crate::plots::scene_plot::{Scene, SceneDetection, scene_keys, scene_plot};
use crate::run_folder::run_directory::VIEWER;
use crate::vocabulary::reason::MistakeKind;
use crate::vocabulary::task::Task;
use crate::worst::mistakes::scan_address;
use crate::worst::objects::{MistakeList, WorstObject};
use crate::worst::recorded::RecordedObject;

/// The section of worst mistakes; `None` if there are none with a position, and no matches.
pub(super) fn worst(facts: &RunFacts) -> Option<Section> {
    if facts.worst.lists().all(|(_, objects)| objects.is_empty()) {
        return None;
    }
    let mut tasks: Vec<Task> = facts.rankings.iter().map(|it| it.task).collect();
    tasks.dedup();
    let content = html! {
        p.about {
            "The missed and false objects with the most points, each object once, and two of the closest matches. Forward is up; the wedge at the edge points to the sensor, and a cross (+) is the sensor. "
            code { "scanbench view RUN --at SCAN" } " opens a scan in the viewer. "
            @if facts.points.is_some() { "Dots are points of the scan: dark above the road, pale on the road." }
        }
        (key(&scene_keys(&facts.detectors())))
        @for &task in &tasks {
            @for (detector_idx, detector) in facts.detectors().iter().enumerate() {
                (of_detector(facts, task, detector, detector_idx == 0))
            }
        }
    };
    Some(Section::new("Worst", "Worst mistakes and best matches, seen from above", content))
}

fn of_detector(facts: &RunFacts, task: Task, detector: &str, is_open: bool) -> Markup {
    let lists = [Some(MistakeKind::Missed), Some(MistakeKind::False), None].map(|kind| {
        let list = MistakeList { task, detector: detector.to_owned(), kind };
        (kind, facts.worst.of(&list))
    });
    html! {
        @if lists.iter().any(|(_, objects)| !objects.is_empty()) {
            details.worst open[is_open] {
                summary { "Task " (task) ": " (detector) }
                div.scenes {
                    @for (kind, objects) in lists {
                        @for worst in objects { (scene(facts, task, detector, kind, worst)) }
                    }
                }
            }
        }
    }
}

fn scene(
    facts: &RunFacts,
    task: Task,
    detector: &str,
    kind: Option<MistakeKind>,
    worst: &WorstObject<Surroundings>,
) -> Markup {
    let word = kind.map_or("matched", MistakeKind::name);
    let boxes = facts.boxes.get(&scan_name(worst)).map_or(&[][..], Vec::as_slice);
    let is_near = |it: &&SeenBox| {
        let [x_m, y_m, _] = it.bounding_box.center_m;
        worst.window.holds(x_m, y_m)
    };
    let near = || boxes.iter().filter(is_near);
    let annotations =
        near().filter(|it| it.detector.is_none() && it.task == task).map(|it| it.bounding_box).collect();
    let is_asked = |it: &SeenBox| it.task == task;
    // A detection that counts in another task alone was found, too, and taken for something else.
    let is_elsewhere = |it: &SeenBox| {
        near().any(|other| is_asked(other) && other.detector == it.detector && other.id == it.id)
    };
    let shown = near().filter(|it| it.detector.is_some() && (is_asked(it) || !is_elsewhere(it)));
    let detections = shown.map(|it| SceneDetection {
        detector_idx: facts.detector_idx(it.detector.as_deref().unwrap_or_default()),
        bounding_box: it.bounding_box,
        is_asked: is_asked(it),
    });
    let [x_m, y_m] = worst.window.center_m;
    let range_m = f64::from(x_m).hypot(f64::from(y_m));
    let object = &worst.object;
    let is_simulated = facts.manifest.datasets.iter().any(|it| it.id == object.dataset && it.simulated);
    let label = format!("{word} {} of {detector}, {range_m:.0} m away, seen from above", worst.class);
    let plot = scene_plot(
        &Scene {
            window: worst.window,
            subject: worst.bounding_box,
            cells: facts.points.as_ref().and_then(|it| it.around(object)),
            annotations,
            detections: detections.collect(),
        },
        label,
    );
    html! {
        figure.scene.matched[kind.is_none()] {
            (PreEscaped(plot.inline()))
            figcaption {
                strong { (word) " " (worst.class) } ": " (worst.reason) br;
                (worst.n_points) " points, " (format!("{range_m:.1}")) " m away" br;
                span.where { code { (scan_address(&object.dataset, &object.sequence, object.scan)) } @if is_simulated { " (simulated)" } }
                @if let Some(RecordedObject { recording, step, .. }) = facts.in_viewer.as_ref().and_then(|it| it.of(object)) {
                    br; a href=(format!("{VIEWER}/index.html#recording={recording}&scan={step}")) target="scanbench-viewer" { "show it in the viewer" }
                }
                @if let Some(recorded) = facts.recordings.as_ref().and_then(|it| it.of(object)) {
                    br; "recorded in " a href=(recorded.recording) { (recorded.recording) } ", at scan " (recorded.step)
                }
            }
        }
    }
}
