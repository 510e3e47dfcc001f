//! Free space on the disk of a folder.

use std::path::Path;

use crate::RemoteError;

/// Bytes that stay free at the end.
const RESERVE_BYTES: u64 = 64 << 20;

/// Makes sure that `n_bytes` more fit into `folder`, which need not be there yet; `option` chooses another one.
///
/// # Errors
///
/// [`RemoteError::NoRoom`]. Where the system does not tell the free space, everything fits.
pub fn check_space(folder: &Path, n_bytes: u64, option: &'static str) -> Result<(), RemoteError> {
    match free_bytes(folder) {
        Some(n_free_bytes) if n_bytes > 0 && n_bytes.saturating_add(RESERVE_BYTES) > n_free_bytes => {
            let folder = folder.to_path_buf();
            Err(RemoteError::NoRoom { folder, n_needed_bytes: n_bytes, n_free_bytes, option })
        }
        _ => Ok(()),
    }
}

/// How many bytes fit into `folder`, which need not be there yet.
#[cfg(unix)]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    let folder = std::path::absolute(folder).ok()?;
    let there = folder.ancestors().find(|it| it.exists())?;
    let of_disk = rustix::fs::statvfs(there).ok()?;
    Some(of_disk.f_bavail.saturating_mul(of_disk.f_frsize))
}

/// Bytes that fit into a folder: not known on this system.
#[cfg(not(unix))]
pub fn free_bytes(_: &Path) -> Option<u64> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_before_anything_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("not/yet/there");
        check_space(&inner, 1, "--into").unwrap();
        let error = check_space(&inner, 1 << 60, "--into").unwrap_err().to_string();
        assert!(error.contains("--into") && error.contains("1152921.5 TB are missing"), "{error}");
        assert!(!inner.exists());
    }
}
