//! The side profiles of known vehicles as a file.

use std::fmt::Write as _;

use serde::Deserialize;

use super::prototype_library::{Prototype, PrototypeLibrary, PrototypeLibraryError};
use super::trained_file::{AtLine, Provenance, TrainedFileError, head_and_provenance, line_of, read_file};

/// What the file calls itself.
const FORMAT: &str = "scanbench side profiles";
/// Of the format; other versions are refused.
const VERSION: i64 = 1;

/// Why a file is no library.
#[derive(Debug, thiserror::Error)]
pub enum PrototypeFileError {
    /// Not TOML, or not a library.
    #[error(transparent)]
    File(#[from] TrainedFileError),
    /// A file with prototypes missing.
    #[error("the file has {found} prototypes but announces {announced}")]
    Count {
        /// How many there are.
        found: usize,
        /// How many there should be.
        announced: usize,
    },
    /// Prototypes that cannot be used.
    #[error(transparent)]
    Library(#[from] PrototypeLibraryError),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    n_prototypes: usize,
    column_m: f32,
    made: Provenance,
    prototype: Vec<Prototype>,
}

impl PrototypeLibrary {
    /// The embedded library of drawn silhouettes, which `examples/drawn_vehicles.rs` writes.
    pub fn drawn() -> Self {
        Self::from_toml(include_str!("drawn_vehicles.toml")).expect("the embedded file is tested")
    }

    /// A library from the text that [`Self::to_toml`] gives.
    ///
    /// # Errors
    ///
    /// [`PrototypeFileError`] with its line if the text is no library, or one of another version, or damaged.
    pub fn from_toml(text: &str) -> Result<Self, AtLine<PrototypeFileError>> {
        let file: File = read_file(text, FORMAT, VERSION)
            .map_err(|it| AtLine { line: it.line, problem: PrototypeFileError::File(it.problem) })?;
        let (found, announced) = (file.prototype.len(), file.n_prototypes);
        if found != announced {
            let problem = PrototypeFileError::Count { found, announced };
            return Err(AtLine { line: line_of(text, &["n_prototypes"], None), problem });
        }
        Self::new(file.made, file.column_m, file.prototype).map_err(|error| {
            let line = match error {
                PrototypeLibraryError::Column { .. } => line_of(text, &["column_m"], None),
                PrototypeLibraryError::Empty => line_of(text, &["n_prototypes"], None),
                PrototypeLibraryError::Contour { prototype_idx, .. } => {
                    line_of(text, &["prototype"], Some(prototype_idx))
                }
            };
            AtLine { line, problem: error.into() }
        })
    }

    /// The library as text. Numbers are written so that they come back to the bit.
    pub fn to_toml(&self) -> String {
        let values = [
            ("n_prototypes", self.prototypes().len().to_string()),
            ("column_m", format!("{:?}", self.column_m())),
        ];
        let mut text = head_and_provenance((FORMAT, VERSION), &values, self.made());
        for prototype in self.prototypes() {
            let name = toml::Value::from(prototype.name.as_str());
            // Writing to a string cannot fail.
            let _ = writeln!(text, "\n[[prototype]]\nname = {name}");
            let _ = writeln!(text, "contour_m = {:?}", prototype.contour_m);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::prototype_library::Facing;
    use crate::describe::prototype_library::tests::library;

    #[test]
    fn a_library_comes_back_from_its_file_to_the_bit() {
        assert_eq!(PrototypeLibrary::from_toml(&library().to_toml()).unwrap(), library());
    }

    #[test]
    fn the_drawn_vehicles_are_written_as_they_are_in_the_repository() {
        assert_eq!(PrototypeLibrary::drawn().to_toml(), include_str!("drawn_vehicles.toml"));
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let text = library().to_toml();
        assert!(text.contains(from), "{text}");
        let error = PrototypeLibrary::from_toml(&text.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }

    #[test]
    fn what_is_no_library_says_where_and_why() {
        check_refused("side profiles", "recipe", "line 1: the format is \"scanbench recipe\"");
        check_refused(
            "version = 1",
            "version = 3",
            "line 2: the format has version 3, but this program reads version 1",
        );
        check_refused(
            "n_prototypes = 2",
            "n_prototypes = 3",
            "line 3: the file has 2 prototypes but announces 3",
        );
        check_refused("column_m = 0.2", "column_m = 0.0", "line 4: column_m = 0 is not within");
        check_refused("[2.0, 1.0]", "[2.0, nan]", "line 12: the contour of prototype 0, \"box\"");
        check_refused("contour_m", "contour", "line 14: unknown field `contour`");
    }

    #[test]
    fn every_drawn_vehicle_is_most_like_itself_either_way() {
        let drawn = PrototypeLibrary::drawn();
        for (prototype_idx, prototype) in drawn.prototypes().iter().enumerate() {
            let nearest = drawn.nearest(&prototype.contour_m).unwrap();
            let mirrored: Vec<[f32; 2]> =
                prototype.contour_m.iter().map(|&[along, up]| [-along, up]).collect();
            for (nearest, facing) in
                [(nearest, Facing::Forward), (drawn.nearest(&mirrored).unwrap(), Facing::Backward)]
            {
                assert_eq!(
                    (nearest.prototype_idx, nearest.facing),
                    (prototype_idx, facing),
                    "{}",
                    prototype.name
                );
            }
        }
    }
}
