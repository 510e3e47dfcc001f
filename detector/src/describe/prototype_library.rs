//! The side profiles of known vehicles, and which of them an object is most like.

use serde::Deserialize;

use super::trained_file::Provenance;
use super::turning_function::TurningFunction;
use crate::portable_math::single;

/// The profile of one vehicle, front forward.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prototype {
    /// Name of the vehicle.
    pub name: String,
    /// Its concave contour: corners (along, up) in metres, with the front at the greater end.
    pub contour_m: Vec<[f32; 2]>,
}

/// Prototypes that profiles are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct PrototypeLibrary {
    // Invariant: `functions` has the turning functions of each prototype, facing forward and backward.
    made: Provenance,
    column_m: f32,
    prototypes: Vec<Prototype>,
    functions: Vec<[TurningFunction; 2]>,
}

/// Direction in which a profile faces along the axis of its box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facing {
    /// The front is at the greater end.
    Forward,
    /// The front is at the smaller end.
    Backward,
}

/// The prototype that an object is most like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPrototype {
    /// Its index in the library.
    pub prototype_idx: usize,
    /// Direction of the object if it is like this prototype.
    pub facing: Facing,
    /// Difference of the contours in 0 to 1.
    pub difference: f32,
}

/// Why there is no library.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum PrototypeLibraryError {
    /// Columns that no profile can be made of.
    #[error("column_m = {column_m} is not within 0.02 to 2 m")]
    Column {
        /// The width.
        column_m: f32,
    },
    /// No prototype to compare with.
    #[error("there is no prototype")]
    Empty,
    /// A prototype that is no outline.
    #[error("the contour of prototype {prototype_idx}, {name:?}, is not a simple closed curve")]
    Contour {
        /// Its index.
        prototype_idx: usize,
        /// Its name.
        name: String,
    },
}

impl PrototypeLibrary {
    /// A library of `prototypes`, whose contours are in columns of `column_m`.
    ///
    /// # Errors
    ///
    /// [`PrototypeLibraryError`] if there is none, or one whose contour has no turning function, or no such columns.
    pub fn new(
        made: Provenance,
        column_m: f32,
        prototypes: Vec<Prototype>,
    ) -> Result<Self, PrototypeLibraryError> {
        if !(0.02..=2.0).contains(&column_m) {
            return Err(PrototypeLibraryError::Column { column_m });
        }
        if prototypes.is_empty() {
            return Err(PrototypeLibraryError::Empty);
        }
        let facings = |(prototype_idx, prototype): (usize, &Prototype)| {
            let mirrored: Vec<[f32; 2]> =
                prototype.contour_m.iter().map(|&[along, up]| [-along, up]).collect();
            TurningFunction::of(&prototype.contour_m)
                .zip(TurningFunction::of(&mirrored))
                .map(|(forward, backward)| [forward, backward])
                .ok_or_else(|| PrototypeLibraryError::Contour { prototype_idx, name: prototype.name.clone() })
        };
        let functions = prototypes.iter().enumerate().map(facings).collect::<Result<_, _>>()?;
        Ok(Self { made, column_m, prototypes, functions })
    }

    /// Its provenance.
    pub fn made(&self) -> &Provenance {
        &self.made
    }

    /// Greatest width of a column of the contours, in metres: contours that are compared with them need the same.
    pub fn column_m(&self) -> f32 {
        self.column_m
    }

    /// The prototypes.
    pub fn prototypes(&self) -> &[Prototype] {
        &self.prototypes
    }

    /// The prototype that `contour_m` (corners along, up in metres) differs least from, facing either way; the first of
    /// equally near ones. `None` if the contour has no turning function, or differs from all as far as can be.
    ///
    /// Paper: VM sections 4 and 5.
    #[inline(always)]
    pub fn nearest(&self, contour_m: &[[f32; 2]]) -> Option<NearestPrototype> {
        let function = TurningFunction::of(contour_m)?;
        let mut nearest: Option<NearestPrototype> = None;
        for (prototype_idx, facings) in self.functions.iter().enumerate() {
            for (prototype, facing) in facings.iter().zip([Facing::Forward, Facing::Backward]) {
                let bound = nearest.map_or(1.0, |it| it.difference);
                if let Some(difference) = function.distance_below(prototype, bound) {
                    nearest = Some(NearestPrototype { prototype_idx, facing, difference });
                }
            }
        }
        nearest
    }

    /// The contour of `nearest`, facing as it does, moved and scaled so that it is as long as `contour_m` and begins
    /// and stands where that does.
    pub fn placed(&self, nearest: &NearestPrototype, contour_m: &[[f32; 2]]) -> Vec<[f32; 2]> {
        let mut prototype_m = self.prototypes[nearest.prototype_idx].contour_m.clone();
        if nearest.facing == Facing::Backward {
            for corner in &mut prototype_m {
                corner[0] = -corner[0];
            }
        }
        let scale = perimeter_m(contour_m) / perimeter_m(&prototype_m);
        let (from, to) = (least(&prototype_m), least(contour_m));
        prototype_m.iter().map(|it| [0, 1].map(|axis| to[axis] + scale * (it[axis] - from[axis]))).collect()
    }
}

fn perimeter_m(contour_m: &[[f32; 2]]) -> f32 {
    let closed = contour_m.iter().zip(contour_m.iter().cycle().skip(1));
    closed.map(|(a, b)| single::hypot(b[0] - a[0], b[1] - a[1])).sum()
}

fn least(contour_m: &[[f32; 2]]) -> [f32; 2] {
    [0, 1].map(|axis| contour_m.iter().map(|it| it[axis]).fold(f32::INFINITY, f32::min))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A box and a wedge.
    pub(crate) fn library() -> PrototypeLibrary {
        let prototype = |name: &str, contour_m: &[[f32; 2]]| Prototype {
            name: name.to_owned(),
            contour_m: contour_m.to_vec(),
        };
        let prototypes = vec![
            prototype("box", &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]),
            prototype("wedge", &WEDGE),
        ];
        PrototypeLibrary::new(Provenance::default(), 0.2, prototypes).unwrap()
    }

    const WEDGE: [[f32; 2]; 4] = [[0.0, 0.0], [3.0, 0.0], [3.0, 0.3], [0.0, 1.0]];

    #[test]
    fn a_mirrored_wedge_is_a_wedge_that_looks_back() {
        let library = library();
        let forward = library.nearest(&WEDGE).unwrap();
        assert_eq!((forward.prototype_idx, forward.facing), (1, Facing::Forward));
        assert_eq!(forward.difference, 0.0);
        let mirrored = WEDGE.map(|[along, up]| [7.0 - 2.0 * along, 2.0 * up - 1.0]);
        let backward = library.nearest(&mirrored).unwrap();
        assert_eq!((backward.prototype_idx, backward.facing), (1, Facing::Backward));
        assert!(backward.difference < 1e-3);
        let placed = library.placed(&backward, &mirrored);
        for (corner, wanted) in placed.iter().zip(mirrored) {
            assert!((0..2).all(|axis| (corner[axis] - wanted[axis]).abs() < 1e-4), "{corner:?} {wanted:?}");
        }
    }

    #[test]
    fn what_has_no_area_is_like_nothing() {
        assert_eq!(library().nearest(&[[0.0, 0.0], [1.0, 0.0]]), None);
    }
}
