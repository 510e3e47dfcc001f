//! Logs what the stages of a detector left behind.

use std::collections::BTreeSet;

use detector::PointCloud;
use detector::stage_product::{Shape, StageProduct, SurfaceClass};
use rerun::{
    Boxes3D, ComponentIdentifier, EntityPath, LineStrips3D, Radius, RecordingStream, SerializedComponentBatch,
};

use super::entity_paths::ProductKind;
use super::error::StreamError;
use super::palette::{self, Rgb};
use super::{archetypes, entity_paths, legend, recording};

/// Half the width of a line, in pixels of a screen of normal density.
const LINE_RADIUS_PX: f32 = 0.8;

/// Logs `products` of `detector` at the current time and returns the entities they became.
///
/// Labels of points become columns of the points of the scan: two bytes a point that compress well, where the positions
/// again would be twelve that do not.
///
/// # Errors
///
/// [`StreamError::ProductLength`] if a product is not of this scan, [`StreamError::Log`] if Rerun refuses.
pub fn log_products(
    stream: &RecordingStream,
    cloud: &PointCloud,
    detector: &str,
    products: &[StageProduct],
) -> Result<BTreeSet<EntityPath>, StreamError> {
    for product in products {
        check_length(cloud, detector, product)?;
    }
    recording::log(stream, entity_paths::POINTS, &point_columns(cloud, detector, products))?;
    let mut logged = BTreeSet::new();
    for product in products {
        logged.extend(log_entity(stream, detector, product)?);
    }
    Ok(logged)
}

/// Logs a product that has an entity of its own, and says which.
fn log_entity(
    stream: &RecordingStream,
    detector: &str,
    product: &StageProduct,
) -> Result<Option<EntityPath>, StreamError> {
    let path = |kind| entity_paths::stage_product(detector, kind, product);
    let (path, logged) = match &product.shape {
        Shape::LabeledPoints(_) | Shape::Clusters(_) => return Ok(None),
        Shape::Cells { cell_size_m, cells } => {
            let ids = cells.iter().map(|cell| legend::surface_id(cell.class));
            let drawn = archetypes::cells(*cell_size_m, cells).with_class_ids(ids);
            let path = path(ProductKind::Cells);
            (path.clone(), recording::log(stream, path, &drawn))
        }
        Shape::Segments(segments) => {
            let drawn = colored_lines(archetypes::segments(segments), palette::ORANGE);
            let path = path(ProductKind::Segments);
            (path.clone(), recording::log(stream, path, &drawn))
        }
        Shape::Contours(contours) => {
            let drawn = colored_lines(archetypes::contours(contours), palette::YELLOW);
            let path = path(ProductKind::Contours);
            (path.clone(), recording::log(stream, path, &drawn))
        }
        Shape::Spheres(spheres) => {
            let drawn = archetypes::spheres(spheres)
                .with_line_radii([Radius::new_ui_points(LINE_RADIUS_PX)])
                .with_colors([legend::rgba(palette::ORANGE)]);
            let path = path(ProductKind::Spheres);
            (path.clone(), recording::log(stream, path, &drawn))
        }
        Shape::Boxes(boxes) => {
            let drawn = colored_boxes(archetypes::boxes(boxes.iter().copied()), palette::GREY);
            let path = path(ProductKind::Boxes);
            (path.clone(), recording::log(stream, path, &drawn))
        }
    };
    logged.map(|()| Some(path))
}

/// The columns of class ids of `detector`; surfaces and clusters are there even if no product tells them, since a view
/// is coloured by them.
fn point_columns(
    cloud: &PointCloud,
    detector: &str,
    products: &[StageProduct],
) -> Vec<SerializedComponentBatch> {
    let last = |is_kind: fn(&Shape) -> bool| products.iter().rposition(|it| is_kind(&it.shape));
    let last_surfaces = last(|shape| matches!(shape, Shape::LabeledPoints(_)));
    let last_clusters = last(|shape| matches!(shape, Shape::Clusters(_)));
    let unknown = |column: ComponentIdentifier| {
        archetypes::class_ids(vec![legend::surface_id(SurfaceClass::Unseen)], column)
    };
    let mut columns = Vec::new();
    if last_surfaces.is_none() {
        columns.push(unknown(entity_paths::surface_column(detector)));
    }
    if last_clusters.is_none() {
        columns.push(unknown(entity_paths::cluster_column(detector)));
    }
    for (product_idx, product) in products.iter().enumerate() {
        let name = if Some(product_idx) == last_surfaces {
            entity_paths::surface_column(detector)
        } else if Some(product_idx) == last_clusters {
            entity_paths::cluster_column(detector)
        } else {
            entity_paths::earlier_column(detector, product)
        };
        columns.extend(point_ids(cloud, &product.shape).map(|ids| archetypes::class_ids(ids, name)));
    }
    columns
}

/// The class id of every point that is drawn; none if the product does not label points.
fn point_ids(cloud: &PointCloud, shape: &Shape) -> Option<Vec<u16>> {
    let drawable = archetypes::drawable_points(cloud);
    let no_cluster = legend::surface_id(SurfaceClass::Unseen);
    match shape {
        Shape::LabeledPoints(classes) => {
            Some(drawable.map(|point_idx| legend::surface_id(classes[point_idx])).collect())
        }
        Shape::Clusters(clusters) => {
            let id = |point_idx: usize| clusters[point_idx].map_or(no_cluster, legend::cluster_id);
            Some(drawable.map(id).collect())
        }
        Shape::Cells { .. }
        | Shape::Segments(_)
        | Shape::Boxes(_)
        | Shape::Contours(_)
        | Shape::Spheres(_) => None,
    }
}

fn check_length(cloud: &PointCloud, detector: &str, product: &StageProduct) -> Result<(), StreamError> {
    let n_labels = match &product.shape {
        Shape::LabeledPoints(classes) => classes.len(),
        Shape::Clusters(cluster_of_point) => cluster_of_point.len(),
        Shape::Cells { .. }
        | Shape::Segments(_)
        | Shape::Boxes(_)
        | Shape::Contours(_)
        | Shape::Spheres(_) => cloud.len(),
    };
    if n_labels == cloud.len() {
        return Ok(());
    }
    Err(StreamError::ProductLength {
        detector: detector.to_owned(),
        product: product.name,
        n_points: cloud.len(),
        n_labels,
    })
}

fn colored_lines(lines: LineStrips3D, color: Rgb) -> LineStrips3D {
    lines.with_radii([Radius::new_ui_points(LINE_RADIUS_PX)]).with_colors([legend::rgba(color)])
}

fn colored_boxes(boxes: Boxes3D, color: Rgb) -> Boxes3D {
    boxes.with_radii([Radius::new_ui_points(LINE_RADIUS_PX)]).with_colors([legend::rgba(color)])
}
