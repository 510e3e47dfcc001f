//! The side profiles of known vehicles as text, which is a part of a model's file.

use std::fmt::Write as _;

use serde::Deserialize;

use super::prototype_library::{Prototype, PrototypeLibrary};
use super::trained_file::Provenance;

/// Name of the format in the text.
const FORMAT: &str = "scanbench side profiles";
/// Version of the format; other versions are refused.
const VERSION: i64 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: i64,
    n_prototypes: usize,
    column_m: f32,
    made: Provenance,
    prototype: Vec<Prototype>,
}

impl PrototypeLibrary {
    /// A library from the text that [`Self::to_toml`] gives; `None` if it is no library, or one of another version, or
    /// damaged.
    pub fn from_toml(text: &str) -> Option<Self> {
        let file: File = toml::from_str(text).ok()?;
        let is_whole = (file.format.as_str(), file.version, file.n_prototypes)
            == (FORMAT, VERSION, file.prototype.len());
        is_whole.then(|| Self::new(file.made, file.column_m, file.prototype).ok())?
    }

    /// The library as text. Numbers are written so that they come back to the bit.
    pub fn to_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let (n_prototypes, column_m) = (self.prototypes().len(), self.column_m());
        let made = toml::to_string(self.made()).expect("text and a number are TOML");
        let mut text = format!(
            "format = {}\nversion = {VERSION}\nn_prototypes = {n_prototypes}\ncolumn_m = {column_m:?}\n\n[made]\n{made}",
            quoted(FORMAT),
        );
        for Prototype { name, contour_m } in self.prototypes() {
            // Writing to a string cannot fail.
            let _ = write!(text, "\n[[prototype]]\nname = {}\ncontour_m = {contour_m:?}\n", quoted(name));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::prototype_library::tests::library;

    #[test]
    fn a_library_comes_back_from_its_text_to_the_bit() {
        assert_eq!(PrototypeLibrary::from_toml(&library().to_toml()), Some(library()));
    }

    #[test]
    fn what_is_no_library_is_refused() {
        let text = library().to_toml();
        for (from, to) in [
            ("side profiles", "recipe"),
            ("version = 1", "version = 3"),
            ("n_prototypes = 2", "n_prototypes = 3"),
            ("column_m = 0.2", "column_m = 0.0"),
            ("[2.0, 1.0]", "[2.0, nan]"),
            ("contour_m", "contour"),
        ] {
            assert!(text.contains(from), "{text}");
            assert_eq!(PrototypeLibrary::from_toml(&text.replacen(from, to, 1)), None, "{to}");
        }
    }
}
