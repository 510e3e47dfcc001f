//! Small data sets in KITTI's layouts, made of drawn points.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};

/// A camera at the sensor that looks along x.
const CALIBRATION: &str = "\
P2: 700 0 621 0 0 700 187 0 0 0 1 0
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0
";

/// KITTI's sensor stands this high above the road.
const SENSOR_HEIGHT_M: f32 = 1.73;

const LENGTH_WIDTH_HEIGHT_M: [f32; 3] = [4.2, 1.8, 1.5];

/// Where the two cars of scan `number` are: the one ahead drives off, the one beside the road is parked.
fn car_centers_m(number: u32) -> [[f32; 2]; 2] {
    [[12.0 + 0.5 * number as f32, -1.5], [18.0, 4.5]]
}

/// A folder `street` in the layout of a benchmark, in a folder that is there already.
pub struct DrawnDataset {
    /// The folder.
    pub root: PathBuf,
}

impl DrawnDataset {
    /// A drive of `n_scans` scans in the layout of the tracking benchmark.
    pub fn tracking(parent: &Path, n_scans: u32) -> Self {
        let dataset = Self { root: parent.join("street") };
        let mut labels = Vec::new();
        for number in 0..n_scans {
            dataset.write(&format!("training/velodyne/0000/{number:06}.bin"), bytes_of(&scan(number)));
            for (track, center_m) in car_centers_m(number).into_iter().enumerate() {
                labels.push(format!("{number} {track} {}\n", label(center_m)));
            }
        }
        dataset.write("training/label_02/0000.txt", labels.concat());
        dataset.write("training/calib/0000.txt", CALIBRATION);
        dataset
    }

    /// Scans 0 to `n_scans` in the layout of the object benchmark.
    pub fn objects(parent: &Path, n_scans: u32) -> Self {
        let dataset = Self { root: parent.join("street") };
        for number in 0..n_scans {
            dataset.write(&format!("training/velodyne/{number:06}.bin"), bytes_of(&scan(number)));
            let labels = car_centers_m(number).map(label).join("\n");
            dataset.write(&format!("training/label_2/{number:06}.txt"), labels);
            dataset.write(&format!("training/calib/{number:06}.txt"), CALIBRATION);
        }
        dataset
    }

    /// Repeats scan 0 of the drive under the numbers up to `n_scans`.
    pub fn repeat_first_scan(&self, n_scans: u32) {
        for number in 1..n_scans {
            let repeated = self.path(&format!("training/velodyne/0000/{number:06}.bin"));
            std::fs::hard_link(self.path("training/velodyne/0000/000000.bin"), repeated).unwrap();
        }
    }

    /// Where the file `name` is.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Writes the file `name`.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }

    /// Changes the bytes of the file `name`.
    pub fn change(&self, name: &str, change: impl FnOnce(&mut Vec<u8>)) {
        let mut bytes = std::fs::read(self.path(name)).unwrap();
        change(&mut bytes);
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// Removes the file `name`.
    pub fn remove(&self, name: &str) {
        std::fs::remove_file(self.path(name)).unwrap();
    }
}

/// A car that heads along x, as a line of a label file.
fn label([x_m, y_m]: [f32; 2]) -> String {
    let [length_m, width_m, height_m] = LENGTH_WIDTH_HEIGHT_M;
    format!(
        "Car 0 0 0 500 150 700 300 {height_m} {width_m} {length_m} {} {SENSOR_HEIGHT_M} {x_m} -1.5707963",
        -y_m
    )
}

/// Points of a level road with two cars on it.
fn scan(number: u32) -> Vec<[f32; 3]> {
    let mut points_m = Vec::new();
    for along in 0..160 {
        for across in 0..64 {
            let at_m = |step: i32, first_m: f32| first_m + (step as f32 + 0.5) * 0.25;
            points_m.push([at_m(along, 0.0), at_m(across, -8.0), -SENSOR_HEIGHT_M]);
        }
    }
    for [x_m, y_m] in car_centers_m(number) {
        push_car([x_m, y_m], &mut points_m);
    }
    points_m
}

/// Points on the sides and the top of a car, a little inside of its box so that rounding leaves them there.
fn push_car([x_m, y_m]: [f32; 2], points_m: &mut Vec<[f32; 3]>) {
    let n_steps = LENGTH_WIDTH_HEIGHT_M.map(|side_m| (side_m / 0.12) as usize);
    for along in 0..=n_steps[0] {
        for across in 0..=n_steps[1] {
            for up in 0..=n_steps[2] {
                let steps = [along, across, up];
                let is_on_side = (0..2).any(|axis| steps[axis] == 0 || steps[axis] == n_steps[axis]);
                if !is_on_side && up < n_steps[2] {
                    continue;
                }
                let from_center = |axis: usize| {
                    let share = steps[axis] as f32 / n_steps[axis] as f32 - 0.5;
                    share * (LENGTH_WIDTH_HEIGHT_M[axis] - 0.1)
                };
                let center_z_m = 0.5 * LENGTH_WIDTH_HEIGHT_M[2] - SENSOR_HEIGHT_M;
                points_m.push([x_m + from_center(0), y_m + from_center(1), center_z_m + from_center(2)]);
            }
        }
    }
}

fn bytes_of(points_m: &[[f32; 3]]) -> Vec<u8> {
    let with_intensity = points_m.iter().flat_map(|&[x, y, z]| [x, y, z, 0.5]);
    with_intensity.flat_map(f32::to_le_bytes).collect()
}
