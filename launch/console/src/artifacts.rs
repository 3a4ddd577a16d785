//! Files that a command leaves: each is whole or not there, in a folder of this user.

use std::io::{Error, ErrorKind};
use std::path::Path;
use zeronav_files::{Folder, Replace, parts};

/// Most runs of one name that a process begins in a second.
const NAMES_MAX: u32 = 1000;

/// Writes `text` to a file beside `file`, makes it durable and gives it the name `file`. What had the
/// name before is replaced, never written through.
///
/// # Errors
/// One line naming the file; what was there before is still there.
pub fn write(file: &Path, text: &str) -> Result<(), String> {
    let written = parts(file).and_then(|(folder, name)| {
        Folder::open(folder)?.write(name, text.as_bytes(), Replace::Yes)
    });
    written.map_err(|error| refused(file, &error))
}

/// As [`write`], in a folder that is open.
///
/// # Errors
/// As [`write`].
pub fn write_in(folder: &Folder, name: &str, text: &str) -> Result<(), String> {
    let written = folder.write(name, text.as_bytes(), Replace::Yes);
    written.map_err(|error| refused(&folder.path().join(name), &error))
}

/// Makes a folder in `out` for what is called `what`: with the time and this process in its name.
///
/// # Errors
/// One line naming the folder.
pub fn new_folder(out: &Path, what: &str) -> Result<Folder, String> {
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .unwrap_or_default();
    let id = format!("{what}-{}-{}", now.as_secs(), std::process::id());
    let within = Folder::make(out).map_err(|error| {
        let why = refused(out, &error);
        if error.kind() == ErrorKind::PermissionDenied {
            format!("{why}: name a folder of your own with --out")
        } else {
            why
        }
    })?;
    // A command that makes several runs may make two in a second.
    let names = (1..NAMES_MAX).map(|n| match n {
        1 => id.clone(),
        n => format!("{id}-{n}"),
    });
    for name in names {
        match within.create(&name) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            made => return made.map_err(|error| refused(&out.join(name), &error)),
        }
    }
    Err(format!("{}: {id} is taken", out.display()))
}

/// That a file or folder was not made.
#[must_use]
pub fn refused(file: &Path, error: &Error) -> String {
    format!("writing {}: {error}", file.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_whole_or_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("result.json");
        write(&file, "first").expect("written");
        write(&file, "second").expect("written over");
        assert_eq!(std::fs::read_to_string(&file).expect("read"), "second");
        // A folder in the way of the name: nothing is left beside it.
        let taken = folder.path().join("taken");
        std::fs::create_dir_all(taken.join("in_use")).expect("a folder");
        let problem = write(&taken, "text").expect_err("the name is taken");
        assert!(problem.contains("taken"), "{problem}");
        let left = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 2);
    }

    #[test]
    fn runs_of_one_name_in_one_second_have_folders_of_their_own() {
        let out = tempfile::tempdir().expect("a folder");
        let made = [(); 3].map(|()| new_folder(out.path(), "it").expect("made"));
        let names = std::fs::read_dir(out.path()).expect("a folder").count();
        assert_eq!(names, made.len());
    }
}
