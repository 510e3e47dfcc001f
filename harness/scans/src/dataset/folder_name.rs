//! Names of drives as names of folders.

use std::fmt::Write as _;

/// `name` as the name of a folder that leads nowhere else, and a different one for every name: each byte of a character that
/// is no letter, digit, `-`, `_` or inner dot becomes `%` and two hexadecimal digits; the empty name becomes `%`.
pub fn folder_name(name: &str) -> String {
    if name.is_empty() {
        return "%".to_owned();
    }
    let mut folder = String::with_capacity(name.len());
    for (index, byte) in name.bytes().enumerate() {
        let is_plain =
            byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_') || (byte == b'.' && index > 0);
        if is_plain {
            folder.push(char::from(byte));
        } else {
            let _ = write!(folder, "%{byte:02X}");
        }
    }
    folder
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_lead_nowhere_else() {
        for (name, expected) in [
            ("0000", "0000"),
            ("main-road-1.2", "main-road-1.2"),
            ("../../etc", "%2E.%2F..%2Fetc"),
            ("/etc", "%2Fetc"),
            ("..", "%2E."),
            ("", "%"),
            ("a\\b:c", "a%5Cb%3Ac"),
            ("a/b", "a%2Fb"),
            ("a_b", "a_b"),
            ("a%2Fb", "a%252Fb"),
            ("straße", "stra%C3%9Fe"),
        ] {
            assert_eq!(folder_name(name), expected, "{name}");
        }
    }

    proptest! {
        #[test]
        fn different_names_are_different_folders(one in ".{0,8}", other in ".{0,8}") {
            prop_assert_eq!(one == other, folder_name(&one) == folder_name(&other));
        }
    }
}
