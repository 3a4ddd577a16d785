//! Temporary folders that go with the command that made them, also when it is killed.

use super::warden;
use std::fs::Permissions;
use std::io::Result;
use std::os::unix::fs::PermissionsExt;
use tempfile::TempDir;

/// Makes a folder for this user alone whose name begins with `prefix`. It is removed when it is dropped,
/// and by the warden when this process is killed before.
///
/// # Errors
/// What the system says.
pub fn folder(prefix: &str) -> Result<TempDir> {
    // It has to be there before there is something to remove.
    warden::start();
    let folder = tempfile::Builder::new()
        .prefix(prefix)
        .permissions(Permissions::from_mode(0o700))
        .tempdir()?;
    warden::watch_folder(folder.path());
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_its_users_alone_and_goes_when_it_is_dropped() {
        let folder = folder("zeronav-test-").expect("a folder");
        let path = folder.path().to_owned();
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(name.starts_with("zeronav-test-"), "{name}");
        let mode = std::fs::metadata(&path).expect("it").permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
        drop(folder);
        assert!(!path.exists());
    }
}
