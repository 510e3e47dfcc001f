//! Logs the stage products of a detector.

use std::collections::BTreeSet;

use detector::stage_product::{LinkFate, ProductCell, ProductLink, Shape, StageProduct};
use detector::surface_class::SurfaceClass;
use re_sdk_types::archetypes::LineStrips3D;
use re_sdk_types::components::Radius;
use rerun::{EntityPath, RecordingStream, SerializedComponentBatch};

use super::archetypes::Column;
use super::drawn_points::DrawnPoints;
use super::entity_paths::ProductKind;
use super::error::StreamError;
use super::palette::{self, Rgb};
use super::rounding::Rounding;
use super::{archetypes, entity_paths, legend, recording};

/// Half the width of a line, in pixels of a screen of normal density.
const LINE_RADIUS_PX: f32 = 0.8;
/// Half the width of outlines that many others cross, in the same pixels.
const THIN_RADIUS_PX: f32 = 0.5;
/// Half the width of the lines of a graph, in the same pixels.
const LINK_RADIUS_PX: f32 = 1.0;

/// Logs `products` of `detector` at the current time and returns their entities.
///
/// Labels of points become columns of colours of the points of the scan. Columns compress well; the positions again would be
/// twelve bytes a point that do not.
///
/// # Errors
///
/// [`StreamError::ProductLength`] if a product is not of this scan, [`StreamError::Log`] if Rerun refuses.
pub fn log_products(
    stream: &RecordingStream,
    points: &DrawnPoints,
    detector: &str,
    products: &[StageProduct],
) -> Result<BTreeSet<EntityPath>, StreamError> {
    for product in products {
        check_length(points.n_points_of_scan(), detector, product)?;
    }
    let columns: Vec<SerializedComponentBatch> = products
        .iter()
        .filter_map(|StageProduct { stage, name, shape }| {
            let column = entity_paths::point_colors(detector, stage, name);
            Some(archetypes::colors(point_colors(points, shape)?, column))
        })
        .collect();
    if !columns.is_empty() {
        recording::log(stream, entity_paths::POINTS, &columns)?;
    }
    let mut logged = BTreeSet::new();
    for product in products {
        if let Some(kind) = ProductKind::of(&product.shape) {
            let path = entity_paths::stage_product(detector, kind, product.stage, product.name);
            log_entity(stream, path, product, points.rounding(), &mut logged)?;
        }
    }
    Ok(logged)
}

/// Logs a product that has an entity of its own, and adds its entities to `logged`.
fn log_entity(
    stream: &RecordingStream,
    path: EntityPath,
    product: &StageProduct,
    rounding: Rounding,
    logged: &mut BTreeSet<EntityPath>,
) -> Result<(), StreamError> {
    let color = palette::line_color(product.name);
    match &product.shape {
        Shape::LabeledPoints(_) | Shape::Clusters(_) => return Ok(()),
        Shape::Cells { cell_size_m, cells } => {
            return log_cells(stream, &path, (*cell_size_m, rounding), cells, logged);
        }
        Shape::Links(links) => return log_links(stream, &path, rounding, links, logged),
        Shape::ObjectCells { cell_size_m, cells } => {
            let columns = cells.iter().map(|it| Column { center_m: it.center_m, z_range_m: it.z_range_m });
            let ids = cells.iter().map(|cell| legend::cluster_id(cell.object));
            let drawn = archetypes::columns(*cell_size_m, rounding, columns).with_class_ids(ids);
            recording::log(stream, path.clone(), &drawn)?;
        }
        Shape::Segments(segments) => {
            let drawn = colored_lines(archetypes::segments(segments), color);
            recording::log(stream, path.clone(), &drawn)?;
        }
        Shape::Contours(contours) => {
            let drawn = colored_lines(archetypes::contours(rounding, contours), color);
            recording::log(stream, path.clone(), &drawn)?;
        }
        Shape::Spheres(spheres) => {
            let drawn = archetypes::spheres(spheres)
                .with_line_radii([Radius::new_ui_points(THIN_RADIUS_PX)])
                .with_colors([legend::rgba(color)]);
            recording::log(stream, path.clone(), &drawn)?;
        }
        Shape::Boxes(boxes) => {
            let drawn = archetypes::boxes(boxes.iter().copied())
                .with_radii([Radius::new_ui_points(THIN_RADIUS_PX)])
                .with_colors([legend::rgba(palette::GREY)]);
            recording::log(stream, path.clone(), &drawn)?;
        }
    }
    logged.insert(path);
    Ok(())
}

/// Logs the cells of each class as an entity of its own.
fn log_cells(
    stream: &RecordingStream,
    product: &EntityPath,
    (cell_size_m, rounding): (f32, Rounding),
    cells: &[ProductCell],
    logged: &mut BTreeSet<EntityPath>,
) -> Result<(), StreamError> {
    for class in SurfaceClass::ALL {
        let of_class = cells.iter().filter(|cell| cell.class == class);
        if of_class.clone().next().is_none() {
            continue;
        }
        let columns = of_class.map(|it| Column { center_m: it.center_m, z_range_m: it.z_range_m });
        let drawn =
            archetypes::columns(cell_size_m, rounding, columns).with_class_ids([legend::surface_id(class)]);
        let path = entity_paths::product_part(product, class.name());
        recording::log(stream, path.clone(), &drawn)?;
        logged.insert(path);
    }
    Ok(())
}

/// Logs the links of each fate as an entity of their own.
fn log_links(
    stream: &RecordingStream,
    product: &EntityPath,
    rounding: Rounding,
    links: &[ProductLink],
    logged: &mut BTreeSet<EntityPath>,
) -> Result<(), StreamError> {
    for fate in LinkFate::ALL {
        let of_fate = links.iter().filter(|link| link.fate == fate);
        if of_fate.clone().next().is_none() {
            continue;
        }
        let drawn = archetypes::links(rounding, of_fate)
            .with_radii([Radius::new_ui_points(LINK_RADIUS_PX)])
            .with_class_ids([legend::link_id(fate)]);
        let path = entity_paths::product_part(product, fate.name());
        recording::log(stream, path.clone(), &drawn)?;
        logged.insert(path);
    }
    Ok(())
}

/// The colour of every drawn point; `None` if the product does not label points.
fn point_colors(points: &DrawnPoints, shape: &Shape) -> Option<Vec<Rgb>> {
    let no_cluster = palette::surface_color(SurfaceClass::Unseen);
    match shape {
        Shape::LabeledPoints(classes) => {
            Some(points.indices().map(|point_idx| palette::surface_color(classes[point_idx])).collect())
        }
        Shape::Clusters(clusters) => {
            let color = |point_idx: usize| clusters[point_idx].map_or(no_cluster, palette::cluster_color);
            Some(points.indices().map(color).collect())
        }
        _ => None,
    }
}

fn check_length(n_points: usize, detector: &str, product: &StageProduct) -> Result<(), StreamError> {
    let n_labels = match &product.shape {
        Shape::LabeledPoints(classes) => classes.len(),
        Shape::Clusters(cluster_of_point) => cluster_of_point.len(),
        _ => n_points,
    };
    if n_labels == n_points {
        return Ok(());
    }
    Err(StreamError::ProductLength {
        detector: detector.to_owned(),
        product: product.name,
        n_points,
        n_labels,
    })
}

fn colored_lines(lines: LineStrips3D, color: Rgb) -> LineStrips3D {
    lines.with_radii([Radius::new_ui_points(LINE_RADIUS_PX)]).with_colors([legend::rgba(color)])
}
