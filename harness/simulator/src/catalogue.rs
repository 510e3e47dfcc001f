//! The catalogue of data sets with drives through simulated streets, and the one that is part of the program.

use scans::dataset::DatasetError;
use scans::dataset::catalogue::{SimulatedEntry, parse_catalogue};

use super::rain::RAIN_RATES_MM_PER_H;
use super::simulated_street::StreetDrive;
use super::street_conditions::check_range;

/// How high a simulated sensor may be mounted above the road, in metres.
const SENSOR_HEIGHTS_M: std::ops::RangeInclusive<f32> = 0.3..=5.0;

/// The catalogue that is part of the program.
const BUILT_IN: &str = include_str!("../../../datasets.toml");

/// The group of the built-in catalogue that is run when no data set is asked for.
pub const DEFAULT_DATASETS: &str = "streets";

/// Data sets on disk and drives through simulated streets, by id.
pub type Catalogue = scans::dataset::catalogue::Catalogue<StreetDrive>;

/// The catalogue that is part of the program.
pub fn built_in_catalogue() -> Result<Catalogue, DatasetError> {
    parse_catalogue("built-in datasets.toml", BUILT_IN)
}

impl SimulatedEntry for StreetDrive {
    fn check(&self) -> Result<(), String> {
        let &Self { n_scans, turns_per_scan, scans_per_drive, .. } = self;
        if scans_per_drive == Some(0) {
            return Err("a drive needs at least one scan".to_owned());
        }
        if n_scans == 0 || turns_per_scan == 0 || n_scans.checked_mul(turns_per_scan).is_none() {
            return Err(format!("{n_scans} scans with {turns_per_scan} turns each are not a drive"));
        }
        check_range("rain_mm_per_h", self.rain_mm_per_h, &RAIN_RATES_MM_PER_H)?;
        check_range("sensor_height_m", self.sensor_height_m, &SENSOR_HEIGHTS_M)?;
        self.conditions.check()?;
        if let Some(limit_deg) = self.labeled_to_either_side_deg
            && !(0.0..=180.0).contains(&limit_deg)
        {
            return Err(format!(
                "labeled_to_either_side_deg is {limit_deg}, but a turn has 180 to either side"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scans::dataset::AnnotatedClasses;
    use scans::dataset::download::DownloadDrives;
    use scans::dataset::kitti::label::KITTI_CLASSES;

    fn parse_catalogue(name: &str, text: &str) -> Result<Catalogue, DatasetError> {
        super::parse_catalogue(name, text)
    }

    #[test]
    fn the_built_in_catalogue_knows_what_kitti_annotates() {
        let catalogue = built_in_catalogue().unwrap();
        let ids: Vec<&String> = catalogue.recorded.keys().collect();
        let expected = [
            "argoverse2",
            "argoverse2-val",
            "kitti-object",
            "kitti-object-val",
            "kitti-raw",
            "kitti-tracking",
            "nuscenes",
            "nuscenes-val",
            "semantic-kitti",
            "semantic-kitti-08",
        ];
        assert_eq!(ids, expected);
        for id in ids.iter().filter(|it| it.starts_with("kitti")) {
            let entry = &catalogue.recorded[*id];
            assert_eq!(entry.annotated, AnnotatedClasses::Only(KITTI_CLASSES.to_vec()));
        }
    }

    #[test]
    fn official_splits_are_parts_of_what_is_there() {
        let recorded = built_in_catalogue().unwrap().recorded;
        let list = recorded["kitti-object-val"].scan_list.clone();
        assert_eq!(list, Some("ImageSets/val.txt".into()));
        let scenes = recorded["nuscenes-val"].parts.sequences.as_ref().expect("not all scenes");
        assert_eq!((scenes.len(), scenes.contains("scene-0003")), (150, true));
        for (split, whole) in [
            ("kitti-object-val", "kitti-object"),
            ("nuscenes-val", "nuscenes"),
            ("argoverse2-val", "argoverse2"),
        ] {
            let [split, whole] = [split, whole].map(|it| &recorded[it]);
            assert_eq!((&split.annotated, &split.sensor), (&whole.annotated, &whole.sensor));
            assert_eq!((split.sensor_height_m, &split.licence), (whole.sensor_height_m, &whole.licence));
        }
    }

    #[test]
    fn what_can_be_fetched_has_a_licence_with_a_page() {
        let recorded = built_in_catalogue().unwrap().recorded;
        let fetched: Vec<_> =
            recorded.iter().filter_map(|(id, it)| Some((id.as_str(), it.download.as_ref()?))).collect();
        let ids: Vec<&str> = fetched.iter().map(|(id, _)| *id).collect();
        assert_eq!(ids, ["argoverse2-val", "kitti-raw", "semantic-kitti"]);
        let [argoverse2, kitti_raw, _] = fetched[..] else { panic!("three") };
        assert_eq!(argoverse2.1.drives(), DownloadDrives::Folders);
        let paths = kitti_raw.1.paths_of(&["2011_09_26_drive_0001".to_owned()]);
        assert_eq!(
            paths,
            [
                "2011_09_26_calib.zip",
                "2011_09_26_drive_0001/2011_09_26_drive_0001_sync.zip",
                "2011_09_26_drive_0001/2011_09_26_drive_0001_tracklets.zip",
            ]
        );
        assert!(
            recorded.values().all(|it| it.licence.is_some() && it.licence_url.is_some() && it.url.is_some())
        );
    }

    /// The drive `simulated.wet`, whose entry ends with `lines`.
    fn parse(lines: &str) -> Result<StreetDrive, DatasetError> {
        let text = format!(
            "[simulated.wet]\nstreet = \"street-narrow\"\nseed = 1\nn_scans = 1\nturns_per_scan = 1\n\
             sensor = \"vlp-16\"\n{lines}"
        );
        parse_catalogue("my.toml", &text).map(|it| it.simulated["wet"].clone())
    }

    #[test]
    fn it_rains_as_hard_as_it_can() {
        assert_eq!(parse("rain_mm_per_h = 10.0").unwrap().rain_mm_per_h, Some(10.0));
        assert_eq!(parse("").unwrap().rain_mm_per_h, None);
        for refused in ["0.0", "-1.0", "nan", "1000.0"] {
            let message = parse(&format!("rain_mm_per_h = {refused}")).expect_err("no rain").to_string();
            assert!(message.contains("0.1 to 150"), "{message}");
        }
    }

    #[test]
    fn a_drive_may_have_conditions_that_can_be() {
        let steep = parse("sensor_height_m = 2.5\n[simulated.wet.conditions]\ngradient = 0.1").unwrap();
        assert_eq!((steep.sensor_height_m, steep.conditions.gradient), (Some(2.5), Some(0.1)));
        for (refused, part) in [
            ("sensor_height_m = 0.0", "0.3 to 5"),
            ("[simulated.wet.conditions]\ngradient = 1.0", "-0.2 to 0.2"),
            ("[simulated.wet.conditions]\nslope = 0.1", "unknown field `slope`"),
        ] {
            let message = parse(refused).expect_err("no such street").to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
