//! A level road to test with, and the results of the first stages on it.

use crate::detector::DetectorOutput;
use crate::params::front_end::FrontEndParams;
use crate::pipeline::foreground_stages::ground;
use crate::pipeline::frame::Frame;
use crate::pipeline::stage_list::Stage as _;
use crate::point_cloud::PointCloud;
use crate::segment::foreground::Foreground;
use crate::surface_class::SurfaceClass;

/// Height of the sensor above the road.
pub(crate) const SENSOR_HEIGHT_M: f32 = 1.73;

/// A point every 20 cm, so many steps ahead, back, and to either side.
pub(crate) fn road(n_steps: i32) -> impl Iterator<Item = [f32; 3]> {
    let steps = move || (-n_steps..n_steps).map(|step| step as f32 * 0.2 + 0.1);
    steps().flat_map(move |x| steps().map(move |y| [x, y, -SENSOR_HEIGHT_M]))
}

/// The grid over `cloud`, its terrain, and the classes of its cells.
pub(crate) fn segmented(params: &FrontEndParams, cloud: &PointCloud) -> Frame<Foreground> {
    let mut frame = Frame::new(Foreground::new(params.foreground.clone()), params, SENSOR_HEIGHT_M);
    frame.grid.fill(cloud);
    ground(params).run(cloud, &mut frame, &mut DetectorOutput::default());
    frame
}

/// The class of the occupied cell around a position.
pub(crate) fn class_around(frame: &Frame<Foreground>, position_m: [f32; 2]) -> SurfaceClass {
    let is_near = |&&cell_idx: &&u32| {
        let [x, y] = frame.grid.center_m(cell_idx);
        (x - position_m[0]).abs() <= 0.3 && (y - position_m[1]).abs() <= 0.3
    };
    let cell_idx = frame.grid.occupied().iter().find(is_near).expect("a point was drawn there");
    frame.classes[*cell_idx as usize]
}
