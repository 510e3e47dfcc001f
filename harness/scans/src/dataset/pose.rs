//! Poses as files have them: a translation in metres and a quaternion.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// The pose at `position_m` with the turn of the quaternion x, y, z, w; a quaternion of length 0 is no turn. Fails if a
/// number is not finite.
pub fn isometry(position_m: [f64; 3], quaternion: [f64; 4]) -> Result<Isometry3<f64>, String> {
    if !position_m.iter().chain(&quaternion).all(|it| it.is_finite()) {
        return Err("has a pose with values that are not numbers".to_owned());
    }
    let [i, j, k, w] = quaternion;
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9).unwrap_or_default();
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(position_m)), rotation))
}

/// The pose for a quaternion whose real part comes first.
pub fn pose(position_m: [f64; 3], [w, x, y, z]: [f64; 4]) -> Result<Isometry3<f64>, String> {
    isometry(position_m, [x, y, z, w])
}
