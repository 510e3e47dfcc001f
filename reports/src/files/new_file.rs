//! Opening of files for writing, never through a link.
//!
//! The folder that a user names may be a link. Its entries may come from other people, and nothing is written through a
//! link there. A [whole file](super::whole_file) does not need these functions: it replaces the link.

use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

/// The name of a file after something that files of others may have named, without its ending: what is neither a letter, a
/// digit nor a hyphen is an underscore.
pub fn file_stem_of(name: &str) -> String {
    name.chars().map(|it| if it.is_ascii_alphanumeric() || it == '-' { it } else { '_' }).collect()
}

/// Whether the `error` of a lock says that the file system has none, like Lustre without `flock` and NFS without its daemon for
/// locks.
pub fn has_no_locks(error: &io::Error) -> bool {
    #[cfg(unix)]
    let is_of_daemon = error.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error());
    #[cfg(not(unix))]
    let is_of_daemon = false;
    is_of_daemon || error.kind() == io::ErrorKind::Unsupported
}

/// Creates the file `path`. A file or link of that name is removed; the target of the link stays as it is.
///
/// # Errors
///
/// If there is a folder, a pipe or a device, or if the operating system refuses.
pub fn create_file(path: &Path) -> io::Result<File> {
    match std::fs::symlink_metadata(path) {
        Ok(it) if it.is_file() || it.is_symlink() => std::fs::remove_file(path)?,
        Ok(it) => refuse_other_than_one_file(&it)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Opens the file `path` to read it and to append to it. It is made if it is missing.
///
/// # Errors
///
/// If there is a link or anything else but a file, or if the operating system refuses.
pub fn open_to_add(path: &Path) -> io::Result<File> {
    match std::fs::symlink_metadata(path) {
        Ok(metadata) => refuse_other_than_one_file(&metadata)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt as _;

        options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32);
    }
    let file = options.read(true).append(true).create(true).open(path)?;
    // Something else may have taken the name since.
    refuse_other_than_one_file(&file.metadata()?)?;
    Ok(file)
}

/// Makes the folder `name` in `folder` unless it is there, and returns its path.
///
/// # Errors
///
/// As [`open_to_add`].
pub fn make_folder(folder: &Path, name: impl AsRef<Path>) -> io::Result<PathBuf> {
    let path = folder.join(name);
    match std::fs::create_dir(&path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        made => made?,
    }
    let metadata = std::fs::symlink_metadata(&path)?;
    if metadata.is_dir() {
        Ok(path)
    } else if metadata.is_symlink() {
        Err(a_link())
    } else {
        Err(io::ErrorKind::NotADirectory.into())
    }
}

/// Gives the file `from` the second name `to`, or copies it where links are impossible. An existing `to` stays.
///
/// # Errors
///
/// If `from` is no file but a link, or if the operating system refuses.
pub fn add_name(from: &Path, to: &Path) -> io::Result<()> {
    if !std::fs::symlink_metadata(from)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it would be a copy of what is no file"));
    }
    std::fs::hard_link(from, to).or_else(|_| {
        let mut copy = OpenOptions::new().write(true).create_new(true).open(to)?;
        io::copy(&mut super::regular_file::RegularFile::open(from)?, &mut copy).map(|_| ())
    })
}

fn refuse_other_than_one_file(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_symlink() || n_names(metadata) > 1 && metadata.is_file() {
        return Err(a_link());
    }
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !metadata.is_file() {
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, "it is a pipe or a device, not a file"));
    }
    Ok(())
}

#[cfg(unix)]
fn n_names(metadata: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::nlink(metadata)
}

#[cfg(not(unix))]
fn n_names(_: &Metadata) -> u64 {
    1
}

fn a_link() -> io::Error {
    io::Error::new(io::ErrorKind::AlreadyExists, "it is a link, and nothing is written through one")
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::Write as _;

    use super::*;

    const A_LINK: &str = "it is a link, and nothing is written through one";

    #[cfg(target_os = "linux")]
    #[test]
    fn disks_without_locks_say_so_in_several_ways() {
        // Function not implemented, operation not supported, no locks available; then permission denied.
        let has_none = |it| has_no_locks(&io::Error::from_raw_os_error(it));
        assert_eq!([38, 95, 37, 13].map(has_none), [true, true, true, false]);
    }

    #[test]
    fn what_is_no_link_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for content in ["long before", "new"] {
            create_file(&path).unwrap().write_all(content.as_bytes()).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), content);
        }
        open_to_add(&path).unwrap().write_all(b" and more").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new and more");
        let figures = make_folder(folder.path(), "figures").unwrap();
        assert_eq!(make_folder(folder.path(), "figures").unwrap(), figures);
        add_name(&path, &figures.join("b")).unwrap();
        assert_eq!(std::fs::read_to_string(figures.join("b")).unwrap(), "new and more");
    }

    #[test]
    fn nothing_is_written_through_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let theirs = elsewhere.path().join("theirs");
        std::fs::write(&theirs, "theirs").unwrap();
        let place = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink(&theirs, place("link")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path().join("gone"), place("dangling")).unwrap();
        std::fs::hard_link(&theirs, place("second")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), place("figures")).unwrap();
        for name in ["link", "dangling", "second"] {
            assert_eq!(open_to_add(&place(name)).unwrap_err().to_string(), A_LINK, "{name}");
        }
        assert!(add_name(&place("link"), &place("copy")).is_err());
        assert_eq!(make_folder(folder.path(), "figures").unwrap_err().to_string(), A_LINK);
        for name in ["link", "dangling", "second"] {
            create_file(&place(name)).unwrap().write_all(b"ours").unwrap();
            assert_eq!(std::fs::read_to_string(place(name)).unwrap(), "ours");
        }
        assert_eq!(std::fs::read_to_string(&theirs).unwrap(), "theirs");
        assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 1);
    }

    #[test]
    fn pipes_are_not_waited_for() {
        use rustix::fs::{CWD, FileType, Mode, mknodat};

        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        assert!(open_to_add(&pipe).is_err() && create_file(&pipe).is_err());
        assert!(pipe.exists());
    }
}
