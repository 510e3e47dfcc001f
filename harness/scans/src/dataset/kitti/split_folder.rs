//! The folder of a KITTI split (`training`) or of a benchmark like it. Its files are checked for existence and added to the
//! checksum as they are read.

use std::path::{Path, PathBuf};

use crate::dataset::DatasetError;
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::on_disk::is_there;
use crate::dataset::png_size::png_size_px;
use crate::dataset::scan_sizes::ScanSizes;
use crate::dataset::source::DamagePolicy;
use crate::dataset::text_file::read_text_file;

/// The sensor of the KITTI recordings.
pub const KITTI_SENSOR: &str = "hdl-64e-s2";

/// The scanner's height above the road in KITTI's car, in metres.
pub const KITTI_SENSOR_HEIGHT_M: f32 = 1.73;

/// The size of most of KITTI's images, in pixels. Others are up to 18 columns and 6 rows smaller or larger.
const USUAL_IMAGE_SIZE_PX: [u32; 2] = [1242, 375];

/// A folder with its checksum so far. Names of files are relative to it, with `/` between folders.
#[derive(Debug, Clone)]
pub struct SplitFolder {
    path: PathBuf,
    checksum: DatasetChecksum,
    sizes: ScanSizes,
}

impl SplitFolder {
    /// The folder `path`, whose scans are in `velodyne`; `labels` is the folder of the labels.
    pub fn with_labels(path: &Path, labels: &str) -> Result<Self, DatasetError> {
        let folder = Self::unchecked(path);
        if folder.path_of(labels).is_dir() {
            return Ok(folder);
        }
        Err(DatasetError::unlabeled(&folder.path_of("velodyne"), &folder.path_of(labels)))
    }

    /// The folder `path` with any content.
    pub fn unchecked(path: &Path) -> Self {
        Self { path: path.to_path_buf(), checksum: DatasetChecksum::default(), sizes: ScanSizes::default() }
    }

    /// The path of the file `name`.
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Adds the size of the scan `name` to the checksum, and returns its path.
    pub fn add_scan(&mut self, name: &str) -> PathBuf {
        let path = self.path_of(name);
        self.checksum.add_scan(name, self.sizes.n_bytes_of(&path));
        path
    }

    /// Reads the text file `name` and adds it to the checksum; `missing` makes the error if it does not exist.
    pub fn read_text(
        &mut self,
        name: &str,
        missing: impl FnOnce(&Path) -> DatasetError,
    ) -> Result<String, DatasetError> {
        let text = match read_text_file(&self.path_of(name)) {
            Err(DatasetError::Io { path, source }) if source.kind() == std::io::ErrorKind::NotFound => {
                return Err(missing(&path));
            }
            result => result?,
        };
        self.checksum.add_text(name, &text);
        Ok(text)
    }

    /// Reads the text file `name` and adds it to the checksum; `None` if it does not exist.
    pub fn read_text_if_present(&mut self, name: &str) -> Result<Option<String>, DatasetError> {
        if is_there(&self.path_of(name)) {
            self.read_text(name, DatasetError::missing_selected).map(Some)
        } else {
            Ok(None)
        }
    }

    /// Width and height in pixels of `image`, added to the checksum under `name`.
    ///
    /// If `image` does not exist, the size is that of most drives, 1242 × 375: no text file of KITTI states it, and the
    /// images are a separate download that scans do not need.
    pub fn image_size_px(&mut self, name: &str, image: &Path) -> Result<[u32; 2], DatasetError> {
        let size_px = if is_there(image) { png_size_px(image)? } else { USUAL_IMAGE_SIZE_PX };
        self.checksum.add_image_size(name, size_px);
        Ok(size_px)
    }

    /// The checksum of all files that were read.
    ///
    /// # Errors
    ///
    /// If scans cannot be read, unless damage is skipped.
    pub fn finish(self, damage: DamagePolicy) -> Result<String, DatasetError> {
        self.sizes.check(&self.path, damage)?;
        Ok(self.checksum.finish())
    }
}
