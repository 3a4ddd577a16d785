//! `zeronav draw`: a recorded run as an animated picture.

use crate::leave;
use crate::show::recording::{FILE, Recording};
use crate::show::terminal::{lose, say, usage};
use std::path::Path;
use std::process::ExitCode;

/// Draws the run in folder `run` into the file `out`; without, `animation.svg` in that folder.
#[must_use]
pub fn draw(run: &Path, out: Option<&Path>) -> ExitCode {
    let file = run.join(FILE);
    let recording = match read(&file) {
        Ok(recording) => recording,
        Err(problem) => return usage(&problem),
    };
    let out = out.map_or_else(|| run.join("animation.svg"), Path::to_owned);
    match leave::write(&out, &recording.to_animation()) {
        Ok(()) => say(&format!("{}\n", out.display())),
        Err(problem) => lose(&problem),
    }
    ExitCode::SUCCESS
}

fn read(file: &Path) -> Result<Recording, String> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|error| format!("{name}: {error}"))?;
    let recording: Recording =
        serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))?;
    recording
        .check()
        .map_err(|problem| format!("{name}: {problem}"))?;
    Ok(recording)
}
