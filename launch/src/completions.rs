//! `zeronav completions` and `zeronav man`: for shells and for `man`, from the command line's own
//! declaration.

use crate::cli::Cli;
use crate::known_words::with_known_words;
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::{Error, ErrorKind};
use std::path::Path;
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_OUTPUT, EXIT_PASS};
use zeronav_console::terminal::{complain, pour, say};
use zeronav_files::{Folder, Replace, read};
use zeronav_supervise::temporary::TemporaryFolder;

/// Name of the command.
const NAME: &str = "zeronav";

/// `zeronav completions`.
#[must_use]
pub fn completions(shell: Shell) -> ExitCode {
    let mut script = Vec::new();
    let mut command = with_known_words(Cli::command());
    clap_complete::generate(shell, &mut command, NAME, &mut script);
    let _ = pour(|to| to.write_all(&script));
    ExitCode::from(EXIT_PASS)
}

/// `zeronav man`: a page for the command and for each of its verbs. Pages that are there and are
/// others are replaced when `force` says so.
#[must_use]
pub fn man(folder: &Path, force: bool) -> ExitCode {
    match pages().and_then(|pages| write_pages(folder, &pages, force)) {
        Ok(()) => say(&format!(
            "{}: read one with `man {}`\n",
            folder.display(),
            folder.join(format!("{NAME}.1")).display()
        )),
        Err(error) => {
            complain(&format!("{}: {error}", folder.display()));
            return ExitCode::from(EXIT_OUTPUT);
        }
    }
    ExitCode::from(EXIT_PASS)
}

/// Name and text of each page.
fn pages() -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let place = TemporaryFolder::new("zeronav-man-")?;
    clap_mangen::generate_to(Cli::command(), place.path())?;
    let mut pages = Vec::new();
    for entry in std::fs::read_dir(place.path())? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        pages.push((name, std::fs::read(entry.path())?));
    }
    pages.sort();
    Ok(pages)
}

/// Writes all pages, or none when one must not be replaced.
fn write_pages(folder: &Path, pages: &[(String, Vec<u8>)], force: bool) -> std::io::Result<()> {
    let folder = Folder::make(folder)?;
    let replace = if force { Replace::Yes } else { Replace::No };
    let is_same = |name: &str, page: &[u8]| {
        let path = folder.here().join(name);
        let is_link = path.is_symlink();
        !is_link && read::bytes(&path, page.len() as u64).is_ok_and(|there| there == page)
    };
    let new: Vec<_> = (pages.iter())
        .filter(|(name, page)| !is_same(name, page))
        .collect();
    let named = |name: &str, error: Error| {
        let hint = if error.kind() == ErrorKind::AlreadyExists && !force {
            " and is another file: --force replaces it"
        } else {
            ""
        };
        Error::new(error.kind(), format!("{name} {error}{hint}"))
    };
    for (name, _) in &new {
        let free = folder.check_free(name, replace);
        free.map_err(|error| named(name, error))?;
    }
    new.iter().try_for_each(|(name, page)| {
        let written = folder.write(name, page, replace);
        written.map_err(|error| named(name, error))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_replace_no_file_and_are_not_written_through_a_link() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("man1");
        let victim = place.path().join("victim");
        std::fs::write(&victim, "mine").expect("written");
        let pages = [("a.1", "page"), ("b.1", "page")].map(|(name, page)| {
            let page: &str = page;
            (name.to_owned(), page.as_bytes().to_vec())
        });
        write_pages(&folder, &pages, false).expect("written");
        write_pages(&folder, &pages, false).expect("the same pages again");
        std::fs::remove_file(folder.join("b.1")).expect("removed");
        std::os::unix::fs::symlink(&victim, folder.join("b.1")).expect("a link");
        let why = write_pages(&folder, &pages, false).expect_err("it is there");
        assert!(why.to_string().contains("b.1 is already there"), "{why}");
        write_pages(&folder, &pages, true).expect("replaced");
        let read = |file| std::fs::read_to_string(file).expect("read");
        assert_eq!(read(victim), "mine");
        assert_eq!(read(folder.join("b.1")), "page");
    }
}
