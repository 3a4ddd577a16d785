//! Services that misbehave, in one program: the name by which it is called says how.
//!
//! Called as `misbehaving FOLDER` it puts itself there under all of these names.

mod ahead_once_obeyed;
mod paths;
mod requests;
mod swapped_fields;
mod writes_wrong_type;
mod wrong_service;

use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::ExitCode;
use zeronav_shell::run;

/// What a program does.
type Run = fn() -> ExitCode;

/// Every name, and what it does.
const ALL: [(&str, Run); 13] = [
    (
        "ahead_once_obeyed",
        run::<ahead_once_obeyed::AheadOnceObeyed>,
    ),
    ("crashes_at_start", crash_at_start),
    (
        "dies_once_obeyed",
        requests::run::<requests::DiesOnceObeyed>,
    ),
    ("floods_requests", requests::run::<requests::FloodsRequests>),
    ("hangs_after_start", paths::run::<paths::HangsAfterStart>),
    ("ignores_sigterm", requests::run::<requests::IgnoresSigterm>),
    ("nan_once_obeyed", requests::run::<requests::NanOnceObeyed>),
    ("stays_silent", stay_silent),
    (
        "swapped_fields_mapping",
        run::<swapped_fields::SwappedFields>,
    ),
    (
        "through_walls_once_obeyed",
        paths::run::<paths::ThroughWalls>,
    ),
    ("too_many_waypoints", paths::run::<paths::TooManyWaypoints>),
    (
        "writes_wrong_type",
        run::<writes_wrong_type::WritesWrongType>,
    ),
    ("wrong_service", wrong_service::run),
];

/// Accepts any configuration and ends before it has opened anything.
fn crash_at_start() -> ExitCode {
    if prints_config() {
        return ExitCode::SUCCESS;
    }
    eprintln!("this is the last line of a service that could not start");
    ExitCode::FAILURE
}

/// Accepts any configuration, runs and does nothing: no port is opened, no heartbeat sent.
fn stay_silent() -> ExitCode {
    while !prints_config() {
        std::thread::park();
    }
    ExitCode::SUCCESS
}

fn prints_config() -> bool {
    std::env::args().any(|word| word == "--print-config")
}

/// Hard links: the supervisor resolves symbolic ones, and would call the program by its own name.
fn link_into(folder: &Path) -> std::io::Result<()> {
    let own = std::env::current_exe()?;
    let inode = own.metadata()?.ino();
    for (name, _) in ALL {
        let link = folder.join(name);
        if !link.metadata().is_ok_and(|link| link.ino() == inode) {
            // Other tests may be about to start it: it is never missing.
            let new = folder.join(format!("{name}.{}", std::process::id()));
            std::fs::hard_link(&own, &new)?;
            std::fs::rename(&new, &link)?;
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    let name = words.first().and_then(|word| Path::new(word).file_name());
    if let Some((_, run)) = ALL.iter().find(|(known, _)| name == Some(known.as_ref())) {
        return run();
    }
    let Some(folder) = words.get(1) else {
        eprintln!(
            "usage: misbehaving FOLDER, which puts it there under the name of every misbehaviour"
        );
        return ExitCode::from(2);
    };
    match link_into(folder.as_ref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}
