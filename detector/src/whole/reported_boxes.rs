//! The boxes that are reported.

use std::sync::Arc;

use serde::Deserialize;

use crate::detection::{DetectedClass, Detection};
use crate::detector::DetectorOutput;
use crate::fit::outline_box::OutlineBox;
use crate::oriented_box::OrientedBox;
use crate::point_cloud::PointCloud;
use crate::whole::box_model::BoxModel;
use crate::whole::whole_box::{SeenVehicle, WholeBoxes};

/// What ends no higher above the ground than this stands on it, in metres.
const MOST_CLEARANCE_M: f32 = 0.6;

/// Which boxes are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxParams {
    /// Whether boxes lie along the outline that the sensor sees; otherwise close to the corners of the convex hull (VM section 4).
    pub outline: bool,
    /// Whether vehicles have the box of the whole vehicle, and other objects one down to the ground; otherwise that of what is seen.
    pub whole: bool,
}

/// Fits the boxes that are reported, when all else has been decided: points and classes are what they are.
#[derive(Debug, Clone)]
pub struct ReportedBoxes {
    outlined: bool,
    // Nothing where boxes are those of what is seen.
    model: Option<Arc<BoxModel>>,
    outline: OutlineBox,
    positions_m: Vec<[f32; 3]>,
    vehicles: Vec<SeenVehicle>,
    whole: WholeBoxes,
}

impl ReportedBoxes {
    /// Boxes as `params` say, of whole vehicles by the model that comes with the program.
    pub fn new(params: BoxParams) -> Self {
        Self {
            outlined: params.outline,
            model: params.whole.then(BoxModel::shipped),
            outline: OutlineBox::default(),
            positions_m: Vec::new(),
            vehicles: Vec::new(),
            whole: WholeBoxes::default(),
        }
    }

    /// The same by another model, if there is one and vehicles are made whole at all.
    pub fn with_model(self, other: Option<Arc<BoxModel>>) -> Self {
        Self { model: self.model.map(|shipped| other.unwrap_or(shipped)), ..self }
    }

    /// Whether vehicles are made whole.
    pub fn are_whole(&self) -> bool {
        self.model.is_some()
    }

    /// Replaces the boxes in `output`, which was found in `cloud`; `ground_below_m` is the elevation of the ground below a box. Without
    /// points a box stays as it is.
    pub fn replace(
        &mut self,
        cloud: &PointCloud,
        ground_below_m: impl Fn(&OrientedBox) -> f32,
        output: &mut DetectorOutput,
    ) {
        for detections in [&mut output.detections, &mut output.unlikely_vehicles] {
            self.vehicles.clear();
            detections.replace_boxes(|it| self.fit(cloud, &ground_below_m, &it));
            let Self { model: Some(model), vehicles, whole, .. } = self else { continue };
            let mut whole = whole.find(model, vehicles).iter();
            detections.replace_boxes(|it| {
                if is_made_whole(&it) { *whole.next().expect("one of each") } else { it.bounding_box }
            });
        }
    }

    /// The box of what is seen. A vehicle that is made whole is noted.
    fn fit(
        &mut self,
        cloud: &PointCloud,
        ground_below_m: impl Fn(&OrientedBox) -> f32,
        detection: &Detection<'_>,
    ) -> OrientedBox {
        let Self { outlined, model, outline, positions_m, vehicles, .. } = self;
        positions_m.clear();
        positions_m.extend(detection.point_indices.iter().map(|&it| cloud.position_m(it as usize)));
        let along = if *outlined { outline.fit(positions_m) } else { None };
        let seen = along.unwrap_or(detection.bounding_box);
        if model.is_none() || positions_m.is_empty() {
            return seen;
        }
        let ground_m = ground_below_m(&seen);
        if is_made_whole(detection) {
            vehicles.push(SeenVehicle::new(seen, ground_m, positions_m));
        }
        standing(seen, ground_m)
    }
}

/// The same box, down to the ground if it ends a little above it: what is low is not seen, or taken for ground.
fn standing(seen: OrientedBox, ground_m: f32) -> OrientedBox {
    let [x_m, y_m, z_m] = seen.center_m;
    let [length_m, width_m, height_m] = seen.length_width_height_m;
    let [bottom_m, top_m] = [z_m - 0.5 * height_m, z_m + 0.5 * height_m];
    if bottom_m <= ground_m || bottom_m > ground_m + MOST_CLEARANCE_M {
        return seen;
    }
    OrientedBox {
        center_m: [x_m, y_m, 0.5 * (ground_m + top_m)],
        length_width_height_m: [length_m, width_m, top_m - ground_m],
        ..seen
    }
}

fn is_made_whole(detection: &Detection<'_>) -> bool {
    detection.class == DetectedClass::Vehicle && !detection.point_indices.is_empty()
}
