//! A change of a result, and how bad it is.

use std::collections::BTreeMap;

use crate::vocabulary::named::named;

named! {
    /// A kind of change of a result, the worst first.
    pub enum ChangeKind {
        /// An annotation was found before and is missed now.
        Lost = "lost",
        /// A detection is false now that was not before.
        NewFalse = "new-false",
        /// An object has another class.
        OtherClass = "other-class",
        /// An annotation was missed before and is found now.
        Found = "found",
        /// A detection that was false before is gone, or not false now.
        NoLongerFalse = "no-longer-false",
        /// An annotation counts now and did not before, or the other way round.
        Counting = "counting",
        /// The outcome is the same, for another reason, at another cost, or with other points.
        Otherwise = "otherwise",
        /// Numbers changed by less than is shown, or ones that are not shown: no more than the count is said.
        NotShown = "not-shown",
    }
}

impl ChangeKind {
    /// The kinds that a person looks at: an object is found, missed, false or of a class on one side only.
    pub const SEEN: [Self; 5] =
        [Self::Lost, Self::NewFalse, Self::OtherClass, Self::Found, Self::NoLongerFalse];

    /// The text of `n` changes of this kind, for people.
    pub fn counted(self, n: usize) -> String {
        let [one, many] = match self {
            Self::Lost => ["object lost", "objects lost"],
            Self::NewFalse => ["new false detection", "new false detections"],
            Self::OtherClass => ["object with another class", "objects with another class"],
            Self::Found => ["object newly found", "objects newly found"],
            Self::NoLongerFalse => ["detection no longer false", "detections no longer false"],
            Self::Counting => ["object that counts otherwise", "objects that count otherwise"],
            Self::Otherwise => [
                "same outcome for another reason, at another cost or with other points",
                "same outcomes for another reason, at another cost or with other points",
            ],
            Self::NotShown => ["change of less than is shown", "changes of less than is shown"],
        };
        format!("{n} {}", if n == 1 { one } else { many })
    }
}

/// A change of the result of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its kind.
    pub kind: ChangeKind,
    /// The object with its outcomes before and now, in words.
    pub text: String,
    /// Number of its points: among changes of one kind, that of the largest object is the worst.
    pub n_points: u64,
    /// Where it is on the ground plan, in metres; `None` if that is not known, or it is about several objects.
    pub position_m: Option<[f32; 2]>,
    /// Number of objects: one, or that of objects of which only the number is known.
    pub n_objects: usize,
}

impl Change {
    /// A change of one object of `n_points`.
    pub fn of_object(kind: ChangeKind, n_points: u64, text: String) -> Self {
        Self { kind, text, n_points, position_m: None, n_objects: 1 }
    }

    /// This change of an object whose centre is known, in metres.
    pub fn at(self, center_m: Option<[f32; 3]>) -> Self {
        Self { position_m: center_m.map(|[x_m, y_m, _]| [x_m, y_m]), ..self }
    }

    /// A change of `n_objects`, or of other numbers of a scan, that is smaller than what is shown.
    pub fn not_shown(n_objects: usize, text: String) -> Self {
        Self { kind: ChangeKind::NotShown, text, n_points: 0, position_m: None, n_objects }
    }
}

/// The number of objects with a change of each kind that occurs, the worst kind first.
pub fn n_of_kinds<'a>(changes: impl Iterator<Item = &'a Change>) -> BTreeMap<ChangeKind, usize> {
    let mut counts = BTreeMap::new();
    for it in changes {
        *counts.entry(it.kind).or_default() += it.n_objects;
    }
    counts
}

/// The counts for people: `65 objects lost, 3 new false detections`.
pub fn in_words(counts: &BTreeMap<ChangeKind, usize>) -> String {
    counts.iter().map(|(kind, n)| kind.counted(*n)).collect::<Vec<_>>().join(", ")
}
