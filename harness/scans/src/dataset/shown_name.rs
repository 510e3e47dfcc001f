//! Names that come from files, as they are shown.
//!
//! A name that ends up in results (a data set, a drive, a sensor) is refused if it holds a control character. Whatever else
//! a file says is shown with control characters escaped.

use std::borrow::Cow;

/// `text` with its control characters as `\n` or `\u{1b}`.
pub fn shown(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_printable) {
        return Cow::Borrowed(text);
    }
    let escape = |it: char| {
        if is_printable(it) { it.to_string() } else { it.escape_default().to_string() }
    };
    Cow::Owned(text.chars().map(escape).collect())
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

    proptest! {
        #[test]
        fn what_is_shown_is_printable(text in "(?s).{0,30}") {
            prop_assert!(shown(&text).chars().all(is_printable));
        }
    }
}
