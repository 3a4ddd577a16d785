//! `zeronav draw`: a recorded run as an animated picture.

use crate::cli::DrawArgs;
use crate::leave;
use crate::show::recording::{FILE, Recording};
use crate::show::terminal::{lose, say, usage};
use std::process::ExitCode;

/// Draws the run in a folder.
#[must_use]
pub fn draw(arguments: &DrawArgs) -> ExitCode {
    let file = arguments.run.join(FILE);
    let recording = match read(&file) {
        Ok(recording) => recording,
        Err(problem) => return usage(&problem),
    };
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| arguments.run.join("animation.svg"));
    match leave::write(&out, &recording.to_animation()) {
        Ok(()) => say(&format!("{}\n", out.display())),
        Err(problem) => lose(&problem),
    }
    ExitCode::SUCCESS
}

fn read(file: &std::path::Path) -> Result<Recording, String> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|error| format!("{name}: {error}"))?;
    let recording: Recording =
        serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))?;
    recording
        .check()
        .map_err(|problem| format!("{name}: {problem}"))?;
    Ok(recording)
}
