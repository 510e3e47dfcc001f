//! `SHA256SUMS`: checksums of files, as `sha256sum` writes and reads them.

use std::collections::BTreeMap;
use std::io::{self, Read as _};
use std::path::Path;

use object_store::path::Path as ObjectPath;
use sha2::{Digest as _, Sha256};

use crate::RemoteError;
use crate::local_file::{open, read_text};

/// The name of the file with the checksums of all files below its folder.
pub const SUMS_FILE: &str = "SHA256SUMS";

/// SHA-256 in lower-case hexadecimal, by the path of the file with `/` between folders.
pub type Sums = BTreeMap<String, String>;

/// Reads the lines of `text`; errors name it `path`.
///
/// # Errors
///
/// [`RemoteError::Sums`], also where a path leads out of the folder.
pub fn parse_sums(path: &str, text: &str) -> Result<Sums, RemoteError> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(index, line)| {
            let refused = || RemoteError::Sums { path: path.to_owned(), line: index + 1 };
            let (sum, name) = line.split_once(' ').ok_or_else(refused)?;
            let name = name.strip_prefix([' ', '*']).ok_or_else(refused)?;
            let name = name.strip_prefix("./").unwrap_or(name);
            let is_sum = sum.len() == 64 && sum.bytes().all(|it| it.is_ascii_hexdigit());
            // Neither empty parts nor . and .. nor a leading /.
            let is_below = ObjectPath::parse(name).is_ok_and(|it| it.as_ref() == name && !name.is_empty());
            if is_sum && is_below { Ok((name.to_owned(), sum.to_ascii_lowercase())) } else { Err(refused()) }
        })
        .collect()
}

/// The text that [`parse_sums`] reads, sorted by path.
pub fn sums_text(sums: &Sums) -> String {
    let lines: Vec<String> = sums.iter().map(|(name, sum)| format!("{sum}  {name}\n")).collect();
    lines.concat()
}

/// The checksums in `folder`; none where it has no such file.
///
/// # Errors
///
/// [`RemoteError::Sums`]; [`RemoteError::Write`] if the file cannot be read.
pub fn read_sums(folder: &Path) -> Result<Sums, RemoteError> {
    let path = folder.join(SUMS_FILE);
    match read_text(&path) {
        Ok(text) => parse_sums(&path.display().to_string(), &text),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Sums::new()),
        Err(error) => Err(RemoteError::write(&path, error)),
    }
}

/// SHA-256 of the file at `path`, in lower-case hexadecimal.
pub(crate) fn sha256_of(path: &Path) -> io::Result<String> {
    let mut file = open(path)?;
    let mut sum = RunningSum::default();
    let mut buffer = vec![0; 1 << 20];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(sum.finish()),
            n_bytes => sum.add(&buffer[..n_bytes]),
        }
    }
}

/// SHA-256 of bytes that come piece by piece.
#[derive(Debug, Default)]
pub(crate) struct RunningSum(Sha256);

impl RunningSum {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The checksum in lower-case hexadecimal.
    pub(crate) fn finish(self) -> String {
        let digits = self.0.finalize();
        let digits = digits.iter().flat_map(|byte| [byte >> 4, byte & 15]);
        digits.map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

    #[test]
    fn sums_are_read_as_they_are_written() {
        let text = format!("{ABC}  a/b.bin\n{}  scans.csv\n", "0".repeat(64));
        let sums = parse_sums("SHA256SUMS", &text).unwrap();
        assert_eq!(sums_text(&sums), text);
        let binary = format!("{ABC} *./a/b.bin\n\n");
        assert_eq!(parse_sums("SHA256SUMS", &binary).unwrap()["a/b.bin"], ABC);
    }

    #[test]
    fn lines_that_are_no_sums_are_named() {
        for line in
            ["abc  a.bin", &format!("{ABC} a.bin"), &format!("{ABC}  ../a"), &format!("{ABC}  /a"), "x"]
        {
            let error = parse_sums("sums", &format!("{ABC}  ok\n{line}\n")).unwrap_err();
            assert!(error.to_string().starts_with("sums, line 2, "), "{line}: {error}");
        }
    }

    #[test]
    fn a_file_has_the_sum_of_its_bytes() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a"), "abc").unwrap();
        assert_eq!(sha256_of(&folder.path().join("a")).unwrap(), ABC);
    }
}
