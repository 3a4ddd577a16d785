//! A domain: the private corner of shared memory in which one robot's stack lives.
//!
//! Everything of a run carries one name: the root folder `/dev/shm/NAME`, in which the middleware
//! keeps its registry, and the segments `/dev/shm/NAME_...`; the middleware's prefix is `NAME_`.
//! (Were the folder called like the prefix itself, the middleware would take it for a segment
//! without a name when it cleans up after a dead process, and panic.) Each member holds a shared
//! lock on `ROOT/lock`; a process that gets it exclusively knows that no member is left and may
//! remove everything. Processes that want to remove it take turns by a lock on the folder itself, so
//! that a members' lock found taken is that of a member and not of another such process. The maker
//! of a domain also holds `ROOT/launch`, which the kernel releases when the process ends in whatever
//! way: by that the others see that the run has no supervisor any more.

use crate::error::StartError;
use crate::folder::{Folder, own_file};
use crate::memory::{SHM, segments};
use iceoryx2::prelude::{Config, FileName, Path as IoxPath, SemanticString};
use rustix::fs::{CWD, FlockOperation, OFlags, flock};
use std::fs::File;
use std::hash::{BuildHasher, Hasher};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// First letters of every domain that launch makes.
pub(crate) const PREFIX_START: &str = "zn_";

/// Letters after [`PREFIX_START`], always as many, so that no prefix begins another.
const RANDOM_LETTERS: usize = 10;

/// Name of the file that the maker of a domain holds.
const LAUNCH: &str = "launch";

/// Name of the file that every member holds.
const LOCK: &str = "lock";

/// Version of the middleware that the workspace pins, with which it names and stamps its counter
/// of nodes.
const MIDDLEWARE: [u16; 3] = [0, 10, 0];

/// What else it has in its name: the SHA-1 of the type `iceoryx2::node::global_management_segment::State`.
const NODE_COUNTER_TYPE: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5";

/// Size of that counter.
const NODE_COUNTER_BYTES: usize = 16;

/// How long a member waits for what another one is just making. By default the middleware gives up after a
/// second of wall time, which a busy machine would decide.
const CREATION_LIMIT: std::time::Duration = std::time::Duration::from_secs(60);

/// How often a new domain is tried again when a sweeper was faster.
const CREATE_TRIES: u32 = 8;

/// How often the maker of a domain looks again whether it is the last member, and the time between.
const CLOSE_TRIES: u32 = 50;
const CLOSE_PAUSE: Duration = Duration::from_millis(4);

/// A domain and this process's membership in it.
#[derive(Debug)]
pub struct Domain {
    folder: Folder,
    prefix: String,
    /// `ROOT/launch`, which is locked as long as the maker of the domain lives.
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
        // Another user may have made a folder of that name: then another one.
        let folder = Folder::create(&root).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists | ErrorKind::NotFound => {
                StartError::Usage(format!("making the domain's folder: {error}"))
            }
            _ => StartError::system(
                format!("making the domain's folder {}", root.display()),
                error,
            ),
        })?;
        let (prefix, member) = member(&folder)?;
        let failed = |error: std::io::Error| StartError::system("locking the new domain", error);
        let launch = folder
            .file(LAUNCH, OFlags::RDWR | OFlags::CREATE | OFlags::EXCL)
            .map_err(failed)?;
        flock(&launch, FlockOperation::NonBlockingLockExclusive)
            .map_err(|error| failed(error.into()))?;
        make_node_counter(&prefix)
            .map_err(|error| StartError::system("making the counter of nodes", error))?;
        Ok(Self {
            folder,
            prefix,
            launch,
            made_here: true,
            _member: member,
        })
    }

    /// Joins the domain whose root folder is `root`.
    ///
    /// # Errors
    /// [`StartError::Usage`] when `root` is not a folder of the caller directly under /dev/shm,
    /// [`StartError::System`] when its lock cannot be had.
    pub fn join(root: &Path) -> Result<Self, StartError> {
        let usage =
            |problem: &str| StartError::Usage(format!("--domain {}: {problem}", root.display()));
        name_of(root).ok_or_else(|| {
            usage("not a folder directly under /dev/shm with a name of 4 to 40 letters")
        })?;
        let folder = Folder::open(root).map_err(|error| match error.kind() {
            ErrorKind::NotFound => usage("no such folder; the run is over or was never started"),
            ErrorKind::PermissionDenied => usage(&format!("not a run of this user: {error}")),
            _ => StartError::system(format!("--domain {}", root.display()), error),
        })?;
        let (prefix, member) = member(&folder)?;
        check_node_counter(&prefix)
            .map_err(|error| StartError::system("the domain's counter of nodes", error))?;
        let launch = folder
            .file(LAUNCH, OFlags::RDONLY)
            .map_err(|error| StartError::system("looking for launch", error))?;
        Ok(Self {
            folder,
            prefix,
            launch,
            made_here: false,
            _member: member,
        })
    }

    /// The root folder.
    #[must_use]
    pub fn root(&self) -> &Path {
        self.folder.path()
    }

    /// The root folder as it was opened.
    #[must_use]
    pub fn folder(&self) -> &Folder {
        &self.folder
    }

    /// First letters of everything that belongs to the domain.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// True when the maker of the domain is gone: one system call, and never false again after that.
    #[must_use]
    pub fn is_orphaned(&self) -> bool {
        !self.made_here && flock(&self.launch, FlockOperation::NonBlockingLockShared).is_ok()
    }

    /// True once files of the domain were deleted under its members: its folder, the lock of its maker,
    /// or the segments beside it. What members have mapped goes on, but none can join or restart.
    #[must_use]
    pub fn is_deleted(&self) -> bool {
        let unlinked = |file: &File| file.metadata().is_ok_and(|file| file.nlink() == 0);
        self.folder.is_gone() || unlinked(&self.launch) || !node_counter(&self.prefix).exists()
    }

    /// The middleware's configuration for this domain.
    ///
    /// # Errors
    /// [`StartError::Usage`] when the middleware cannot use the name.
    pub fn config(&self) -> Result<Config, StartError> {
        config(self.root(), &self.prefix)
    }

    /// Leaves the domain and removes it, if this was its last member.
    ///
    /// # Errors
    /// What the file system says.
    pub fn close(self) -> std::io::Result<bool> {
        let root = self.root().to_owned();
        if self.made_here && self.is_deleted() {
            // Without its folder the domain would not be found again.
            remove_segments(&self.prefix);
        }
        // A child that was forked and has not called exec yet holds the locks of its parent, too.
        let tries = if self.made_here { CLOSE_TRIES } else { 0 };
        drop(self);
        for _ in 0..tries {
            if sweep(&root)? {
                return Ok(true);
            }
            std::thread::sleep(CLOSE_PAUSE);
        }
        sweep(&root)
    }
}

/// The middleware's configuration for the caller's own domain at `root`.
///
/// # Errors
/// [`StartError::Usage`] when there is no such domain.
pub fn look_up(root: &Path) -> Result<Config, StartError> {
    let unusable = |problem: &dyn core::fmt::Display| {
        StartError::Usage(format!("--domain {}: {problem}", root.display()))
    };
    let name = name_of(root).ok_or_else(|| unusable(&"not a folder directly under /dev/shm"))?;
    Folder::open(root).map_err(|error| unusable(&error))?;
    config(root, &prefix_of(name))
}

/// The middleware's configuration for the domain at `root`.
fn config(root: &Path, prefix: &str) -> Result<Config, StartError> {
    let unusable = |_| StartError::Usage(format!("--domain {}: unusable name", root.display()));
    let mut config = Config::default();
    // What dead members left is removed by a process of its own (see `cleaning.rs`): a member
    // that did it would wait for files that may be corrupt.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    // The other end of a half-made connection may get no processor for a while.
    config.global.creation_timeout = CREATION_LIMIT;
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(unusable)?;
    let root = root.to_str().unwrap_or("");
    config
        .global
        .set_root_path(&IoxPath::new(root.as_bytes()).map_err(unusable)?);
    Ok(config)
}

/// The name of a domain's root folder, when `root` can be one.
fn name_of(root: &Path) -> Option<&str> {
    let name = root.file_name()?.to_str()?;
    (root.parent() == Some(Path::new(SHM)) && (4..=40).contains(&name.len())).then_some(name)
}

/// Becomes a member of the domain in `folder`: its prefix, and the lock that says so.
fn member(folder: &Folder) -> Result<(String, File), StartError> {
    let root = folder.path();
    let usage = |problem| StartError::Usage(format!("--domain {}: {problem}", root.display()));
    let name = name_of(root).ok_or_else(|| usage("unusable name"))?;
    let lock = folder
        .lock(LOCK, FlockOperation::NonBlockingLockShared)
        .map_err(|error| StartError::system("locking the domain", error))?
        .ok_or_else(|| usage("the domain is being removed"))?;
    Ok((prefix_of(name), lock))
}

/// The middleware's prefix for the domain with this name.
fn prefix_of(name: &str) -> String {
    format!("{name}_")
}

/// The middleware's prefix for the domain at `root`, when that can be one.
pub(crate) fn prefix_at(root: &Path) -> Option<String> {
    name_of(root).map(prefix_of)
}

/// The file in which the middleware counts its nodes.
fn node_counter(prefix: &str) -> PathBuf {
    let [major, minor, patch] = MIDDLEWARE;
    Path::new(SHM).join(format!(
        "{prefix}{NODE_COUNTER_TYPE}_node.{major}_{minor}_{patch}.global_mgmt"
    ))
}

/// Makes the counter of nodes: a version and a number. Without it the first node would make it, and
/// give every user of the machine the right to write it.
fn make_node_counter(prefix: &str) -> std::io::Result<()> {
    let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL;
    let mut file = own_file(CWD, &node_counter(prefix), flags)?;
    let mut bytes = [0; NODE_COUNTER_BYTES];
    bytes[..8].copy_from_slice(&middleware_version().to_ne_bytes());
    file.write_all(&bytes)
}

/// With what every segment of the middleware begins.
pub(crate) fn middleware_version() -> u64 {
    let [major, minor, patch] = MIDDLEWARE.map(u64::from);
    (major << 32) | (minor << 16) | patch
}

/// Accepts a counter of nodes that the middleware can map: it waits for ever for an empty one.
fn check_node_counter(prefix: &str) -> std::io::Result<()> {
    let bytes = own_file(CWD, &node_counter(prefix), OFlags::RDONLY)?
        .metadata()?
        .len();
    if bytes >= NODE_COUNTER_BYTES as u64 {
        Ok(())
    } else {
        Err(std::io::Error::other(format!("corrupt: {bytes} bytes")))
    }
}

/// Removes the domain at `root` if no member is left; true when it is gone.
///
/// # Errors
/// `PermissionDenied` when it is not a folder of the caller, and what the file system says.
pub fn sweep(root: &Path) -> std::io::Result<bool> {
    let Some(name) = name_of(root) else {
        return Ok(false);
    };
    // A service may have let others into it.
    let folder = match Folder::reclaim(root) {
        Ok(folder) => folder,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(error),
    };
    if !folder.take_turn()? {
        return Ok(false);
    }
    if folder.is_gone() {
        return Ok(true);
    }
    let Some(_held) = folder.lock(LOCK, FlockOperation::NonBlockingLockExclusive)? else {
        return Ok(false);
    };
    remove_segments(&prefix_of(name));
    // The folder is the caller's own in a sticky one: no other user can have put another in its
    // place.
    std::fs::remove_dir_all(root)?;
    Ok(true)
}

fn remove_segments(prefix: &str) {
    for (segment, _) in segments(prefix) {
        let _ = std::fs::remove_file(segment);
    }
}

/// Root folders of all domains of the caller on this host, dead or alive. Users whom a service has let
/// into one are shut out again.
#[must_use]
pub fn all() -> Vec<PathBuf> {
    let mut roots: Vec<PathBuf> = std::fs::read_dir(SHM)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| {
            entry.file_name().to_str().is_some_and(|name| {
                name.len() == PREFIX_START.len() + RANDOM_LETTERS && name.starts_with(PREFIX_START)
            })
        })
        .map(|entry| entry.path())
        .filter(|root| Folder::reclaim(root).is_ok())
        .collect();
    roots.sort();
    roots
}

/// The caller's segments whose domain is gone: the folder is made before and removed after them.
#[must_use]
pub fn stray_segments() -> Vec<PathBuf> {
    let len = PREFIX_START.len() + RANDOM_LETTERS;
    let is_stray = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        let name = name.and_then(|name| name.get(..=len)?.strip_suffix('_'));
        name.is_some_and(|name| !Path::new(SHM).join(name).exists())
    };
    let mut stray: Vec<PathBuf> = segments(PREFIX_START)
        .map(|(path, _)| path)
        .filter(is_stray)
        .collect();
    stray.sort();
    stray
}

/// Removes every domain without members; returns those.
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
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_domain_that_was_opened_to_others_is_shut_and_swept() {
        let domain = Domain::create().unwrap();
        let root = domain.root().to_owned();
        let open = std::fs::Permissions::from_mode(0o777);
        std::fs::set_permissions(&root, open).unwrap();
        assert!(all().contains(&root));
        let mode = std::fs::metadata(&root).unwrap().mode() & 0o7777;
        assert_eq!(mode, 0o700);
        drop(domain);
        // Another test may sweep, too.
        let _ = sweep_dead();
        assert!(!root.exists());
    }

    #[test]
    fn no_member_gives_up_what_another_one_makes_because_the_machine_is_busy() {
        let domain = Domain::create().unwrap();
        let config = domain.config().unwrap();
        assert_eq!(config.global.creation_timeout, CREATION_LIMIT);
        assert!(CREATION_LIMIT.as_secs() >= 60);
        assert!(domain.close().unwrap());
    }

    #[test]
    #[allow(
        clippy::used_underscore_binding,
        reason = "held for life, looked at here alone"
    )]
    fn a_child_between_fork_and_exec_leaves_nothing_behind() {
        let domain = Domain::create().unwrap();
        // It shares the lock, as a child does.
        let child = domain._member.try_clone().unwrap();
        let exec = std::thread::spawn(move || {
            std::thread::sleep(2 * CLOSE_PAUSE);
            drop(child);
        });
        assert!(domain.close().unwrap());
        exec.join().unwrap();
    }

    #[test]
    fn who_leaves_last_removes_a_domain_that_was_opened_to_others() {
        let domain = Domain::create().unwrap();
        let root = domain.root().to_owned();
        let other = Domain::join(&root).unwrap();
        std::fs::set_permissions(&root, std::fs::Permissions::from_mode(0o777)).unwrap();
        assert!(!domain.close().unwrap(), "the other one is a member");
        assert!(root.exists());
        std::fs::set_permissions(&root, std::fs::Permissions::from_mode(0o500)).unwrap();
        assert!(other.close().unwrap());
        assert!(!root.exists());
    }
}
