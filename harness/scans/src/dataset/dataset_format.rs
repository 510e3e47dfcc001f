//! The formats that can be read.

use std::fmt;
use std::str::FromStr;

use super::DatasetError;

/// How a data set is laid out on disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DatasetFormat {
    /// KITTI's tracking benchmark: whole drives.
    KittiTracking,
    /// KITTI's object benchmark: single scans.
    KittiObject,
    /// `SemanticKITTI`: KITTI's odometry drives with a label for every point.
    SemanticKitti,
    /// A recording of ROS 2 or Foxglove.
    Mcap,
    /// Argoverse 2, the sensor data set.
    #[serde(rename = "argoverse2")]
    Argoverse2,
    /// KITTI's raw recordings: whole drives with tracklets.
    KittiRaw,
    /// nuScenes.
    #[serde(rename = "nuscenes")]
    NuScenes,
    /// A capture of the packets of a Velodyne sensor.
    VelodynePcap,
    /// A folder of scans that are a file each.
    ScanFolder,
}

impl DatasetFormat {
    /// All formats.
    pub const ALL: [Self; 9] = [
        Self::KittiTracking,
        Self::KittiObject,
        Self::SemanticKitti,
        Self::Mcap,
        Self::Argoverse2,
        Self::KittiRaw,
        Self::NuScenes,
        Self::VelodynePcap,
        Self::ScanFolder,
    ];

    /// Whether data in this format are in drives, logs or scenes of which some can be chosen.
    pub fn has_sequences(self) -> bool {
        self.is_of_benchmark() && self != Self::KittiObject
    }

    /// Whether data in this format are of one benchmark, whose sensor is known.
    pub fn is_of_benchmark(self) -> bool {
        !matches!(self, Self::Mcap | Self::VelodynePcap | Self::ScanFolder)
    }

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::KittiTracking => "kitti-tracking",
            Self::KittiObject => "kitti-object",
            Self::SemanticKitti => "semantic-kitti",
            Self::Mcap => "mcap",
            Self::Argoverse2 => "argoverse2",
            Self::KittiRaw => "kitti-raw",
            Self::NuScenes => "nuscenes",
            Self::VelodynePcap => "velodyne-pcap",
            Self::ScanFolder => "scan-folder",
        }
    }

    /// The names of all formats.
    pub fn names() -> Vec<String> {
        Self::ALL.map(|format| format.name().to_owned()).to_vec()
    }
}

impl fmt::Display for DatasetFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for DatasetFormat {
    type Err = DatasetError;

    fn from_str(name: &str) -> Result<Self, DatasetError> {
        Self::ALL.into_iter().find(|format| format.name() == name).ok_or_else(|| {
            let known = Self::names().join(", ");
            DatasetError::Usage(format!("unknown format {name:?}; formats are {known}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_found_by_its_name() {
        for format in DatasetFormat::ALL {
            assert_eq!(format.name().parse::<DatasetFormat>().unwrap(), format);
        }
    }

    #[test]
    fn an_unknown_format_is_a_usage_error_that_lists_the_known_ones() {
        let error = "kitty".parse::<DatasetFormat>().expect_err("no such format");
        let known = DatasetFormat::names().join(", ");
        assert!(known.starts_with("kitti-tracking, kitti-object, "));
        assert_eq!(error.to_string(), format!(r#"unknown format "kitty"; formats are {known}"#));
        assert!(error.is_usage_error());
    }
}
