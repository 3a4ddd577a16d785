//! Keeps the seats taken: notices deaths and hangs, and starts successors.

use crate::collect::Collector;
use crate::ending::Ending;
use crate::prepare::Prepared;
use crate::starvation::Starvation;
use rustix::process::Signal;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_console::terminal::note;
use zeronav_measure::result::{Restart, Starved};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::seconds;
use zeronav_supervise::child::{Child, is_short};
use zeronav_supervise::cleaner::Ticket;
use zeronav_supervise::hang::HangWatch;
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::restart::{Decision, Restarts};
use zeronav_supervise::stack::{Launch, Stack};

/// How long the services may take until they can answer, of their own time.
pub(crate) const READY_LIMIT: Duration = Duration::from_secs(15);

/// A seat that waits for its successor.
#[derive(Debug, Clone, Copy)]
struct Vacant {
    role: Role,
    /// When the backoff is over.
    due: Instant,
    /// Removes what the dead process has left.
    cleaning: Ticket,
    /// Ticks for which the seat stays empty once the successor can answer; `None` when it is
    /// obeyed from its start.
    absent_ticks: Option<u64>,
}

/// A successor that is not in its seat yet.
#[derive(Debug, Clone)]
struct Joining {
    role: Role,
    start: Patience,
    /// It can answer, and no answer is due, lockstep only.
    ready: bool,
    /// As of the vacant seat.
    absent_ticks: Option<u64>,
}

/// A successor that is to be obeyed: its seat is empty from `off_tick` to before `on_tick`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taken {
    pub role: Role,
    pub off_tick: u64,
    pub on_tick: u64,
}

/// Keeps the seats of a run taken.
#[derive(Debug)]
pub(crate) struct Restarter<'a> {
    prepared: &'a Prepared,
    /// The binary of each seat that launch fills.
    binaries: BTreeMap<Role, PathBuf>,
    configs: BTreeMap<Role, PathBuf>,
    restarts: Restarts,
    hangs: HangWatch,
    looked: Instant,
    /// The same as run time. [s]
    looked_s: f64,
    /// Seats that were killed because they hung, and what the kernel said of the process.
    hung: BTreeMap<Role, String>,
    vacant: Vec<Vacant>,
    joining: Vec<Joining>,
    /// The first processes, until they can answer.
    starting: BTreeMap<Role, Patience>,
    /// Processes that are ended on purpose: by a fault of the scenario or of a client.
    struck: BTreeSet<(Role, u32)>,
    memory_peaks: BTreeMap<Role, u64>,
    records: Vec<Restart>,
    /// What was not asked for and changed the run, one line each.
    unasked: Vec<String>,
    starvation: Starvation,
}

impl<'a> Restarter<'a> {
    /// A restarter for the seats of `prepared`, whose configuration lies in `configs`.
    #[must_use]
    pub(crate) fn new(prepared: &'a Prepared, configs: BTreeMap<Role, PathBuf>) -> Self {
        Self {
            prepared,
            binaries: prepared.binaries.clone(),
            configs,
            restarts: Restarts::default(),
            hangs: HangWatch::default(),
            looked: Instant::now(),
            looked_s: 0.0,
            hung: BTreeMap::new(),
            vacant: Vec::new(),
            joining: Vec::new(),
            starting: BTreeMap::new(),
            struck: BTreeSet::new(),
            memory_peaks: BTreeMap::new(),
            records: Vec::new(),
            unasked: Vec::new(),
            starvation: Starvation::default(),
        }
    }

    /// Starts the process of a seat, or says how to start one by hand.
    ///
    /// # Errors
    /// One line naming the binary.
    pub(crate) fn start(&mut self, stack: &mut Stack, role: Role) -> Result<(), String> {
        (self.try_start(stack, role)).map_err(|error| error.to_string())
    }

    fn try_start(&mut self, stack: &mut Stack, role: Role) -> std::io::Result<()> {
        let none = || std::io::Error::other(format!("no configuration for {role}"));
        let config = self.configs.get(&role).ok_or_else(none)?;
        let Some(binary) = self.binaries.get(&role) else {
            note(&format!(
                "waiting for {role}; start it with --domain {} --epoch {} --config {}",
                stack.root().display(),
                stack.epoch(role),
                config.display()
            ));
            return Ok(());
        };
        let log = self.prepared.log(format!("{role}.log"));
        let launch = Launch {
            binary,
            config,
            log_level: &self.prepared.log_level,
            log: &log,
        };
        stack.start(role, &launch)?;
        if let Some(child) = stack.children.last() {
            let (pid, epoch) = (child.pid(), child.epoch);
            tracing::info!(%role, pid, epoch, binary = %binary.display(), "started");
            self.starting.insert(role, Patience::with(pid));
            for refused in child.refused_at_start() {
                note(&format!(
                    "warning: the kernel did not grant {role} {refused}"
                ));
            }
        }
        Ok(())
    }

    /// Binary and configuration of a seat that launch fills.
    #[must_use]
    pub(crate) fn files(&self, role: Role) -> Option<(&Path, &Path)> {
        Some((self.binaries.get(&role)?, self.configs.get(&role)?))
    }

    /// From now on the seat is filled with this binary and configuration; the configuration before.
    pub(crate) fn refit(
        &mut self,
        role: Role,
        binary: PathBuf,
        config: PathBuf,
    ) -> Option<PathBuf> {
        self.binaries.insert(role, binary);
        self.hung.remove(&role);
        self.configs.insert(role, config)
    }

    /// True while no process in the seat can answer.
    #[must_use]
    pub(crate) fn is_vacant(&self, role: Role) -> bool {
        self.vacant.iter().any(|vacant| vacant.role == role)
            || self.joining.iter().any(|joining| joining.role == role)
    }

    /// The restarts that were made.
    #[must_use]
    pub(crate) fn records(&self) -> &[Restart] {
        &self.records
    }

    /// The services that got no processor, and for how long, in real time.
    #[must_use]
    pub(crate) fn starved(&self) -> Vec<Starved> {
        let mut all = self.starvation.clone();
        let limit = self.prepared.scenario.restart.hang_after();
        if self.prepared.mode == RunMode::RealTime {
            for seen in self.hangs.starving(limit) {
                all.note(&seen, self.looked_s);
            }
        }
        all.results()
    }

    /// The ends of services that neither the scenario nor a client asked for, one line each.
    #[must_use]
    pub(crate) fn unasked(&self) -> &[String] {
        &self.unasked
    }

    /// The process with this epoch is ended on purpose: what becomes of its seat belongs to the run.
    pub(crate) fn strike(&mut self, role: Role, epoch: u32) {
        self.struck.insert((role, epoch));
    }

    /// True when the newest process of a seat has spent too much of its own time without being able to
    /// answer. One on the other host may have to be started there first.
    pub(crate) fn is_late(&mut self, role: Role) -> bool {
        let is_here = !self.prepared.remote.contains(&role);
        let start = self.starting.get_mut(&role);
        is_here && start.is_some_and(|start| start.is_over(READY_LIMIT))
    }

    /// How many times the process of a seat was started.
    #[must_use]
    pub(crate) fn starts(&self, role: Role) -> u32 {
        1 + self.restarts.of(role)
    }

    /// Largest memory of the processes of a seat that have ended. [bytes]
    #[must_use]
    pub(crate) fn memory_peak_bytes(&self, role: Role) -> u64 {
        self.memory_peaks.get(&role).copied().unwrap_or(0)
    }

    /// One look at every process but that of the seat `left_out`, which a swap looks after. Returns
    /// the seats whose successor is to be obeyed from now on.
    ///
    /// # Errors
    /// How the run ends when a seat cannot be filled again.
    pub(crate) fn look(
        &mut self,
        stack: &mut Stack,
        collector: &Collector,
        left_out: Option<Role>,
    ) -> Result<Vec<Taken>, Ending> {
        let since = self.looked.elapsed();
        self.looked = Instant::now();
        let mut taken = self.look_at_hearts(stack, collector, since, left_out);
        while let Some(at) = stack.dead(left_out) {
            self.replace(stack, collector, at)?;
        }
        self.vacate(stack, collector);
        self.fill_seats(stack, collector, &mut taken)?;
        Ok(taken)
    }

    /// True while a seat waits for its successor: then the next look should come soon.
    #[must_use]
    pub(crate) fn is_busy(&self) -> bool {
        !self.vacant.is_empty()
    }

    /// Starts the successors whose time has come; `taken` gets those that are obeyed at once.
    fn fill_seats(
        &mut self,
        stack: &mut Stack,
        collector: &Collector,
        taken: &mut Vec<Taken>,
    ) -> Result<(), Ending> {
        for vacant in core::mem::take(&mut self.vacant) {
            if Instant::now() < vacant.due || !stack.is_clean(vacant.cleaning) {
                self.vacant.push(vacant);
                continue;
            }
            let is_started = self.join(stack, collector, vacant)?;
            if is_started && vacant.absent_ticks.is_none() {
                taken.push(Taken {
                    role: vacant.role,
                    off_tick: 0,
                    on_tick: 0,
                });
            }
        }
        Ok(())
    }

    /// Lets the next process started by hand take a seat whose owner, started by hand, has ended. In
    /// lockstep the tick would wait for an answer to what the next one never heard.
    fn vacate(&mut self, stack: &mut Stack, collector: &Collector) {
        if self.prepared.mode == RunMode::Lockstep {
            return;
        }
        let ended = |role: &Role| {
            let owner = stack.occupants.get(role);
            owner.is_some_and(|owner| owner.epoch == stack.epoch(*role) && owner.has_ended())
        };
        let external = Role::SERVICES
            .into_iter()
            .filter(|role| !self.binaries.contains_key(role));
        for role in external.filter(ended).collect::<Vec<_>>() {
            self.records.push(Restart {
                service: role.to_string(),
                time_s: seconds(collector.robot_tick() * self.prepared.scenario.run.tick_ns()),
                how: "started by hand, ended".to_owned(),
                wait_ms: 0,
            });
            stack.next_epoch(role);
            stack.obey_newest(role, 0, 0);
            if let Err(problem) = self.start(stack, role) {
                tracing::warn!(%role, problem, "the seat stays empty");
            }
        }
    }

    fn look_at_hearts(
        &mut self,
        stack: &mut Stack,
        collector: &Collector,
        since: Duration,
        left_out: Option<Role>,
    ) -> Vec<Taken> {
        let mut taken = Vec::new();
        for (role, epoch, progress, ready) in stack.heartbeats() {
            if ready {
                taken.extend(self.seat(stack, collector, role));
            }
            let reading = || stack.reading(role);
            let beat = (epoch, progress);
            let limit = self.prepared.hang_limit(role);
            let is_hung = self.hangs.look(role, beat, since, limit, reading);
            if is_hung && left_out != Some(role) && self.prepared.judges_hangs(role) {
                self.kill(stack, role);
            }
        }
        let prepared = self.prepared;
        let late = self.joining.iter_mut().filter_map(|joining| {
            let is_here = !prepared.remote.contains(&joining.role);
            (is_here && !joining.ready && joining.start.is_over(READY_LIMIT))
                .then_some(joining.role)
        });
        for role in late.collect::<Vec<_>>() {
            self.kill(stack, role);
        }
        self.note_starved(collector);
        taken
    }

    /// Remembers who got no processor. In lockstep a run only takes longer then.
    fn note_starved(&mut self, collector: &Collector) {
        self.looked_s = seconds(collector.robot_tick() * self.prepared.scenario.run.tick_ns());
        for seen in self.hangs.take_starved() {
            if self.prepared.mode != RunMode::Lockstep {
                self.starvation.note(&seen, self.looked_s);
            }
        }
    }

    /// Lets a successor that can answer take its seat. In lockstep that happens at the tick at
    /// which the robot is held for the seat's answer, whenever the successor was ready: the roster
    /// says for how long from there the seat is empty, and the successor hears nothing from before.
    fn seat(&mut self, stack: &Stack, collector: &Collector, role: Role) -> Option<Taken> {
        let at = (self.joining.iter()).position(|joining| joining.role == role)?;
        let Some(absent_ticks) = self.joining[at].absent_ticks else {
            self.joining.remove(at);
            return None;
        };
        if !collector.owes(role, &stack.roster) {
            self.joining[at].ready = true;
            return None;
        }
        self.joining.remove(at);
        Some(Taken {
            role,
            off_tick: collector.answered_by(role) + 1,
            on_tick: collector.robot_tick() + absent_ticks,
        })
    }

    /// Kills a process that makes no progress; its death is seen with the others.
    fn kill(&mut self, stack: &mut Stack, role: Role) {
        if !self.binaries.contains_key(&role) {
            // Started by hand: not ours to end.
            if self.hung.insert(role, String::new()).is_none() {
                tracing::warn!(%role, "no progress");
            }
            return;
        }
        if let Some(child) = stack.children.iter_mut().find(|child| child.role == role)
            && child.ended().is_none()
            && !self.hung.contains_key(&role)
        {
            let condition = child.condition();
            tracing::warn!(%role, pid = child.pid(), condition, "no progress, killed");
            self.hung.insert(role, condition);
            child.signal(Signal::KILL);
        }
    }

    /// Buries an ended process; its seat is vacant, or the run is over.
    fn replace(
        &mut self,
        stack: &mut Stack,
        collector: &Collector,
        at: usize,
    ) -> Result<(), Ending> {
        let child = &mut stack.children[at];
        let role = child.role;
        let status = child.ended();
        let code = status.and_then(|status| status.code());
        let how = if let Some(condition) = self.hung.remove(&role) {
            format!("made no progress and was killed ({condition})")
        } else {
            status.map_or_else(String::new, Child::end_in_words)
        };
        if !self.struck.remove(&(role, child.epoch)) {
            self.unasked.push(format!("{role} {how}"));
        }
        let peak = self.memory_peaks.entry(role).or_default();
        *peak = (*peak).max(child.memory_peak_bytes());
        self.joining.retain(|joining| joining.role != role);
        let log = child.log_tail(8);
        let wait = self
            .restart_after(collector, role, code, how)
            .map_err(|how| Ending::Died {
                role,
                how,
                code,
                log,
            })?;
        let cleaning = stack.bury(at);
        // Before that no tick waits for an answer.
        let played = self.prepared.mode == RunMode::Lockstep && stack.was_ready;
        // Then the tick is held until the successor can answer; its absence and its wait are
        // played by the roster, in ticks.
        let tick_ns = u128::from(self.prepared.scenario.run.tick_ns());
        let wait_ticks = u64::try_from(wait.as_nanos().div_ceil(tick_ns)).unwrap_or(u64::MAX);
        let now = Instant::now();
        self.vacant.push(Vacant {
            role,
            due: if played { now } else { now + wait },
            cleaning,
            absent_ticks: played.then(|| self.prepared.scenario.restart.absent_ticks + wait_ticks),
        });
        Ok(())
    }

    /// Starts a successor; it is obeyed when the roster says so. False when the system has no room for
    /// it now: that counts as a restart, and the next one comes after its wait.
    fn join(
        &mut self,
        stack: &mut Stack,
        collector: &Collector,
        vacant: Vacant,
    ) -> Result<bool, Ending> {
        let role = vacant.role;
        stack.next_epoch(role);
        let Err(error) = self.try_start(stack, role) else {
            let pid = stack.children.last().map_or(0, Child::pid);
            self.joining.push(Joining {
                role,
                start: Patience::with(pid),
                ready: false,
                absent_ticks: vacant.absent_ticks,
            });
            return Ok(true);
        };
        let (how, died) = (error.to_string(), |how| Ending::not_started(role, how));
        if !is_short(&error) {
            return Err(died(how));
        }
        // The next run may find room.
        (self.unasked).push(format!("a successor of {role} found no room: {how}"));
        let wait = (self.restart_after(collector, role, None, how)).map_err(died)?;
        self.vacant.push(Vacant {
            due: Instant::now() + wait,
            ..vacant
        });
        Ok(false)
    }

    /// The wait before the next start of a service that has ended like this, which is noted.
    ///
    /// # Errors
    /// The same and why it is not started again.
    fn restart_after(
        &mut self,
        collector: &Collector,
        role: Role,
        code: Option<i32>,
        how: String,
    ) -> Result<Duration, String> {
        let run_ns = collector.robot_tick() * self.prepared.scenario.run.tick_ns();
        let spec = &self.prepared.scenario.restart;
        let wait = match self.restarts.decide(spec, role, code, run_ns) {
            Decision::Restart(wait) => wait,
            Decision::GiveUp(why) => return Err(format!("{how}; {why}")),
        };
        tracing::warn!(%role, how, ?wait, "restarting");
        self.records.push(Restart {
            service: role.to_string(),
            time_s: seconds(run_ns),
            how,
            wait_ms: u64::try_from(wait.as_millis()).unwrap_or(u64::MAX),
        });
        Ok(wait)
    }
}
