//! Paths of the catalogue with environment variables and `~` in them.

use std::ffi::OsString;
use std::path::PathBuf;

/// A path whose variables are not yet replaced by their values.
///
/// `${NAME}` stands for the value of the variable, `${NAME:-default}` for the default if it has none or is empty, and a
/// leading `~` for the home folder. `$` has no other meaning, and defaults hold no variables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RootTemplate {
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Text(String),
    Variable { name: String, default: Option<String> },
}

/// A variable that has no value and no default.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnsetVariable(pub String);

impl RootTemplate {
    /// Reads a template.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.is_empty() {
            return Err("an empty path".to_owned());
        }
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once("${") {
            let (inside, behind) =
                after.split_once('}').ok_or_else(|| format!("{text:?} has a \"${{\" without \"}}\""))?;
            let (name, default) = match inside.split_once(":-") {
                Some((name, default)) => (name, Some(default.to_owned())),
                None => (inside, None),
            };
            if !is_variable_name(name) {
                return Err(format!("{name:?} cannot be the name of an environment variable"));
            }
            pieces.push(Piece::Text(before.to_owned()));
            pieces.push(Piece::Variable { name: name.to_owned(), default });
            rest = behind;
        }
        pieces.push(Piece::Text(rest.to_owned()));
        Ok(Self { pieces })
    }

    /// The path, with the values of variables from `environment`.
    pub fn expand(&self, environment: impl Fn(&str) -> Option<OsString>) -> Result<PathBuf, UnsetVariable> {
        let value_of = |name: &str| environment(name).filter(|value| !value.is_empty());
        let mut path = OsString::new();
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => path.push(text),
                Piece::Variable { name, default } => {
                    let value = value_of(name).or_else(|| default.as_ref().map(OsString::from));
                    path.push(value.ok_or_else(|| UnsetVariable(name.clone()))?);
                }
            }
        }
        let path = PathBuf::from(path);
        match path.strip_prefix("~") {
            Ok(below_home) => {
                let home = value_of("HOME").ok_or_else(|| UnsetVariable("HOME".to_owned()))?;
                Ok(PathBuf::from(home).join(below_home))
            }
            Err(_) => Ok(path),
        }
    }

    /// The first variable in it, by which the user can tell where the data are.
    pub fn variable(&self) -> Option<&str> {
        self.pieces.iter().find_map(|piece| match piece {
            Piece::Variable { name, .. } => Some(name.as_str()),
            Piece::Text(_) => None,
        })
    }
}

fn is_variable_name(name: &str) -> bool {
    !name.is_empty()
        && !name.starts_with(|first: char| first.is_ascii_digit())
        && name.chars().all(|it| it.is_ascii_alphanumeric() || it == '_')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn environment(name: &str) -> Option<OsString> {
        match name {
            "HOME" => Some("/home/ada".into()),
            "DATA" => Some("/data".into()),
            "EMPTY" => Some("".into()),
            _ => None,
        }
    }

    #[track_caller]
    fn check(template: &str, expected: Result<&str, &str>) {
        let path = RootTemplate::parse(template).unwrap().expand(environment);
        assert_eq!(path, expected.map(PathBuf::from).map_err(|name| UnsetVariable(name.to_owned())));
    }

    #[test]
    fn variables_and_home_are_replaced() {
        check("kitti", Ok("kitti"));
        check("${DATA}/kitti", Ok("/data/kitti"));
        check("a/${DATA}b${DATA}", Ok("a//datab/data"));
        check("~/kitti", Ok("/home/ada/kitti"));
        check("~", Ok("/home/ada"));
        check("~bob/kitti", Ok("~bob/kitti"));
        check("cost$", Ok("cost$"));
    }

    #[test]
    fn defaults_stand_in_for_unset_and_empty_variables() {
        check("${DATA:-/other}/kitti", Ok("/data/kitti"));
        check("${UNSET:-/other}/kitti", Ok("/other/kitti"));
        check("${EMPTY:-~/data}/kitti", Ok("/home/ada/data/kitti"));
    }

    #[test]
    fn a_variable_without_value_is_named() {
        check("${UNSET}/kitti", Err("UNSET"));
        check("${EMPTY}/kitti", Err("EMPTY"));
    }

    #[test]
    fn malformed_templates_are_refused() {
        for template in ["", "${DATA", "${}", "${1A}", "${A B}", "${:-x}"] {
            assert!(RootTemplate::parse(template).is_err(), "{template}");
        }
    }

    proptest! {
        #[test]
        fn any_text_gives_a_template_or_an_error(text in "(\\PC|[$~]|\\$\\{|:-|\\}|/){0,30}") {
            let _ = RootTemplate::parse(&text).map(|template| template.expand(environment));
        }
    }
}
