//! What became of every annotation and every detection of a scan.

use scans::task::Task;

/// The assignment of one scan for one task, and what follows from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// The task it was made for.
    pub task: Task,
    /// For every annotation of the scan, in order, what became of it.
    pub annotations: Vec<AnnotationOutcome>,
    /// For every detection of the scan, in order, what became of it.
    pub detections: Vec<DetectionOutcome>,
    /// Annotations that are ignored because they are tall, and the detections that found them nevertheless, by annotation.
    pub found_tall: Vec<FoundTall>,
}

/// A tall annotation that a detection found which had found nothing that counts. Both are ignored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundTall {
    /// The annotation.
    pub annotation_idx: usize,
    /// The detection.
    pub detection_idx: usize,
    /// What matching them cost, as in [`AnnotationOutcome::Matched`].
    pub cost: f64,
}

/// What became of an annotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnnotationOutcome {
    /// Not asked for by the task: it belongs to the background.
    NotAsked,
    /// Neither found nor missed.
    Ignored(IgnoredAnnotation),
    /// Found.
    Matched {
        /// By this detection.
        detection_idx: usize,
        /// At this cost; lower is better, the unit is the criterion's.
        cost: f64,
    },
    /// Missed.
    Missed(MissReason),
}

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
}

/// What became of a detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DetectionOutcome {
    /// Not of a class the task asks for.
    NotAsked,
    /// Neither right nor false.
    Ignored(IgnoredDetection),
    /// Right.
    Matched {
        /// It found this annotation.
        annotation_idx: usize,
        /// At this cost.
        cost: f64,
    },
    /// False.
    False(FalseReason),
    /// Whether it is false cannot be known: it lies where the labels would not show its kind.
    Unknowable,
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
