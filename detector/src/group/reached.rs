//! Positions that groups reach while they grow, in four bytes each, as there are many.

/// The conducting cells of a group, which stand one behind the other: what its first cell reaches, and how many values
/// farther the next group begins.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GroupRange {
    pub(super) first: Reached,
    pub(super) n_values: u32,
}

/// Which conducting cell reached a position first, and in how many steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Reached(pub(super) u32);

impl Reached {
    /// Bits for the steps, of which there are at most 20.
    const STEP_BITS: u32 = 5;
    pub(super) const NOTHING: Self = Self(u32::MAX);
    /// The outermost cells, which hold no points and are never reached.
    pub(super) const BORDER: Self = Self(u32::MAX - 1);

    /// The conducting cell itself.
    pub(super) fn by(conducting_idx: usize) -> Self {
        Self((conducting_idx as u32) << Self::STEP_BITS)
    }

    /// The position one step farther.
    pub(super) fn next(self) -> Self {
        Self(self.0 + 1)
    }

    pub(super) fn conducting_idx(self) -> usize {
        (self.0 >> Self::STEP_BITS) as usize
    }

    pub(super) fn steps(self) -> u32 {
        self.0 & ((1 << Self::STEP_BITS) - 1)
    }

    pub(super) fn is_of(self, group: GroupRange) -> bool {
        self.0.wrapping_sub(group.first.0) < group.n_values
    }
}

/// A step to a position: the position, and the direction in four bits.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Step(u32);

impl Step {
    pub(super) fn new(position: u32, direction: usize) -> Self {
        Self(position << 4 | direction as u32)
    }

    pub(super) fn position(self) -> u32 {
        self.0 >> 4
    }

    pub(super) fn direction(self) -> usize {
        (self.0 & 15) as usize
    }
}

/// The direction of a step to where it began, among those to all neighbours row by row.
pub(super) const NOWHERE: usize = 4;
