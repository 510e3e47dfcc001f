//! Walls around the program of a detector: it has no network, and it does not see the data sets.
//!
//! They keep it from reading labels. They are no protection from a program that wants to do harm: it still has the rights of
//! the user on everything that is not hidden.

use std::io;
use std::path::{Path, PathBuf};

use nix::errno::Errno;
use nix::mount::{MsFlags, mount};
use nix::sched::{CloneFlags, unshare};
use nix::unistd::{getgid, getuid};

/// Walls in this process and those that it will start: no network, and nothing at the paths `hidden`, of which those that do
/// not exist are passed over. The process must have a single thread.
///
/// # Errors
///
/// If the system does not let its users build walls, or if the working directory would be behind one.
pub fn wall_in(hidden: &[PathBuf]) -> io::Result<()> {
    let hidden = outermost(hidden);
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
        .map_err(|it| refused("namespaces", it))?;
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
    unshare(CloneFlags::CLONE_NEWUSER | CloneFlags::CLONE_NEWNS).map_err(|it| refused("namespaces", it))?;
    of_users.keep()
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
    let refused = |it| refused(&format!("hiding {}", path.display()), it);
    mount(what, path, kind, flags, None::<&str>).map_err(refused)
}

fn refused(what: &str, errno: Errno) -> io::Error {
    io::Error::other(format!("this system lets its users build no sandbox ({what}: {})", errno.desc()))
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
        std::fs::write("/proc/self/setgroups", "deny")?;
        std::fs::write("/proc/self/uid_map", &self.uid)?;
        std::fs::write("/proc/self/gid_map", &self.gid)
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
}
