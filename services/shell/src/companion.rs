//! A companion: a process beside a stack that reads its topics and may ask launch for something, and on
//! which nothing in the stack waits.

use crate::domain::Domain;
use crate::error::{EXIT_STOPPED, StartError};
use crate::flags::{CompanionFlags, MemberFlags};
use crate::peer::Peer;
use crate::program;
use crate::roster::Roster;
use crate::roster_reader::RosterReader;
use crate::signals;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use zeronav_msgs::role::Role;
use zeronav_params::Parameter;

/// A program that runs beside a stack. It polls: it takes no seat, and no message rings for it.
///
/// Launch starts it with the flags of a service and asks it to end (SIGTERM) once the services are gone.
pub trait Companion: Sized {
    /// Its configuration, TOML; an empty file gives the defaults.
    type Config: Serialize + DeserializeOwned;

    /// Time between two looks. The shortest queue of a reader holds 32 messages: 0.6 s in real time.
    const PAUSE: Duration = Duration::from_millis(8);

    /// How much lower than that of the stack its priority is.
    const NICER: i32 = 5;

    /// True when it waits, before it opens its ports, until launch has said how the run goes.
    const AWAITS_LAUNCH: bool = true;

    /// The parameters of its configuration, printed by `--print-params`.
    #[must_use]
    fn parameters() -> Vec<Parameter> {
        Vec::new()
    }

    /// Accepts configurations that it can work with. Called for `--print-config`, with which launch asks
    /// before the run begins, and before [`Self::open`].
    ///
    /// # Errors
    /// [`StartError::config`], naming the field.
    fn check(_config: &Self::Config) -> Result<(), StartError> {
        Ok(())
    }

    /// Opens the ports, of a stack whose services may not have been started yet.
    ///
    /// # Errors
    /// What keeps the companion from starting.
    fn open(guest: &Guest, config: Self::Config) -> Result<Self, StartError>;

    /// One look: takes in what has come. It may take as long as it likes; what comes meanwhile is lost once
    /// a queue is full.
    ///
    /// # Errors
    /// What ends the process as a crash.
    fn look(&mut self, guest: &Guest) -> Result<(), StartError>;

    /// `main` of a companion: flags, configuration, ports, loop, exit code.
    #[must_use]
    fn run() -> ExitCode {
        let flags: CompanionFlags = match program::flags() {
            Ok(flags) => flags,
            Err(code) => return code,
        };
        crate::logs::start(&flags.member.log_level);
        match start::<Self>(&flags) {
            Ok(()) => ExitCode::from(EXIT_STOPPED),
            Err(error) => {
                if flags.member.print_config {
                    program::complain(&error.to_string());
                } else {
                    tracing::error!("{error}");
                }
                error.exit_code()
            }
        }
    }
}

/// Membership in a stack as a companion has it.
#[derive(Debug)]
pub struct Guest {
    roster: RosterReader,
    peer: Peer,
}

impl Guest {
    fn join(flags: &CompanionFlags, awaits_launch: bool) -> Result<Self, StartError> {
        let root = flags.member.domain.as_ref();
        let root = root.ok_or_else(|| StartError::Usage("--domain is missing".to_owned()))?;
        let peer = Peer::join(Domain::join(root)?, Role::Tap, flags.epoch)?;
        let mut roster = RosterReader::open(&peer)?;
        if awaits_launch {
            roster.await_known()?;
        }
        Ok(Self { roster, peer })
    }

    /// The membership, to open ports with.
    #[must_use]
    pub fn peer(&self) -> &Peer {
        &self.peer
    }

    /// Which processes are obeyed and how time runs, as of this look.
    #[must_use]
    pub fn roster(&self) -> &Roster {
        self.roster.roster()
    }
}

fn start<C: Companion>(flags: &CompanionFlags) -> Result<(), StartError> {
    let member = &flags.member;
    if member.print_params {
        return program::print_parameters(&C::parameters());
    }
    let config: C::Config = member.read_config(C::check)?;
    if member.print_config {
        return program::print(&MemberFlags::config_text(&config)?);
    }
    let (stop, signals) = signals::catch()?;
    // The stack comes first. Where the system does not allow even that, it goes on as it is.
    let _ = rustix::process::nice(C::NICER);
    let mut guest = Guest::join(flags, C::AWAITS_LAUNCH)?;
    let mut companion = C::open(&guest, config)?;
    while !is_over(&guest, &stop) {
        guest.roster.poll();
        companion.look(&guest)?;
        sleep(&signals, C::PAUSE);
    }
    // Ports first. Of a run that is over, launch removes what this cannot.
    drop(companion);
    drop(guest.roster);
    let _ = guest.peer.leave().close();
    Ok(())
}

fn is_over(guest: &Guest, stop: &Arc<AtomicBool>) -> bool {
    stop.load(Ordering::Relaxed) || guest.peer.domain().is_orphaned()
}

/// Sleeps for `pause`, or until a signal comes.
fn sleep(signals: &UnixStream, pause: Duration) {
    let timeout = Timespec {
        tv_sec: pause.as_secs().cast_signed(),
        tv_nsec: i64::from(pause.subsec_nanos()),
    };
    let _ = poll(&mut [PollFd::new(signals, PollFlags::IN)], Some(&timeout));
}
