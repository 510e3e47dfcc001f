//! The size of a PNG image, without decoding it.

use std::io::Read as _;
use std::path::Path;

use reports::files::regular_file::RegularFile;

use super::DatasetError;

/// Signature, length and name of the first chunk, width, height.
const N_HEADER_BYTES: usize = 24;

/// The beginning of every PNG file, up to the name of its first chunk.
const HEADER_START: [u8; 16] = *b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR";

/// Width and height in pixels of the image at `path`, from the first 24 bytes of the file.
pub fn png_size_px(path: &Path) -> Result<[u32; 2], DatasetError> {
    let io_error = DatasetError::io(path);
    let file = RegularFile::open(path).map_err(io_error)?;
    let mut header = Vec::with_capacity(N_HEADER_BYTES);
    file.take(N_HEADER_BYTES as u64).read_to_end(&mut header).map_err(io_error)?;
    size_in_header(&header).ok_or_else(|| DatasetError::damaged(path, "is not a PNG image"))
}

fn size_in_header(header: &[u8]) -> Option<[u32; 2]> {
    let (fields, _) = header.strip_prefix(&HEADER_START)?.as_chunks::<4>();
    let [width, height] = *fields else { return None };
    let size_px = [width, height].map(u32::from_be_bytes);
    (size_px[0] > 0 && size_px[1] > 0).then_some(size_px)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn header(width_px: u32, height_px: u32) -> Vec<u8> {
        [&HEADER_START[..], &width_px.to_be_bytes(), &height_px.to_be_bytes()].concat()
    }

    #[track_caller]
    fn check(bytes: &[u8], expected: Option<[u32; 2]>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("000000.png");
        std::fs::write(&path, bytes).unwrap();
        match (png_size_px(&path), expected) {
            (Ok(size_px), Some(expected)) => assert_eq!(size_px, expected),
            (Err(error), None) => assert!(error.to_string().ends_with("is not a PNG image"), "{error}"),
            (found, _) => panic!("{found:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn the_header_has_the_size() {
        check(&[header(1224, 370), b"and all the rest of the image".to_vec()].concat(), Some([1224, 370]));
    }

    #[test]
    fn what_is_no_image_is_refused() {
        check(b"", None);
        check(&header(1242, 375)[..23], None);
        check(&header(0, 375), None);
        check(b"\xff\xd8\xff\xe0 this is a JPEG, not a PNG", None);
    }

    proptest! {
        #[test]
        fn any_bytes_give_a_size_or_nothing(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = size_in_header(&bytes);
        }
    }
}
