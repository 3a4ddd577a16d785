//! A process that sits in a seat for one on the other host: launch starts it like any service, and it ends when
//! that one does, with its exit code.
//!
//! The seat is the one that launch hands over, so it needs no word that says which. Its configuration says what is to be
//! started there ([`Program`]). It beats no heart and writes no topic: the link does that for it.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use zeronav_msgs::role::Role;
use zeronav_shell::flags::Flags;
use zeronav_shell::printable::printable;
use zeronav_shell::remote_seats::{FromLink, Line, Program, SeatStart, ToLink, Wanted};
use zeronav_shell::seat::SeatLock;
use zeronav_shell::{Domain, StartError};

/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(5);

/// `main` of the process.
///
/// # Errors
/// What keeps it from sitting there.
pub fn sit(flags: &Flags) -> Result<ExitCode, StartError> {
    let root = flags.member.domain.as_ref();
    let root = root.ok_or_else(|| StartError::Usage("--domain is missing".to_owned()))?;
    let epoch = flags
        .epoch
        .ok_or_else(|| StartError::Usage("--epoch is missing: no shadow sits here".to_owned()))?;
    let domain = Domain::join(root)?;
    let handed_over = |role: Role| Some((role, SeatLock::handed_over(&domain, role)?));
    let (role, _seat) = Role::SERVICES
        .into_iter()
        .find_map(handed_over)
        .ok_or_else(|| {
            let why = "launch hands the seat over: this program is not started by hand";
            StartError::Usage(why.to_owned())
        })?;
    let program: Program = flags.member.read_config(|_| Ok(()))?;
    let stop = stop_flag()?;
    let seat = SeatStart {
        role: role.code(),
        epoch,
    };
    let sit = ToLink::Sit {
        wanted: Wanted { seat, program },
        pid: std::process::id(),
    };
    let mut line = None;
    while !stop.load(Ordering::Relaxed) && !domain.is_orphaned() {
        // The link may not be there yet, or not be there again.
        if line.is_none() {
            line = Line::connect(domain.folder()).ok();
            if let Some(line) = &mut line {
                let _ = line.send(&sit);
            }
        }
        match line.as_mut().map(Line::receive) {
            Some(Ok(said)) => {
                for said in said {
                    if let FromLink::Ended { code, why } = said {
                        let why = printable(&why);
                        tracing::warn!(%role, code, "the process on the other host has ended: {why}");
                        return Ok(ExitCode::from(code));
                    }
                }
            }
            Some(Err(_)) => line = None,
            None => {}
        }
        std::thread::sleep(PAUSE);
    }
    Ok(ExitCode::SUCCESS)
}

fn stop_flag() -> Result<Arc<AtomicBool>, StartError> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in zeronav_shell::signals::stopping() {
        let registered = signal_hook::flag::register(signal, Arc::clone(&stop));
        registered.map_err(|error| StartError::system("catching signals", error))?;
    }
    Ok(stop)
}
