//! Why an annotation or a detection has the outcome that it has.

/// Why an annotation does not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum IgnoredAnnotation {
    /// Fewer points than the minimum.
    TooFewPoints,
    /// Farther away than the maximum.
    BeyondRange,
    /// Of a class that is neither right nor wrong in this task, such as a tram among vehicles.
    AmbiguousClass,
    /// At least half of its points are unscorable.
    Unscorable,
    /// It has no box, where boxes are compared.
    NoBox,
    /// It reaches higher above the ground than an object does that is to be found in this task.
    Tall,
}

/// Why an annotation was missed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MissReason {
    /// No detection shares a point with it, or comes near it.
    NothingThere,
    /// A detection has it, but is not of the class asked for.
    WrongClass,
    /// Most of it lies in a detection that holds at least as much of other things.
    MergedWithOthers,
    /// It is spread over several detections, none of which is good enough.
    Split,
    /// One detection has part of it, but too little.
    PartlyFound,
    /// A detection is good enough, but was needed for another annotation.
    TakenByAnother,
    /// The detector gave no answer to the scan.
    DetectorFailed,
}

/// Why a detection does not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum IgnoredDetection {
    /// At least half of its points lie on ignored annotations, or it has none and stands inside the box of one, or it found
    /// a tall annotation.
    OnIgnoredAnnotation,
    /// At least half of its points lie outside the labelled region, or it has none and stands there.
    OutsideLabeledRegion,
    /// At least half of its points are farther away than the maximum, or it has none and stands there.
    BeyondRange,
    /// At least half of its points are unscorable, or not to be judged for different ones of these reasons.
    OnIgnoredPoints,
}

/// Why a detection is false.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FalseReason {
    /// No annotation shares a point with it, or none of them much.
    NothingThere,
    /// It lies on something annotated that is not of the class asked for.
    WrongClass,
    /// It is a part of an annotation, too small or one of several.
    Fragment,
    /// It joins several annotations.
    JoinsSeveral,
    /// It holds an annotation and too much else.
    TooLarge,
}

macro_rules! reason_names {
    ($($type:ident { $($variant:ident => $name:literal),+ $(,)? })+) => {$(
        impl $type {
            /// The name used in files and on screens.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// The reason of this name; `None` if there is none.
            pub fn from_name(name: &str) -> Option<Self> {
                [$(Self::$variant),+].into_iter().find(|it| it.name() == name)
            }
        }
    )+};
}

reason_names! {
    IgnoredAnnotation {
        TooFewPoints => "too few points",
        BeyondRange => "beyond range",
        AmbiguousClass => "ambiguous class",
        Unscorable => "unscorable",
        NoBox => "no box",
        Tall => "tall",
    }
    MissReason {
        NothingThere => "nothing there",
        WrongClass => "wrong class",
        MergedWithOthers => "merged with others",
        Split => "split",
        PartlyFound => "partly found",
        TakenByAnother => "taken by another",
        DetectorFailed => "detector failed",
    }
    IgnoredDetection {
        OnIgnoredAnnotation => "on ignored annotation",
        OutsideLabeledRegion => "outside labelled region",
        BeyondRange => "beyond range",
        OnIgnoredPoints => "on ignored points",
    }
    FalseReason {
        NothingThere => "nothing there",
        WrongClass => "wrong class",
        Fragment => "fragment",
        JoinsSeveral => "joins several",
        TooLarge => "too large",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_found_by_their_names() {
        assert_eq!(MissReason::from_name(MissReason::Split.name()), Some(MissReason::Split));
        assert_eq!(FalseReason::from_name("too large"), Some(FalseReason::TooLarge));
        assert_eq!(IgnoredDetection::from_name("too large"), None);
        assert_eq!(IgnoredAnnotation::from_name(""), None);
    }
}
