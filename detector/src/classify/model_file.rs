//! A trained model as a file: a head that people can read, and numbers.
//!
//! The file is [`MAGIC`], the length of the head as a `u32`, the head as TOML, the parts one behind the other, and the
//! SHA-256 of all that comes before it. Numbers are little-endian. The head holds the kind of the model, its provenance, the
//! constants that it was trained with, and of each part its name, the names of the values that it looks at, and its length
//! in bytes.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::classify::forest::{DEPTH, DecisionTree, Forest, N_LEAVES, N_SPLITS};
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::trained_file::Provenance;

/// First bytes of every model.
pub const MAGIC: &[u8; 16] = b"scanbench model\n";
/// Version of the format; other versions are refused.
const VERSION: u32 = 1;
/// The part that holds side profiles, as text.
const PROTOTYPES: &str = "prototypes";
const N_CHECKSUM: usize = 32;
/// Bytes of a tree: which value each decision looks at, its threshold, and the leaves.
const N_TREE: usize = N_SPLITS + 4 * N_SPLITS + 4 * N_LEAVES;

/// A model that is being written, or was read.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFile {
    head: Head,
    parts: Vec<Vec<u8>>,
}

/// Content of the head.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    /// Kind of the model.
    model: String,
    version: u32,
    made: Provenance,
    constants: toml::Table,
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    parameters: toml::Table,
    #[serde(default, rename = "part")]
    parts: Vec<PartHead>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartHead {
    name: String,
    values: Vec<String>,
    n_bytes: usize,
}

/// Why there is no model.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelFileError {
    /// Another kind of file.
    #[error("this is no model of scanbench")]
    Magic,
    /// Cut short, or changed.
    #[error("the file is damaged: its checksum is not that of its content")]
    Checksum,
    /// The head is malformed.
    #[error("bad head: {0}")]
    Head(String),
    /// A file of another version of the format.
    #[error("the format has version {found}, but this program reads version {VERSION}")]
    Version {
        /// Version in the file.
        found: u32,
    },
    /// A model of another kind.
    #[error("it is a model of {found:?}, not of {expected:?}")]
    Model {
        /// Kind in the file.
        found: String,
        /// Kind that the program asked for.
        expected: &'static str,
    },
    /// Trained with another constant than the program has.
    #[error("it was trained with {name} = {found}, and the program has {name} = {expected}")]
    Constant {
        /// The constant.
        name: String,
        /// Value in the file.
        found: String,
        /// Value in the program.
        expected: String,
    },
    /// A part is missing.
    #[error("the part {name:?} is missing")]
    MissingPart {
        /// Its name.
        name: &'static str,
    },
    /// A part that looks at other values.
    #[error("{name:?} looks at the values {}, not at {}", .found.join(", "), .expected.join(", "))]
    Values {
        /// The part.
        name: &'static str,
        /// Names of the values in the file.
        found: Vec<String>,
        /// Names of the values in the program.
        expected: Vec<&'static str>,
    },
    /// A part that cannot be read as what its name says.
    #[error("the part {name:?} is damaged")]
    Part {
        /// Its name.
        name: &'static str,
    },
}

impl ModelFile {
    /// A model without parts, with this provenance and the constants of the program.
    pub fn new(model: &str, made: Provenance, constants: toml::Table) -> Self {
        let (model, parameters) = (model.to_owned(), toml::Table::new());
        let head = Head { model, version: VERSION, made, constants, parameters, parts: Vec::new() };
        Self { head, parts: Vec::new() }
    }

    /// Adds the parameters that it was trained with instead of the shipped ones, by their full names.
    pub fn with_parameters(mut self, parameters: toml::Table) -> Self {
        self.head.parameters = parameters;
        self
    }

    /// Adds a forest.
    pub fn with_forest<const D: usize>(
        self,
        name: &'static str,
        values: [&'static str; D],
        forest: &Forest<D>,
    ) -> Self {
        let mut bytes = forest.base().to_le_bytes().to_vec();
        for tree in forest.trees() {
            bytes.extend_from_slice(&tree.value_of_split[..N_SPLITS]);
            bytes.extend(f32_bytes(tree.thresholds[..N_SPLITS].iter().chain(&tree.leaves)));
        }
        self.with_part(name, values.map(str::to_owned).to_vec(), bytes)
    }

    /// Adds side profiles.
    pub fn with_prototypes(self, library: &PrototypeLibrary) -> Self {
        self.with_part(PROTOTYPES, Vec::new(), library.to_toml().into_bytes())
    }

    /// Adds a part of these bytes, which looks at these values.
    pub(crate) fn with_part(mut self, name: &str, values: Vec<String>, bytes: Vec<u8>) -> Self {
        self.head.parts.push(PartHead { name: name.to_owned(), values, n_bytes: bytes.len() });
        self.parts.push(bytes);
        self
    }

    /// The content of the file. The same model gives the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let head = toml::to_string(&self.head).expect("names, numbers and text are TOML");
        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&(head.len() as u32).to_le_bytes());
        bytes.extend_from_slice(head.as_bytes());
        for part in &self.parts {
            bytes.extend_from_slice(part);
        }
        let checksum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&checksum);
        bytes
    }

    /// The model of kind `model` that `bytes` hold, trained with these constants of the program.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if they hold no model, one of another kind or version, one that was trained with other constants,
    /// or a damaged one.
    pub fn from_bytes(
        bytes: &[u8],
        model: &'static str,
        constants: &toml::Table,
    ) -> Result<Self, ModelFileError> {
        let file = Self::of_any_kind(bytes)?;
        if file.head.model != model {
            return Err(ModelFileError::Model { found: file.head.model, expected: model });
        }
        check_constants(&file.head.constants, constants)?;
        Ok(file)
    }

    /// The model that `bytes` hold, of any kind.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if they hold no model, one of another version, or a damaged one.
    pub fn of_any_kind(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let after_magic = bytes.strip_prefix(MAGIC).ok_or(ModelFileError::Magic)?;
        let content = bytes.len().checked_sub(N_CHECKSUM).filter(|&it| it >= MAGIC.len());
        let (content, checksum) = bytes.split_at(content.ok_or(ModelFileError::Checksum)?);
        if Sha256::digest(content).as_slice() != checksum {
            return Err(ModelFileError::Checksum);
        }
        let damaged = || ModelFileError::Head("it is shorter than it says".to_owned());
        let (length, rest) =
            after_magic[..after_magic.len() - N_CHECKSUM].split_first_chunk().ok_or_else(damaged)?;
        let (head, mut rest) =
            rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(damaged)?;
        let syntax = |error: &dyn std::fmt::Display| ModelFileError::Head(error.to_string());
        let head = std::str::from_utf8(head).map_err(|error| syntax(&error))?;
        let head: Head = toml::from_str(head).map_err(|error| syntax(&error.message()))?;
        if head.version != VERSION {
            return Err(ModelFileError::Version { found: head.version });
        }
        let mut parts = Vec::new();
        for part in &head.parts {
            let (bytes, after) = rest.split_at_checked(part.n_bytes).ok_or_else(damaged)?;
            parts.push(bytes.to_vec());
            rest = after;
        }
        Ok(Self { head, parts })
    }

    /// Its provenance.
    pub fn made(&self) -> &Provenance {
        &self.head.made
    }

    /// The constants that it was trained with.
    pub fn constants(&self) -> &toml::Table {
        &self.head.constants
    }

    /// The parameters that it was trained with instead of the shipped ones, by their full names.
    pub fn parameters(&self) -> &toml::Table {
        &self.head.parameters
    }

    /// The forest of this name.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if there is none, it looks at other values, or is damaged.
    pub fn forest<const D: usize>(
        &self,
        name: &'static str,
        values: [&'static str; D],
    ) -> Result<Forest<D>, ModelFileError> {
        forest_of(self.part_of_values(name, &values)?).ok_or(ModelFileError::Part { name })
    }

    /// The side profiles.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if there are none, or they are damaged.
    pub fn prototypes(&self) -> Result<PrototypeLibrary, ModelFileError> {
        let (_, bytes) = self.part(PROTOTYPES)?;
        let library = std::str::from_utf8(bytes).ok().and_then(PrototypeLibrary::from_toml);
        library.ok_or(ModelFileError::Part { name: PROTOTYPES })
    }

    /// The bytes of the part of this name, which have to look at `values`.
    pub(crate) fn part_of_values(
        &self,
        name: &'static str,
        values: &[&'static str],
    ) -> Result<&[u8], ModelFileError> {
        let (head, bytes) = self.part(name)?;
        if head.values != values {
            let found = head.values.clone();
            return Err(ModelFileError::Values { name, found, expected: values.to_vec() });
        }
        Ok(bytes)
    }

    /// Whether there is a part of this name.
    pub fn has_part(&self, name: &str) -> bool {
        self.head.parts.iter().any(|it| it.name == name)
    }

    fn part(&self, name: &'static str) -> Result<(&PartHead, &[u8]), ModelFileError> {
        let mut parts = self.head.parts.iter().zip(&self.parts);
        let found = parts.find(|(head, _)| head.name == name).ok_or(ModelFileError::MissingPart { name })?;
        Ok((found.0, found.1))
    }
}

/// The bytes of numbers.
pub(crate) fn f32_bytes<'a>(numbers: impl Iterator<Item = &'a f32>) -> impl Iterator<Item = u8> {
    numbers.flat_map(|it| it.to_le_bytes())
}

/// The numbers that [`f32_bytes`] wrote; `None` if one is not finite, or cut off.
pub(crate) fn f32_numbers(bytes: &[u8]) -> Option<Vec<f32>> {
    let (numbers, []) = bytes.as_chunks() else { return None };
    let numbers = numbers.iter().map(|it| f32::from_le_bytes(*it));
    numbers.map(|it| Some(it).filter(|it| it.is_finite())).collect()
}

/// Constants that only the model has are not checked: their readers ask for them.
fn check_constants(found: &toml::Table, expected: &toml::Table) -> Result<(), ModelFileError> {
    for (name, value) in expected {
        let in_model = found.get(name);
        if in_model != Some(value) {
            let found = in_model.map_or_else(|| "nothing".to_owned(), ToString::to_string);
            let (name, expected) = (name.clone(), value.to_string());
            return Err(ModelFileError::Constant { name, found, expected });
        }
    }
    Ok(())
}

fn forest_of<const D: usize>(bytes: &[u8]) -> Option<Forest<D>> {
    let (base, trees) = bytes.split_first_chunk::<4>()?;
    let (trees, []) = trees.as_chunks::<N_TREE>() else { return None };
    let tree = |bytes: &[u8; N_TREE]| {
        let (splits, numbers) = bytes.split_at(N_SPLITS);
        let numbers = f32_numbers(numbers)?;
        let (thresholds_of_splits, leaves) = numbers.split_at(N_SPLITS);
        let (mut value_of_split, mut thresholds) = ([0; N_LEAVES], [0.0; N_LEAVES]);
        value_of_split[..N_SPLITS].copy_from_slice(splits);
        thresholds[..N_SPLITS].copy_from_slice(thresholds_of_splits);
        Some(DecisionTree { value_of_split, thresholds, leaves: leaves.try_into().ok()? })
    };
    Forest::new(trees.iter().map(tree).collect::<Option<_>>()?, *f32_numbers(base)?.first()?)
}

const _: () = assert!(N_SPLITS == (1 << DEPTH) - 1);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::prototype_library::tests::library;

    const VALUES: [&str; 2] = ["length_m", "width_m"];
    const MODEL: &str = "chairs";

    fn forest() -> Forest<2> {
        let tree = |first: f32| DecisionTree {
            value_of_split: std::array::from_fn(|it| (it % 2) as u8),
            thresholds: std::array::from_fn(|it| first + it as f32 * 0.1),
            leaves: std::array::from_fn(|it| first - it as f32 / 3.0),
        };
        Forest::new(vec![tree(0.3), tree(-1e-20)], 0.7).unwrap()
    }

    fn constants(cost: f64) -> toml::Table {
        [("cost".to_owned(), cost.into())].into_iter().collect()
    }

    fn model() -> ModelFile {
        let made = Provenance {
            command: "train".to_owned(),
            data: vec!["street".to_owned()],
            seed: 1,
            split: "none".to_owned(),
        };
        let file = ModelFile::new(MODEL, made, constants(0.42)).with_forest("objects", VALUES, &forest());
        file.with_prototypes(&library())
    }

    fn read(bytes: &[u8]) -> Result<ModelFile, ModelFileError> {
        ModelFile::from_bytes(bytes, MODEL, &constants(0.42))
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        let bytes = model().to_bytes();
        let file = read(&bytes).unwrap();
        assert_eq!(file, model());
        assert_eq!(file.forest("objects", VALUES), Ok(forest()));
        assert_eq!(file.prototypes(), Ok(library()));
        assert_eq!(file.to_bytes(), bytes);
        // People find the provenance in it.
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("command = \"train\"") && text.contains("cost = 0.42"), "{text}");
    }

    #[test]
    fn shipped_profiles_are_written_as_they_were_read() {
        let file = ModelFile::of_any_kind(include_bytes!("../params/clusters.model")).unwrap();
        let (_, text) = file.part(PROTOTYPES).unwrap();
        assert_eq!(file.prototypes().unwrap().to_toml().as_bytes(), text);
    }

    #[test]
    fn other_and_damaged_files_are_refused() {
        let bytes = model().to_bytes();
        assert_eq!(read(b"format = 1"), Err(ModelFileError::Magic));
        assert_eq!(read(MAGIC), Err(ModelFileError::Checksum));
        assert_eq!(read(&bytes[..bytes.len() - 1]), Err(ModelFileError::Checksum));
        for index in (MAGIC.len()..bytes.len()).step_by(97) {
            let mut changed = bytes.clone();
            changed[index] ^= 4;
            assert_eq!(read(&changed), Err(ModelFileError::Checksum), "byte {index}");
        }
        let message = |result: Result<ModelFile, ModelFileError>| result.unwrap_err().to_string();
        assert_eq!(
            message(ModelFile::from_bytes(&bytes, "tables", &constants(0.42))),
            "it is a model of \"chairs\", not of \"tables\""
        );
        assert_eq!(
            message(ModelFile::from_bytes(&bytes, MODEL, &constants(0.5))),
            "it was trained with cost = 0.42, and the program has cost = 0.5"
        );
    }

    /// The file of the model with a changed head, and with the checksum of that.
    fn with_head(change: impl FnOnce(&mut Head)) -> Vec<u8> {
        let mut model = model();
        change(&mut model.head);
        model.to_bytes()
    }

    #[test]
    fn a_head_that_does_not_go_with_the_parts_is_refused() {
        assert_eq!(read(&with_head(|it| it.version = 9)), Err(ModelFileError::Version { found: 9 }));
        let longer = read(&with_head(|it| it.parts[1].n_bytes += 1));
        assert!(matches!(longer, Err(ModelFileError::Head(_))), "{longer:?}");
        let shorter = read(&with_head(|it| it.parts[0].n_bytes -= 1)).unwrap();
        assert_eq!(shorter.forest("objects", VALUES), Err(ModelFileError::Part { name: "objects" }));
        let renamed = read(&with_head(|it| it.parts[0].name = "others".to_owned())).unwrap();
        assert_eq!(renamed.forest("objects", VALUES), Err(ModelFileError::MissingPart { name: "objects" }));
        let error = model().forest("objects", ["length_m", "height_m"]).unwrap_err().to_string();
        assert_eq!(error, "\"objects\" looks at the values length_m, width_m, not at length_m, height_m");
        assert_eq!(
            model()
                .forest::<1>("objects", ["length_m"])
                .map_err(|it| matches!(it, ModelFileError::Values { .. })),
            Err(true)
        );
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let mut file = model();
        // The base is not finite; then a decision looks at a value that does not exist.
        file.parts[0][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(file.forest("objects", VALUES), Err(ModelFileError::Part { name: "objects" }));
        let mut file = model();
        file.parts[0][4] = 2;
        assert_eq!(file.forest("objects", VALUES), Err(ModelFileError::Part { name: "objects" }));
    }
}
