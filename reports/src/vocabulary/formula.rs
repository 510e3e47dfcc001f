//! How metrics are made of sums.

/// A sum; every ratio is made of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// NO, the annotations that count.
    Annotations,
    /// TP, those found.
    Matched,
    /// FO, the false detections.
    False,
    /// Annotations that are neither found nor missed.
    IgnoredAnnotations,
    /// Detections that are neither right nor false.
    IgnoredDetections,
    /// Detections of which it cannot be known whether they are false.
    Unknowable,
    /// Annotations that are torn apart.
    Split,
    /// Detections that hold an annotation.
    Holding,
    /// Of these, those that hold several.
    Joining,
    /// Entropy of the annotations over the detections, in nats.
    OverEntropy,
    /// Entropy of the detections over the annotations, in nats.
    UnderEntropy,
    /// Detections with a point of an annotation.
    Touching,
    /// Matched pairs both of which have a box.
    BoxPairs,
    /// Distances of the centres of these, in metres.
    CenterError,
    /// Differences of their lengths, in metres.
    LengthError,
    /// Differences of their widths, in metres.
    WidthError,
    /// Angles between their headings, in degrees.
    YawError,
    /// Scans whose instructions and memory were counted.
    CountedScans,
    /// Instructions of detections in these, in millions.
    Instructions,
    /// Most memory of detections in these at once, in MiB.
    PeakMemory,
    /// Scans whose time counts and was measured beside that of the reference.
    TimedScans,
    /// Logarithms of the times of these over those of the reference.
    LogTimeRatio,
    /// Logarithms of the times of the reference in milliseconds.
    LogReference,
}

impl Term {
    /// How many there are.
    pub const N: usize = Self::LogReference as usize + 1;
}

/// How a metric follows from sums.
#[derive(Debug, Clone, Copy)]
pub enum Formula {
    /// It is one of them.
    Sum(Term),
    /// The first without the second.
    Difference(Term, Term),
    /// All of the first over all of the second.
    Ratio(&'static [Term], &'static [Term]),
    /// The geometric mean of values: the sum of their logarithms, and how many they are.
    GeometricMean(Term, Term),
    /// It does not: it is made of times or ranks, or is a number of a protocol.
    NotOfSums,
}
