//! The recording of objects that grow: the step of uncovering, or the way that was driven, instead of time.

use std::path::Path;

use detector::PointCloud;
use evaluation::partial::growth::{Growth, GrowthMoment, ScannerPosition};
use re_sdk_types::archetypes::{BarChart, LineStrips3D, Points3D, Scalars, SeriesLines, ViewCoordinates};
use re_sdk_types::components::Radius;
use re_sdk_types::datatypes::Rgba32;
use reports::rows::partial_row::{OfClasses, Predicted};
use reports::vocabulary::partial_class::PartialClass;
use rerun::RecordingStream;

use super::blueprint::growth::{GrowthColumn, GrowthTab, send_growth_blueprint};
use super::entity_paths::{GrowthPart, growth};
use super::error::StreamError;
use super::layers::APPLICATION_ID;
use super::palette::Rgb;
use super::single_file::SingleFile;
use super::{legend, palette, recording};

/// Timeline, and its steps a second, of objects that are uncovered, and of objects that are driven toward.
const STEPS: (&str, f64) = ("step", 2.0);
const DRIVEN: (&str, f64) = ("driven_cm", 100.0);

/// Writes `growths` to the file at `path`, a tab for each end that objects are seen from.
///
/// # Errors
///
/// [`StreamError`] if the file cannot be written, or Rerun refuses.
pub fn record_growths(path: &Path, name: &str, growths: &[Growth]) -> Result<(), StreamError> {
    let file = SingleFile::begin(path, name)?;
    let stream = &file.stream;
    let timeline = if growths.iter().any(|it| it.moments.iter().any(|it| it.scanner.is_some())) {
        DRIVEN
    } else {
        STEPS
    };
    for growth in growths {
        log_lines(stream, growth)?;
        let mut before = PointCloud::default();
        for moment in &growth.moments {
            stream.set_time_sequence(timeline.0, moment.at);
            log_moment(stream, growth, moment, &before)?;
            before = moment.cloud.clone();
        }
    }
    send_growth_blueprint(stream, APPLICATION_ID, &tabs(growths), timeline)?;
    file.finish()
}

fn tabs(growths: &[Growth]) -> Vec<GrowthTab> {
    let mut tabs: Vec<GrowthTab> = Vec::new();
    for it in growths {
        let name = match it.direction {
            "drive" => format!("partial: {} on the way", it.data),
            direction => format!("partial: {} from {direction}", it.data),
        };
        let (middle_m, extent_m) = bounds(it);
        let of = names_of(it);
        let column = GrowthColumn { of, title: format!("{}: {}", it.class, it.object), middle_m, extent_m };
        match tabs.iter_mut().find(|it| it.name == name) {
            Some(tab) => tab.columns.push(column),
            None => tabs.push(GrowthTab { name, columns: vec![column] }),
        }
    }
    tabs
}

/// The names that make up the path of a growing object: data set, direction, object.
fn names_of(growth: &Growth) -> [String; 3] {
    [growth.data.clone(), growth.direction.to_owned(), growth.object.clone()]
}

/// The middle and the largest extent of the points that are seen in the end, in metres.
fn bounds(growth: &Growth) -> ([f32; 3], f32) {
    let (mut low_m, mut high_m) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position_m in growth.moments.last().iter().flat_map(|it| it.cloud.positions_m()) {
        for axis in (0..3).filter(|_| position_m.iter().all(|it| it.is_finite())) {
            low_m[axis] = low_m[axis].min(position_m[axis]);
            high_m[axis] = high_m[axis].max(position_m[axis]);
        }
    }
    if low_m[0] > high_m[0] {
        return ([0.0; 3], 1.0);
    }
    let extent_m = (0..3).map(|axis| high_m[axis] - low_m[axis]).fold(0.0, f32::max);
    ([0, 1, 2].map(|axis| f32::midpoint(low_m[axis], high_m[axis])), extent_m)
}

/// Names and colours of the lines of all classes, for the whole recording.
fn log_lines(stream: &RecordingStream, of: &Growth) -> Result<(), StreamError> {
    let names = names_of(of);
    let at = |part| growth(&names, part);
    recording::log_static(stream, at(GrowthPart::Scene), &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    let lines = SeriesLines::new()
        .with_names(PartialClass::ALL.map(PartialClass::name))
        .with_colors(PartialClass::ALL.map(|it| legend::rgba(palette::partial_class_color(it))))
        .with_widths(PartialClass::ALL.map(|it| if it == of.class { 3.0 } else { 1.5 }));
    recording::log_static(stream, at(GrowthPart::Chances), &lines)?;
    recording::log_static(stream, at(GrowthPart::Errors), &lines)
}

fn log_moment(
    stream: &RecordingStream,
    of: &Growth,
    moment: &GrowthMoment,
    before: &PointCloud,
) -> Result<(), StreamError> {
    let names = names_of(of);
    let at = |part| growth(&names, part);
    let colors = colors_of_points(&moment.cloud, before);
    let points = Points3D::new(moment.cloud.positions_m())
        .with_colors(colors.into_iter().map(legend::rgba))
        .with_radii([Radius::new_ui_points(1.6)]);
    recording::log(stream, at(GrowthPart::Points), &points)?;
    let keypoints = Points3D::new(moment.keypoints.iter().map(|it| it.position_m.map(|it| it as f32)))
        .with_colors(moment.keypoints.iter().map(|it| legend::rgba(label_color(it.label))))
        .with_radii([Radius::new_ui_points(4.5)]);
    recording::log(stream, at(GrowthPart::Keypoints), &keypoints)?;
    let [r, g, b] = palette::YELLOW;
    let graphs = LineStrips3D::new(moment.graphs_m.iter().cloned())
        .with_colors([Rgba32::from_unmultiplied_rgba(r, g, b, 110)])
        .with_radii([Radius::new_ui_points(0.7)]);
    recording::log(stream, at(GrowthPart::Graphs), &graphs)?;
    recording::log(stream, at(GrowthPart::Decision), &decision(of, moment))?;
    if let Some(position) = moment.scanner {
        recording::log(stream, at(GrowthPart::Scanner), &scanner(position))?;
    }
    log_numbers(stream, at(GrowthPart::Chances), &moment.answer.chances)?;
    log_numbers(stream, at(GrowthPart::Errors), &moment.answer.errors)?;
    if moment.bag.is_empty() {
        return Ok(());
    }
    let bars =
        BarChart::new(moment.bag.as_slice()).with_color(legend::rgba(palette::partial_class_color(of.class)));
    recording::log(stream, at(GrowthPart::Bag), &bars)
}

/// Logs a number for each class; one that the method does not know leaves a gap.
fn log_numbers(
    stream: &RecordingStream,
    path: rerun::EntityPath,
    numbers: &OfClasses,
) -> Result<(), StreamError> {
    if numbers.iter().all(Option::is_none) {
        return Ok(());
    }
    recording::log(stream, path, &Scalars::new(numbers.map(|it| it.unwrap_or(f64::NAN))))
}

/// Colours of the points: new ones stand out. Points keep their order, so that those of `before` come one after the other.
fn colors_of_points(cloud: &PointCloud, before: &PointCloud) -> Vec<Rgb> {
    let bits = |it: [f32; 3]| it.map(f32::to_bits);
    let mut known = before.positions_m().map(bits).peekable();
    let color = |position_m: [f32; 3]| {
        if known.next_if_eq(&bits(position_m)).is_some() { palette::SEEN_BEFORE } else { palette::SEEN_NOW }
    };
    cloud.positions_m().map(color).collect()
}

fn label_color(label: u8) -> Rgb {
    palette::CYCLE[usize::from(label) % palette::CYCLE.len()]
}

/// The predicted class and its chance, above the object.
fn decision(of: &Growth, moment: &GrowthMoment) -> Points3D {
    let ([x, y, z], extent_m) = bounds(of);
    let top_m = moment.cloud.z_m().iter().copied().filter(|it| it.is_finite()).fold(z, f32::max);
    let predicted = moment.answer.predicted;
    let chance = moment.answer.chances.into_iter().flatten().reduce(f64::max);
    let text = match (predicted, chance) {
        (Predicted::NotJudged | Predicted::NoneOfThese, _) | (_, None) => predicted.name().to_owned(),
        (_, Some(chance)) => format!("{} {:.0} %", predicted.name(), 100.0 * chance),
    };
    let color = match predicted {
        predicted if predicted == Predicted::from(of.class) => palette::MATCHED,
        Predicted::NotJudged => palette::GREY,
        _ => palette::FALSE,
    };
    Points3D::new([[x, y, top_m + 0.22 * extent_m]])
        .with_labels([text])
        .with_show_labels(true)
        .with_colors([legend::rgba(color)])
        .with_radii([Radius::new_ui_points(3.0)])
}

/// The plane of the scanner as a triangle that ends at the object.
fn scanner(ScannerPosition { position_m, slope }: ScannerPosition) -> LineStrips3D {
    let [x, y, z] = position_m;
    let reach_m = -x;
    let corner = |aside: f32| [0.0, y + aside * reach_m, z + slope * reach_m];
    LineStrips3D::new([vec![position_m, corner(0.35), corner(-0.35), position_m]])
        .with_colors([legend::rgba(palette::VERMILION)])
        .with_radii([Radius::new_ui_points(1.2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_there_before_is_new() {
        let cloud = |heights_m: &[f32]| heights_m.iter().map(|it| [0.0, 0.0, *it]).collect::<PointCloud>();
        let colors = colors_of_points(&cloud(&[3.0, 1.0, 2.0, f32::NAN]), &cloud(&[1.0, f32::NAN]));
        let (now, before) = (palette::SEEN_NOW, palette::SEEN_BEFORE);
        assert_eq!(colors, [now, before, now, before]);
    }
}
