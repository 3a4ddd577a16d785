//! Files that commands make of others: in their place once they are complete, and until then what was there.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;
use zeronav_console::exit::EXIT_OUTPUT;
use zeronav_console::terminal::{complain, usage};
use zeronav_files::{Folder, Replace, parts};
use zeronav_shell::printable::printable;

/// Why there is none.
#[derive(Debug)]
pub(crate) enum Problem {
    /// What it was to be made of, or its name.
    Input(String),
    /// The system does not write it.
    Output(String),
}

impl Problem {
    /// Says it; the exit code that belongs to it.
    pub(crate) fn say(&self) -> ExitCode {
        match self {
            Self::Input(why) => usage(&printable(why)),
            Self::Output(why) => {
                complain(&printable(why));
                ExitCode::from(EXIT_OUTPUT)
            }
        }
    }

    /// `out` cannot be written.
    pub(crate) fn writing(out: &Path, why: &dyn core::fmt::Display) -> Self {
        Self::Output(format!("writing {}: {why}", out.display()))
    }
}

/// Has `write` make the file `out`. One of this name is replaced with `force` only.
///
/// # Errors
/// [`Problem`]; what was there before is still there then.
pub(crate) fn made<T>(
    out: &Path,
    force: bool,
    write: impl FnOnce(&File) -> Result<T, Problem>,
) -> Result<T, Problem> {
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::AlreadyExists if !force => Problem::Input(format!(
            "{}: it exists; name another file with --out, or --force to replace it",
            out.display()
        )),
        _ => Problem::writing(out, &error),
    };
    let replace = if force { Replace::Yes } else { Replace::No };
    let (folder, name) = parts(out).map_err(failed)?;
    let folder = Folder::open(folder).map_err(failed)?;
    folder.check_free(name, replace).map_err(failed)?;
    let part = folder.part().map_err(failed)?;
    let made = write(part.file())?;
    part.place(name, replace).map_err(failed)?;
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn what_was_there_stays_until_the_new_one_is_complete() {
        let place = tempfile::tempdir().expect("a folder");
        let out = place.path().join("it.mcap");
        let names = || std::fs::read_dir(place.path()).expect("it").count();
        let writes = |text: &'static str, end: Result<(), Problem>| {
            move |mut file: &File| {
                file.write_all(text.as_bytes()).expect("written");
                end
            }
        };
        made(&out, false, writes("first", Ok(()))).expect("made");
        let taken = made(&out, false, writes("second", Ok(())));
        assert!(matches!(taken, Err(Problem::Input(why)) if why.contains("--force")));
        let fails = writes("half", Err(Problem::Input("it is damaged".to_owned())));
        assert!(
            matches!(made(&out, true, fails), Err(Problem::Input(why)) if why == "it is damaged")
        );
        assert_eq!(std::fs::read_to_string(&out).expect("it"), "first");
        made(&out, true, writes("second", Ok(()))).expect("made");
        assert_eq!(std::fs::read_to_string(&out).expect("it"), "second");
        assert_eq!(names(), 1, "nothing else is left");
    }
}
