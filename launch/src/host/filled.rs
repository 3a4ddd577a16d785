//! The processes in the seats of a host that fills them for the launch of another: started when they are wanted,
//! ended when they are not, and what became of each.

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
use zeronav_shell::remote_seats::{Held, SeatStart};
use zeronav_shell::seat::SeatLock;
use zeronav_supervise::child::{Child, Start};
use zeronav_supervise::cleaner::{Cleaner, Ticket};
use zeronav_supervise::own_time::Patience;

/// Own time that a process may take to stop before it is killed.
const STOP_LIMIT: Duration = Duration::from_secs(2);

/// For how long nobody may want a process before it is ended: a link that is started again knows of nobody at first.
const UNWANTED_LIMIT: Duration = Duration::from_secs(1);

/// Starts of seats whose end is remembered; of the seat that ends next the oldest are forgotten.
const ENDED_MAX: usize = 64;

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
    configs: BTreeMap<Role, PathBuf>,
    scheduling: BTreeMap<Role, SchedulingSpec>,
    seats: BTreeMap<Role, SeatLock>,
    running: BTreeMap<SeatStart, Running>,
    ended: BTreeMap<SeatStart, u8>,
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
        let configs = configs::write(&prepared.scenario, &prepared.world, &root)?;
        let mut seats = BTreeMap::new();
        for role in prepared.binaries.keys() {
            let seat = SeatLock::take_free(domain, *role).map_err(|error| error.to_string())?;
            seats.insert(*role, seat);
        }
        Ok(Self {
            prepared,
            configs,
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
        let running = self.running.keys().map(|seat| (*seat, None));
        let ended = self.ended.iter().map(|(seat, code)| (*seat, Some(*code)));
        running
            .chain(ended)
            .map(|(seat, ended)| Held { seat, ended })
            .collect()
    }

    /// One look: starts what is wanted, ends what is not: at once when the run is over, or a successor is wanted.
    pub(super) fn look(&mut self, wanted: &[SeatStart], is_over: bool) {
        self.reap();
        for (seat, running) in &mut self.running {
            if let Some(patience) = &mut running.stopping {
                if patience.is_over(STOP_LIMIT) {
                    running.child.signal(Signal::KILL);
                }
                continue;
            }
            if !is_over && wanted.contains(seat) {
                running.unwanted = None;
                continue;
            }
            let since = *running.unwanted.get_or_insert_with(Instant::now);
            let is_succeeded = wanted.iter().any(|other| other.role == seat.role);
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
        for seat in wanted {
            // A predecessor has to end first.
            let is_taken = self.running.keys().any(|other| other.role == seat.role);
            if !is_taken && !self.ended.contains_key(seat) {
                self.start(*seat);
            }
        }
    }

    fn start(&mut self, seat: SeatStart) {
        let Some(role) = seat.role() else { return };
        match self.try_start(role, seat.epoch) {
            Ok(child) => {
                tracing::info!(%role, epoch = seat.epoch, pid = child.pid(), "started");
                let running = Running {
                    child,
                    unwanted: None,
                    stopping: None,
                };
                self.running.insert(seat, running);
            }
            Err(error) => {
                note(&format!("{role}: {error}"));
                self.remember(seat, NOT_STARTED);
            }
        }
    }

    fn try_start(&self, role: Role, epoch: u32) -> std::io::Result<Child> {
        let none = || std::io::Error::other(format!("{role} is no seat of this host"));
        let binary = self.prepared.binaries.get(&role).ok_or_else(none)?;
        let config = self.configs.get(&role).ok_or_else(none)?;
        let seat = self.seats.get(&role).ok_or_else(none)?;
        let arguments: [OsString; 8] = [
            "--domain".into(),
            self.root.clone().into(),
            "--epoch".into(),
            epoch.to_string().into(),
            "--config".into(),
            config.into(),
            "--log-level".into(),
            self.prepared.log_level.clone().into(),
        ];
        let start = Start {
            binary,
            arguments: &arguments,
            root: &self.root,
            log: &self.prepared.log(format!("{role}.log")),
            scheduling: self.scheduling.get(&role),
        };
        Child::start(role, epoch, seat.for_child()?, &start)
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
            ended.push((*seat, code(status)));
            false
        });
        for (seat, code) in ended {
            self.remember(seat, code);
            self.cleaning = Some(self.cleaner.ask());
        }
    }

    fn remember(&mut self, seat: SeatStart, code: u8) {
        self.ended.insert(seat, code);
        while self.ended.len() > ENDED_MAX {
            let of_role = |(it, _): (&SeatStart, &u8)| (it.role == seat.role).then_some(*it);
            let Some(oldest) = self.ended.iter().find_map(of_role) else {
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
