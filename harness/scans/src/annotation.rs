//! Ground truth: what a person, or the simulator, labelled.
//!
//! It lives here and not beside the detectors, so that no detector can look at it.

use detector::{OrientedBox, PointCloud};

/// One scan with its ground truth.
#[derive(Debug, Clone, PartialEq)]
pub struct LabeledScan {
    /// Which scan this is.
    pub id: ScanId,
    /// The points, in the sensor frame.
    pub cloud: PointCloud,
    /// The labelled objects.
    pub annotations: Vec<Annotation>,
    /// For every point, whether the labels say anything about it.
    pub point_regions: Vec<PointRegion>,
}

/// Names a scan within its data set.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ScanId {
    /// The drive it belongs to, such as `0000`.
    pub sequence: String,
    /// Its number within the drive.
    pub index: u32,
}

impl std::fmt::Display for ScanId {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}/{:06}", self.sequence, self.index)
    }
}

/// One labelled object.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    /// What it is.
    pub class: AnnotationClass,
    /// The box around the whole object, seen and unseen parts, in the sensor frame. `None` where only points are labelled.
    pub bounding_box: Option<OrientedBox>,
    /// Its points, as indices into the scan, ascending: the labelled ones, or those inside the box.
    pub point_indices: Vec<u32>,
    /// Number of the object within its drive, the same in all scans that show it.
    pub track: Option<u32>,
    /// How much of it other things hide from the sensor.
    pub occlusion: Option<Occlusion>,
    /// Share of it outside the labelled region, 0 to 1.
    pub truncation: Option<f32>,
}

impl Annotation {
    /// What it is called on screens, such as `car 7`.
    pub fn label(&self) -> String {
        match self.track {
            Some(track) => format!("{} {track}", self.class.name()),
            None => self.class.name().to_owned(),
        }
    }
}

/// How much of an object is hidden by others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Occlusion {
    /// Less than a tenth.
    None,
    /// Up to a half.
    Partly,
    /// More than a half.
    Largely,
}

impl Occlusion {
    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Partly => "partly",
            Self::Largely => "largely",
        }
    }
}

/// Whether the labels say anything about a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PointRegion {
    /// Labelled: a point of no annotation belongs to no object.
    Labeled,
    /// Marked as not to be judged, such as KITTI's `DontCare`.
    Unscorable,
    /// Outside of what was labelled, such as behind the camera on KITTI.
    Outside,
}

/// What an annotated object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnnotationClass {
    /// Passenger car.
    Car,
    /// Van or large people carrier.
    Van,
    /// Truck.
    Truck,
    /// Bus.
    Bus,
    /// Person on foot.
    Pedestrian,
    /// Person sitting.
    SittingPerson,
    /// Bicycle or motorcycle with its rider.
    Cyclist,
    /// Bicycle or motorcycle without a rider.
    ParkedCycle,
    /// Tram or train.
    Tram,
    /// Trailer.
    Trailer,
    /// Pole, lamp post, traffic light or sign.
    Pole,
    /// Trunk and crown of a tree.
    Tree,
    /// Hedge or bush.
    Hedge,
    /// Fence or railing.
    Fence,
    /// Mail box, bin, bench, advertising column and the like.
    StreetFurniture,
    /// Labelled, but none of the above.
    Misc,
}

impl AnnotationClass {
    /// All classes, in the order in which tables list them.
    pub const ALL: [Self; 16] = [
        Self::Car,
        Self::Van,
        Self::Truck,
        Self::Bus,
        Self::Pedestrian,
        Self::SittingPerson,
        Self::Cyclist,
        Self::ParkedCycle,
        Self::Tram,
        Self::Trailer,
        Self::Pole,
        Self::Tree,
        Self::Hedge,
        Self::Fence,
        Self::StreetFurniture,
        Self::Misc,
    ];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Van => "van",
            Self::Truck => "truck",
            Self::Bus => "bus",
            Self::Pedestrian => "pedestrian",
            Self::SittingPerson => "sitting-person",
            Self::Cyclist => "cyclist",
            Self::ParkedCycle => "parked-cycle",
            Self::Tram => "tram",
            Self::Trailer => "trailer",
            Self::Pole => "pole",
            Self::Tree => "tree",
            Self::Hedge => "hedge",
            Self::Fence => "fence",
            Self::StreetFurniture => "street-furniture",
            Self::Misc => "misc",
        }
    }
}

/// Indices of the points of `cloud` inside or on `bounding_box`, ascending.
pub fn points_inside(cloud: &PointCloud, bounding_box: &OrientedBox) -> Vec<u32> {
    let inside =
        cloud.positions_m().zip(0_u32..).filter(|(position_m, _)| bounding_box.contains(*position_m));
    inside.map(|(_, point_idx)| point_idx).collect()
}
