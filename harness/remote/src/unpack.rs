//! Unpacks archives that were fetched.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use zip::ZipArchive;

use crate::RemoteError;
use crate::local_file::{create, open, read_text};
use crate::session::write_sums;
use crate::space::check_space;
use crate::sums::{RunningSum, SUMS_FILE, read_sums, sha256_of};

/// Files that were taken from an archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Unpacked {
    /// Number of files that were wanted.
    pub n_files: usize,
    /// Their size in bytes.
    pub n_bytes: u64,
}

/// How an archive is unpacked.
pub struct UnpackPlan<'a> {
    /// Where its files go.
    pub into: &'a Path,
    /// Only files whose paths contain one of these are taken; all if there are none.
    pub wanted: &'a [String],
    /// The option of the program that chooses the folder, for errors.
    pub folder_option: &'static str,
    /// The most bytes that the files may have; without it, as many as archives of scans and labels usually have.
    pub n_most_bytes: Option<u64>,
    /// Ends the work once it is set.
    pub interrupted: &'a AtomicBool,
}

/// Most bytes of files per byte of archive: archives of labels of points are a sixtieth of their files, those of scans half.
const MAX_GROWTH: u64 = 200;
/// Files of this many bytes together are taken of an archive of any size.
const ALWAYS_TAKEN_BYTES: u64 = 1 << 26;

/// Whether `archive` has been unpacked and removed: its record states its size.
pub fn is_unpacked(archive: &Path, n_bytes: u64) -> bool {
    let text = read_text(&record_of(archive)).unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|it| it.parse().ok()) == Some(n_bytes)
}

/// The file that stands for an archive that was unpacked: its SHA-256 and its size.
fn record_of(archive: &Path) -> PathBuf {
    archive.with_file_name(format!("{}.unpacked", archive.file_name().unwrap_or_default().to_string_lossy()))
}

/// Unpacks the zip file `archive`, each file whole or not at all, and puts a record of it in its place. Checksums of its
/// files are added to the `SHA256SUMS` of the folder.
///
/// # Errors
///
/// [`RemoteError::Archive`] if it is damaged; [`RemoteError::NoRoom`]; [`RemoteError::Write`].
pub fn unpack(archive: &Path, plan: &UnpackPlan<'_>) -> Result<Unpacked, RemoteError> {
    let damaged = |reason: String| RemoteError::Archive { path: archive.to_path_buf(), reason };
    let file = open(archive).map_err(|error| RemoteError::write(archive, error))?;
    let mut zip = ZipArchive::new(file).map_err(|error| damaged(error.to_string()))?;
    let n_archive_bytes = std::fs::metadata(archive).map_or(0, |it| it.len());
    let members = members(&mut zip, plan).map_err(damaged)?;
    check_growth(archive, &members, n_archive_bytes, plan.n_most_bytes)?;
    let n_missing = members.iter().filter(|it| !it.is_there(plan.into)).map(|it| it.n_bytes).sum();
    check_space(plan.into, n_missing, plan.folder_option)?;
    let mut sums = read_sums(plan.into)?;
    let mut unpacked = Unpacked::default();
    for member in &members {
        if plan.interrupted.load(Ordering::Relaxed) {
            return Err(RemoteError::Interrupted { n_done: unpacked.n_files, n_files: members.len() });
        }
        if !member.is_there(plan.into) || !sums.contains_key(&member.name) {
            let packed = zip.by_index(member.index).map_err(|error| damaged(error.to_string()))?;
            let sum = write_member(packed, member, plan.into, archive)?;
            sums.insert(member.name.clone(), sum);
        }
        unpacked.n_files += 1;
        unpacked.n_bytes += member.n_bytes;
    }
    sums.remove(&archive.file_name().unwrap_or_default().to_string_lossy().into_owned());
    write_sums(plan.into, &sums)?;
    let written = sha256_of(archive).and_then(|sum| {
        let record = record_of(archive);
        create(&record)?.write_all(format!("{sum} {n_archive_bytes}\n").as_bytes())?;
        std::fs::remove_file(archive)
    });
    written.map_err(|error| RemoteError::write(archive, error))?;
    Ok(unpacked)
}

/// A file in an archive.
struct Member {
    index: usize,
    /// Path with `/` between folders; leads to below the folder that it is unpacked into.
    name: String,
    n_bytes: u64,
}

/// Start and end of the bytes of the archive that a member takes, and its name.
type Extent = (u64, u64, String);

/// Fails if `members` are far larger than those of an archive of `n_archive_bytes` should be, or than `n_most_bytes`.
fn check_growth(
    archive: &Path,
    members: &[Member],
    n_archive_bytes: u64,
    n_most_bytes: Option<u64>,
) -> Result<(), RemoteError> {
    let n_bytes = members.iter().fold(0_u64, |sum, it| sum.saturating_add(it.n_bytes));
    let usual = n_archive_bytes.saturating_mul(MAX_GROWTH).max(ALWAYS_TAKEN_BYTES);
    let n_most_bytes = n_most_bytes.unwrap_or(usual);
    if n_bytes <= n_most_bytes {
        return Ok(());
    }
    let path = archive.to_path_buf();
    Err(RemoteError::Growth { path, n_archive_bytes, n_bytes, n_most_bytes })
}

/// Fails if two members share bytes of the archive: then a few of these may stand for any number of files.
fn check_apart(mut extents: Vec<Extent>) -> Result<(), String> {
    extents.sort();
    match extents.array_windows().find(|[(_, end, _), (begin, _, _)]| end > begin) {
        Some([(_, _, one), (_, _, other)]) => Err(format!("{one} and {other} overlap in it")),
        None => Ok(()),
    }
}

/// Fails if `name` cannot stand in a list of files with one name on each line.
fn check_name(name: &str) -> Result<(), String> {
    match name.chars().find(|it| it.is_control() || matches!(it, '\u{2028}' | '\u{2029}')) {
        Some(_) => Err(format!("the name {} has a control character", name.escape_debug())),
        None => Ok(()),
    }
}

impl Member {
    fn is_there(&self, folder: &Path) -> bool {
        let found = std::fs::symlink_metadata(folder.join(&self.name));
        found.is_ok_and(|it| it.is_file() && it.len() == self.n_bytes)
    }
}

fn members(zip: &mut ZipArchive<File>, plan: &UnpackPlan<'_>) -> Result<Vec<Member>, String> {
    let (mut members, mut extents, mut names) = (Vec::new(), Vec::new(), BTreeSet::new());
    for index in 0..zip.len() {
        let packed = zip.by_index_raw(index).map_err(|error| error.to_string())?;
        let named = || packed.name().map(|it| it.escape_debug().to_string()).unwrap_or_default();
        let begin = packed.data_start().unwrap_or_else(|| packed.header_start());
        let end = begin.saturating_add(packed.compressed_size());
        extents.push((packed.header_start(), end, named()));
        if packed.is_dir() || packed.is_symlink() {
            continue;
        }
        let path = packed.enclosed_name().ok_or_else(|| format!("the path {} leads out of it", named()))?;
        let parts: Vec<String> =
            path.components().map(|it| it.as_os_str().to_string_lossy().into_owned()).collect();
        let name = parts.join("/");
        check_name(&name)?;
        if !names.insert(name.clone()) {
            return Err(format!("it has {} twice", named()));
        }
        let is_wanted = plan.wanted.is_empty() || plan.wanted.iter().any(|it| name.contains(it.as_str()));
        if is_wanted && name != SUMS_FILE && !name.is_empty() {
            members.push(Member { index, name, n_bytes: packed.size() });
        }
    }
    check_apart(extents)?;
    Ok(members)
}

/// Writes one file of an archive, and returns its checksum.
fn write_member(
    packed: impl Read,
    member: &Member,
    folder: &Path,
    archive: &Path,
) -> Result<String, RemoteError> {
    let path = &folder.join(&member.name);
    let write = |error| RemoteError::write(path, error);
    let damaged = |reason: String| RemoteError::Archive { path: archive.to_path_buf(), reason };
    // One byte more than announced, so that a file that goes on is noticed.
    let mut packed = packed.take(member.n_bytes.saturating_add(1));
    let mut n_written = 0;
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|error| RemoteError::write(folder, error))?;
    let partial = path.with_file_name(format!(
        ".{}.partial-{}",
        path.file_name().unwrap_or_default().to_string_lossy(),
        std::process::id()
    ));
    let mut file = create(&partial).map_err(write)?;
    let mut sum = RunningSum::default();
    let mut buffer = vec![0; 1 << 18];
    let copied = loop {
        match packed.read(&mut buffer) {
            Ok(0) if n_written == member.n_bytes => break Ok(()),
            Ok(0) => {
                let (name, expected) = (&member.name, member.n_bytes);
                break Err(damaged(format!("{name} has {n_written} bytes, and should have {expected}")));
            }
            Ok(n_bytes) => {
                n_written += n_bytes as u64;
                sum.add(&buffer[..n_bytes]);
                if let Err(error) = file.write_all(&buffer[..n_bytes]) {
                    break Err(write(error));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => break Err(damaged(error.to_string())),
        }
    };
    let named =
        copied.and_then(|()| file.sync_all().and_then(|()| std::fs::rename(&partial, path)).map_err(write));
    if named.is_err() {
        let _ = std::fs::remove_file(&partial);
    }
    named.map(|()| sum.finish())
}
