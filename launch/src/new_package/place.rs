//! The folder of a new package, and its files: all of them are written, or none.

use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use zeronav_files::Folder;

/// A file of a package: its path in the folder, and its text.
pub(crate) type Text = (PathBuf, String);

/// Makes the folder when it is not there, and writes the files.
///
/// # Errors
/// The folder is in use, or something could not be written; then what was written is removed again.
pub(crate) fn write(folder: &Path, files: &[Text]) -> Result<(), String> {
    let named = |error: Error| format!("{}: {error}", folder.display());
    let missing: Vec<&Path> = folder.ancestors().take_while(|it| !it.exists()).collect();
    let root = if missing.is_empty() {
        Folder::open(folder)
    } else {
        Folder::create_at(folder)
    };
    let root = root.map_err(named)?;
    if !root.names().map_err(named)?.is_empty() {
        return Err(format!(
            "{} is not empty: name a new folder",
            folder.display()
        ));
    }
    let mut made = Made::default();
    let result = files.iter().try_for_each(|(path, text)| {
        let written = made.file(&root, path, text);
        written.map_err(|error| format!("{}: {error}", folder.join(path).display()))
    });
    result.inspect_err(|_| {
        made.remove();
        // What others have put into a folder meanwhile keeps the folder.
        for folder in missing {
            let _ = std::fs::remove_dir(folder);
        }
    })
}

/// What was made, in its order: the folder and the name in it.
#[derive(Debug, Default)]
struct Made(Vec<(Folder, String)>);

impl Made {
    fn file(&mut self, root: &Folder, path: &Path, text: &str) -> std::io::Result<()> {
        let (parents, name) = zeronav_files::parts(path)?;
        let mut at = root.clone();
        for parent in parents {
            let parent = parent.to_str().ok_or(ErrorKind::InvalidInput)?;
            let new = at.create(parent);
            if new.is_ok() {
                self.0.push((at.clone(), parent.to_owned()));
            }
            at = match new {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => at.inside(parent)?,
                other => other?,
            };
        }
        let mut file = at.new_file(name)?;
        self.0.push((at, name.to_owned()));
        file.write_all(text.as_bytes())
    }

    fn remove(&mut self) {
        for (folder, name) in self.0.drain(..).rev() {
            folder.remove(&name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
