//! The names of the stages.
//!
//! Each name is used for the time of the stage, for its products and for its rows in tables. Names are nouns, lower case,
//! words joined by `_`; where a stage has parameters, it is the name of their table.

/// Points are sorted into cells.
pub const GRID: &str = "grid";
/// The ground is found, and cells are separated from it.
pub const GROUND: &str = "ground";
/// Walls are taken out of the short cells.
pub const WALLS: &str = "walls";
/// The points of short objects are gathered.
pub const FOREGROUND: &str = "foreground";
/// Foreground points are sorted into dense cells.
pub const DENSE_LEVEL: &str = "dense_level";
/// Coarse cells that belong together are linked.
pub const MERGE: &str = "merge";
/// Links are cut along gaps between dense cells.
pub const SEPARATION: &str = "separation";
/// The gaps between dense cells are found.
pub const GAPS: &str = "gaps";
/// Dense cells are gathered to groups within groups.
pub const GROUPING: &str = "grouping";
/// Groups are cut where there is no gap.
pub const CUTS: &str = "cuts";
/// The values by which a group is judged to be an object are computed.
pub const DESCRIPTION: &str = "description";
/// The groups with the greatest gain are taken for objects.
pub const BEST_CUT: &str = "best_cut";
/// Boxes are fitted to clusters.
pub const BOXES: &str = "boxes";
/// The features of a vehicle model are computed.
pub const FEATURES: &str = "features";
/// A vehicle model decides by these features.
pub const CLASSIFICATION: &str = "classification";
/// Objects get the points in their boxes that are no foreground.
pub const COMPLETION: &str = "completion";
/// Boxes are fitted to the seen part, and made whole.
pub const REPORTED_BOXES: &str = "reported_boxes";
