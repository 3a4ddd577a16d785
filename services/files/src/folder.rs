//! A folder that files are left in.
//!
//! On the way to it no link of another user is followed, unless that user is root. The folder itself
//! must belong to the caller or to root; root is a user like the others, so what belongs to somebody
//! else is refused for root, too. What is made in it is new, or takes the place of a name as a whole.

use rustix::fs::{
    AtFlags, CWD, FileType, Mode, OFlags, RenameFlags, Stat, fstat, mkdirat, openat, readlinkat,
    renameat_with, statat, unlinkat,
};
use rustix::io::Errno;
use std::collections::VecDeque;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{Error, ErrorKind, Write};
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::ffi::OsStringExt;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Modes of what is made, before the umask: others may read, whatever the umask.
const FOLDER_MODE: Mode = Mode::from_raw_mode(0o755);
const FILE_MODE: Mode = Mode::from_raw_mode(0o644);

/// Most links on the way to a folder, as in the kernel.
const LINKS_MAX: usize = 40;

/// How often a missing folder is made that somebody else removes again.
const TRIES: usize = 16;

/// What becomes of a file that is already there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Replace {
    /// The new one takes its place, a link or a regular file.
    Yes,
    /// It stays and the new one is not written.
    No,
}

/// See the module's description. Clones share one descriptor.
#[derive(Debug, Clone)]
pub struct Folder {
    handle: Arc<OwnedFd>,
    path: PathBuf,
}

impl Folder {
    /// Opens the folder at `path`, empty for the working folder.
    ///
    /// # Errors
    /// `PermissionDenied` when it belongs to another user or one of that user's links leads there, and
    /// what the system says.
    pub fn open(path: &Path) -> std::io::Result<Self> {
        Self::at(path, false)
    }

    /// Opens the folder at `path`, and makes what is missing of it.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn make(path: &Path) -> std::io::Result<Self> {
        Self::at(path, true)
    }

    fn at(path: &Path, make: bool) -> std::io::Result<Self> {
        let handle = walk(path, make)?;
        check_owner(&fstat(&handle)?)?;
        Ok(Self {
            handle: Arc::new(handle),
            path: path.to_owned(),
        })
    }

    /// Where it was opened: for people, and for what only reads.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the folder `name` in this one.
    ///
    /// # Errors
    /// `AlreadyExists` when something has the name, and what the system says.
    pub fn create(&self, name: &str) -> std::io::Result<Self> {
        mkdirat(&*self.handle, plain(name)?, FOLDER_MODE)?;
        self.inside(name)
    }

    /// Makes a folder `parent/name` that is not there yet. The parent may belong to anyone.
    ///
    /// # Errors
    /// As [`Self::create`] and [`Self::open`].
    pub fn create_at(path: &Path) -> std::io::Result<Self> {
        let (parent, name) = parts(path)?;
        let parent = Self {
            handle: Arc::new(walk(parent, true)?),
            path: parent.to_owned(),
        };
        parent.create(name)
    }

    /// Opens the folder `name` in this one.
    ///
    /// # Errors
    /// `PermissionDenied` when it is a link or belongs to another user, and what the system says.
    pub fn inside(&self, name: &str) -> std::io::Result<Self> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let handle = match openat(&*self.handle, plain(name)?, flags, Mode::empty()) {
            Ok(handle) => handle,
            Err(Errno::LOOP | Errno::NOTDIR) => return Err(denied("is not a folder")),
            Err(error) => return Err(error.into()),
        };
        check_owner(&fstat(&handle)?)?;
        Ok(Self {
            handle: Arc::new(handle),
            path: self.path.join(name),
        })
    }

    /// Makes the file `name`.
    ///
    /// # Errors
    /// `AlreadyExists` when something has the name, a link included, and what the system says.
    pub fn new_file(&self, name: &str) -> std::io::Result<File> {
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL;
        self.opened(name, flags)
    }

    /// Opens the file `name` for reading.
    ///
    /// # Errors
    /// `PermissionDenied` when it is no regular file or a link, and what the system says.
    pub fn existing(&self, name: &str) -> std::io::Result<File> {
        let flags = OFlags::RDONLY | OFlags::NONBLOCK;
        let file = self.opened(name, flags)?;
        match FileType::from_raw_mode(fstat(&file)?.st_mode) {
            FileType::RegularFile => Ok(file),
            _ => Err(denied("is not a file")),
        }
    }

    /// Opens the file `name` for more at its end, and makes it when it is missing.
    ///
    /// # Errors
    /// `PermissionDenied` when it is no regular file of the caller or has a second name, and what the
    /// system says.
    pub fn append(&self, name: &str) -> std::io::Result<File> {
        let flags = OFlags::RDWR | OFlags::APPEND | OFlags::CREATE | OFlags::NONBLOCK;
        let file = self.opened(name, flags)?;
        let stat = fstat(&file)?;
        check_owner(&stat)?;
        if FileType::from_raw_mode(stat.st_mode) != FileType::RegularFile || stat.st_nlink > 1 {
            return Err(denied("is not a file with one name"));
        }
        Ok(file)
    }

    fn opened(&self, name: &str, flags: OFlags) -> std::io::Result<File> {
        let flags = flags | OFlags::NOFOLLOW | OFlags::NOCTTY | OFlags::CLOEXEC;
        match openat(&*self.handle, plain(name)?, flags, FILE_MODE) {
            Ok(file) => Ok(File::from(file)),
            Err(Errno::LOOP) => Err(denied("is a symbolic link")),
            Err(error) => Err(error.into()),
        }
    }

    /// Puts the file `name` in its place once it is complete and durable.
    ///
    /// # Errors
    /// `AlreadyExists` when it is there and `replace` says no, or when something that is neither a file
    /// nor a link is there; what the system says. What was there before is still there then.
    pub fn write(&self, name: &str, bytes: &[u8], replace: Replace) -> std::io::Result<()> {
        self.check_free(name, replace)?;
        let part = self.part()?;
        part.file().write_all(bytes)?;
        part.place(name, replace)
    }

    /// Begins a file of this folder that has no name yet.
    ///
    /// # Errors
    /// What the system says.
    pub fn part(&self) -> std::io::Result<Part> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!(".zeronav.{}.{n}.{}.part", std::process::id(), moment());
        Ok(Part {
            file: self.new_file(&name)?,
            folder: self.clone(),
            name,
        })
    }

    /// Accepts a name for [`Self::write`].
    ///
    /// # Errors
    /// `AlreadyExists`.
    pub fn check_free(&self, name: &str, replace: Replace) -> std::io::Result<()> {
        let taken = |why| Err(Error::new(ErrorKind::AlreadyExists, why));
        let Ok(stat) = statat(&*self.handle, plain(name)?, AtFlags::SYMLINK_NOFOLLOW) else {
            return Ok(());
        };
        match FileType::from_raw_mode(stat.st_mode) {
            _ if replace == Replace::No => taken("is already there"),
            FileType::RegularFile | FileType::Symlink => Ok(()),
            _ => taken("is there and is not a file"),
        }
    }

    fn rename(&self, part: &str, name: &str, replace: Replace) -> std::io::Result<()> {
        let how = match replace {
            Replace::Yes => RenameFlags::empty(),
            Replace::No => RenameFlags::NOREPLACE,
        };
        let rename = |how| renameat_with(&*self.handle, part, &*self.handle, name, how);
        match rename(how) {
            // Some file systems know no flags; the name was free a moment ago.
            Err(Errno::INVAL | Errno::NOSYS) if replace == Replace::No => {
                self.check_free(name, replace)?;
                Ok(rename(RenameFlags::empty())?)
            }
            other => Ok(other?),
        }
    }

    /// Removes a file or an empty folder of this one; what cannot be removed stays.
    pub fn remove(&self, name: &str) {
        if unlinkat(&*self.handle, name, AtFlags::empty()).is_err() {
            let _ = unlinkat(&*self.handle, name, AtFlags::REMOVEDIR);
        }
    }

    /// The names in it.
    ///
    /// # Errors
    /// What the system says.
    pub fn names(&self) -> std::io::Result<Vec<OsString>> {
        let entries = std::fs::read_dir(self.here())?;
        entries.map(|entry| Ok(entry?.file_name())).collect()
    }

    /// A path of this very folder, whatever is at [`Self::path`] by now. It holds as long as `self` in
    /// this process.
    #[must_use]
    pub fn here(&self) -> PathBuf {
        PathBuf::from(format!("/proc/self/fd/{}", self.handle.as_raw_fd()))
    }
}

/// A file that is being written: what has its name stays until it is complete. Dropping it removes it.
#[derive(Debug)]
pub struct Part {
    folder: Folder,
    name: String,
    file: File,
}

impl Part {
    /// Where it is written.
    #[must_use]
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Gives it its name, complete and durable.
    ///
    /// # Errors
    /// As [`Folder::write`].
    pub fn place(self, name: &str, replace: Replace) -> std::io::Result<()> {
        self.folder.check_free(name, replace)?;
        self.file.sync_all()?;
        self.folder.rename(&self.name, plain(name)?, replace)?;
        Ok(rustix::fs::fsync(&*self.folder.handle)?)
    }
}

impl Drop for Part {
    /// Half a file is of no use; without it there is more room.
    fn drop(&mut self) {
        self.folder.remove(&self.name);
    }
}

/// Folder and name of a file that is to be written.
///
/// # Errors
/// `InvalidInput` when the path ends in no name, or in one that is not UTF-8.
pub fn parts(file: &Path) -> std::io::Result<(&Path, &str)> {
    let none = || Error::new(ErrorKind::InvalidInput, "does not end in a name");
    let name = file.file_name().and_then(OsStr::to_str).ok_or_else(none)?;
    Ok((file.parent().unwrap_or(Path::new("")), name))
}

/// A name without a way.
fn plain(name: &str) -> std::io::Result<&str> {
    let mut parts = Path::new(name).components();
    match (parts.next(), parts.next()) {
        (Some(Component::Normal(_)), None) if !name.contains('/') => Ok(name),
        _ => Err(Error::new(ErrorKind::InvalidInput, "is not a plain name")),
    }
}

/// Nanoseconds that make a name new.
fn moment() -> u32 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(0, |now| now.subsec_nanos())
}

/// Goes to `path` step by step, each by the descriptor of the one before.
fn walk(path: &Path, make: bool) -> std::io::Result<OwnedFd> {
    let step = |name: &OsStr, at: Option<&OwnedFd>| {
        let flags = OFlags::PATH | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        match at {
            Some(at) => openat(at, name, flags, Mode::empty()),
            None => openat(CWD, name, flags, Mode::empty()),
        }
    };
    let names = |path: &Path| -> Vec<OsString> {
        let parts = path.components();
        parts.map(|part| part.as_os_str().to_owned()).collect()
    };
    let mut left: VecDeque<OsString> = names(path).into();
    let mut at = step(OsStr::new("."), None)?;
    let (mut links, mut tries) = (0, 0);
    while let Some(name) = left.pop_front() {
        let next = match step(&name, Some(&at)) {
            Ok(next) => next,
            Err(Errno::NOENT) if make && tries < TRIES => {
                tries += 1;
                match mkdirat(&at, &name, FOLDER_MODE) {
                    Ok(()) | Err(Errno::EXIST) => left.push_front(name),
                    Err(error) => return Err(error.into()),
                }
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        let stat = fstat(&next)?;
        match FileType::from_raw_mode(stat.st_mode) {
            FileType::Directory => at = next,
            FileType::Symlink => {
                let named = |why: Error| denied(&format!("the link {} {why}", name.display()));
                check_owner(&stat).map_err(named)?;
                links += 1;
                if links > LINKS_MAX {
                    return Err(Errno::LOOP.into());
                }
                let target = readlinkat(&next, "", Vec::new())?.into_bytes();
                for part in names(Path::new(&OsString::from_vec(target)))
                    .into_iter()
                    .rev()
                {
                    left.push_front(part);
                }
            }
            _ => return Err(Errno::NOTDIR.into()),
        }
    }
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
    Ok(openat(&at, ".", flags, Mode::empty())?)
}

/// Accepts what belongs to the caller or to root.
fn check_owner(stat: &Stat) -> std::io::Result<()> {
    let own = rustix::process::geteuid().as_raw();
    if stat.st_uid == own || stat.st_uid == 0 {
        return Ok(());
    }
    let owner = stat.st_uid;
    Err(denied(&format!("belongs to user id {owner}, not to {own}")))
}

fn denied(why: &str) -> Error {
    Error::new(ErrorKind::PermissionDenied, why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::{Gid, Uid, chownat};
    use std::os::unix::fs::symlink;

    #[test]
    fn a_file_is_whole_and_new_or_as_it_was() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::make(&place.path().join("a/b")).unwrap();
        let file = place.path().join("a/b/it");
        folder.write("it", b"first", Replace::No).unwrap();
        let error = folder.write("it", b"other", Replace::No).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::AlreadyExists);
        folder.write("it", b"second", Replace::Yes).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "second");
        folder.create("taken").unwrap();
        assert!(folder.write("taken", b"", Replace::Yes).is_err());
        assert!(folder.write("../it", b"", Replace::Yes).is_err());
        assert_eq!(folder.names().unwrap().len(), 2, "nothing is left beside");
    }

    #[test]
    fn links_are_replaced_and_not_written_through() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path()).unwrap();
        let victim = place.path().join("victim");
        std::fs::write(&victim, "mine").unwrap();
        symlink(&victim, place.path().join("link")).unwrap();
        std::fs::hard_link(&victim, place.path().join("second")).unwrap();
        for name in ["link", "second"] {
            assert!(folder.append(name).is_err(), "{name}");
            assert!(folder.new_file(name).is_err(), "{name}");
        }
        folder.write("link", b"new", Replace::Yes).unwrap();
        assert_eq!(std::fs::read_to_string(&victim).unwrap(), "mine");
        assert!(folder.inside("link").is_err());
    }

    #[test]
    fn files_stay_in_the_folder_that_was_opened() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("runs");
        let folder = Folder::make(&path).unwrap();
        std::fs::rename(&path, place.path().join("away")).unwrap();
        let victim = place.path().join("victim");
        std::fs::create_dir(&victim).unwrap();
        symlink(&victim, &path).unwrap();
        folder.write("it", b"text", Replace::Yes).unwrap();
        folder.append("log").unwrap();
        assert_eq!(std::fs::read_dir(&victim).unwrap().count(), 0);
        assert!(place.path().join("away/it").exists());
    }

    #[test]
    fn what_belongs_to_another_user_is_refused() {
        if !rustix::process::geteuid().is_root() {
            eprintln!("SKIPPED: only root can give a file away");
            return;
        }
        let place = tempfile::tempdir().unwrap();
        let foreign = |name: &str| {
            let path = place.path().join(name);
            let (user, group) = (Uid::from_raw(65534), Gid::from_raw(65534));
            chownat(
                CWD,
                &path,
                Some(user),
                Some(group),
                AtFlags::SYMLINK_NOFOLLOW,
            )
            .unwrap();
            path
        };
        std::fs::create_dir_all(place.path().join("own/runs")).unwrap();
        std::fs::create_dir(place.path().join("runs")).unwrap();
        symlink(place.path().join("own"), place.path().join("link")).unwrap();
        symlink(place.path().join("own"), place.path().join("my_link")).unwrap();
        let said = |error: Error| error.to_string();
        let why = Folder::make(&foreign("runs")).map_err(said).unwrap_err();
        assert!(why.contains("user id 65534"), "{why}");
        let why = Folder::make(&foreign("link").join("runs")).map_err(said);
        assert!(why.unwrap_err().contains("the link link belongs"));
        assert!(Folder::make(&place.path().join("my_link/runs/new")).is_ok());
        // A folder of one's own in the folder of another user.
        assert!(Folder::make(&place.path().join("runs/new")).is_ok());
        assert!(Folder::create_at(&place.path().join("runs/newer")).is_ok());
    }
}
