//! Opening of regular files for reading.
//!
//! A file from other people may be a pipe that never ends or a device without an end. Only regular files are opened, and
//! only the bytes that they had at that time are read.

use std::fs::{File, FileType, Metadata, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// The largest file of settings, in bytes: people write them by hand.
pub const MOST_OF_SETTINGS: u64 = 1 << 24;
/// The largest file of a trained model, in bytes.
pub const MOST_OF_MODEL: u64 = 1 << 30;

/// A regular file that is read up to the size that it had when it was opened.
#[derive(Debug)]
pub struct RegularFile {
    file: File,
    n_bytes: u64,
    position: u64,
}

impl RegularFile {
    /// Opens the file at `path`; links are followed.
    ///
    /// # Errors
    ///
    /// If it is a folder, a pipe, a device or a socket, or if the operating system refuses.
    pub fn open(path: &Path) -> io::Result<Self> {
        // Opening a device can have effects, and opening a pipe waits.
        refuse_irregular(&std::fs::metadata(path)?)?;
        let file = open_at_once(path)?;
        // Something else may have taken the name since.
        let metadata = file.metadata()?;
        refuse_irregular(&metadata)?;
        Ok(Self { file, n_bytes: metadata.len(), position: 0 })
    }

    /// The size of the file in bytes, when it was opened.
    pub fn n_bytes(&self) -> u64 {
        self.n_bytes
    }
}

impl Read for RegularFile {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n_left = usize::try_from(self.n_bytes.saturating_sub(self.position)).unwrap_or(usize::MAX);
        let n_wanted = buffer.len().min(n_left);
        let n_read = self.file.read(&mut buffer[..n_wanted])?;
        self.position += n_read as u64;
        Ok(n_read)
    }
}

impl Seek for RegularFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.position = self.file.seek(to)?;
        Ok(self.position)
    }
}

/// All bytes of the regular file at `path`, at most `n_most_bytes`.
///
/// The file is read, not mapped into memory: if another program cut a mapped file off, the process would end.
///
/// # Errors
///
/// As [`RegularFile::open`], or if the file has more bytes or the memory does not suffice.
pub fn read_bytes(path: &Path, n_most_bytes: u64) -> io::Result<Vec<u8>> {
    let mut file = RegularFile::open(path)?;
    let n_bytes = file.n_bytes();
    if n_bytes > n_most_bytes {
        return Err(too_large(&format!("it has {n_bytes} bytes"), n_most_bytes));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(n_bytes).unwrap_or(usize::MAX)).map_err(io::Error::other)?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of the regular file at `path`, at most `n_most_bytes` long.
///
/// # Errors
///
/// As [`read_bytes`], or if it is not UTF-8.
pub fn read_text(path: &Path, n_most_bytes: u64) -> io::Result<String> {
    text_of(read_bytes(path, n_most_bytes)?)
}

/// The settings at `path`, which the user has named: a regular file, or a pipe as made by `<(…)` of a shell; `/dev/null`
/// has none.
///
/// # Errors
///
/// As [`read_bytes`], or if a pipe gives nothing or has no end.
pub fn read_settings(path: &Path) -> io::Result<Vec<u8>> {
    let file_type = std::fs::metadata(path)?.file_type();
    if !is_pipe(file_type) && !is_null_device(path) {
        return read_bytes(path, MOST_OF_SETTINGS);
    }
    // A pipe without writers has ended.
    let file = open_at_once(path)?;
    wait_for_writers(&file)?;
    let mut bytes = Vec::new();
    file.take(MOST_OF_SETTINGS + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST_OF_SETTINGS {
        return Err(too_large("it gives more", MOST_OF_SETTINGS));
    }
    if bytes.is_empty() && is_pipe(file_type) {
        return Err(io::Error::other("it is a pipe that gives nothing"));
    }
    Ok(bytes)
}

/// The settings at `path` as text.
///
/// # Errors
///
/// As [`read_settings`], or if they are not UTF-8.
pub fn read_settings_text(path: &Path) -> io::Result<String> {
    text_of(read_settings(path)?)
}

/// A reader that fails at a line of more than `n_most_bytes`: a line of zeros takes no room on a disk, but all the memory
/// of a program that waits for its end.
#[derive(Debug)]
pub struct BoundedLines<R> {
    reader: R,
    n_most_bytes: u64,
    n_in_line: u64,
}

impl<R: Read> BoundedLines<R> {
    /// Bounds the lines of `reader`.
    pub fn new(reader: R, n_most_bytes: u64) -> Self {
        Self { reader, n_most_bytes, n_in_line: 0 }
    }

    /// The reader itself.
    pub fn into_inner(self) -> R {
        self.reader
    }
}

impl<R: Read> Read for BoundedLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n_read = self.reader.read(buffer)?;
        let n_read_of_line = match buffer[..n_read].iter().rposition(|it| *it == b'\n') {
            Some(end) => {
                self.n_in_line = 0;
                n_read - end - 1
            }
            None => n_read,
        };
        self.n_in_line += n_read_of_line as u64;
        if self.n_in_line > self.n_most_bytes {
            return Err(too_large("it has a line with more", self.n_most_bytes));
        }
        Ok(n_read)
    }
}

fn text_of(bytes: Vec<u8>) -> io::Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let problem = format!("it is not UTF-8 from byte {} on", error.utf8_error().valid_up_to());
        io::Error::new(io::ErrorKind::InvalidData, problem)
    })
}

fn too_large(what: &str, n_most_bytes: u64) -> io::Error {
    let problem = format!("{what}, but {n_most_bytes} bytes are the most that is read");
    io::Error::new(io::ErrorKind::FileTooLarge, problem)
}

/// Fails for anything but a regular file; the error names what it is.
fn refuse_irregular(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let what = if is_pipe(metadata.file_type()) { "a pipe" } else { "a device or a socket" };
    Err(io::Error::other(format!("it is {what}, not a file")))
}

#[cfg(unix)]
fn is_pipe(file_type: FileType) -> bool {
    use std::os::unix::fs::FileTypeExt as _;

    file_type.is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
}

/// Whether `path` leads to `/dev/null`.
fn is_null_device(path: &Path) -> bool {
    cfg!(unix) && std::fs::canonicalize(path).is_ok_and(|it| it == Path::new("/dev/null"))
}

/// Opens the file at `path` for reading, without waiting for the writers of a pipe.
fn open_at_once(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt as _;

        options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32);
    }
    options.read(true).open(path)
}

/// Makes reads of a pipe wait for its writers from now on.
#[cfg(unix)]
fn wait_for_writers(file: &File) -> io::Result<()> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};

    Ok(fcntl_setfl(file, fcntl_getfl(file)? - OFlags::NONBLOCK)?)
}

#[cfg(not(unix))]
fn wait_for_writers(_: &File) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_refused<T: std::fmt::Debug>(read: io::Result<T>, expected: &str) {
        assert_eq!(read.unwrap_err().to_string(), expected);
    }

    #[test]
    fn a_file_is_read_up_to_its_size_and_the_budget() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(read_text(&path, 3).unwrap(), "abc");
        check_refused(read_bytes(&path, 2), "it has 3 bytes, but 2 bytes are the most that is read");
        let mut file = RegularFile::open(&path).unwrap();
        // Bytes that are added after opening are not read.
        std::fs::write(&path, "abcdef").unwrap();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, b"abc");
        file.seek(SeekFrom::Start(1)).unwrap();
        bytes.clear();
        file.read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, b"bc");
        file.seek(SeekFrom::Start(7)).unwrap();
        assert_eq!(file.read(&mut [0; 4]).unwrap(), 0);
        std::fs::write(&path, b"ab\xff").unwrap();
        check_refused(read_text(&path, 3), "it is not UTF-8 from byte 2 on");
    }

    #[test]
    fn a_large_claim_costs_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sparse");
        File::create(&path).unwrap().set_len(1 << 42).unwrap();
        let n_bytes = 1_u64 << 42;
        check_refused(
            read_bytes(&path, 1 << 30),
            &format!("it has {n_bytes} bytes, but 1073741824 bytes are the most that is read"),
        );
        let mut lines = BoundedLines::new(RegularFile::open(&path).unwrap(), 1 << 20);
        check_refused(
            lines.read_to_end(&mut Vec::new()),
            "it has a line with more, but 1048576 bytes are the most that is read",
        );
    }

    #[test]
    fn lines_count_from_their_beginning() {
        let text = "12345\n\n1234567\n123".repeat(3);
        for n_at_once in [1, 2, 3, 7, 100] {
            let reader = io::BufReader::with_capacity(n_at_once, text.as_bytes());
            let mut bounded = BoundedLines::new(reader, 8);
            let mut found = String::new();
            bounded.read_to_string(&mut found).unwrap();
            assert_eq!(found, text, "{n_at_once}");
        }
        assert!(BoundedLines::new(text.as_bytes(), 2).read_to_end(&mut Vec::new()).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        use rustix::fs::{CWD, FileType, Mode, mknodat};

        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        check_refused(RegularFile::open(&pipe), "it is a pipe, not a file");
        check_refused(read_settings(&pipe), "it is a pipe that gives nothing");
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        for path in [&link, Path::new("/dev/zero")] {
            check_refused(RegularFile::open(path), "it is a device or a socket, not a file");
            check_refused(read_settings(path), "it is a device or a socket, not a file");
        }
        assert_eq!(RegularFile::open(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn settings_come_from_pipes_that_the_user_names() {
        use std::io::Write as _;
        use std::os::fd::AsRawFd as _;

        let (reader, mut writer) = io::pipe().unwrap();
        let path = format!("/proc/self/fd/{}", reader.as_raw_fd());
        let written = std::thread::spawn(move || {
            // Later than the read begins.
            std::thread::sleep(std::time::Duration::from_millis(20));
            writer.write_all(b"jobs = 2").unwrap();
        });
        assert_eq!(read_settings_text(Path::new(&path)).unwrap(), "jobs = 2");
        written.join().unwrap();
        assert_eq!(read_settings(Path::new("/dev/null")).unwrap(), b"");
    }
}
