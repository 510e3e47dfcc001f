//! Why an annotation or a detection has the outcome that it has.

use crate::vocabulary::named::named;

named! {
    /// The two kinds of mistakes.
    pub enum MistakeKind {
        /// An annotation that nothing found.
        Missed = "missed",
        /// A detection of nothing.
        False = "false",
    }

    /// Kinds of objects of which a few are shown.
    pub enum ShownKind {
        /// An annotation that nothing found.
        Missed = "missed",
        /// A detection of nothing.
        False = "false",
        /// A detection that no other detector has, where nothing is labelled.
        Alone = "alone",
        /// One of the closest matches.
        Matched = "matched",
    }

    /// How many of the detectors of a run have a detection, where nothing is labelled.
    pub enum Agreement {
        /// All.
        All = "found by all",
        /// Some others, but not all.
        Some = "found by some others",
        /// None but its own.
        Alone = "found by no other",
    }

    /// Why an annotation does not count.
    pub enum IgnoredAnnotation {
        /// Fewer points than the minimum.
        TooFewPoints = "too few points",
        /// Farther away than the maximum.
        BeyondRange = "beyond range",
        /// Outside the slice that alone is judged.
        OutsideSlice = "outside slice",
        /// Of a class that is neither right nor wrong in this task, such as a tram among vehicles.
        AmbiguousClass = "ambiguous class",
        /// At least half of its points are unscorable.
        Unscorable = "unscorable",
        /// It has no box, where boxes are compared.
        NoBox = "no box",
        /// It reaches higher above the ground than an object does that is to be found in this task.
        Tall = "tall",
    }

    /// Why an annotation was missed.
    pub enum MissReason {
        /// More than half of its points are in no detection, and most of these are outside of the grid.
        OutsideGrid = "outside of the grid",
        /// The same, in cells with too few points.
        Clutter = "taken for clutter",
        /// The same, taken for ground.
        Ground = "taken for ground",
        /// The same, in cells that are tall.
        Tall = "taken for tall",
        /// The same, in cells that are short and lie on a wall, or behind one.
        Wall = "taken for a wall",
        /// The same, in clusters that are no objects because of their size.
        ClusterSize = "cluster of a wrong size",
        /// No detection shares a point with it, or comes near it, and no stage says why.
        NothingThere = "nothing there",
        /// A detection has it, but is not of the class asked for.
        WrongClass = "wrong class",
        /// Most of it lies in a detection that holds at least as much else, and more of other objects than of what is none.
        MergedWithOthers = "merged with others",
        /// The same, and more of what is no object, or not labelled: the road, walls.
        MergedWithBackground = "merged with background",
        /// It is spread over several detections, none of which is good enough.
        Split = "split",
        /// One detection has part of it, but too little.
        PartlyFound = "partly found",
        /// A detection is good enough, but was needed for another annotation.
        TakenByAnother = "taken by another",
        /// The detector gave no answer to the scan.
        DetectorFailed = "detector failed",
    }

    /// Why a detection does not count.
    pub enum IgnoredDetection {
        /// At least half of its points lie on ignored annotations, or it has none and stands inside the box of one, or it
        /// found a tall annotation.
        OnIgnoredAnnotation = "on ignored annotation",
        /// At least half of its points lie outside the labelled region, or it has none and stands there.
        OutsideLabeledRegion = "outside labelled region",
        /// At least half of its points are farther away than the maximum, or it has none and stands there.
        BeyondRange = "beyond range",
        /// Outside the slice that alone is judged, by its own box.
        OutsideSlice = "outside slice",
        /// At least half of its points are unscorable, or not to be judged for different ones of these reasons.
        OnIgnoredPoints = "on ignored points",
    }

    /// Why a detection is false.
    pub enum FalseReason {
        /// No annotation shares a point with it, or none of them much.
        NothingThere = "nothing there",
        /// It lies on something annotated that is not of the class asked for.
        WrongClass = "wrong class",
        /// It is a part of an annotation, too small or one of several.
        Fragment = "fragment",
        /// It joins several annotations.
        JoinsSeveral = "joins several",
        /// It holds an annotation and too much else.
        TooLarge = "too large",
    }
}
