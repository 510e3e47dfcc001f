//! Detectors side by side: where each is right and wrong, and why.

use re_sdk_types::blueprint::archetypes::{PlotLegend, ScalarAxis, TextLogColumns, VisualBounds2D};
use re_sdk_types::blueprint::components::{Corner2D, TextLogColumn};
use re_sdk_types::blueprint::datatypes;
use re_sdk_types::blueprint::datatypes::TextLogColumnKind;
use re_sdk_types::datatypes::{Range1D, Range2D};
use reports::vocabulary::task::Task;
use rerun::EntityPath;
use rerun::blueprint::{
    ContainerLike, Horizontal, Spatial2DView, Tabs, TextDocumentView, TextLogView, TimeSeriesView, Vertical,
};

use super::RecordingLayout;
use super::scene::{Eye, Property, Scene, ScenePoints, add, hide, plain_background};
use crate::entity_paths::{self, ProductKind};
use crate::legend;
use crate::product_views::DetectorViews;

/// The scene of the first detector beside that of the second, the others a click away; and below them the mistakes in words
/// and the series.
pub fn compare(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> ContainerLike {
    let (first, others) = layout.detectors.split_at(layout.detectors.len().min(1));
    let mut scenes: Vec<ContainerLike> =
        first.iter().map(|it| detector_tabs(layout, it, properties)).collect();
    match others {
        [] => {}
        [second] => scenes.push(detector_tabs(layout, second, properties)),
        _ => {
            let of_others =
                others.iter().map(|it| outcomes(layout, it, entity_paths::SENSOR, Eye::BEHIND, properties));
            scenes.push(Tabs::new(of_others.collect::<Vec<_>>()).into());
        }
    }
    let mut shares = vec![1.0; scenes.len()];
    if layout.axis.is_of_a_sweep() {
        // In a sweep the curves matter most, and how the scene looks where they turn.
        scenes.push(Vertical::new(curves(layout, properties)).into());
        shares.push(0.7);
    }
    let scenes = Horizontal::new(scenes).with_column_shares(shares).into();
    let below = bottom_row(layout, properties);
    Vertical::new([scenes, below]).with_row_shares(vec![2.6, 1.0]).with_name("compare detectors").into()
}

/// Two runs side by side, and below them what changed, in words.
pub fn changes(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> ContainerLike {
    let scenes: Vec<ContainerLike> = layout
        .detectors
        .iter()
        .map(|it| outcomes(layout, it, entity_paths::SENSOR, Eye::OVER, properties))
        .collect();
    let lists = layout.detectors.iter().rev().take(1);
    let mut below: Vec<ContainerLike> =
        lists.map(|it| lines("pointed at, in words", &it.detector, layout, properties)).collect();
    below.push(drawn_legend(layout, entity_paths::LEGEND_OUTCOMES, properties));
    let below = Horizontal::new(below).with_column_shares(vec![2.6, 1.0]);
    let rows: [ContainerLike; 2] = [Horizontal::new(scenes).into(), below.into()];
    Vertical::new(rows).with_row_shares(vec![2.9, 1.0]).with_name("side by side").into()
}

/// Outcomes of a detector, in `frame`; its stage products are one click away.
pub fn outcomes(
    layout: &RecordingLayout<'_>,
    detector: &DetectorViews,
    frame: &'static str,
    eye: Eye,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let name = &detector.detector;
    let contents = vec![entity_paths::detector(name)];
    let points = ScenePoints::by(detector.surfaces);
    let view = Scene { name, frame, eye, contents, points }.view(properties);
    hide(properties, &view, &entity_paths::ANNOTATIONS.into());
    hide(properties, &view, &entity_paths::scores(name));
    for kind in ProductKind::ALL {
        hide(properties, &view, &entity_paths::products(name, kind));
    }
    for task in Task::ALL.into_iter().filter(|task| *task != layout.opening.shown_task) {
        hide(properties, &view, &entity_paths::outcomes(name, task));
    }
    view
}

/// The views of one detector as tabs: outcomes, cells, clusters.
fn detector_tabs(
    layout: &RecordingLayout<'_>,
    detector: &DetectorViews,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let outcomes = outcomes(layout, detector, entity_paths::SENSOR, Eye::BEHIND, properties);
    let mut scene = |name, kinds: &[ProductKind], points| {
        let contents: Vec<EntityPath> =
            kinds.iter().map(|kind| entity_paths::products(&detector.detector, *kind)).collect();
        let frame = entity_paths::SENSOR;
        Scene { name, frame, eye: Eye::BEHIND, contents, points }.view(properties)
    };
    let cells = scene("cells", &[ProductKind::Cells, ProductKind::Segments], ScenePoints::None);
    let around = [ProductKind::Contours, ProductKind::Boxes];
    let clusters = scene("clusters", &around, ScenePoints::by(detector.clusters));
    for view in [&cells, &clusters] {
        hide(properties, view, &entity_paths::ANNOTATIONS.into());
    }
    Tabs::new([outcomes, cells, clusters]).into()
}

/// The mistakes of each detector in words, as wide as sentences need; F-rates, and the legend.
fn bottom_row(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> ContainerLike {
    let detectors = || layout.detectors.iter().map(|it| it.detector.as_str());
    let of_detectors: Vec<ContainerLike> = detectors().map(|it| in_words(layout, it, properties)).collect();
    let (mut columns, mut shares) = (vec![Tabs::new(of_detectors).into()], vec![2.4]);
    if !layout.axis.is_of_a_sweep() {
        columns.push(rates(layout, properties));
        shares.push(1.0);
    }
    columns.push(drawn_legend(layout, entity_paths::LEGEND_OUTCOMES, properties));
    shares.push(1.0);
    Horizontal::new(columns).with_column_shares(shares).into()
}

/// F-rates over the axis, or numbers of detections where nothing is labelled; and times. The colours of the lines are in the
/// drawn legend, since plots are small.
fn rates(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> ContainerLike {
    let mut f_rate_view = |task: Task| {
        let (title, origin) = if layout.is_labelled {
            (layout.axis.rates.as_str(), entity_paths::f_rates(task))
        } else {
            ("detections", entity_paths::numbers_of_detections(task))
        };
        let view: ContainerLike =
            TimeSeriesView::new(format!("{title}: {}", task.name())).with_origin(origin).into();
        if layout.is_labelled {
            add(properties, &view, "ScalarAxis", ScalarAxis::new().with_range([0.0, 1.0]));
        }
        add(properties, &view, "PlotLegend", PlotLegend::new().with_visible(false));
        view
    };
    let others = Task::ALL.into_iter().filter(|task| *task != layout.opening.shown_task);
    let mut tabs: Vec<ContainerLike> =
        std::iter::once(layout.opening.shown_task).chain(others).map(&mut f_rate_view).collect();
    let latency: ContainerLike =
        TimeSeriesView::new("latency in ms").with_origin(entity_paths::LATENCY).into();
    add(properties, &latency, "PlotLegend", PlotLegend::new().with_visible(false));
    tabs.push(latency);
    Tabs::new(tabs).into()
}

/// Series over a parameter: rates, and those that only this recording has.
fn curves(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> Vec<ContainerLike> {
    let mut curves = vec![rates(layout, properties)];
    let further = layout.axis.further_series.iter();
    let further: Vec<ContainerLike> = further
        .map(|it| {
            let name = format!("cell fitness: {it}");
            TimeSeriesView::new(name).with_origin(entity_paths::further(it)).into()
        })
        .collect();
    if !further.is_empty() {
        curves.push(Tabs::new(further).into());
    }
    curves
}

/// Counts and stage times of a detector.
fn numbers(
    layout: &RecordingLayout<'_>,
    detector: &str,
    properties: &mut Vec<Property>,
) -> [ContainerLike; 2] {
    let mut series = |name, origin| {
        let view: ContainerLike = TimeSeriesView::new(name).with_origin(origin).into();
        add(properties, &view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop));
        view
    };
    let counts = entity_paths::counts(detector, layout.opening.shown_task);
    let stage_times = entity_paths::stage_times(detector);
    [series("counts", counts), series("stage times in ms", stage_times)]
}

/// The mistakes of a detector in words: of the scan that is shown as links to its boxes, and of all scans; then its numbers.
fn in_words(layout: &RecordingLayout<'_>, detector: &str, properties: &mut Vec<Property>) -> ContainerLike {
    let of_scan = entity_paths::mistakes_of_scan(detector, layout.opening.shown_task);
    let mut tabs: Vec<ContainerLike> = vec![
        TextDocumentView::new(format!("{detector}: {} in this scan", what_is_listed(layout)))
            .with_origin(of_scan)
            .into(),
        mistakes(layout, detector, properties),
    ];
    if layout.is_labelled {
        tabs.extend(numbers(layout, detector, properties));
    }
    Tabs::new(tabs).with_name(detector).into()
}

fn what_is_listed(layout: &RecordingLayout<'_>) -> &'static str {
    if layout.is_labelled { "missed and false" } else { "what no other detector has" }
}

/// Mistakes of a detector in all scans, in words.
pub fn mistakes(
    layout: &RecordingLayout<'_>,
    detector: &str,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    lines(&format!("{}, scan by scan", what_is_listed(layout)), detector, layout, properties)
}

/// The lines that a detector has in the shown task, as a list with this title.
fn lines(
    title: &str,
    detector: &str,
    layout: &RecordingLayout<'_>,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let view: ContainerLike = TextLogView::new(title)
        .with_origin(entity_paths::mistakes(detector, layout.opening.shown_task))
        .into();
    let body = datatypes::TextLogColumn { visible: true.into(), kind: TextLogColumnKind::Body };
    // The time stays beside it: the view goes on over all scans.
    let columns = TextLogColumns::new().with_text_log_columns([TextLogColumn(body)]);
    add(properties, &view, "TextLogColumns", columns);
    view
}

/// Legend of the colours: of a scene and of the lines of detectors, with the name of the scan; or of the stages.
pub fn drawn_legend(
    layout: &RecordingLayout<'_>,
    origin: &'static str,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let with_scan = origin == entity_paths::LEGEND_OUTCOMES;
    let mut contents = vec![format!("+ /{origin}/**")];
    contents.extend(with_scan.then(|| format!("+ /{}", entity_paths::LEGEND_SCAN)));
    let name = if with_scan { "scan and legend" } else { "legend of stages" };
    let view: ContainerLike = Spatial2DView::new(name).with_origin(origin).with_contents(contents).into();
    let visible_y = if with_scan { legend::visible_y(layout.detectors.len()) } else { legend::VISIBLE_Y };
    let bounds = Range2D { x_range: Range1D(legend::VISIBLE_X), y_range: Range1D(visible_y) };
    add(properties, &view, "VisualBounds2D", VisualBounds2D::new(bounds));
    add(properties, &view, "Background", plain_background());
    view
}

/// Outcomes of each detector, with an eye that goes along with the sensor.
pub fn drive(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> ContainerLike {
    let view = |detector| outcomes(layout, detector, entity_paths::WORLD, Eye::ALONG, properties);
    let views: Vec<ContainerLike> = layout.detectors.iter().map(view).collect();
    Horizontal::new(views).with_name("follow the drive").into()
}
