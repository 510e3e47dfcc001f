//! The points of a scan in a file in shared memory that detectors map.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

use detector::PointCloud;
use reports::files::unfinished::{Kind, Unfinished};

use super::message::Column;

/// Columns begin at multiples of this, in bytes.
const ALIGNMENT: usize = 64;
/// Most columns of a cloud, of at most four bytes each.
const MOST_COLUMNS: usize = 6;
/// Folder of files in memory; where it is missing, ordinary temporary files are used.
const IN_MEMORY: &str = "/dev/shm";

/// A file with room for the points of a scan.
pub struct SharedCloud {
    file: File,
    max_points: usize,
    name: Option<(PathBuf, Unfinished)>,
    bytes: Vec<u8>,
    // Where the next column begins.
    end: usize,
}

/// How many points a file has to have room for if these clouds are to be written together.
pub fn room_for<'a>(clouds: impl IntoIterator<Item = &'a PointCloud>) -> usize {
    clouds.into_iter().map(|it| it.len().next_multiple_of(ALIGNMENT / size_of::<f32>())).sum()
}

impl SharedCloud {
    /// Room for `max_points`.
    ///
    /// # Errors
    ///
    /// If there is not enough memory.
    pub fn with_room(max_points: usize) -> io::Result<Self> {
        let folder =
            if Path::new(IN_MEMORY).is_dir() { PathBuf::from(IN_MEMORY) } else { std::env::temp_dir() };
        // Nobody can guess the name, and nobody else can read the file.
        let create = || {
            tempfile::Builder::new()
                .prefix("scanbench-")
                .rand_bytes(16)
                .tempfile_in(&folder)?
                .keep()
                .map_err(|it| it.error)
        };
        let (entry, (file, path)) =
            Unfinished::begin(Kind::Memory, create, |(_, path)| path.clone()).map_err(about_memory)?;
        let n_bytes = MOST_COLUMNS * column_bytes(max_points);
        let shared = Self { file, max_points, name: Some((path, entry)), bytes: Vec::new(), end: 0 };
        shared.file.set_len(n_bytes.max(1) as u64).map_err(about_memory)?;
        Ok(shared)
    }

    /// Most points of a scan that it has room for.
    pub fn max_points(&self) -> usize {
        self.max_points
    }

    /// Path of the file; `None` once it has been [hidden](Self::hide).
    pub fn path(&self) -> Option<&Path> {
        self.name.as_ref().map(|(path, _)| path.as_path())
    }

    /// Removes the name of the file: processes that have mapped it keep it, and nothing is left behind.
    pub fn hide(&mut self) {
        if let Some((path, entry)) = self.name.take() {
            let _ = entry.undisturbed(|| std::fs::remove_file(path));
        }
    }

    /// Writes the points of `clouds`, one after the other. Returns the columns of each with their positions.
    ///
    /// # Errors
    ///
    /// If the memory cannot be written.
    pub fn write<'a>(
        &mut self,
        clouds: impl IntoIterator<Item = &'a PointCloud>,
    ) -> io::Result<Vec<Vec<Column>>> {
        self.end = 0;
        clouds.into_iter().map(|it| self.add(it)).collect()
    }

    fn add(&mut self, cloud: &PointCloud) -> io::Result<Vec<Column>> {
        let mut written = Vec::new();
        let coordinates = [("x_m", cloud.x_m()), ("y_m", cloud.y_m()), ("z_m", cloud.z_m())];
        let numbers = coordinates.into_iter().chain([("intensity", cloud.intensity())]);
        for (name, values) in numbers.chain(cloud.time_offset_s().map(|it| ("time_offset_s", it))) {
            self.write_column(name, "f32", values.iter().map(|it| it.to_le_bytes()), &mut written)?;
        }
        if let Some(ring) = cloud.ring() {
            self.write_column("ring", "u16", ring.iter().map(|it| it.to_le_bytes()), &mut written)?;
        }
        Ok(written)
    }

    /// Writes the next column, called `name` and of the type `kind`, after those that are `written`.
    fn write_column<const N: usize>(
        &mut self,
        name: &str,
        kind: &str,
        values: impl ExactSizeIterator<Item = [u8; N]>,
        written: &mut Vec<Column>,
    ) -> io::Result<()> {
        let offset = self.end;
        // As if all values had four bytes, for which there is room.
        self.end += column_bytes(values.len());
        self.bytes.clear();
        self.bytes.extend(values.flatten());
        self.file.write_all_at(&self.bytes, offset as u64).map_err(about_memory)?;
        written.push(Column { name: name.to_owned(), kind: kind.to_owned(), offset });
        Ok(())
    }
}

impl Drop for SharedCloud {
    fn drop(&mut self) {
        self.hide();
    }
}

/// Adds advice to errors for lack of shared memory, of which containers have little.
fn about_memory(error: io::Error) -> io::Error {
    if error.kind() != io::ErrorKind::StorageFull {
        return error;
    }
    let what = format!(
        "{error}: {IN_MEMORY} is too small for the points of a scan; free some of it, or give a container more, as with \
         `docker run --shm-size=1g`"
    );
    io::Error::new(io::ErrorKind::StorageFull, what)
}

fn column_bytes(n_points: usize) -> usize {
    (n_points * size_of::<f32>()).next_multiple_of(ALIGNMENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_stand_where_it_is_said() {
        let mut cloud = PointCloud::default();
        (0..17_u8).for_each(|it| cloud.push([it, it + 50, it + 100].map(f32::from), 0.5));
        let mut shared = SharedCloud::with_room(17).unwrap();
        let path = shared.path().unwrap().to_owned();
        let mapped = File::open(&path).unwrap();
        shared.hide();
        assert!(!path.exists());
        let columns = shared.write([&cloud]).unwrap().remove(0);
        let names = |columns: &[Column]| columns.iter().map(|it| it.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&columns), ["x_m", "y_m", "z_m", "intensity"]);
        for (column, values) in columns.iter().zip([cloud.x_m(), cloud.y_m(), cloud.z_m(), cloud.intensity()])
        {
            assert_eq!(column.offset % ALIGNMENT, 0);
            let mut bytes = vec![0; 4 * cloud.len()];
            mapped.read_exact_at(&mut bytes, column.offset as u64).unwrap();
            let read: Vec<f32> =
                bytes.chunks_exact(4).map(|it| f32::from_le_bytes(it.try_into().unwrap())).collect();
            assert_eq!(read, values);
        }
        cloud.set_ring((0..17).map(|it| 60_000 + it).collect());
        cloud.set_time_offset_s(vec![-0.05; 17]);
        let columns = shared.write([&cloud]).unwrap().remove(0);
        assert_eq!(names(&columns), ["x_m", "y_m", "z_m", "intensity", "time_offset_s", "ring"]);
        let [.., time, ring] = &columns[..] else { panic!("{columns:?}") };
        let mut bytes = [0; 2 * 17];
        mapped.read_exact_at(&mut bytes, ring.offset as u64).unwrap();
        assert_eq!((&bytes[32..], ring.kind.as_str()), (&60_016_u16.to_le_bytes()[..], "u16"));
        mapped.read_exact_at(&mut bytes[..4], time.offset as u64 + 64).unwrap();
        assert_eq!((&bytes[..4], time.kind.as_str()), (&(-0.05_f32).to_le_bytes()[..], "f32"));
    }

    #[test]
    fn several_clouds_stand_one_after_the_other() {
        let cloud = |n: u8| (0..n).map(|it| [f32::from(it), 0.0, f32::from(n)]).collect::<PointCloud>();
        let clouds = [cloud(17), cloud(3), cloud(0), cloud(40)];
        let mut shared = SharedCloud::with_room(room_for(&clouds)).unwrap();
        assert_eq!(shared.max_points(), 32 + 16 + 48);
        let columns = shared.write(&clouds).unwrap();
        let offsets: Vec<usize> = columns.iter().flatten().map(|it| it.offset).collect();
        assert_eq!(offsets[..9], [0, 128, 256, 384, 512, 576, 640, 704, 768]);
        for (cloud, columns) in clouds.iter().zip(&columns) {
            let mut bytes = vec![0; 4 * cloud.len()];
            shared.file.read_exact_at(&mut bytes, columns[2].offset as u64).unwrap();
            assert!(bytes.as_chunks::<4>().0.iter().all(|it| *it == (cloud.len() as f32).to_le_bytes()));
        }
    }

    #[test]
    fn nobody_else_reads_it_or_guesses_its_name() {
        use std::os::unix::fs::PermissionsExt as _;

        let shared = [0, 0].map(|it| SharedCloud::with_room(it).unwrap());
        let paths = shared.each_ref().map(|it| it.path().unwrap());
        assert_eq!(shared[0].file.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        let letters = |path: &Path| path.file_name().unwrap().len() - "scanbench-".len();
        assert!(paths[0] != paths[1] && letters(paths[0]) == 16, "{paths:?}");
    }

    #[test]
    fn nothing_is_left_behind() {
        let shared = SharedCloud::with_room(0).unwrap();
        let path = shared.path().unwrap().to_owned();
        assert!(path.exists());
        drop(shared);
        assert!(!path.exists());
    }
}
