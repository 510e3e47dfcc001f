//! The points of a scan in shared memory, as a detector reads them: the other side of
//! [`SharedCloud`](super::shared_cloud::SharedCloud).

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;
use std::path::Path;

use detector::PointCloud;

use super::message::AskedScan;

/// Columns that our detectors read. The intensity may be missing.
const COLUMNS: [&str; 4] = ["x_m", "y_m", "z_m", INTENSITY];
const INTENSITY: &str = "intensity";

/// Points of the latest scan, with the memory that they come in.
pub struct ReceivedCloud {
    memory: File,
    columns: [Vec<f32>; COLUMNS.len()],
    cloud: PointCloud,
}

impl ReceivedCloud {
    /// Opens the memory at `path`.
    ///
    /// # Errors
    ///
    /// If the operating system refuses.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self { memory: File::open(path)?, columns: Default::default(), cloud: PointCloud::default() })
    }

    /// The points of `asked`.
    ///
    /// # Errors
    ///
    /// The column that is missing or cannot be read, as a sentence.
    pub fn read(&mut self, asked: &AskedScan) -> Result<&PointCloud, String> {
        for (name, values) in COLUMNS.into_iter().zip(&mut self.columns) {
            values.resize(asked.n_points, 0.0);
            match asked.columns.iter().find(|it| it.name == name) {
                Some(column) => {
                    // Read directly into the column: the clock runs.
                    let bytes = bytemuck::cast_slice_mut(values);
                    let read = self.memory.read_exact_at(bytes, column.offset as u64);
                    read.map_err(|error| format!("{name} cannot be read: {error}"))?;
                    // Changes nothing on little-endian processors.
                    for value in values.iter_mut() {
                        *value = f32::from_bits(u32::from_le(value.to_bits()));
                    }
                }
                None if name == INTENSITY => values.fill(0.0),
                None => return Err(format!("there is no column {name}")),
            }
        }
        self.cloud.swap_columns(&mut self.columns);
        Ok(&self.cloud)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::shared_cloud::SharedCloud;

    #[test]
    fn points_arrive_as_they_were_written() {
        let mut shared = SharedCloud::with_room(100).unwrap();
        let mut received = ReceivedCloud::open(shared.path().unwrap()).unwrap();
        for n_points in [17_u8, 100, 3, 0] {
            let mut cloud = PointCloud::default();
            (0..n_points).for_each(|it| cloud.push([it, it / 2, 255 - it].map(f32::from), f32::from(it)));
            let columns = shared.write([&cloud]).unwrap().remove(0);
            let mut asked = AskedScan {
                number: 1,
                name: "0001/000017".to_owned(),
                time_s: 0.0,
                n_points: cloud.len(),
                columns,
                begins_drive: false,
                world_from_sensor: None,
                earlier: Vec::new(),
            };
            assert_eq!(received.read(&asked).unwrap(), &cloud);
            asked.columns.retain(|it| it.name != INTENSITY);
            assert!(received.read(&asked).unwrap().intensity().iter().all(|it| *it == 0.0));
            asked.columns.remove(1);
            assert_eq!(received.read(&asked).unwrap_err(), "there is no column y_m");
        }
    }
}
