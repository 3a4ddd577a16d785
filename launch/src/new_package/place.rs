//! The folder of a new package, and its files: all of them are written, or none.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A file of a package: its path in the folder, and its text.
pub(crate) type Text = (PathBuf, String);

/// Makes the folder when it is not there, and writes the files.
///
/// # Errors
/// The folder is in use, or something could not be written; then what was written is removed again.
pub(crate) fn write(folder: &Path, files: &[Text]) -> Result<(), String> {
    let named = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut made = Made::default();
    if folder.is_dir() {
        let mut entries = fs::read_dir(folder).map_err(named)?;
        if entries.next().is_some() {
            return Err(format!(
                "{} is not empty: name a new folder",
                folder.display()
            ));
        }
    }
    let result = files
        .iter()
        .try_for_each(|(path, text)| made.file(&folder.join(path), text));
    result.inspect_err(|_| made.remove())
}

/// What was made, in its order.
#[derive(Debug, Default)]
struct Made(Vec<PathBuf>);

impl Made {
    fn folder(&mut self, folder: &Path) -> Result<(), String> {
        let none = folder.as_os_str().is_empty();
        if none || folder.is_dir() {
            return Ok(());
        }
        if let Some(parent) = folder.parent() {
            self.folder(parent)?;
        }
        match fs::create_dir(folder) {
            Ok(()) => self.0.push(folder.to_owned()),
            Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(error) => return Err(format!("{}: {error}", folder.display())),
        }
        Ok(())
    }

    fn file(&mut self, path: &Path, text: &str) -> Result<(), String> {
        self.folder(path.parent().unwrap_or_else(|| Path::new("")))?;
        let named = |error: std::io::Error| format!("{}: {error}", path.display());
        let mut file = File::create_new(path).map_err(named)?;
        self.0.push(path.to_owned());
        file.write_all(text.as_bytes()).map_err(named)
    }

    fn remove(&mut self) {
        // What others have put into a folder meanwhile keeps the folder.
        for path in self.0.drain(..).rev() {
            let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir(&path));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(names: &[&str]) -> Vec<Text> {
        names
            .iter()
            .map(|name| (PathBuf::from(name), "text".to_owned()))
            .collect()
    }

    #[test]
    fn an_empty_folder_is_filled_and_another_is_not_touched() {
        let root = tempfile::tempdir().unwrap();
        write(root.path(), &files(&["a", "src/b"])).unwrap();
        assert_eq!(
            fs::read_to_string(root.path().join("src/b")).unwrap(),
            "text"
        );
        let why = write(root.path(), &files(&["c"])).unwrap_err();
        assert!(why.contains("is not empty"), "{why}");
        assert!(!root.path().join("c").exists());
        assert!(write(&root.path().join("a"), &files(&["c"])).is_err());
    }

    #[test]
    fn when_one_file_fails_nothing_is_left() {
        let root = tempfile::tempdir().unwrap();
        // A file cannot be a folder.
        assert!(write(&root.path().join("x/y"), &files(&["a", "src/b", "a/c"])).is_err());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
    }
}
