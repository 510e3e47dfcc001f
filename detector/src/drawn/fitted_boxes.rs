//! Boxes, and the hulls they were fitted to.

use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::stage;
use crate::stage_product::{Shape, StageProduct};

/// The hulls, ground plans and boxes of `fitted`.
pub fn fitted_boxes(fitted: &FittedObjects) -> Vec<StageProduct> {
    let objects = &fitted.objects;
    let hull = |object: &FittedObject| {
        let [_, _, bottom_m] = object.bounding_box.bottom_m()[0];
        fitted.hull_m(object).iter().map(|&[x_m, y_m]| [x_m, y_m, bottom_m]).collect()
    };
    let hulls = objects.iter().map(hull).collect();
    let rectangles = objects.iter().map(|it| it.bounding_box.bottom_m().to_vec()).collect();
    let boxes = objects.iter().map(|it| it.bounding_box).collect();
    let product = |name, shape| StageProduct { stage: stage::BOXES, name, shape };
    vec![
        product("hulls", Shape::Contours(hulls)),
        product("rectangles", Shape::Contours(rectangles)),
        product("boxes", Shape::Boxes(boxes)),
    ]
}
