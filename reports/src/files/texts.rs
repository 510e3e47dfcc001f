//! Checks of texts in tests.

/// Checks that `text` contains all `parts`.
#[track_caller]
pub(crate) fn check_holds(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no {part} in {text}");
    }
}
