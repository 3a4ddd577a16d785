//! `zeronav view FILE`: plays a recording in a page of its own.

use crate::bag::validity;
use crate::judge;
use crate::live_view::ViewArgs;
use crate::output_file::{self, Problem};
use crate::recorded::drive::RecordedDrive;
use crate::recorder::recording_in;
use crate::report::messages::{OfMessages, page};
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{complain, note, say, say_json, usage};
use zeronav_import::recording::IMPORTED;
use zeronav_msgs::time::seconds;
use zeronav_shell::printable::printable;

/// `zeronav view FILE`: writes the page and prints its name, or prints what is played as JSON.
#[must_use]
pub fn view(file: &Path, arguments: &ViewArgs) -> ExitCode {
    let read = recording_in(file).and_then(|file| Ok((of_messages(&file)?, file)));
    let (of, file) = match read {
        Ok(read) => read,
        Err(problem) => return usage(&printable(&problem)),
    };
    if let Some(why) = &of.incomplete {
        let said = format!("{}: NOT COMPLETE: {why}", file.display());
        note(&printable(&said));
    }
    if arguments.json {
        say_json(&of.recording);
        return ExitCode::from(EXIT_PASS);
    }
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| file.with_extension("html"));
    if let Err(problem) = write(&file, &out, arguments.force, &page(&of)) {
        return problem.say();
    }
    say(&format!("{}\n", out.display()));
    if arguments.page.open {
        open(&out);
    }
    ExitCode::from(EXIT_PASS)
}

/// What the recording in `file` says.
///
/// # Errors
/// One line naming the file, and the fix where there is one.
fn of_messages(file: &Path) -> Result<OfMessages, String> {
    let drive = RecordedDrive::read(file)?;
    let subject = drive.subject();
    let found = &drive.recorded.found;
    let seen = &subject.collector.totals;
    let imported = found.metadata.get(IMPORTED);
    let reasons = &subject.collector.reasons;
    let mut about = vec![
        ("file", file.display().to_string()),
        ("by", found.library.clone()),
        ("messages", found.messages().to_string()),
    ];
    if let Some([first_ns, last_ns]) = found.range_ns {
        about.push((
            "time",
            format!("{:.1} s", seconds(last_ns.saturating_sub(first_ns))),
        ));
    }
    for name in ["format", "missing", "assumed", "mended"] {
        let said = imported.and_then(|fields| fields.get(name));
        about.extend(
            said.filter(|it| !it.is_empty())
                .map(|it| (name, it.clone())),
        );
    }
    if let Some(why) = &drive.no_world {
        about.push(("no world", why.clone()));
    }
    let (is_whole, why) = validity(found, None);
    Ok(OfMessages {
        recording: drive.recording(),
        plans: judge::plans(&subject),
        touches: judge::touches(&subject),
        reasons: reasons.moments(subject.goals_run_ns, subject.end_run_ns),
        clearance_m_min: seen.clearance_m_min,
        is_simulated: imported.is_none() && seen.truth.is_some(),
        incomplete: (!is_whole).then_some(why),
        about,
    })
}

/// Writes `out`, which is not the recording itself.
fn write(file: &Path, out: &Path, force: bool, page: &str) -> Result<(), Problem> {
    let is_out = |file: PathBuf| out.canonicalize().is_ok_and(|out| out == file);
    if file.canonicalize().is_ok_and(is_out) {
        let problem = "it is the recording; name another file";
        return Err(Problem::Input(format!("{}: {problem}", out.display())));
    }
    output_file::made(out, force, |mut output| {
        let written = output.write_all(page.as_bytes());
        written.map_err(|error| Problem::writing(out, &error))
    })
}

/// Opens a page in the browser of the user's choice, which outlives this process.
fn open(page: &Path) {
    let started = Command::new("xdg-open")
        .arg(page)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn();
    if let Err(error) = started {
        complain(&format!("--open: xdg-open: {error}"));
    }
}
