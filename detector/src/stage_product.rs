//! Products of the stages of a detector, in a form that can be drawn without knowing the detector.

use crate::oriented_box::OrientedBox;
use crate::surface_class::SurfaceClass;

/// A named product of one stage, in the sensor frame and in metres.
///
/// One logger draws every detector from these, so a new detector is streamed without new drawing code.
#[derive(Debug, Clone, PartialEq)]
pub struct StageProduct {
    /// Name of the stage, as in [`StageTime`](crate::detector::StageTime).
    pub stage: &'static str,
    /// Name of the product, unique within the detector: lower case, words joined by `_`.
    pub name: &'static str,
    /// Its form.
    pub shape: Shape,
}

/// The forms a product can take.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// One class for every point of the scan, in scan order.
    LabeledPoints(Vec<SurfaceClass>),
    /// The cluster of every point of the scan, in scan order; `None` for points of no cluster.
    Clusters(Vec<Option<u32>>),
    /// Square columns over the ground.
    Cells {
        /// Side length in metres.
        cell_size_m: f32,
        /// The occupied cells.
        cells: Vec<ProductCell>,
    },
    /// Straight lines from end to end.
    Segments(Vec<[[f32; 3]; 2]>),
    /// Boxes.
    Boxes(Vec<OrientedBox>),
    /// Closed outlines; the first vertex is not repeated at the end.
    Contours(Vec<Vec<[f32; 3]>>),
    /// Spheres.
    Spheres(Vec<ProductSphere>),
    /// Links between neighbouring cells, kept or not: a graph whose components are objects.
    Links(Vec<ProductLink>),
    /// Square columns over the ground, each of one object.
    ObjectCells {
        /// Side length in metres.
        cell_size_m: f32,
        /// The occupied cells.
        cells: Vec<ObjectCell>,
    },
}

/// One link of [`Shape::Links`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProductLink {
    /// Positions of its ends, in metres.
    pub ends_m: [[f32; 3]; 2],
    /// Its fate.
    pub fate: LinkFate,
}

/// Fate of a pair of neighbouring cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LinkFate {
    /// They belong together.
    Kept,
    /// They were linked, and near-empty cells between them cut the link.
    Cut,
    /// They never were linked: one is too much higher than the other.
    Unlinked,
}

impl LinkFate {
    /// All fates, in the order of their discriminants.
    pub const ALL: [Self; 3] = [Self::Kept, Self::Cut, Self::Unlinked];

    /// The name used on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "link kept",
            Self::Cut => "link cut",
            Self::Unlinked => "no link",
        }
    }
}

/// One cell of [`Shape::ObjectCells`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectCell {
    /// Centre on the ground plan in metres.
    pub center_m: [f32; 2],
    /// Lowest and highest point in metres.
    pub z_range_m: [f32; 2],
    /// Number of its object, as in the detector's clusters.
    pub object: u32,
}

/// One sphere of [`Shape::Spheres`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProductSphere {
    /// Centre in metres.
    pub center_m: [f32; 3],
    /// Radius in metres.
    pub radius_m: f32,
}

/// One cell of [`Shape::Cells`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProductCell {
    /// Centre on the ground plan in metres.
    pub center_m: [f32; 2],
    /// Lowest and highest point in metres.
    pub z_range_m: [f32; 2],
    /// Its class.
    pub class: SurfaceClass,
}
