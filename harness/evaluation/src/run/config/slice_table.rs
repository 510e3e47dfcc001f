//! `[slice.NAME]`: slices of the user.

use std::collections::BTreeMap;

use reports::vocabulary::own_slice::{OwnSlice, SliceBounds};
use toml::Value;

/// The table of slices.
pub(super) const SLICES: &str = "slice";

/// Slices of the user, by name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OwnSlices(BTreeMap<OwnSlice, SliceBounds>);

impl OwnSlices {
    /// Those of the table `written`.
    ///
    /// # Errors
    ///
    /// The keys of what is wrong, and the rest of a sentence about it.
    pub(super) fn of_table(written: Option<&Value>) -> Result<Self, (Vec<String>, String)> {
        let Some(written) = written else { return Ok(Self::default()) };
        let Value::Table(written) = written else {
            return Err((vec![SLICES.to_owned()], " is no table: write [slice.NAME]".to_owned()));
        };
        let slice = |(name, value): (&String, &Value)| {
            let wrong = |problem: String| (vec![SLICES.to_owned(), name.clone()], format!(": {problem}"));
            let no_name = || wrong(format!("{name:?} is no name of a slice: use a-z, 0-9 and -"));
            let slice = OwnSlice::named(name).ok_or_else(no_name)?;
            let bounds: SliceBounds = value
                .clone()
                .try_into()
                .map_err(|error: toml::de::Error| wrong(error.message().to_owned()))?;
            match bounds.problem() {
                Some(problem) => Err(wrong(problem)),
                None => Ok((slice, bounds)),
            }
        };
        written.iter().map(slice).collect::<Result<_, _>>().map(Self)
    }

    /// The bounds of the slice `name`, for as long as the program runs.
    ///
    /// # Errors
    ///
    /// A sentence if there is none.
    pub fn bounds_of(&self, name: &str) -> Result<&'static SliceBounds, String> {
        let found = OwnSlice::named(name).and_then(|it| self.0.get(&it));
        let bounds = found.ok_or_else(|| {
            let names: Vec<&str> = self.0.keys().map(|it| it.name()).collect();
            let known = if names.is_empty() { "there are none".to_owned() } else { names.join(", ") };
            format!("there is no slice {name:?}; slices of the configuration: {known}; one is defined by [slice.{name}]")
        })?;
        Ok(Box::leak(Box::new(bounds.clone())))
    }

    /// All, by name.
    pub fn all(&self) -> BTreeMap<String, SliceBounds> {
        self.0.iter().map(|(slice, bounds)| (slice.name().to_owned(), bounds.clone())).collect()
    }
}
