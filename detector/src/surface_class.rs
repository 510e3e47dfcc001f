//! What a cell is taken for.

/// What a cell, and with it a point, is taken for.
///
/// Paper: HG section 3.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum SurfaceClass {
    /// Outside the grid, or not looked at.
    #[default]
    Unseen,
    /// Too few points to say anything.
    Clutter,
    /// Road, pavement, grass.
    Ground,
    /// Façades, poles, tree crowns.
    Tall,
    /// Vehicles, people, street furniture: the foreground.
    Short,
    /// Of what stages leave behind: short by itself, and tall because it is on a wall. To the stages it is [`Self::Tall`].
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
