//! Temporary folders that go with the command that made them, also when it is killed.

use super::warden;
use std::fs::DirBuilder;
use std::io::Result;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

/// A folder for this user alone. It is removed when this is dropped, and by the warden when this process is
/// killed before.
pub struct TemporaryFolder {
    path: PathBuf,
}

impl TemporaryFolder {
    /// Makes one whose name begins with `prefix`.
    ///
    /// # Errors
    /// What the system says.
    pub fn new(prefix: &str) -> Result<Self> {
        let made = tempfile::Builder::new().prefix(prefix).make(|path| {
            // Before it is there: this process may be killed between the two.
            warden::watch_folder(path);
            (DirBuilder::new().mode(0o700).create(path))
                .inspect_err(|_| warden::forget_folder(path))
        })?;
        let ((), path) = made.keep()?;
        Ok(Self { path })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.path);
        warden::forget_folder(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_folder_is_its_users_alone_and_goes_when_it_is_dropped() {
        let folder = TemporaryFolder::new("zeronav-test-").expect("a folder");
        let path = folder.path().to_owned();
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(name.starts_with("zeronav-test-"), "{name}");
        let mode = std::fs::metadata(&path).expect("it").permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
        drop(folder);
        assert!(!path.exists());
    }
}
