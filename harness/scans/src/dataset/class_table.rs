//! Classes of the names in labels, by the user and by what is known, and the unknown names.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use reports::run_folder::command_line::shell_word;
use reports::vocabulary::class::AnnotationClass;

use super::{AnnotatedClasses, DatasetError};
use reports::vocabulary::taxonomy::{class_named, likeliest_class, plain_name};

/// At most this many names are listed.
const MAX_LISTED: usize = 50;

/// The classes that the user gave to names in labels, which override all others.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ClassTable {
    // By the name in one spelling: the name as written, and its class.
    by_name: BTreeMap<String, (String, AnnotationClass)>,
}

impl ClassTable {
    /// Lets `name`, in any spelling, stand for `class`.
    pub fn insert(&mut self, name: &str, class: AnnotationClass) {
        self.by_name.insert(plain_name(name), (name.to_owned(), class));
    }

    /// This table, extended by the names that only `other` has.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        let mut both = other.clone();
        both.by_name.extend(self.by_name.clone());
        both
    }

    /// The class of `name`, if the user gave it one.
    pub fn get(&self, name: &str) -> Option<AnnotationClass> {
        self.by_name.get(&plain_name(name)).map(|(_, class)| *class)
    }

    /// The class that a detector calls `word`: by this table, or by the names that are known. `object` is none of them.
    ///
    /// # Errors
    ///
    /// A sentence with the lines that would make the word known.
    pub fn class_of_detection(&self, word: &str) -> Result<AnnotationClass, String> {
        if plain_name(word) == "object" {
            return Ok(AnnotationClass::Misc);
        }
        self.get(word).or_else(|| class_named(word)).ok_or_else(|| {
            let (key, likeliest) = (serde_json::Value::from(word), likeliest_class(word).name());
            let own = plain_name(word);
            format!(
                "{word:?} is not a class; classes are {}; give it one in scanbench.toml, with the line\n  {key} = \"{likeliest}\"\n\
                 under [classes], or as a class of your own, with\n  [class.{own}]",
                all_classes()
            )
        })
    }

    /// The names as they were written, each with its class.
    pub fn written(&self) -> BTreeMap<String, AnnotationClass> {
        self.by_name.values().cloned().collect()
    }
}

/// The class that a user calls `word`. Errors list the classes.
pub fn class_of_word(word: &str) -> Result<AnnotationClass, String> {
    class_named(word).ok_or_else(|| format!("{word:?} is not a class; classes are {}", all_classes()))
}

/// The names of our classes, separated by commas.
pub(super) fn all_classes() -> String {
    AnnotationClass::ALL.map(AnnotationClass::name).join(", ")
}

/// Handling of unknown names.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum UnknownNames {
    /// They are errors, all at once.
    #[default]
    Refuse,
    /// They are *misc*, where classes do not matter.
    TakeAsMisc,
}

/// How a reader makes classes of names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassRules {
    /// The table of the user.
    pub table: ClassTable,
    /// Handling of unknown names.
    pub unknown: UnknownNames,
    /// The classes that are labelled according to the catalogue.
    pub catalogued: AnnotatedClasses,
}

impl Default for ClassRules {
    fn default() -> Self {
        let catalogued = AnnotatedClasses::EveryObject;
        Self { table: ClassTable::default(), unknown: UnknownNames::default(), catalogued }
    }
}

/// Rules for work without classes: no name is refused.
pub fn whatever_classes() -> ClassRules {
    ClassRules { unknown: UnknownNames::TakeAsMisc, ..ClassRules::default() }
}

/// Names of a format that mean another class than the plain word.
pub type Vocabulary = [(&'static str, AnnotationClass)];

impl ClassRules {
    /// The class of `name`: first by the user's table, then by the format, then by the names that are known for all formats.
    pub fn class_of(&self, name: &str, vocabulary: &Vocabulary) -> Option<AnnotationClass> {
        let plain = plain_name(name);
        let of_format = || vocabulary.iter().find(|(it, _)| plain_name(it) == plain).map(|(_, class)| *class);
        let known = self.table.get(name).or_else(of_format).or_else(|| class_named(name));
        known.or_else(|| (self.unknown == UnknownNames::TakeAsMisc).then_some(AnnotationClass::Misc))
    }
}

/// Makes classes of the names in labels, and keeps the unknown names.
#[derive(Debug, Clone)]
pub struct ClassReader<'a> {
    rules: &'a ClassRules,
    vocabulary: &'a Vocabulary,
    unknown: UnknownClasses,
}

impl<'a> ClassReader<'a> {
    /// A reader of labels in a format with this vocabulary.
    pub fn new(rules: &'a ClassRules, vocabulary: &'a Vocabulary) -> Self {
        Self { rules, vocabulary, unknown: UnknownClasses::default() }
    }

    /// The class of `name`, which stands at `position`; `None` if the name is unknown, which is noted.
    pub fn class_of(&mut self, name: &str, position: impl FnOnce() -> String) -> Option<AnnotationClass> {
        let class = self.rules.class_of(name, self.vocabulary);
        if class.is_none() {
            self.unknown.add(name, position);
        }
        class
    }

    /// Whether `class` is not labelled according to the catalogue.
    pub fn contradicts_catalogue(&self, class: AnnotationClass) -> bool {
        matches!(&self.rules.catalogued, AnnotatedClasses::Only(classes) if !classes.contains(&class))
    }

    /// Whether the user gave any name a class.
    pub fn has_own_classes(&self) -> bool {
        !self.rules.table.by_name.is_empty()
    }

    /// The class that the user gave to `name`, whatever it stands for otherwise.
    pub fn own_class_of(&self, name: &str) -> Option<AnnotationClass> {
        self.rules.table.get(name)
    }

    /// The unknown names so far.
    pub fn unknown(&self) -> &UnknownClasses {
        &self.unknown
    }
}

/// Unknown names, with the number of times and the first place that each was met.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UnknownClasses {
    by_name: BTreeMap<String, Unknown>,
    n_others: u64,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Unknown {
    written: String,
    n: u64,
    first: String,
}

impl UnknownClasses {
    /// Notes that `name` was met at `position`, such as `"a.txt", line 3`.
    pub fn add(&mut self, name: &str, position: impl FnOnce() -> String) {
        let plain = plain_name(name);
        if let Some(unknown) = self.by_name.get_mut(&plain) {
            unknown.n += 1;
        } else if self.by_name.len() < MAX_LISTED {
            self.by_name.insert(plain, Unknown { written: name.to_owned(), n: 1, first: position() });
        } else {
            self.n_others += 1;
        }
    }

    /// Adds the names of `other`.
    pub fn append(&mut self, other: &Self) {
        self.n_others += other.n_others;
        for (plain, unknown) in &other.by_name {
            if let Some(known) = self.by_name.get_mut(plain) {
                known.n += unknown.n;
            } else if self.by_name.len() < MAX_LISTED {
                self.by_name.insert(plain.clone(), unknown.clone());
            } else {
                self.n_others += unknown.n;
            }
        }
    }

    /// Whether all names are known.
    pub fn is_empty(&self) -> bool {
        self.by_name.is_empty()
    }

    /// Fails if there are unknown names, with an error that lists them and the lines that would map them. `id` is the data
    /// set.
    pub fn refuse(&self, id: &str) -> Result<(), DatasetError> {
        self.refuse_words_in(&format!("the labels of {id:?}"))
    }

    /// The same of results; `name` is that of their file or folder.
    pub fn refuse_results(&self, name: &str) -> Result<(), DatasetError> {
        self.refuse_words_in(&format!("the results {name:?}"))
    }

    fn refuse_words_in(&self, what: &str) -> Result<(), DatasetError> {
        if self.is_empty() {
            return Ok(());
        }
        let (n_names, listing) = (self.by_name.len(), self.listing());
        let classes = if n_names == 1 { "class" } else { "classes" };
        Err(DatasetError::Usage(format!("{what} have {n_names} unknown {classes}:\n{listing}")))
    }

    fn listing(&self) -> String {
        const ENDLESS: &str = "a string takes all that is written";
        let mut text = String::new();
        let quoted: Vec<String> = self.by_name.values().map(|it| format!("{:?}", it.written)).collect();
        let width = quoted.iter().map(|it| it.chars().count()).max().unwrap_or(0);
        for (name, Unknown { n, first, .. }) in quoted.iter().zip(self.by_name.values()) {
            writeln!(text, "  {name:<width$}  {n:>6} times, first in {first}").expect(ENDLESS);
        }
        if self.n_others > 0 {
            writeln!(text, "  and others, {} times in all", self.n_others).expect(ENDLESS);
        }
        let options: Vec<String> = self
            .by_name
            .values()
            .filter_map(|it| Some(format!("--class {}", option_of(&it.written)?)))
            .collect();
        writeln!(text, "give the class of each (here the likeliest) with options\n  {}", options.join(" "))
            .expect(ENDLESS);
        writeln!(text, "or in the file of -c or the catalogue\n  [classes]").expect(ENDLESS);
        for Unknown { written, .. } in self.by_name.values() {
            // A string in JSON is one in TOML.
            let key = serde_json::Value::from(written.as_str());
            writeln!(text, "  {key} = \"{}\"", likeliest_class(written).name()).expect(ENDLESS);
        }
        let own: Vec<String> =
            self.by_name.values().map(|it| format!("[class.{}]", plain_name(&it.written))).collect();
        writeln!(
            text,
            "or make classes of your own of them in the file of -c or scanbench.toml\n  {}",
            own.join("  ")
        )
        .expect(ENDLESS);
        write!(text, "classes are {}; objects of misc are ignored in the task vehicles", all_classes())
            .expect(ENDLESS);
        text
    }
}

/// `name=CLASS`, with the likeliest class, as a word for a shell; `None` if the name cannot be typed.
fn option_of(name: &str) -> Option<String> {
    if name.chars().any(char::is_control) {
        return None;
    }
    Some(shell_word(&format!("{name}={}", likeliest_class(name).name())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_user_has_the_last_word_then_the_format() {
        let mut rules = ClassRules::default();
        let vocabulary = [("Person", AnnotationClass::SittingPerson)];
        assert_eq!(rules.class_of("PERSON", &vocabulary), Some(AnnotationClass::SittingPerson));
        assert_eq!(rules.class_of("person", &[]), Some(AnnotationClass::Pedestrian));
        assert_eq!(rules.class_of("Fork Lift", &vocabulary), None);
        rules.table.insert("fork_lift", AnnotationClass::Truck);
        rules.table.insert("person", AnnotationClass::Cyclist);
        assert_eq!(rules.class_of("Fork Lift", &vocabulary), Some(AnnotationClass::Truck));
        assert_eq!(rules.class_of("Person", &vocabulary), Some(AnnotationClass::Cyclist));
        rules.unknown = UnknownNames::TakeAsMisc;
        assert_eq!(rules.class_of("unicorn", &vocabulary), Some(AnnotationClass::Misc));
    }

    #[test]
    fn of_two_tables_the_first_counts() {
        let table = |class| {
            let mut table = ClassTable::default();
            table.insert("forklift", class);
            table
        };
        let mut other = table(AnnotationClass::Truck);
        other.insert("cart", AnnotationClass::Trailer);
        let both = table(AnnotationClass::Misc).or(&other);
        assert_eq!(both.get("Forklift"), Some(AnnotationClass::Misc));
        assert_eq!(both.get("cart"), Some(AnnotationClass::Trailer));
    }

    #[test]
    fn unknown_names_are_listed_at_once_with_the_lines_that_map_them() {
        let mut unknown = UnknownClasses::default();
        assert!(unknown.refuse("drive").is_ok());
        for name in ["forklift", "cart \"a\"", "Forklift", "it's"] {
            unknown.add(name, || "\"a.txt\", line 3".to_owned());
        }
        let message = unknown.refuse("drive").expect_err("unknown").to_string();
        for line in [
            "  \"forklift\"         2 times, first in \"a.txt\", line 3",
            "  --class 'cart \"a\"=misc' --class forklift=misc --class 'it'\\''s=misc'",
            "  \"cart \\\"a\\\"\" = \"misc\"",
            "  \"forklift\" = \"misc\"",
        ] {
            assert!(message.lines().any(|it| it == line), "{line}\n{message}");
        }
        assert!(message.starts_with("the labels of \"drive\" have 3 unknown classes"), "{message}");
        let table: toml::Table = message
            .lines()
            .skip_while(|it| *it != "  [classes]")
            .take(4)
            .collect::<Vec<_>>()
            .join("\n")
            .parse()
            .expect("what is to be pasted is TOML");
        assert_eq!(table["classes"].as_table().unwrap().len(), 3);
    }

    #[test]
    fn a_flood_of_names_is_counted() {
        let mut unknown = UnknownClasses::default();
        (0..1000).for_each(|it| unknown.add(&format!("n{it}"), String::new));
        let message = unknown.refuse("drive").expect_err("unknown").to_string();
        assert!(
            message.contains("and others, 950 times in all") && message.lines().count() < 120,
            "{message}"
        );
    }
}
