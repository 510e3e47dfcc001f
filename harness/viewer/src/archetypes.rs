//! Turns our shapes into Rerun's, one function per archetype.

use std::sync::Arc;

use detector::OrientedBox;
use detector::detection::SeenSides;
use detector::stage_product::{ProductLink, ProductSphere};
use re_sdk_types::archetypes::{Boxes3D, Ellipsoids3D, LineStrips3D, Points2D, Points3D};
use re_sdk_types::components::{Color, FillMode, Radius};
use re_sdk_types::datatypes::{Quaternion, Rgba32};
use rerun::external::arrow::array::{ArrayRef, FixedSizeListArray, Float32Array, UInt32Array};
use rerun::external::arrow::datatypes::{DataType, Field};
use rerun::{Component as _, ComponentDescriptor, ComponentIdentifier, SerializedComponentBatch};

use super::box_edges::box_edges;
use super::legend;
use super::palette::Rgb;
use super::rounding::Rounding;

/// Cells are drawn at least this high, so that a flat one can be seen.
const MIN_CELL_HEIGHT_M: f32 = 0.04;

/// Points of one `color`, unless a view maps a column of [`colors`] to them.
///
/// The Arrow array is made by hand, because Rerun's own conversion copies every point several times.
pub fn points(
    positions_m: impl Iterator<Item = [f32; 3]>,
    radius: Radius,
    color: Rgba32,
) -> Vec<SerializedComponentBatch> {
    let coordinates: Vec<f32> = positions_m.flatten().collect();
    let coordinate = Arc::new(Field::new("item", DataType::Float32, false));
    let coordinates: ArrayRef = Arc::new(Float32Array::from(coordinates));
    let array = Arc::new(FixedSizeListArray::new(coordinate, 3, coordinates, None));
    let Points3D { radii, colors, .. } = Points3D::update_fields().with_radii([radius]).with_colors([color]);
    let positions = SerializedComponentBatch::new(array, Points3D::descriptor_positions());
    [Some(positions), radii, colors].into_iter().flatten().collect()
}

/// Column of colours, without effect until a view maps it to the points. (Class ids would say more, but viewers from 0.38 on
/// ignore those that are mapped.)
pub fn colors(colors: Vec<Rgb>, column: ComponentIdentifier) -> SerializedComponentBatch {
    let descriptor = ComponentDescriptor::partial(column).with_component_type(Color::name());
    let colors = UInt32Array::from_iter_values(colors.into_iter().map(|it| legend::rgba(it).to_u32()));
    SerializedComponentBatch::new(Arc::new(colors), descriptor)
}

/// Outlines of upright boxes.
pub fn boxes(boxes: impl IntoIterator<Item = OrientedBox>) -> Boxes3D {
    let mut centers_m = Vec::new();
    let mut half_sizes_m = Vec::new();
    let mut turns = Vec::new();
    for it in boxes {
        let (sin, cos) = (it.yaw_rad / 2.0).sin_cos();
        centers_m.push(it.center_m);
        half_sizes_m.push(it.length_width_height_m.map(|side_m| side_m / 2.0));
        turns.push(Quaternion::from_xyzw([0.0, 0.0, sin, cos]));
    }
    Boxes3D::from_centers_and_half_sizes(centers_m, half_sizes_m)
        .with_quaternions(turns)
        .with_fill_mode(FillMode::MajorWireframe)
}

/// Outlines of upright boxes, dashed where no side is seen, and for each of their lines the index of its box in `boxes`. (A
/// viewer shows the label of a line that is pointed at; of [`boxes`] it only shows how many components they have.)
pub fn labelled_boxes(
    boxes: impl IntoIterator<Item = (OrientedBox, Option<SeenSides>)>,
) -> (LineStrips3D, Vec<usize>) {
    let (mut lines, mut indices) = (Vec::new(), Vec::new());
    for (index, (drawn, seen)) in boxes.into_iter().enumerate() {
        let edges = box_edges(&drawn, seen);
        indices.extend(std::iter::repeat_n(index, edges.len()));
        lines.extend(edges);
    }
    (LineStrips3D::new(lines), indices)
}

/// Outlines of spheres.
pub fn spheres(spheres: &[ProductSphere]) -> Ellipsoids3D {
    let centers_m = spheres.iter().map(|it| it.center_m);
    Ellipsoids3D::from_centers_and_radii(centers_m, spheres.iter().map(|it| it.radius_m))
        .with_fill_mode(FillMode::MajorWireframe)
}

/// A column over the ground.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Centre on the ground plan in metres.
    pub center_m: [f32; 2],
    /// Lower and upper end in metres.
    pub z_range_m: [f32; 2],
}

/// Solid square columns over the ground, without their colour.
pub fn columns(side_m: f32, rounding: Rounding, columns: impl Iterator<Item = Column> + Clone) -> Boxes3D {
    let half_side_m = side_m * 0.46;
    let centers_m = columns.clone().map(|Column { center_m: [x_m, y_m], z_range_m: [low_m, high_m] }| {
        [x_m, y_m, rounding.coordinate_m(f32::midpoint(low_m, high_m))]
    });
    let half_sizes_m = columns.map(|Column { z_range_m: [low_m, high_m], .. }| {
        let half_height_m = rounding.coordinate_m((high_m - low_m) / 2.0).max(MIN_CELL_HEIGHT_M / 2.0);
        [half_side_m, half_side_m, half_height_m]
    });
    Boxes3D::from_centers_and_half_sizes(centers_m, half_sizes_m).with_fill_mode(FillMode::Solid)
}

/// The lines of a graph.
pub fn links<'a>(rounding: Rounding, links: impl Iterator<Item = &'a ProductLink>) -> LineStrips3D {
    LineStrips3D::new(links.map(|it| it.ends_m.map(|end_m| rounding.position_m(end_m))))
}

/// Straight lines from end to end.
pub fn segments(segments: &[[[f32; 3]; 2]]) -> LineStrips3D {
    LineStrips3D::new(segments)
}

/// Closed outlines; the first vertex of each is repeated at its end.
pub fn contours(rounding: Rounding, contours: &[Vec<[f32; 3]>]) -> LineStrips3D {
    let closed = contours.iter().map(|contour| contour.iter().chain(contour.first()).copied());
    LineStrips3D::new(closed.map(|it| rounding.line_m(&it.collect::<Vec<_>>())))
}

/// A line of text in two dimensions.
pub fn written(position: [f32; 2], text: String) -> Points2D {
    Points2D::new([position])
        .with_radii([Radius::new_ui_points(0.0)])
        .with_colors([Rgba32::WHITE])
        .with_labels([text])
        .with_show_labels(true)
}
