//! The formats that can be read.

use std::str::FromStr;

use reports::vocabulary::named::named;

use super::DatasetError;

named! {
    /// How a data set is laid out on disk.
    pub enum DatasetFormat {
        /// KITTI's tracking benchmark: whole drives.
        KittiTracking = "kitti-tracking",
        /// KITTI's object benchmark: single scans.
        KittiObject = "kitti-object",
        /// `SemanticKITTI`: KITTI's odometry drives with a label for every point.
        SemanticKitti = "semantic-kitti",
        /// A recording of ROS 2 or Foxglove.
        Mcap = "mcap",
        /// Argoverse 2, the sensor data set.
        Argoverse2 = "argoverse2",
        /// KITTI's raw recordings: whole drives with tracklets.
        KittiRaw = "kitti-raw",
        /// nuScenes.
        NuScenes = "nuscenes",
        /// A capture of the packets of a Velodyne sensor.
        VelodynePcap = "velodyne-pcap",
        /// A folder of scans that are a file each.
        ScanFolder = "scan-folder",
    }
}

impl DatasetFormat {
    /// Whether data in this format are divided into drives, logs or scenes of which some can be chosen.
    pub fn has_sequences(self) -> bool {
        self.is_of_benchmark() && self != Self::KittiObject
    }

    /// Whether data in this format belong to one benchmark, whose sensor is known.
    pub fn is_of_benchmark(self) -> bool {
        !matches!(self, Self::Mcap | Self::VelodynePcap | Self::ScanFolder)
    }

    /// The names of all formats.
    pub fn names() -> Vec<String> {
        Self::ALL.map(|format| format.name().to_owned()).to_vec()
    }
}

impl FromStr for DatasetFormat {
    type Err = DatasetError;

    fn from_str(name: &str) -> Result<Self, DatasetError> {
        Self::from_name(name).ok_or_else(|| {
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
