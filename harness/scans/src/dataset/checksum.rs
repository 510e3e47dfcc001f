//! A checksum that tells whether a data set changed, and is cheap enough to be taken at every run.
//!
//! It is the SHA-256 of sorted lines, each ended by a newline:
//!
//! - `scan NAME SIZE` for every scan file and every file with a label a point, SIZE in bytes. Scans are by far the most of the data; hashing their contents
//!   would take longer than running the detectors, so a scan that changes but keeps its size is not noticed.
//! - `text NAME SHA256` for every label and calibration file, over its content.
//! - `image NAME WIDTHxHEIGHT` for the image size, in pixels, that the labelled region of the scan or sequence NAME is
//!   computed with.
//!
//! Names of files are relative to the folder of the data set, with `/` between folders, so that it may lie anywhere.

use sha2::{Digest as _, Sha256};

/// Collects what a data set is made of.
#[derive(Debug, Clone, Default)]
pub struct DatasetChecksum {
    lines: Vec<String>,
}

impl DatasetChecksum {
    /// Adds a scan file by its size.
    pub fn add_scan(&mut self, name: &str, n_bytes: u64) {
        self.lines.push(format!("scan {name} {n_bytes}\n"));
    }

    /// Adds a label or calibration file, or one of results, by its content.
    pub fn add_text(&mut self, name: &str, content: impl AsRef<[u8]>) {
        self.lines.push(format!("text {name} {}\n", sha256(content)));
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
    /// Adds what comes next.
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

/// SHA-256 of `content` in lower-case hexadecimal.
pub fn sha256(content: impl AsRef<[u8]>) -> String {
    let mut checksum = ContentChecksum::default();
    checksum.add(content.as_ref());
    checksum.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

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
