//! Class that a detector from elsewhere gives an object.

use detector::GivenClass;
use reports::vocabulary::class::AnnotationClass;

use reports::vocabulary::taxonomy::plain_name;

/// Words that say less than a class: a group, or nothing.
const GENERAL_WORDS: [&str; 5] = ["vehicle", "vehicles", "object", "objects", "misc"];

/// Class that a detector from elsewhere gives an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForeignClass {
    /// The class, or for a general word one that counts alike: *car* for a vehicle, *misc* for another object.
    pub class: AnnotationClass,
    /// The class in the word of the detector; `None` for a general word.
    pub given: Option<GivenClass>,
}

impl ForeignClass {
    /// `class`, which the detector calls `word`.
    pub fn of(word: &str, class: AnnotationClass) -> Self {
        let is_general = GENERAL_WORDS.contains(&plain_name(word).as_str());
        Self { class, given: (!is_general).then(|| GivenClass::new(class.name(), word)) }
    }
}

impl From<AnnotationClass> for ForeignClass {
    fn from(class: AnnotationClass) -> Self {
        Self::of(class.name(), class)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_kept_unless_it_says_less_than_a_class() {
        let given = |word: &str, class| ForeignClass::of(word, class).given.map(|it| [it.name(), it.word()]);
        assert_eq!(given("REGULAR_VEHICLE", AnnotationClass::Car), Some(["car", "REGULAR_VEHICLE"]));
        assert_eq!(given("animal", AnnotationClass::Misc), Some(["misc", "animal"]));
        assert_eq!(given("Vehicle", AnnotationClass::Car), None);
        assert_eq!(given("object", AnnotationClass::Misc), None);
    }
}
