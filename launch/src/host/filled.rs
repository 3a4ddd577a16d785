//! The processes in the seats of a host that fills them for the launch of another: started when they are wanted,
//! ended when they are not, and what became of each.

use super::programs::Programs;
use crate::configs;
use crate::prepare::Prepared;
use rustix::process::Signal;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::time::{Duration, Instant};
use zeronav_console::terminal::note;
use zeronav_msgs::role::Role;
use zeronav_scenario::scheduling::SchedulingSpec;
use zeronav_shell::Domain;
use zeronav_shell::printable::printable;
use zeronav_shell::remote_seats::{Held, SeatStart, WHY_CHARS_MAX, Wanted};
use zeronav_shell::seat::SeatLock;
use zeronav_supervise::child::{Child, Start};
use zeronav_supervise::cleaner::{Cleaner, Ticket};
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::question::headline;

/// Own time that a process may take to stop before it is killed.
const STOP_LIMIT: Duration = Duration::from_secs(2);

/// For how long nobody may want a process before it is ended: a link that is started again knows of nobody at first.
const UNWANTED_LIMIT: Duration = Duration::from_secs(1);

/// Starts of seats whose end is remembered; of the seat that ends next the oldest are forgotten.
const ENDED_MAX: usize = 32;

/// Processes of a seat at a time, and starts of it that are looked at.
const PAIR: usize = 2;

/// Exit code of a process that could not be started.
const NOT_STARTED: u8 = 1;

struct Running {
    child: Child,
    /// Since nobody has wanted it.
    unwanted: Option<Instant>,
    /// Since it was asked to end.
    stopping: Option<Patience>,
}

/// See the module's description.
pub(super) struct Filled<'a> {
    prepared: &'a Prepared,
    scheduling: BTreeMap<Role, SchedulingSpec>,
    programs: Programs,
    seats: BTreeMap<Role, SeatLock>,
    running: BTreeMap<SeatStart, Running>,
    /// Exit codes, and why.
    ended: BTreeMap<SeatStart, (u8, String)>,
    cleaner: Cleaner,
    /// What dead processes have left is being removed: until then none is started.
    cleaning: Option<Ticket>,
    root: PathBuf,
}

impl<'a> Filled<'a> {
    /// Takes the seats of this host in `domain`.
    ///
    /// # Errors
    /// One line when a seat is taken, or a configuration cannot be written.
    pub(super) fn new(prepared: &'a Prepared, domain: &Domain) -> Result<Self, String> {
        let root = domain.root().to_owned();
        let configs = configs::write(&prepared.scenario, &prepared.world, &[], &root)?;
        let mut seats = BTreeMap::new();
        for role in prepared.binaries.keys() {
            let seat = SeatLock::take_free(domain, *role).map_err(|error| error.to_string())?;
            seats.insert(*role, seat);
        }
        Ok(Self {
            prepared,
            programs: Programs::new(prepared, configs, &root),
            scheduling: prepared.scenario.scheduling(),
            seats,
            running: BTreeMap::new(),
            ended: BTreeMap::new(),
            cleaner: Cleaner::new(&root),
            cleaning: None,
            root,
        })
    }

    /// What became of each start.
    pub(super) fn held(&self) -> Vec<Held> {
        let running = self.running.keys().map(|seat| Held {
            seat: *seat,
            ended: None,
            why: String::new(),
        });
        let ended = self.ended.iter().map(|(seat, (code, why))| Held {
            seat: *seat,
            ended: Some(*code),
            why: why.clone(),
        });
        running.chain(ended).collect()
    }

    /// One look: starts what is wanted, ends what is not: at once when the run is over, or a successor is wanted.
    pub(super) fn look(&mut self, wanted: &[Wanted], is_over: bool) {
        self.reap();
        let is_wanted = |seat: &SeatStart| wanted.iter().any(|it| it.seat == *seat);
        for (seat, running) in &mut self.running {
            if let Some(patience) = &mut running.stopping {
                if patience.is_over(STOP_LIMIT) {
                    running.child.signal(Signal::KILL);
                }
                continue;
            }
            if !is_over && is_wanted(seat) {
                running.unwanted = None;
                continue;
            }
            let since = *running.unwanted.get_or_insert_with(Instant::now);
            let is_succeeded = wanted.iter().any(|other| other.seat.role == seat.role);
            if is_over || is_succeeded || since.elapsed() > UNWANTED_LIMIT {
                running.child.signal(Signal::TERM);
                running.stopping = Some(Patience::with(running.child.pid()));
            }
        }
        let (cleaning, cleaner) = (&mut self.cleaning, &mut self.cleaner);
        cleaning.take_if(|ticket| cleaner.is_done(*ticket));
        if self.cleaning.is_some() || is_over {
            return;
        }
        for (n, start) in wanted.iter().enumerate() {
            let seat = start.seat;
            let before = wanted[..n].iter();
            if before.filter(|it| it.seat.role == seat.role).count() >= PAIR {
                continue;
            }
            let others = self.running.keys().filter(|it| it.role == seat.role);
            let others: Vec<&SeatStart> = others.collect();
            // A predecessor that nobody wants any more has to end first; beside one that is wanted, too, a newcomer runs.
            let is_taken = |other: &&SeatStart| **other == seat || !is_wanted(other);
            let waits = others.len() >= PAIR || others.iter().any(is_taken);
            if !waits && !self.ended.contains_key(&seat) {
                self.start(start);
            }
        }
    }

    fn start(&mut self, wanted: &Wanted) {
        let seat = wanted.seat;
        let Some(role) = seat.role() else { return };
        match self.try_start(role, wanted) {
            Ok(child) => {
                tracing::info!(%role, epoch = seat.epoch, pid = child.pid(), "started");
                let running = Running {
                    child,
                    unwanted: None,
                    stopping: None,
                };
                self.running.insert(seat, running);
            }
            Err(why) => {
                note(&format!("{role}: {}", printable(&why)));
                self.remember(seat, NOT_STARTED, &why);
            }
        }
    }

    fn try_start(&mut self, role: Role, wanted: &Wanted) -> Result<Child, String> {
        let (binary, config) = self.programs.files(role, wanted)?;
        let none = || format!("{role} is no seat of this host");
        let seat = self.seats.get(&role).ok_or_else(none)?;
        let arguments: [OsString; 8] = [
            "--domain".into(),
            self.root.clone().into(),
            "--epoch".into(),
            wanted.seat.epoch.to_string().into(),
            "--config".into(),
            config.into(),
            "--log-level".into(),
            self.prepared.log_level.clone().into(),
        ];
        let start = Start {
            binary: &binary,
            arguments: &arguments,
            root: &self.root,
            log: &self.prepared.log(format!("{role}.log")),
            scheduling: self.scheduling.get(&role),
        };
        let seat = seat.for_child();
        let child = seat.and_then(|seat| Child::start(role, wanted.seat.epoch, seat, &start));
        child.map_err(|error| error.to_string())
    }

    fn reap(&mut self) {
        let mut ended = Vec::new();
        self.running.retain(|seat, running| {
            let Some(status) = running.child.ended() else {
                return true;
            };
            let how = Child::end_in_words(status);
            tracing::info!(
                role = running.child.role.label(),
                epoch = seat.epoch,
                how,
                "ended"
            );
            let (code, mut said) = (code(status), Vec::new());
            if code != 0 {
                said = running.child.log_tail(1);
            }
            ended.push((*seat, code, headline(&said.concat())));
            false
        });
        for (seat, code, why) in ended {
            self.remember(seat, code, &why);
            self.cleaning = Some(self.cleaner.ask());
        }
    }

    fn remember(&mut self, seat: SeatStart, code: u8, why: &str) {
        self.programs.forget(seat);
        let why = printable(why).chars().take(WHY_CHARS_MAX).collect();
        self.ended.insert(seat, (code, why));
        while self.ended.len() > ENDED_MAX {
            let mut starts = self.ended.keys().copied();
            let Some(oldest) = starts.find(|it| it.role == seat.role) else {
                break;
            };
            self.ended.remove(&oldest);
        }
    }

    /// True once every process has ended.
    pub(super) fn is_empty(&self) -> bool {
        self.running.is_empty()
    }

    /// Root folder of the domain.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }
}

/// Exit code of a process; 128 and the number of the signal that has ended it.
fn code(status: ExitStatus) -> u8 {
    let code = status.code().or_else(|| Some(128 + status.signal()?));
    code.and_then(|code| u8::try_from(code).ok())
        .unwrap_or(NOT_STARTED)
}
