//! A domain: the private corner of shared memory in which one robot's stack lives.
//!
//! Everything of a run carries one name: the root folder `/dev/shm/NAME`, in which the middleware
//! keeps its registry, and the segments `/dev/shm/NAME_...`; the middleware's prefix is `NAME_`.
//! (Were the folder called like the prefix itself, the middleware would take it for a segment
//! without a name when it cleans up after a dead process, and panic.) Each member holds a shared
//! lock on `ROOT/lock`; whoever gets it exclusively knows that nobody is left and may remove
//! everything. Those who want to remove it take turns by a lock on the folder itself: who finds
//! the members' lock taken has then met a member and not another sweeper. Whoever makes a domain
//! also holds `ROOT/launch`, which the kernel lets go of when the process ends in whatever way: by
//! that the others see that nobody looks after the run any more.

use crate::error::StartError;
use crate::memory::SHM;
use iceoryx2::prelude::{Config, FileName, Path as IoxPath, SemanticString};
use rustix::fs::{FlockOperation, flock};
use std::fs::{File, OpenOptions};
use std::hash::{BuildHasher, Hasher};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

/// First letters of every domain that launch makes.
pub const PREFIX_START: &str = "zn_";

/// Letters after [`PREFIX_START`], always as many, so that no prefix begins another.
const RANDOM_LETTERS: usize = 10;

/// Name of the file that whoever makes a domain holds.
const LAUNCH: &str = "launch";

/// For how long a segment must be half made until its maker counts as dead.
const HALF_MADE: std::time::Duration = std::time::Duration::from_millis(100);

/// How often a new domain is tried again when a sweeper was faster.
const CREATE_TRIES: u32 = 8;

/// A domain and this process's membership in it.
#[derive(Debug)]
pub struct Domain {
    root: PathBuf,
    prefix: String,
    /// `ROOT/launch`, which is locked as long as whoever made the domain lives.
    launch: File,
    made_here: bool,
    _member: File,
}

impl Domain {
    /// Makes a new domain with a random name and joins it.
    ///
    /// # Errors
    /// [`StartError::System`] when the folder or the lock cannot be made.
    pub fn create() -> Result<Self, StartError> {
        let mut made = Self::create_once();
        // A sweeper may take a folder away between its making and its lock: then another one.
        for _ in 0..CREATE_TRIES {
            match made {
                Err(StartError::Usage(_)) => made = Self::create_once(),
                settled => return settled,
            }
        }
        made
    }

    fn create_once() -> Result<Self, StartError> {
        let mut bits = std::collections::hash_map::RandomState::new()
            .build_hasher()
            .finish();
        let mut name = String::from(PREFIX_START);
        for _ in 0..RANDOM_LETTERS {
            let letter = u32::try_from(bits % 36).unwrap_or(0);
            name.push(char::from_digit(letter, 36).unwrap_or('0'));
            bits /= 36;
        }
        let root = Path::new(SHM).join(&name);
        std::fs::DirBuilder::new()
            .mode(0o700)
            .create(&root)
            .map_err(|error| {
                StartError::system(
                    format!("making the domain's folder {}", root.display()),
                    error,
                )
            })?;
        let (prefix, member) = member(&root)?;
        let failed = |error: std::io::Error| StartError::system("locking the new domain", error);
        let launch = File::create_new(root.join(LAUNCH)).map_err(failed)?;
        flock(&launch, FlockOperation::NonBlockingLockExclusive)
            .map_err(|error| failed(error.into()))?;
        Ok(Self {
            root,
            prefix,
            launch,
            made_here: true,
            _member: member,
        })
    }

    /// Joins the domain whose root folder is `root`.
    ///
    /// # Errors
    /// [`StartError::Usage`] when `root` is not a folder directly under /dev/shm,
    /// [`StartError::System`] when its lock cannot be had.
    pub fn join(root: &Path) -> Result<Self, StartError> {
        let (prefix, member) = member(root)?;
        let launch = File::open(root.join(LAUNCH))
            .map_err(|error| StartError::system("looking for launch", error))?;
        Ok(Self {
            root: root.to_owned(),
            prefix,
            launch,
            made_here: false,
            _member: member,
        })
    }

    /// The root folder.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// First letters of everything that belongs to the domain.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// True when whoever made the domain is gone: one system call, and no going back.
    #[must_use]
    pub fn is_orphaned(&self) -> bool {
        !self.made_here && flock(&self.launch, FlockOperation::NonBlockingLockShared).is_ok()
    }

    /// The middleware's configuration for this domain.
    ///
    /// # Errors
    /// [`StartError::Usage`] when the middleware cannot use the name.
    pub fn config(&self) -> Result<Config, StartError> {
        let unusable =
            |_| StartError::Usage(format!("--domain {}: unusable name", self.root.display()));
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(unusable)?;
        let root = self.root.to_str().unwrap_or("");
        config
            .global
            .set_root_path(&IoxPath::new(root.as_bytes()).map_err(unusable)?);
        Ok(config)
    }

    /// Leaves the domain and removes it, if this was its last member.
    ///
    /// # Errors
    /// What the file system says.
    pub fn close(self) -> std::io::Result<bool> {
        let root = self.root.clone();
        drop(self);
        sweep(&root)
    }
}

/// Becomes a member of the domain at `root`: its prefix, and the lock that says so.
fn member(root: &Path) -> Result<(String, File), StartError> {
    let usage =
        |problem: &str| StartError::Usage(format!("--domain {}: {problem}", root.display()));
    let name = root
        .file_name()
        .and_then(|name| name.to_str())
        .filter(|_| root.parent() == Some(Path::new(SHM)))
        .ok_or_else(|| usage("not a folder directly under /dev/shm"))?;
    if name.len() > 40 || name.len() < 4 {
        return Err(usage("the folder's name needs 4 to 40 letters"));
    }
    if !root.is_dir() {
        return Err(usage(
            "no such folder; the run is over or was never started",
        ));
    }
    let lock = lock(root, FlockOperation::NonBlockingLockShared)
        .map_err(|error| StartError::system("locking the domain", error))?
        .ok_or_else(|| usage("the domain is being removed"))?;
    Ok((prefix_of(name), lock))
}

/// The middleware's prefix for the domain with this name.
fn prefix_of(name: &str) -> String {
    format!("{name}_")
}

/// Takes the lock of the domain at `root`; `None` when others hold it.
fn lock(root: &Path, how: FlockOperation) -> std::io::Result<Option<File>> {
    loop {
        let path = root.join("lock");
        let file = match OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
        {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        match flock(&file, how) {
            Ok(()) => {}
            Err(error) if error == rustix::io::Errno::WOULDBLOCK => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        // A sweeper may have unlinked the file between open and lock: then try again.
        match std::fs::metadata(&path) {
            Ok(meta) if meta.ino() == file.metadata()?.ino() => return Ok(Some(file)),
            _ => {}
        }
    }
}

/// Removes the domain at `root` if no member is left; true when it is gone.
///
/// # Errors
/// What the file system says.
pub fn sweep(root: &Path) -> std::io::Result<bool> {
    let Some(name) = root.file_name().and_then(|name| name.to_str()) else {
        return Ok(false);
    };
    let prefix = prefix_of(name);
    let turn = match File::open(root) {
        Ok(folder) => folder,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(error),
    };
    flock(&turn, FlockOperation::LockExclusive)?;
    if !root.is_dir() {
        return Ok(true);
    }
    let Some(_held) = lock(root, FlockOperation::NonBlockingLockExclusive)? else {
        return Ok(false);
    };
    for entry in std::fs::read_dir(SHM)?.flatten() {
        let name = entry.file_name();
        if name.to_str().is_some_and(|name| name.starts_with(&prefix)) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
    std::fs::remove_dir_all(root)?;
    Ok(true)
}

/// Removes the segments of a domain whose maker died while it made them. The middleware gives the
/// right to read with the last step, and whoever cleans up waits for that step for ever.
pub fn remove_half_made(prefix: &str) {
    let first = half_made(prefix);
    if first.is_empty() {
        return;
    }
    // Who lives needs far less than this for it.
    std::thread::sleep(HALF_MADE);
    for (path, inode) in half_made(prefix) {
        if first.contains(&(path.clone(), inode)) {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The segments that nobody may read, with their inodes.
fn half_made(prefix: &str) -> Vec<(PathBuf, u64)> {
    let entries = std::fs::read_dir(SHM).into_iter().flatten().flatten();
    entries
        .filter(|entry| {
            let name = entry.file_name();
            name.to_str().is_some_and(|name| name.starts_with(prefix))
        })
        .filter_map(|entry| {
            let metadata = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
            (metadata.mode() & 0o400 == 0).then(|| (entry.path(), metadata.ino()))
        })
        .collect()
}

/// Root folders of all domains on this host, dead or alive.
#[must_use]
pub fn all() -> Vec<PathBuf> {
    let mut roots: Vec<PathBuf> = std::fs::read_dir(SHM)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| {
            entry.file_name().to_str().is_some_and(|name| {
                name.len() == PREFIX_START.len() + RANDOM_LETTERS && name.starts_with(PREFIX_START)
            }) && entry.path().is_dir()
        })
        .map(|entry| entry.path())
        .collect();
    roots.sort();
    roots
}

/// Removes every domain that nobody is a member of any more; returns those.
#[must_use]
pub fn sweep_dead() -> Vec<PathBuf> {
    all()
        .into_iter()
        .filter(|root| sweep(root).unwrap_or(false))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::OpenOptionsExt;

    #[test]
    fn segments_that_were_never_finished_are_removed_and_the_others_stay() {
        let domain = Domain::create().unwrap();
        let make = |name: &str, mode: u32| {
            let path = Path::new(SHM).join(format!("{}{name}", domain.prefix()));
            let mut options = OpenOptions::new();
            options.write(true).create_new(true).mode(mode);
            options.open(&path).unwrap();
            path
        };
        let (half, whole) = (make("a.connection", 0o200), make("b.connection", 0o600));
        remove_half_made(domain.prefix());
        assert!(!half.exists());
        assert!(whole.exists());
        assert!(domain.close().unwrap());
        assert!(!whole.exists());
    }
}
