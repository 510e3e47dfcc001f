//! Classes of cells and points.

/// Class of a cell, and with it of a point.
///
/// Paper: HG section 3.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum SurfaceClass {
    /// Outside the grid, or not classified.
    #[default]
    Unseen,
    /// Too few points for another class.
    Clutter,
    /// Road, pavement, grass.
    Ground,
    /// Façades, poles, tree crowns.
    Tall,
    /// Vehicles, people, street furniture: the foreground.
    Short,
    /// For drawing only: short by itself, and tall because it is on a wall. The stages see [`Self::Tall`] instead.
    Wall,
}

impl SurfaceClass {
    /// All classes, in the order of their discriminants.
    pub const ALL: [Self; 6] =
        [Self::Unseen, Self::Clutter, Self::Ground, Self::Tall, Self::Short, Self::Wall];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unseen => "unseen",
            Self::Clutter => "clutter",
            Self::Ground => "ground",
            Self::Tall => "tall",
            Self::Short => "short object",
            Self::Wall => "wall",
        }
    }
}
