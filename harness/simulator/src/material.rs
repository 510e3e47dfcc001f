//! Materials of surfaces, as a laser pulse meets them.

/// Material of a thing, as far as a laser is concerned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Share of light that comes back diffusely, 0 to 1.
    pub reflectivity: f32,
    /// Whether pulses get through.
    pub passage: Passage,
}

/// Whether pulses get through a thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Passage {
    /// Never.
    Blocked,
    /// A pane: some pulses pass, some come back, the rest is lost.
    Pane,
    /// Leaves or mesh: a pulse flies this far inside on average before it hits something, in metres.
    FreePath(f32),
}

impl Material {
    /// Something solid and dull.
    pub const fn solid(reflectivity: f32) -> Self {
        Self { reflectivity, passage: Passage::Blocked }
    }

    /// Leaves with this mean free path in metres.
    pub const fn foliage(mean_free_path_m: f32) -> Self {
        Self { reflectivity: 0.35, passage: Passage::FreePath(mean_free_path_m) }
    }

    /// Window glass.
    pub const GLASS: Self = Self { reflectivity: 0.3, passage: Passage::Pane };
    /// Tyres, dashboards, seats.
    pub const RUBBER: Self = Self::solid(0.06);
    /// Plaster, stone, brick.
    pub const MASONRY: Self = Self::solid(0.35);
    /// Bare or painted steel of street furniture.
    pub const METAL: Self = Self::solid(0.3);
    /// Bark and weathered timber.
    pub const WOOD: Self = Self::solid(0.3);
    /// Coated traffic signs and number plates, brighter than any dull surface.
    pub const RETROREFLECTOR: Self = Self::solid(1.0);
}

/// Fate of a pulse that reached a pane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaneFate {
    /// It went on.
    Passed,
    /// It came back.
    Returned,
    /// It went elsewhere.
    Lost,
    /// It was mirrored, and meets a surface then that is bright enough to be seen in the mirror.
    Mirrored,
}

/// Share of spots on panes that show mirror images.
const MIRROR_CHANCE: f32 = 0.04;

/// Decides by `chance` (0 to 1) the fate of a pulse that meets a pane at `cos_incidence`.
///
/// Panes are mirrors: they send a pulse back only when met head-on, and the flatter the less gets through.
pub fn pane_fate(chance: f32, cos_incidence: f32) -> PaneFate {
    let returned = if cos_incidence > 0.9 { 0.3 } else { 0.1 };
    let passed = 0.65 * cos_incidence.sqrt();
    if chance < returned {
        PaneFate::Returned
    } else if chance < returned + passed * (1.0 - returned) {
        PaneFate::Passed
    } else if chance > 1.0 - MIRROR_CHANCE {
        PaneFate::Mirrored
    } else {
        PaneFate::Lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_share_passed(cos_incidence: f32, expected: std::ops::Range<f32>) {
        let n_passed =
            (0..1000).filter(|n| pane_fate(*n as f32 / 1000.0, cos_incidence) == PaneFate::Passed).count();
        let share = n_passed as f32 / 1000.0;
        assert!(expected.contains(&share), "{share}");
    }

    #[test]
    fn a_pane_lets_most_through_when_met_head_on() {
        check_share_passed(1.0, 0.4..0.6);
    }

    #[test]
    fn a_pane_lets_little_through_when_met_flat() {
        check_share_passed(0.05, 0.05..0.2);
    }
}
