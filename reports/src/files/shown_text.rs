//! Text from files and programs, as it is shown.
//!
//! A name that ends up in results (a data set, a drive, a sensor) is refused if it holds a control character. All other text
//! of a file or a program is shown with control characters escaped, and cut if it is too long.

use std::borrow::Cow;
use std::fmt::Write as _;

use serde::de::Error as _;
use serde::{Deserialize as _, Deserializer};

/// Number of characters of a text that are shown.
const MOST_SHOWN_CHARS: usize = 2000;
/// Number of characters of a message that are shown; it may quote several texts.
const MOST_SAID_CHARS: usize = 20_000;

/// `text` with its control characters as `\n` or `\u{1b}`, cut after two thousand characters.
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(text, is_printable, MOST_SHOWN_CHARS)
}

/// As [`shown`] for a text of several lines: line breaks and tabs stay, and it is cut after twenty thousand characters.
pub fn shown_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |it| it == '\n' || it == '\t' || is_printable(it), MOST_SAID_CHARS)
}

/// As [`shown_lines`], but never cut.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |it| it == '\n' || it == '\t' || is_printable(it), usize::MAX)
}

fn escaped(text: &str, stays: impl Fn(char) -> bool, n_most_chars: usize) -> Cow<'_, str> {
    let (kept, cut) = match text.char_indices().nth(n_most_chars) {
        Some((end, _)) => text.split_at(end),
        None => (text, ""),
    };
    if cut.is_empty() && kept.chars().all(&stays) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(kept.len());
    for it in kept.chars() {
        if stays(it) {
            shown.push(it);
        } else {
            shown.extend(it.escape_default());
        }
    }
    if !cut.is_empty() {
        write!(shown, "… ({} more characters)", cut.chars().count()).expect("a string takes all text");
    }
    Cow::Owned(shown)
}

/// Reads the name of a data set, a drive or a detector, which must have no control character.
///
/// # Errors
///
/// If the name has one; the error shows it.
pub(crate) fn printable_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let name = String::deserialize(deserializer)?;
    if name.chars().all(is_printable) {
        return Ok(name);
    }
    Err(D::Error::custom(format!("the name \"{}\" has a control character", shown(&name))))
}

/// Whether a terminal or a page shows `character` as it is: it is no control character, ends no line, and does not turn the
/// direction of text.
pub fn is_printable(character: char) -> bool {
    let ends_a_line = matches!(character, '\u{2028}' | '\u{2029}');
    let turns_direction = matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !(character.is_control() || ends_a_line || turns_direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_a_terminal_would_obey_is_escaped() {
        assert_eq!(shown("straße 7/a"), "straße 7/a");
        assert_eq!(shown("a\u{1b}[31mb\n\u{202e}c\u{7f}"), "a\\u{1b}[31mb\\n\\u{202e}c\\u{7f}");
    }

    #[test]
    fn lines_stay_where_there_may_be_some_and_the_end_of_long_texts_goes() {
        assert_eq!(shown_lines("a\n\tb\u{1b}]0;c\u{7}\r"), "a\n\tb\\u{1b}]0;c\\u{7}\\r");
        let long = "ä".repeat(MOST_SHOWN_CHARS);
        assert_eq!(shown(&long), long);
        assert_eq!(shown(&format!("{long}bc")), format!("{long}… (2 more characters)"));
    }

    proptest! {
        #[test]
        fn what_is_shown_is_printable(text in "(?s).{0,30}") {
            prop_assert!(shown(&text).chars().all(is_printable));
        }
    }
}
