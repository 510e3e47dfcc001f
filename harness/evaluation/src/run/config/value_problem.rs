//! Problems with the values of resolved parameters.

use detector::params::ParamsError;
use toml::de::DeTable;

/// A parameter and the problem with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ValueProblem {
    /// The parameter with its tables, from the outermost in.
    pub(super) keys: Vec<String>,
    /// The problem, as a continuation of its name.
    pub(super) problem: String,
}

impl ValueProblem {
    /// The problem of `error` in the resolved `document`, which holds the parameters of the table `parent`, or of several
    /// tables if that is `None`.
    pub(super) fn new(error: &ParamsError, parent: Option<&str>, document: &str) -> Self {
        let (names, problem) = match error {
            ParamsError::OutOfRange { name, value, allowed } => {
                let names = name.split('.').map(str::to_owned).collect();
                (names, format!(" = {value} is not within {allowed}"))
            }
            ParamsError::TooLow { name, value, least } => {
                let names = name.split('.').map(str::to_owned).collect();
                (names, format!(" = {value} is less than {least}"))
            }
            ParamsError::Syntax(error) => {
                let offset = error.span().map_or(0, |span| span.start);
                let parsed = DeTable::parse(document).expect("the document was written from values");
                let names = key_at(parsed.get_ref(), offset).unwrap_or_default();
                (names, format!(": {}", error.message()))
            }
        };
        let mut keys: Vec<String> = parent.map(str::to_owned).into_iter().collect();
        keys.extend(names);
        Self { keys, problem }
    }
}

/// Names of the value at this position of the document of `table`, from the outermost table in.
fn key_at(table: &DeTable<'_>, byte_offset: usize) -> Option<Vec<String>> {
    table.iter().find_map(|(key, value)| {
        let mut keys = vec![key.get_ref().to_string()];
        match value.get_ref().as_table() {
            Some(inner) => keys.extend(key_at(inner, byte_offset)?),
            None if value.span().contains(&byte_offset) => {}
            None => return None,
        }
        Some(keys)
    })
}
