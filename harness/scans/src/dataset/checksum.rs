//! Checksums that show whether data changed, and are cheap enough for every run.
//!
//! The checksum of a data set is computed when it is opened, and that of each scan as it is read ([`checksum_as_read`]). The
//! former is the SHA-256 of sorted lines, each ended by a newline:
//!
//! - `scan NAME SIZE` for every scan file and every file with a label for each point, SIZE in bytes. Scans are by far the
//!   most of the data; hashing their contents would take longer than opening the data set. A change that keeps the size of a
//!   file shows in the checksums of the scans that are read.
//! - `text NAME SHA256` for every label and calibration file, over its content.
//! - `image NAME WIDTHxHEIGHT` for the image size, in pixels, that the labelled region of the scan or sequence NAME is
//!   computed with.
//!
//! Names of files are relative to the folder of the data set, with `/` between folders, so that it may lie anywhere.

use std::path::Path;

use sha2::{Digest as _, Sha256};

use super::DatasetError;
use super::on_disk::n_bytes_of;
use crate::annotation::{Annotation, LabeledScan};

/// Collects the files of a data set.
#[derive(Debug, Clone, Default)]
pub struct DatasetChecksum {
    lines: Vec<String>,
}

impl DatasetChecksum {
    /// Adds a scan file by its size.
    pub fn add_scan(&mut self, name: &str, n_bytes: u64) {
        self.lines.push(format!("scan {name} {n_bytes}\n"));
    }

    /// Adds the file at `path` by its size.
    pub fn add_file(&mut self, name: &str, path: &Path) -> Result<(), DatasetError> {
        self.add_scan(name, n_bytes_of(path)?);
        Ok(())
    }

    /// Adds a label or calibration file, or one of results, by its content.
    pub fn add_text(&mut self, name: &str, content: impl AsRef<[u8]>) {
        self.add_hashed(name, &sha256(content));
    }

    /// Adds a label or calibration file by the SHA-256 of its content.
    pub fn add_hashed(&mut self, name: &str, sha256: &str) {
        self.lines.push(format!("text {name} {sha256}\n"));
    }

    /// Adds the size of the image of the scan or sequence `name`, in pixels.
    pub fn add_image_size(&mut self, name: &str, [width_px, height_px]: [u32; 2]) {
        self.lines.push(format!("image {name} {width_px}x{height_px}\n"));
    }

    /// The checksum in lower-case hexadecimal; the order of the additions does not matter.
    pub fn finish(mut self) -> String {
        self.lines.sort_unstable();
        sha256(self.lines.concat())
    }
}

/// SHA-256 of content that comes piece by piece.
#[derive(Debug, Clone, Default)]
pub struct ContentChecksum(Sha256);

impl ContentChecksum {
    /// Adds the next bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The checksum in lower-case hexadecimal.
    pub fn finish(self) -> String {
        let digest = self.0.finalize();
        let digits = digest.iter().flat_map(|byte| [byte >> 4, byte & 15]);
        digits.map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)])).collect()
    }
}

/// CRC-32 of all values of a scan that results depend on, as it was read: points, annotations, and the parts without labels.
///
/// [`DatasetChecksum`] is of the files of a data set before any of them is read, so it takes large ones by their size. This
/// one also changes with labels that kept their size, with another transform, and with other names of classes.
pub fn checksum_as_read(scan: &LabeledScan) -> u32 {
    let LabeledScan { id: _, cloud, annotations, point_regions, labeled_area, points_left_out } = scan;
    let mut checksum = crc32fast::Hasher::new();
    for values in [cloud.x_m(), cloud.y_m(), cloud.z_m(), cloud.intensity()] {
        add(&mut checksum, values.iter().map(|it| it.to_le_bytes()));
    }
    add(&mut checksum, cloud.ring().unwrap_or_default().iter().map(|it| it.to_le_bytes()));
    add(&mut checksum, cloud.time_offset_s().unwrap_or_default().iter().map(|it| it.to_le_bytes()));
    for it in annotations {
        let Annotation { class, bounding_box, point_indices, track, occlusion, truncation } = it;
        checksum
            .update(format!("{class:?} {bounding_box:?} {track:?} {occlusion:?} {truncation:?}").as_bytes());
        add(&mut checksum, point_indices.iter().map(|it| it.to_le_bytes()));
    }
    add(&mut checksum, point_regions.iter().map(|it| [*it as u8]));
    checksum.update(format!("{labeled_area:?}").as_bytes());
    add(&mut checksum, points_left_out.iter().map(|it| it.to_le_bytes()));
    checksum.finalize()
}

/// Adds numbers, and how many they are.
fn add<const N: usize>(checksum: &mut crc32fast::Hasher, numbers: impl ExactSizeIterator<Item = [u8; N]>) {
    checksum.update(&(numbers.len() as u64).to_le_bytes());
    let bytes: Vec<[u8; N]> = numbers.collect();
    checksum.update(bytes.as_flattened());
}

/// SHA-256 of `content` in lower-case hexadecimal.
pub fn sha256(content: impl AsRef<[u8]>) -> String {
    let mut checksum = ContentChecksum::default();
    checksum.add(content.as_ref());
    checksum.finish()
}

#[cfg(test)]
mod tests {
    use detector::PointCloud;
    use reports::vocabulary::class::AnnotationClass;

    use super::*;
    use crate::annotation::{PointRegion, ScanId};

    fn street() -> DatasetChecksum {
        let mut checksum = DatasetChecksum::default();
        checksum.add_scan("velodyne/000001.bin", 32);
        checksum.add_text("label_2/000001.txt", "");
        checksum.add_image_size("000001", [1242, 375]);
        checksum
    }

    #[test]
    fn it_is_the_sha256_of_the_lines() {
        // printf 'image 000001 1242x375\nscan velodyne/000001.bin 32\ntext label_2/000001.txt %s\n' \
        //     "$(printf '' | sha256sum | cut -d ' ' -f 1)" | sha256sum
        assert_eq!(street().finish(), "6cd07de633514705fad581990f67c1f2f2a237e15cf0e9d0f75e05c8d45bc498");
    }

    #[test]
    fn the_order_of_the_files_does_not_matter() {
        let mut checksum = DatasetChecksum::default();
        checksum.add_image_size("000001", [1242, 375]);
        checksum.add_text("label_2/000001.txt", "");
        checksum.add_scan("velodyne/000001.bin", 32);
        assert_eq!(checksum.finish(), street().finish());
    }

    fn scan() -> LabeledScan {
        let mut cloud = PointCloud::default();
        cloud.push([1.0, 2.0, 3.0], 0.5);
        cloud.push([4.0, 5.0, 6.0], 0.25);
        let car =
            Annotation { point_indices: vec![1], track: Some(7), ..Annotation::of(AnnotationClass::Car) };
        LabeledScan::everywhere(ScanId { sequence: "0000".to_owned(), index: 3 }, cloud, vec![car])
    }

    #[test]
    fn all_that_was_read_changes_the_checksum_of_a_scan_and_its_name_does_not() {
        let before = checksum_as_read(&scan());
        let mut renamed = scan();
        renamed.id.index = 4;
        assert_eq!(checksum_as_read(&renamed), before);
        let changes: [fn(&mut LabeledScan); 8] = [
            |it| it.cloud.move_points(|[x_m, y_m, z_m]| [x_m, y_m, z_m + 1e-3]),
            |it| it.cloud.set_ring(vec![0, 1]),
            |it| it.annotations[0].class = AnnotationClass::Van,
            |it| it.annotations[0].point_indices = vec![0],
            |it| it.annotations[0].track = None,
            |it| it.annotations.clear(),
            |it| it.point_regions[0] = PointRegion::Outside,
            |it| it.points_left_out.push(9),
        ];
        for (idx, change) in changes.into_iter().enumerate() {
            let mut changed = scan();
            change(&mut changed);
            assert_ne!(checksum_as_read(&changed), before, "change {idx}");
        }
    }

    #[test]
    fn a_changed_label_or_size_changes_it() {
        for change in [
            |it: &mut DatasetChecksum| it.add_text("label_2/000002.txt", "Car"),
            |it: &mut DatasetChecksum| it.add_scan("velodyne/000002.bin", 16),
        ] {
            let mut changed = street();
            change(&mut changed);
            assert_ne!(changed.finish(), street().finish());
        }
    }
}
