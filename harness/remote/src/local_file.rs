//! The door through which files of this machine are opened: regular ones alone, and none is written through a link.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _};
use std::path::Path;

/// The largest text that is read, in bytes.
const MOST_OF_TEXT: u64 = 256 << 20;

/// Opens the file at `path` for reading, wherever links lead.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    // Opening a pipe waits, and opening a device can do something.
    refuse_irregular(&std::fs::metadata(path)?)?;
    opened(path, OpenOptions::new().read(true), Links::Followed)
}

/// The text of the file at `path`.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    let file = open(path)?;
    if file.metadata()?.len() > MOST_OF_TEXT {
        return Err(io::ErrorKind::FileTooLarge.into());
    }
    let mut text = String::new();
    file.take(MOST_OF_TEXT).read_to_string(&mut text)?;
    Ok(text)
}

/// Opens the file at `path` to add to it, and makes it if it is not there. A link is refused.
pub(crate) fn open_to_add(path: &Path) -> io::Result<File> {
    opened(path, OpenOptions::new().append(true).create(true), Links::Refused)
}

/// Creates the file at `path` in place of a file or a link that is there; the target of the link stays as it is.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    match std::fs::symlink_metadata(path) {
        Ok(it) if it.is_file() || it.is_symlink() => std::fs::remove_file(path)?,
        Ok(it) => refuse_irregular(&it)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    File::create_new(path)
}

#[derive(Clone, Copy)]
enum Links {
    Followed,
    Refused,
}

fn opened(path: &Path, how: &mut OpenOptions, links: Links) -> io::Result<File> {
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt as _;

        let flags = match links {
            Links::Followed => OFlags::NONBLOCK,
            Links::Refused => OFlags::NONBLOCK | OFlags::NOFOLLOW,
        };
        how.custom_flags(flags.bits() as i32);
    }
    #[cfg(not(unix))]
    let _ = links;
    let file = how.open(path)?;
    refuse_irregular(&file.metadata()?)?;
    Ok(file)
}

fn refuse_irregular(metadata: &std::fs::Metadata) -> io::Result<()> {
    if metadata.is_file() {
        Ok(())
    } else {
        Err(io::Error::other("it is a pipe, a device or a folder, not a file"))
    }
}
