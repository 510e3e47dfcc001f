//! The files of a log beside the points: boxes, poses, and positions of the lidars.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Isometry3, Vector3};
use reports::vocabulary::class::AnnotationClass;

use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;
use crate::dataset::feather::FeatherTable;
use crate::dataset::official::OfficialObject;
use crate::dataset::on_disk::is_there;
use crate::dataset::pose::isometry;
use crate::dataset::upright_box::upright_box;

/// The file of the annotations of a log.
pub const ANNOTATIONS: &str = "annotations.feather";

/// The point halfway between the two lidars, in the frame of the car, in metres. For logs without their calibration.
const USUAL_CAR_FROM_LIDARS_M: [f64; 3] = [1.35, 0.0, 1.6];

/// The names of the lidars in the calibration.
const LIDARS: [&str; 2] = ["up_lidar", "down_lidar"];

/// The columns of a pose: a translation, and a quaternion.
pub const POSE: [&str; 7] = ["tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw"];

/// All of a log but its points.
#[derive(Debug, Clone, PartialEq)]
pub struct LogTruth {
    /// Annotations without points by time, in nanoseconds, in the sensor frame.
    pub annotations: BTreeMap<i64, Vec<Annotation>>,
    /// Labelled objects by time, in the frame of the car.
    pub objects: BTreeMap<i64, Vec<OfficialObject>>,
    /// Pose of the sensor by time.
    pub world_from_sensor: BTreeMap<i64, Isometry3<f64>>,
    /// Position of the sensor in the frame of the car.
    pub car_from_sensor_m: Vector3<f64>,
}

impl LogTruth {
    /// Reads the log in `folder`.
    ///
    /// Annotations of unknown classes are noted in `classes` and left out. The origin becomes the point halfway between the
    /// two lidars; the axes stay those of the car.
    ///
    /// Poses and calibration may be missing.
    pub fn read(folder: &Path, classes: &mut ClassReader<'_>) -> Result<Self, DatasetError> {
        let car_from_sensor_m = car_from_sensor_m(&folder.join("calibration/egovehicle_SE3_sensor.feather"))?;
        let (annotations, objects) = read_labels(&folder.join(ANNOTATIONS), &car_from_sensor_m, classes)?;
        let poses = folder.join("city_SE3_egovehicle.feather");
        let mut world_from_sensor = BTreeMap::new();
        if is_there(&poses) {
            let names = [&POSE[..], &["timestamp_ns"]].concat();
            let mut table = FeatherTable::read(&poses, &names)?;
            let damaged = |problem| DatasetError::Damaged { path: poses.clone(), problem };
            let times = table.take_integers("timestamp_ns").map_err(damaged)?;
            for (time, pose) in times.into_iter().zip(take_poses(&mut table).map_err(damaged)?) {
                world_from_sensor.insert(
                    time,
                    pose * Isometry3::translation(
                        car_from_sensor_m.x,
                        car_from_sensor_m.y,
                        car_from_sensor_m.z,
                    ),
                );
            }
        }
        Ok(Self { annotations, objects, world_from_sensor, car_from_sensor_m })
    }
}

/// Notes the unknown classes in the annotations of the log in `folder`.
pub fn survey_classes(folder: &Path, classes: &mut ClassReader<'_>) -> Result<(), DatasetError> {
    let path = folder.join(ANNOTATIONS);
    let categories = FeatherTable::read(&path, &["category"])?.take_texts("category");
    let damaged = |problem| DatasetError::Damaged { path: path.clone(), problem };
    for (row, category) in categories.map_err(damaged)?.iter().enumerate() {
        classes.class_of(category, || format!("{path:?}, row {row}"));
    }
    Ok(())
}

fn car_from_sensor_m(path: &Path) -> Result<Vector3<f64>, DatasetError> {
    if !is_there(path) {
        return Ok(Vector3::from(USUAL_CAR_FROM_LIDARS_M));
    }
    let names = [&POSE[..], &["sensor_name"]].concat();
    let mut table = FeatherTable::read(path, &names)?;
    let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
    let sensors = table.take_texts("sensor_name").map_err(damaged)?;
    let poses = take_poses(&mut table).map_err(damaged)?;
    let lidars: Vec<Vector3<f64>> = sensors
        .iter()
        .zip(poses)
        .filter(|(name, _)| LIDARS.contains(&name.as_str()))
        .map(|(_, pose)| pose.translation.vector)
        .collect();
    match lidars[..] {
        [first, second] => Ok((first + second) / 2.0),
        _ => Err(damaged(format!("has {} of the sensors {}", lidars.len(), LIDARS.join(" and ")))),
    }
}

/// Takes the columns [`POSE`] of `table`. Errors are the rest of a sentence about the file.
pub fn take_poses(table: &mut FeatherTable) -> Result<Vec<Isometry3<f64>>, String> {
    let mut columns = Vec::with_capacity(POSE.len());
    for name in POSE {
        columns.push(table.take_numbers(name)?);
    }
    let n_rows = columns.iter().map(Vec::len).min().unwrap_or(0);
    let row = |row: usize| {
        let at = |column: usize| columns[column][row];
        isometry([at(0), at(1), at(2)], [at(3), at(4), at(5), at(6)])
    };
    (0..n_rows).map(row).collect()
}

/// Annotations in the frame of the sensor, and objects in that of the car, by time.
type Labels = (BTreeMap<i64, Vec<Annotation>>, BTreeMap<i64, Vec<OfficialObject>>);

/// The column of the number of points in a box, which not all tables have.
const N_POINTS: &str = "num_interior_pts";

fn read_labels(
    path: &Path,
    car_from_sensor_m: &Vector3<f64>,
    classes: &mut ClassReader<'_>,
) -> Result<Labels, DatasetError> {
    let names = ["timestamp_ns", "track_uuid", "category", "length_m", "width_m", "height_m"];
    let mut table = FeatherTable::read_some(path, &[&names[..], &POSE[..]].concat(), &[N_POINTS])?;
    let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
    let n_points = table.take_integers(N_POINTS).unwrap_or_default();
    let times = table.take_integers("timestamp_ns").map_err(damaged)?;
    let tracks = table.take_texts("track_uuid").map_err(damaged)?;
    let categories = table.take_texts("category").map_err(damaged)?;
    let mut sides_m = Vec::new();
    for name in ["length_m", "width_m", "height_m"] {
        sides_m.push(table.take_numbers(name).map_err(damaged)?);
    }
    let poses = take_poses(&mut table).map_err(damaged)?;
    let n_rows = times.len();
    let lengths =
        [tracks.len(), categories.len(), poses.len(), sides_m[0].len(), sides_m[1].len(), sides_m[2].len()];
    if lengths.iter().any(|it| *it != n_rows) {
        return Err(damaged(format!("has columns of {n_rows} and of {lengths:?} rows")));
    }
    // Tracks are numbered by the order of their names, so that the numbers do not depend on the sweeps that exist.
    let mut sorted: Vec<&String> = tracks.iter().collect();
    sorted.sort_unstable();
    sorted.dedup();
    let (mut annotations, mut objects) = Labels::default();
    for row in 0..n_rows {
        let size_m = [sides_m[0][row], sides_m[1][row], sides_m[2][row]];
        if !size_m.iter().all(|side_m| *side_m > 0.0 && *side_m < 1e4) {
            return Err(damaged(format!("has a box with sides of {size_m:?} m in row {row}")));
        }
        let n_points = n_points.get(row).and_then(|it| u64::try_from(*it).ok());
        let object =
            OfficialObject { n_points, ..OfficialObject::new(&categories[row], &poses[row], size_m) };
        objects.entry(times[row]).or_default().push(object);
        let position = || format!("{path:?}, row {row}");
        let Some(class) = classes.class_of(&categories[row], position) else { continue };
        let track = sorted.binary_search(&&tracks[row]).ok().map(|number| number as u32);
        annotations.entry(times[row]).or_default().push(annotation(
            class,
            &poses[row],
            size_m,
            track,
            car_from_sensor_m,
        ));
    }
    Ok((annotations, objects))
}

fn annotation(
    class: AnnotationClass,
    car_from_box: &Isometry3<f64>,
    size_m: [f64; 3],
    track: Option<u32>,
    car_from_sensor_m: &Vector3<f64>,
) -> Annotation {
    let center_m = car_from_box.translation.vector - car_from_sensor_m;
    let sensor_from_box = Isometry3::from_parts(center_m.into(), car_from_box.rotation);
    let bounding_box = Some(upright_box(&sensor_from_box, size_m));
    Annotation { bounding_box, track, ..Annotation::of(class) }
}
