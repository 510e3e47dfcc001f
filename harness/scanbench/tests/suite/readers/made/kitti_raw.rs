//! A drive as KITTI's raw recordings have it.

use std::fmt::Write as _;
use std::path::Path;

use reports::vocabulary::class::Occlusion;
use scans::dataset::Dataset;

use super::{boxed, scans, write};

pub const DRIVE: &str = "2011_09_26/2011_09_26_drive_0001_sync";

/// The drive as KITTI's raw recordings have it: a tracklet for each box of each scan, and a car that drives north.
pub fn kitti_raw(folder: &Path, dataset: &dyn Dataset) {
    let scans = scans(dataset);
    let mut items = String::new();
    let mut n_items = 0;
    let mut times = String::new();
    for (number, scan) in scans.iter().enumerate() {
        let bytes: Vec<u8> = scan
            .cloud
            .positions_m()
            .zip(scan.cloud.intensity())
            .flat_map(|([x, y, z], i)| [x, y, z, *i])
            .flat_map(f32::to_le_bytes)
            .collect();
        write(&folder.join(format!("{DRIVE}/velodyne_points/data/{number:010}.bin")), bytes);
        let oxts = format!("{} 8.43 112.5 0.01 -0.02 1.5 {}", 49.0 + number as f64 * 1e-5, "0 ".repeat(24));
        write(&folder.join(format!("{DRIVE}/oxts/data/{number:010}.txt")), oxts);
        writeln!(times, "2011-09-26 13:02:25.{:09}", number * 100_000_000).unwrap();
        for annotation in &boxed(scan).annotations {
            let bounding_box = annotation.bounding_box.unwrap();
            let [x, y, z] = bounding_box.center_m.map(f64::from);
            let [length, width, height] = bounding_box.length_width_height_m.map(f64::from);
            let occlusion = match annotation.occlusion {
                None => "-1",
                Some(Occlusion::None) => "0",
                Some(Occlusion::Partly) => "1",
                Some(Occlusion::Largely) => "2",
            };
            let class = annotation.class.name();
            writeln!(
                items,
                "<item><objectType>{class}</objectType><h>{height}</h><w>{width}</w><l>{length}</l>\
                 <first_frame>{number}</first_frame><poses><count>1</count><item_version>2</item_version><item>\
                 <tx>{x}</tx><ty>{y}</ty><tz>{}</tz><rx>0</rx><ry>0</ry><rz>{}</rz><state>2</state>\
                 <occlusion>{occlusion}</occlusion><occlusion_kf>0</occlusion_kf><truncation>-1</truncation>\
                 </item></poses><finished>1</finished></item>",
                z - height / 2.0,
                bounding_box.yaw_rad
            )
            .unwrap();
            n_items += 1;
        }
    }
    let tracklets = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\" ?>\n<!DOCTYPE boost_serialization>\n\
         <boost_serialization signature=\"serialization::archive\" version=\"9\"><tracklets class_id=\"0\">\n\
         <count>{n_items}</count><item_version>1</item_version>{items}</tracklets></boost_serialization>\n"
    );
    write(&folder.join(format!("{DRIVE}/tracklet_labels.xml")), tracklets);
    write(&folder.join(format!("{DRIVE}/velodyne_points/timestamps.txt")), times);
    let day = folder.join("2011_09_26");
    write(&day.join("calib_velo_to_cam.txt"), "calib_time: x\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n");
    write(&day.join("calib_imu_to_velo.txt"), "calib_time: x\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
    write(
        &day.join("calib_cam_to_cam.txt"),
        "corner_dist: 9.95e-02\nS_rect_02: 1242 375\nR_rect_00: 1 0 0 0 1 0 0 0 1\n\
         P_rect_02: 700 0 621 0 0 700 187 0 0 0 1 0\n",
    );
}
