//! A domain's root folder, opened once and used only when it is the caller's own.
//!
//! Every user of the machine may make files and folders in /dev/shm. What another user has put
//! there is never followed, opened for writing, waited for or removed, and root is a user like the
//! others. A folder counts when it is a real directory with the caller's user id and mode 0700:
//! only the same user can have put anything into it.

use crate::error::StartError;
use rustix::fs::{AtFlags, CWD, FileType, FlockOperation, Mode, OFlags, Stat};
use rustix::fs::{chmodat, fchmod, flock, fstat, mkdirat, openat, statat};
use rustix::io::Errno;
use std::fs::File;
use std::io::{Error, ErrorKind};
use std::os::fd::{AsFd, AsRawFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Mode of a domain's root folder.
const FOLDER_MODE: u32 = 0o700;

/// Mode of every file of a domain.
pub const FILE_MODE: u32 = 0o600;

/// How often a lock is tried again whose file was removed while it was taken.
const LOCK_TRIES: u32 = 100;

/// How long a sweeper waits for its turn, and how often it looks.
const TURN_LIMIT: Duration = Duration::from_secs(1);
const TURN_PAUSE: Duration = Duration::from_millis(1);

/// See the module's description.
#[derive(Debug)]
pub struct Folder {
    handle: OwnedFd,
    path: PathBuf,
}

impl Folder {
    /// Makes the folder at `path`, which must not exist.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        mkdirat(CWD, path, Mode::from_raw_mode(FOLDER_MODE))?;
        // Whatever the umask of the process is just now; the middleware changes it for a moment.
        chmodat(
            CWD,
            path,
            Mode::from_raw_mode(FOLDER_MODE),
            AtFlags::empty(),
        )?;
        Self::open(path)
    }

    /// Opens the folder at `path`.
    ///
    /// # Errors
    /// `NotFound` when there is none, `PermissionDenied` when it is not the caller's own, and what
    /// the system says.
    pub fn open(path: &Path) -> std::io::Result<Self> {
        let (handle, mode) = open_own(path)?;
        if mode != FOLDER_MODE {
            return Err(denied(&format!("has mode {mode:04o} instead of 0700")));
        }
        Ok(Self {
            handle,
            path: path.to_owned(),
        })
    }

    /// Opens the caller's own folder at `path`; a service may have let others in, whom it shuts out.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn reclaim(path: &Path) -> std::io::Result<Self> {
        let (handle, mode) = open_own(path)?;
        if mode != FOLDER_MODE {
            fchmod(&handle, Mode::from_raw_mode(FOLDER_MODE))?;
        }
        Self::open(path)
    }

    /// Where it was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A path of `name` in this very folder, whatever is at [`Self::path`] by now. It holds
    /// as long as `self` in this process.
    #[must_use]
    pub fn entry(&self, name: &str) -> PathBuf {
        let handle = self.handle.as_raw_fd();
        PathBuf::from(format!("/proc/self/fd/{handle}/{name}"))
    }

    /// Opens a file of the folder; with [`OFlags::CREATE`] it may be made, mode 0600.
    ///
    /// # Errors
    /// `PermissionDenied` when it is not a regular file of the caller, and what the system says.
    pub fn file(&self, name: &str, flags: OFlags) -> std::io::Result<File> {
        own_file(&self.handle, Path::new(name), flags)
    }

    /// True once the folder has been removed.
    #[must_use]
    pub(crate) fn is_gone(&self) -> bool {
        fstat(&self.handle).is_ok_and(|stat| stat.st_nlink == 0)
    }

    /// Takes the lock `name` in the folder without waiting; `None` when others hold it or the
    /// folder is gone.
    ///
    /// # Errors
    /// As [`Self::file`].
    pub fn lock(&self, name: &str, how: FlockOperation) -> std::io::Result<Option<File>> {
        for _ in 0..LOCK_TRIES {
            let file = match self.file(name, OFlags::RDWR | OFlags::CREATE) {
                Ok(file) => file,
                Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(error),
            };
            match flock(&file, how) {
                Ok(()) => {}
                Err(Errno::WOULDBLOCK) => return Ok(None),
                Err(error) => return Err(error.into()),
            }
            // A sweeper may have unlinked the file between open and lock: then try again.
            let locked = fstat(&file)?;
            match statat(&self.handle, name, AtFlags::SYMLINK_NOFOLLOW) {
                Ok(there) if (there.st_dev, there.st_ino) == (locked.st_dev, locked.st_ino) => {
                    return Ok(Some(file));
                }
                _ => {}
            }
        }
        Ok(None)
    }

    /// Waits a bounded time until this process may look whether the folder can be removed; false
    /// when it was not let. The turn ends when `self` is dropped.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn take_turn(&self) -> std::io::Result<bool> {
        let started = Instant::now();
        loop {
            match flock(&self.handle, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => return Ok(true),
                Err(Errno::WOULDBLOCK) if started.elapsed() < TURN_LIMIT => {
                    std::thread::sleep(TURN_PAUSE);
                }
                Err(Errno::WOULDBLOCK) => return Ok(false),
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Takes the rights of others from every file that lies directly in the folder.
    ///
    /// # Errors
    /// [`StartError::System`] naming the file.
    pub fn make_files_private(&self) -> Result<(), StartError> {
        let failed = |error: Error| {
            StartError::system(format!("rights below {}", self.path.display()), error)
        };
        for entry in std::fs::read_dir(self.entry("")).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let file = entry.file_type().map_err(failed)?.is_file();
            if let (true, Some(name)) = (file, entry.file_name().to_str()) {
                let file = self.file(name, OFlags::RDONLY).map_err(failed)?;
                rustix::fs::fchmod(&file, Mode::from_raw_mode(FILE_MODE))
                    .map_err(|error| failed(error.into()))?;
            }
        }
        Ok(())
    }
}

/// Opens the regular file `path` of the caller, relative to `folder`, without following a link or
/// waiting for anything.
///
/// # Errors
/// `PermissionDenied` when it is something else, and what the system says.
pub fn own_file(folder: impl AsFd, path: &Path, flags: OFlags) -> std::io::Result<File> {
    // A FIFO would wait for its other end.
    let flags = flags | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let file = match openat(folder, path, flags, Mode::from_raw_mode(FILE_MODE)) {
        Ok(file) => file,
        Err(Errno::LOOP) => return Err(denied("is a symbolic link")),
        Err(error) => return Err(error.into()),
    };
    let stat = fstat(&file)?;
    check_owner(&stat)?;
    if FileType::from_raw_mode(stat.st_mode) == FileType::RegularFile {
        Ok(File::from(file))
    } else {
        Err(denied("is not a regular file"))
    }
}

/// Opens the caller's own directory at `path`; its mode.
fn open_own(path: &Path) -> std::io::Result<(OwnedFd, u32)> {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    let handle = match openat(CWD, path, flags, Mode::empty()) {
        Ok(handle) => handle,
        // NOFOLLOW: a link is not a directory.
        Err(Errno::LOOP | Errno::NOTDIR) => return Err(denied("is not a directory")),
        Err(error) => return Err(error.into()),
    };
    let stat = fstat(&handle)?;
    check_owner(&stat)?;
    Ok((handle, stat.st_mode & 0o7777))
}

/// Accepts what belongs to the caller.
fn check_owner(stat: &Stat) -> std::io::Result<()> {
    if stat.st_uid == rustix::process::geteuid().as_raw() {
        Ok(())
    } else {
        Err(denied(&format!("belongs to user id {}", stat.st_uid)))
    }
}

fn denied(why: &str) -> Error {
    Error::new(ErrorKind::PermissionDenied, why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    /// A folder in a place that is removed with it.
    fn made() -> (tempfile::TempDir, Folder) {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::create(&place.path().join("it")).unwrap();
        (place, folder)
    }

    #[test]
    fn links_and_open_folders_do_not_count() {
        let (place, folder) = made();
        let link = place.path().join("link");
        symlink(folder.path(), &link).unwrap();
        let open = place.path().join("open");
        std::fs::create_dir(&open).unwrap();
        std::fs::set_permissions(&open, std::fs::Permissions::from_mode(0o750)).unwrap();
        let file = place.path().join("file");
        std::fs::write(&file, "").unwrap();
        for path in [&link, &open, &file] {
            let error = Folder::open(path).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::PermissionDenied, "{error}");
        }
        let absent = Folder::open(&place.path().join("absent")).unwrap_err();
        assert_eq!(absent.kind(), ErrorKind::NotFound);
        assert!(Folder::open(folder.path()).is_ok());
    }

    #[test]
    fn a_link_or_a_pipe_in_place_of_a_lock_is_neither_followed_nor_waited_for() {
        let (place, folder) = made();
        let target = place.path().join("made_by_the_link");
        symlink(&target, folder.path().join("lock")).unwrap();
        let error = folder
            .lock("lock", FlockOperation::NonBlockingLockShared)
            .unwrap_err();
        assert_eq!(error.kind(), ErrorKind::PermissionDenied);
        assert!(!target.exists());
        let pipe = folder.path().join("pipe");
        rustix::fs::mknodat(
            CWD,
            &pipe,
            FileType::Fifo,
            Mode::from_raw_mode(FILE_MODE),
            0,
        )
        .unwrap();
        let error = folder.file("pipe", OFlags::RDONLY).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::PermissionDenied);
    }

    #[test]
    fn a_lock_that_others_hold_is_not_waited_for() {
        let (_place, folder) = made();
        let exclusive = FlockOperation::NonBlockingLockExclusive;
        let held = folder.lock("lock", exclusive).unwrap();
        assert!(held.is_some());
        let other = Folder::open(folder.path()).unwrap();
        assert!(other.lock("lock", exclusive).unwrap().is_none());
        drop(held);
        assert!(other.lock("lock", exclusive).unwrap().is_some());
    }

    #[test]
    fn a_turn_is_waited_for_no_longer_than_its_limit() {
        let (_place, folder) = made();
        assert!(folder.take_turn().unwrap());
        let other = Folder::open(folder.path()).unwrap();
        let started = Instant::now();
        assert!(!other.take_turn().unwrap());
        assert!(started.elapsed() >= TURN_LIMIT);
        drop(folder);
        assert!(other.take_turn().unwrap());
    }

    #[test]
    fn a_removed_folder_is_gone_and_gives_no_lock() {
        let (_place, folder) = made();
        assert!(!folder.is_gone());
        std::fs::remove_dir(folder.path()).unwrap();
        assert!(folder.is_gone());
        let lock = folder.lock("lock", FlockOperation::NonBlockingLockShared);
        assert!(lock.unwrap().is_none());
    }
}
