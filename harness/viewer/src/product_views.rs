//! The entities and the column of points that show the products of a stage.

use detector::StageProduct;
use detector::stage_product::Shape;
use rerun::EntityPath;

use super::entity_paths::{self, PointColumns, ProductKind};

/// The views of one detector, as far as they follow from its stage products.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorViews {
    /// Its name.
    pub detector: String,
    /// Columns of the final surface classes of the points; without them, of the final clusters.
    pub surfaces: Option<PointColumns>,
    /// Columns of the final clusters of the points.
    pub clusters: Option<PointColumns>,
    /// The views of the stages, in the order of the stages.
    pub stages: Vec<StageView>,
}

/// View of the products of one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StageView {
    /// Its name.
    pub stage: &'static str,
    /// The entities that are drawn.
    pub entities: Vec<EntityPath>,
    /// Columns that colour the points: the labels of this stage, or else of the one before.
    pub labels: Option<PointColumns>,
    /// Whether it shows cells, which points would hide, or be hidden by.
    pub is_of_cells: bool,
}

impl DetectorViews {
    /// The views of `detector`, whose stages leave these `products` behind.
    pub fn of(detector: &str, products: &[StageProduct]) -> Self {
        let mut views =
            Self { detector: detector.to_owned(), surfaces: None, clusters: None, stages: Vec::new() };
        for product in products {
            let columns = PointColumns::of(detector, product);
            match product.shape {
                Shape::LabeledPoints(_) => views.surfaces = columns,
                Shape::Clusters(_) => views.clusters = columns,
                _ => {}
            }
            let is_same = |it: &StageView| it.stage == product.stage;
            if !views.stages.last().is_some_and(is_same) {
                let labels = views.stages.last().and_then(|it| it.labels);
                views.stages.push(StageView {
                    stage: product.stage,
                    entities: Vec::new(),
                    labels,
                    is_of_cells: false,
                });
            }
            let Some(view) = views.stages.last_mut() else { continue };
            view.is_of_cells |= matches!(product.shape, Shape::Cells { .. } | Shape::Links(_));
            match ProductKind::of(&product.shape) {
                Some(kind) => view.entities.push(entity_paths::stage_product(detector, kind, product)),
                None => view.labels = columns,
            }
        }
        // Without surface classes, at least the clusters of the points are shown.
        views.surfaces = views.surfaces.or(views.clusters);
        views
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_nobody_classifies_show_their_clusters() {
        let product = |shape| StageProduct { stage: "clusters", name: "clusters", shape };
        let views = DetectorViews::of("foreign", &[product(Shape::Clusters(Vec::new()))]);
        assert!(views.surfaces.is_some() && views.surfaces == views.clusters);
    }

    #[test]
    fn a_stage_without_labels_shows_those_of_the_one_before() {
        let product = |stage, name, shape| StageProduct { stage, name, shape };
        let products = [
            product("walls", "segments", Shape::Segments(Vec::new())),
            product("foreground", "points", Shape::LabeledPoints(Vec::new())),
            product("boxes", "hulls", Shape::Contours(Vec::new())),
            product("boxes", "boxes", Shape::Boxes(Vec::new())),
        ];
        let views = DetectorViews::of("grid", &products);
        let columns = PointColumns::of("grid", &products[1]);
        assert!(columns.is_some() && (views.surfaces, views.clusters) == (columns, None));
        let described: Vec<_> =
            views.stages.iter().map(|it| (it.stage, it.entities.len(), it.labels)).collect();
        assert_eq!(described, [("walls", 1, None), ("foreground", 0, columns), ("boxes", 2, columns)]);
    }
}
