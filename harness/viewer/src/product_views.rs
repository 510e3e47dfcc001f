//! The entities and the column of points that show the products of a stage.

use detector::StageProduct;
use detector::stage_product::Shape;
use rerun::{ComponentIdentifier, EntityPath};
use serde::{Deserialize, Serialize};

use super::entity_paths::{self, ProductKind};

/// The products of the stages of a detector, in the order of the stages, without what is in them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DetectorOutline {
    /// The name of the detector.
    pub detector: String,
    /// Its products.
    pub products: Vec<ProductOutline>,
}

/// A product of a stage without what is in it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProductOutline {
    stage: String,
    name: String,
    form: ProductForm,
}

/// How a product is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ProductForm {
    /// As colours of points by their classes.
    PointClasses,
    /// As colours of points by their clusters.
    PointClusters,
    /// As an entity.
    Entity(ProductKind),
}

impl DetectorOutline {
    /// That of `detector`, whose stages leave these `products` behind.
    pub fn of(detector: &str, products: &[StageProduct]) -> Self {
        let outline = |StageProduct { stage, name, shape }: &StageProduct| ProductOutline {
            stage: (*stage).to_owned(),
            name: (*name).to_owned(),
            form: match (ProductKind::of(shape), shape) {
                (Some(kind), _) => ProductForm::Entity(kind),
                (None, Shape::Clusters(_)) => ProductForm::PointClusters,
                (None, _) => ProductForm::PointClasses,
            },
        };
        Self { detector: detector.to_owned(), products: products.iter().map(outline).collect() }
    }
}

/// The views of one detector, as far as they follow from its stage products.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorViews {
    /// Its name.
    pub detector: String,
    /// Column of the final surface classes of the points; without them, of the final clusters.
    pub surfaces: Option<ComponentIdentifier>,
    /// Column of the final clusters of the points.
    pub clusters: Option<ComponentIdentifier>,
    /// The views of the stages, in the order of the stages.
    pub stages: Vec<StageView>,
}

/// View of the products of one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StageView {
    /// Its name.
    pub stage: String,
    /// The entities that are drawn.
    pub entities: Vec<EntityPath>,
    /// Column that colours the points: the labels of this stage, or else of the one before.
    pub labels: Option<ComponentIdentifier>,
    /// Whether it shows cells, which points would hide, or be hidden by.
    pub is_of_cells: bool,
}

impl DetectorViews {
    /// The views of a detector.
    pub fn of(outline: &DetectorOutline) -> Self {
        let detector = &outline.detector;
        let mut views =
            Self { detector: detector.clone(), surfaces: None, clusters: None, stages: Vec::new() };
        for ProductOutline { stage, name, form } in &outline.products {
            let column = entity_paths::point_colors(detector, stage, name);
            match form {
                ProductForm::PointClasses => views.surfaces = Some(column),
                ProductForm::PointClusters => views.clusters = Some(column),
                ProductForm::Entity(_) => {}
            }
            if views.stages.last().is_none_or(|it| it.stage != *stage) {
                let labels = views.stages.last().and_then(|it| it.labels);
                let (stage, entities) = (stage.clone(), Vec::new());
                views.stages.push(StageView { stage, entities, labels, is_of_cells: false });
            }
            let Some(view) = views.stages.last_mut() else { continue };
            match form {
                ProductForm::PointClasses | ProductForm::PointClusters => view.labels = Some(column),
                ProductForm::Entity(kind) => {
                    view.is_of_cells |= matches!(kind, ProductKind::Cells | ProductKind::Links);
                    view.entities.push(entity_paths::stage_product(detector, *kind, stage, name));
                }
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

    fn views(detector: &str, products: &[StageProduct]) -> DetectorViews {
        DetectorViews::of(&DetectorOutline::of(detector, products))
    }

    #[test]
    fn points_that_nobody_classifies_show_their_clusters() {
        let product = |shape| StageProduct { stage: "clusters", name: "clusters", shape };
        let views = views("foreign", &[product(Shape::Clusters(Vec::new()))]);
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
        let views = views("grid", &products);
        let column = Some(entity_paths::point_colors("grid", "foreground", "points"));
        assert_eq!((views.surfaces, views.clusters), (column, None));
        let described: Vec<_> =
            views.stages.iter().map(|it| (it.stage.as_str(), it.entities.len(), it.labels)).collect();
        assert_eq!(described, [("walls", 1, None), ("foreground", 0, column), ("boxes", 2, column)]);
    }
}
