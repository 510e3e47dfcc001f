//! Walls around the program of a detector: it has no network, and it does not see the data sets.
//!
//! They keep it from reading labels. They are no protection from a program that wants to do harm: it still has the rights of
//! the user on everything that is not hidden.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use nix::mount::{MsFlags, mount};
use nix::sched::{CloneFlags, unshare};
use nix::unistd::{getgid, getuid};

/// Links are looked for in a hidden folder and so many levels below it: data sets have their folders of labels there.
const LEVELS_BELOW: usize = 2;

/// Walls in this process and those that it will start: no network, and nothing at the paths `hidden` and where links in them
/// lead. Paths that do not exist are passed over. The process must have a single thread.
///
/// # Errors
///
/// If the system does not let its users build walls, or if the working directory would be behind one.
pub fn wall_in(hidden: &[PathBuf]) -> io::Result<()> {
    let hidden = outermost(&with_links(hidden));
    let folder = std::env::current_dir()?;
    if let Some(path) = hidden.iter().find(|it| folder.starts_with(it)) {
        return Err(io::Error::other(format!(
            "its folder {} would be hidden from it by sandbox, with the data or runs in {}",
            folder.display(),
            path.display()
        )));
    }
    let of_users = Users::own();
    unshare(CloneFlags::CLONE_NEWUSER | CloneFlags::CLONE_NEWNS | CloneFlags::CLONE_NEWNET)
        .map_err(|it| refused("namespaces", it.desc()))?;
    of_users.keep()?;
    // What is hidden here stays in sight of all others.
    place(None, Path::new("/"), None, MsFlags::MS_REC | MsFlags::MS_PRIVATE)?;
    for path in &hidden {
        if path.is_dir() {
            let flags = MsFlags::MS_RDONLY | MsFlags::MS_NOSUID | MsFlags::MS_NODEV | MsFlags::MS_NOEXEC;
            place(Some("tmpfs"), path, Some("tmpfs"), flags)?;
        } else {
            place(Some("/dev/null"), path, None, MsFlags::MS_BIND)?;
        }
    }
    // What other users placed cannot be removed. From now on, that is who we were.
    unshare(CloneFlags::CLONE_NEWUSER | CloneFlags::CLONE_NEWNS)
        .map_err(|it| refused("namespaces", it.desc()))?;
    of_users.keep()
}

/// `paths`, and the links in those that are folders.
fn with_links(paths: &[PathBuf]) -> Vec<PathBuf> {
    let (mut all, mut folders) = (paths.to_vec(), paths.to_vec());
    for _ in 0..=LEVELS_BELOW {
        let entries = folders.iter().filter_map(|it| it.read_dir().ok()).flatten().flatten();
        let mut inner = Vec::new();
        for (entry, kind) in entries.filter_map(|it| Some((it.path(), it.file_type().ok()?))) {
            if kind.is_symlink() {
                all.push(entry.clone());
            }
            if kind.is_dir() || (kind.is_symlink() && entry.is_dir()) {
                inner.push(entry);
            }
        }
        folders = inner;
    }
    all
}

/// Those of `paths` that exist, in full, without those inside others.
fn outermost(paths: &[PathBuf]) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = paths.iter().filter_map(|it| it.canonicalize().ok()).collect();
    paths.sort();
    // Sorted, a folder stands before all that is in it.
    let mut outermost: Vec<PathBuf> = Vec::new();
    for path in paths {
        if outermost.last().is_none_or(|it| !path.starts_with(it)) {
            outermost.push(path);
        }
    }
    outermost
}

fn place(what: Option<&str>, path: &Path, kind: Option<&str>, flags: MsFlags) -> io::Result<()> {
    mount(what, path, kind, flags, None::<&str>)
        .map_err(|it| refused(&format!("hiding {}", path.display()), it.desc()))
}

fn refused(what: &str, why: impl Display) -> io::Error {
    io::Error::other(format!("this system lets its users build no sandbox ({what}: {why})"))
}

/// User and group of this process.
struct Users {
    uid: String,
    gid: String,
}

impl Users {
    fn own() -> Self {
        let map = |id: u32| format!("{id} {id} 1");
        Self { uid: map(getuid().as_raw()), gid: map(getgid().as_raw()) }
    }

    /// Keeps user and group in a namespace that this process has just entered.
    fn keep(&self) -> io::Result<()> {
        for (file, content) in [("setgroups", "deny"), ("uid_map", &self.uid), ("gid_map", &self.gid)] {
            std::fs::write(format!("/proc/self/{file}"), content).map_err(|it| refused(file, it))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_inside_hidden_ones_and_missing_ones_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().canonicalize().unwrap().join(name);
        for name in ["data/street", "data-2", "other"] {
            std::fs::create_dir_all(path(name)).unwrap();
        }
        let given = ["data/street", "other", "missing", "data-2", "data"].map(path);
        assert_eq!(outermost(&given), ["data", "data-2", "other"].map(path));
    }

    #[test]
    fn links_in_folders_are_hidden_where_they_lead() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().canonicalize().unwrap().join(name);
        for name in ["data/sequences/00", "a/deep", "b", "c"] {
            std::fs::create_dir_all(path(name)).unwrap();
        }
        std::fs::write(path("file"), "").unwrap();
        for (link, to) in [
            ("data/training", "a/deep"),
            ("data/sequences/00/labels", "b"),
            ("a/deep/0000.txt", "file"),
            ("data/again", "data"),
            ("data/nowhere", "nowhere"),
        ] {
            std::os::unix::fs::symlink(path(to), path(link)).unwrap();
        }
        let hidden = outermost(&with_links(&[path("data")]));
        assert_eq!(hidden, ["a/deep", "b", "data", "file"].map(path));
    }

    #[test]
    fn a_system_that_does_not_take_users_is_said_to_build_no_sandbox() {
        // Outside of a namespace of its own, nobody may say who its users are.
        let error = Users::own().keep().unwrap_err().to_string();
        assert!(error.starts_with("this system lets its users build no sandbox ("), "{error}");
    }
}
