//! Addresses of the files of data sets, as the catalogue has them.

use std::collections::BTreeSet;

use serde::Deserialize;

use super::shown_name::is_printable;

/// The placeholder for the name of a drive in [`Download::files`].
const DRIVE: &str = "{drive}";

/// The files of a data set that can be fetched without a login, and their address.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Download {
    /// Address of the folder that all paths start at: `s3://…`, `gs://…` or `https://…`.
    pub from: String,
    /// Paths below it, where `{drive}` stands for each drive; a path that ends in `/` is a folder to fetch as a whole.
    pub files: Vec<String>,
    /// The drives; if empty, and paths have `{drive}`, the drives are the folders at the address.
    #[serde(default)]
    pub drives: BTreeSet<String>,
    /// The region of the bucket.
    #[serde(default)]
    pub region: Option<String>,
    /// Only files whose paths contain one of these are unpacked from archives; all if there are none.
    #[serde(default)]
    pub unpack: Vec<String>,
    /// Other files that are needed, and where they are, as a sentence.
    #[serde(default)]
    pub rest: Option<String>,
}

/// The drives of a download.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DownloadDrives {
    /// There are no drives.
    None,
    /// These drives.
    Listed(BTreeSet<String>),
    /// All folders at the address.
    Folders,
}

impl Download {
    /// The drives of the download.
    pub fn drives(&self) -> DownloadDrives {
        if !self.files.iter().any(|it| it.contains(DRIVE)) {
            DownloadDrives::None
        } else if self.drives.is_empty() {
            DownloadDrives::Folders
        } else {
            DownloadDrives::Listed(self.drives.clone())
        }
    }

    /// The paths for these drives, each once, sorted.
    pub fn paths_of(&self, drives: &[String]) -> Vec<String> {
        let of_drives = drives.iter().flat_map(|drive| self.files.iter().map(|it| it.replace(DRIVE, drive)));
        let of_all = self.files.iter().filter(|it| !it.contains(DRIVE)).cloned();
        of_all.chain(of_drives).collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Checks that the download is possible; the error says what is not.
    pub(super) fn check(&self) -> Result<(), String> {
        let schemes = ["s3://", "gs://", "https://", "http://"];
        if !schemes.iter().any(|it| self.from.starts_with(it)) {
            return Err(format!("from {:?} begins with none of {}", self.from, schemes.join(", ")));
        }
        if self.files.is_empty() {
            return Err("files has no path".to_owned());
        }
        let is_below = |path: &&String| path.trim_end_matches('/').split('/').all(is_part);
        if let Some(path) = self.files.iter().find(|it| !is_below(it)) {
            return Err(format!("{path:?} is not a path below the address"));
        }
        if let Some(drive) = self.drives.iter().find(|it| !is_drive_name(it)) {
            return Err(format!("{drive:?} is not the name of a drive"));
        }
        if !self.drives.is_empty() && self.drives() == DownloadDrives::None {
            return Err(format!("there are drives, but no path has {DRIVE}"));
        }
        let texts = [Some(&self.from), self.region.as_ref(), self.rest.as_ref()];
        match texts.into_iter().flatten().find(|it| !it.chars().all(is_printable)) {
            Some(text) => Err(format!("{text:?} has a control character")),
            None => Ok(()),
        }
    }
}

/// Whether `name` can be the name of a drive: one part of a path, without characters that are special to shells or servers.
pub fn is_drive_name(name: &str) -> bool {
    is_part(name) && name.chars().all(|it| it.is_ascii_alphanumeric() || "-_.".contains(it))
}

fn is_part(part: &str) -> bool {
    !part.is_empty() && part != "." && part != ".." && part.chars().all(|it| is_printable(it) && it != '\\')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Download, String> {
        let download: Download = toml::from_str(text).map_err(|error| error.message().to_owned())?;
        download.check().map(|()| download)
    }

    #[test]
    fn paths_are_made_of_drives() {
        let download = parse(
            r#"
            from = "https://example.org/raw"
            files = ["calib.zip", "{drive}/{drive}_sync.zip", "{drive}/labels/"]
            drives = ["b", "a"]"#,
        )
        .unwrap();
        assert_eq!(download.paths_of(&["a".to_owned()]), ["a/a_sync.zip", "a/labels/", "calib.zip"]);
        let both = BTreeSet::from(["a".to_owned(), "b".to_owned()]);
        assert_eq!(download.drives(), DownloadDrives::Listed(both));
        let whole = parse("from = \"s3://bucket\"\nfiles = [\"{drive}/\"]").unwrap();
        assert_eq!(whole.drives(), DownloadDrives::Folders);
        let single = parse("from = \"s3://bucket\"\nfiles = [\"a.zip\"]").unwrap();
        assert_eq!((single.drives(), single.paths_of(&[])), (DownloadDrives::None, vec!["a.zip".to_owned()]));
    }

    #[test]
    fn what_leads_elsewhere_is_refused() {
        for (text, part) in [
            ("from = \"ftp://x\"\nfiles = [\"a\"]", "none of s3://"),
            ("from = \"s3://x\"\nfiles = []", "no path"),
            ("from = \"s3://x\"\nfiles = [\"../a\"]", "not a path below"),
            ("from = \"s3://x\"\nfiles = [\"/a\"]", "not a path below"),
            ("from = \"s3://x\"\nfiles = [\"{drive}/\"]\ndrives = [\"a/..\"]", "not the name of a drive"),
            ("from = \"s3://x\"\nfiles = [\"a\"]\ndrives = [\"b\"]", "no path has {drive}"),
            ("from = \"s3://x\"\nfiles = [\"a\"]\nrest = \"a\\u001b\"", "control character"),
            ("from = \"s3://x\"\nfiles = [\"a\"]\nsha = \"1\"", "unknown field"),
        ] {
            let problem = parse(text).unwrap_err();
            assert!(problem.contains(part), "{text}: {problem}");
        }
    }
}
