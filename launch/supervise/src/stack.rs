//! A running stack: the domain, its topics, launch's own ports, and the processes.

mod pair;
mod sent;
mod shutdown;

pub use shutdown::close;

use super::child::{Child, Start};
use super::child_log::LogPlace;
use super::cleaner::{Cleaner, Ticket};
use super::occupant::Occupant;
use super::own_time::{Doing, Reading};
use super::taps::Taps;
use super::warden;
use crate::shared_memory;
use rustix::process::Signal;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ffi::OsString;
use std::path::Path;
use zeronav_msgs::health::{HealthState, REASON_ZONES};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, Seat, TOPIC_FAULTS_MAX, TopicFault};
use zeronav_msgs::topics::{
    EVENT_NEED_KEYFRAME, RunClockTopic, RunControlTopic, SimPlacement, TaskGoal, TaskPose,
    TaskZones, TopicRow,
};
use zeronav_scenario::scheduling::SchedulingSpec;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Bells;
use zeronav_shell::folder::Folder;
use zeronav_shell::peer::Topics;
use zeronav_shell::seat::SeatLock;
use zeronav_shell::{Domain, Draft, Peer, Roster, StartError, Writer};

/// Launch's own epoch: it is started once per domain.
const LAUNCH_EPOCH: u32 = 1;

/// Epoch of the first process in each seat.
const FIRST_EPOCH: u32 = 1;

/// How the process of a seat is started.
#[derive(Debug, Clone, Copy)]
pub struct Launch<'a> {
    /// Its binary.
    pub binary: &'a Path,
    /// Its configuration file.
    pub config: &'a Path,
    /// What it logs.
    pub log_level: &'a str,
    /// Where its log goes.
    pub log: &'a LogPlace,
}

/// A running stack. Dropping it ends the processes and removes the domain.
#[derive(Debug)]
pub struct Stack {
    /// The processes, one per seat that launch fills.
    pub children: Vec<Child>,
    /// A second process in one of the seats: a newcomer, or a predecessor that is still warm.
    pub beside: Option<Child>,
    /// How the processes of a seat are scheduled, where the scenario says so.
    pub scheduling: BTreeMap<Role, SchedulingSpec>,
    /// Every service could answer once: from then on the robot may tick.
    pub was_ready: bool,
    /// Some of its processes are on another host, where this one does not see what they do.
    pub is_shared: bool,
    /// What launch reads.
    pub taps: Taps,
    /// The seats that launch fills, held for the whole run.
    seats: BTreeMap<Role, SeatLock>,
    /// The process in each seat that has beaten its heart and is the newest there.
    pub occupants: BTreeMap<Role, Occupant>,
    /// Who is obeyed and how time runs, as launch has said it.
    pub roster: Roster,
    /// The newest process of each seat, obeyed or not yet.
    newest: Roster,
    /// Highest epoch of each seat so far.
    last_epochs: BTreeMap<Role, u32>,
    clock: Writer<RunClockTopic>,
    control: Writer<RunControlTopic>,
    goals: Writer<TaskGoal>,
    poses: Writer<TaskPose>,
    placements: Writer<SimPlacement>,
    /// Opened with the first zone: without one they take no memory.
    zones: Option<Writer<TaskZones>>,
    bells: Bells,
    cleaner: Cleaner,
    topics: Option<Topics>,
    peer: Option<Peer>,
}

impl Stack {
    /// Makes a domain with every topic, and says how time runs, from now on, and who will be obeyed.
    ///
    /// # Errors
    /// What the middleware or the system refuses.
    pub fn create(clock: RunClock) -> Result<Self, StartError> {
        let peer = Peer::join(Domain::create()?, Role::Launch, LAUNCH_EPOCH)?;
        warden::watch_domain(peer.domain().root());
        let topics = peer.create_topics()?;
        let taps = Taps::open(&peer)?;
        let seats = Role::SERVICES
            .iter()
            .map(|role| Seat {
                role: role.code(),
                epoch: FIRST_EPOCH,
                ..Seat::default()
            })
            .collect::<Vec<_>>();
        let roster = Roster {
            clock: RunClock {
                zero_ns: now_ns(),
                ..clock
            },
            control: RunControl {
                n_seats: u32::try_from(seats.len()).unwrap_or(0),
                ..RunControl::default()
            },
            seats,
            own: None,
            woken_ns: 0,
        };
        let mut stack = Self {
            children: Vec::new(),
            beside: None,
            scheduling: BTreeMap::new(),
            was_ready: false,
            is_shared: false,
            taps,
            last_epochs: BTreeMap::new(),
            seats: BTreeMap::new(),
            occupants: BTreeMap::new(),
            newest: roster.clone(),
            roster,
            clock: peer.writer(1)?,
            control: peer.writer(zeronav_msgs::run::SEATS_MAX)?,
            goals: peer.writer(zeronav_msgs::task::GOALS_MAX)?,
            poses: peer.writer(1)?,
            placements: peer.writer(zeronav_msgs::truth::TRUTH_OBSTACLES_MAX)?,
            zones: None,
            bells: Bells::open(&peer)?,
            cleaner: Cleaner::new(peer.domain().root()),
            topics: Some(topics),
            peer: Some(peer),
        };
        let clock = stack.roster.clock;
        stack.clock.publish(&Draft::default(), clock, &[]);
        stack.publish_control();
        Ok(stack)
    }

    /// Sends a signal to the process of a seat; false when there is none.
    pub fn signal(&mut self, role: Role, signal: Signal) -> bool {
        let mut alive = false;
        for child in self.children.iter_mut().filter(|child| child.role == role) {
            alive |= child.ended().is_none();
            child.signal(signal);
        }
        alive
    }

    /// Root folder of the domain.
    #[must_use]
    pub fn root(&self) -> &Path {
        self.peer
            .as_ref()
            .map_or(Path::new("/"), |peer| peer.domain().root())
    }

    /// Holds the seat of `role` for the whole run, so that no process but those that are started
    /// here sits in it.
    ///
    /// # Errors
    /// One line with the process that sits there already.
    pub fn hold_seat(&mut self, role: Role) -> Result<&SeatLock, StartError> {
        let Some(peer) = &self.peer else {
            return Err(StartError::Usage("the stack is closed".to_owned()));
        };
        Ok(match self.seats.entry(role) {
            Entry::Occupied(seat) => seat.into_mut(),
            Entry::Vacant(seat) => seat.insert(SeatLock::take_free(peer.domain(), role)?),
        })
    }

    /// Starts the newest process of a seat.
    ///
    /// # Errors
    /// One line naming the binary.
    pub fn start(&mut self, role: Role, launch: &Launch<'_>) -> std::io::Result<()> {
        let child = self.start_as(role, self.epoch(role), launch)?;
        self.name_owner(role, child.pid());
        self.children.push(child);
        Ok(())
    }

    fn start_as(&mut self, role: Role, epoch: u32, launch: &Launch<'_>) -> std::io::Result<Child> {
        let arguments: Vec<OsString> = [
            "--domain".into(),
            self.root().into(),
            "--epoch".into(),
            epoch.to_string().into(),
            "--config".into(),
            launch.config.into(),
            "--log-level".into(),
            launch.log_level.into(),
        ]
        .into();
        let seat = self.hold_seat(role).map_err(std::io::Error::other)?;
        let stdin = seat.for_child()?;
        let start = Start {
            binary: launch.binary,
            arguments: &arguments,
            root: self.root(),
            log: launch.log,
            scheduling: self.scheduling.get(&role),
        };
        Child::start(role, epoch, stdin, &start)
    }

    /// Says in the seat of `role` who sits there, for a process that comes second.
    fn name_owner(&self, role: Role, pid: u32) {
        if let Some(Err(error)) = self.seats.get(&role).map(|seat| seat.name_owner(pid)) {
            tracing::warn!(%role, %error, "the owner of the seat could not be written");
        }
    }

    /// Epoch of the newest process in the seat of `role`.
    #[must_use]
    pub fn epoch(&self, role: Role) -> u32 {
        self.newest
            .seat(role)
            .map_or(FIRST_EPOCH, |seat| seat.epoch)
    }

    /// Takes an ended process out, and has removed what it left in the middleware's registry.
    pub fn bury(&mut self, at: usize) -> Ticket {
        let child = self.children.remove(at);
        self.name_owner(child.role, std::process::id());
        drop(child);
        self.cleaner.ask()
    }

    /// Has removed what a guest that has died left in the middleware's registry.
    pub fn clean(&mut self) -> Ticket {
        self.cleaner.ask()
    }

    /// True once that cleaning has ended.
    pub fn is_clean(&mut self, ticket: Ticket) -> bool {
        self.cleaner.is_done(ticket)
    }

    /// The domain's root folder as it was opened.
    #[must_use]
    pub fn folder(&self) -> Option<&Folder> {
        self.peer.as_ref().map(|peer| peer.domain().folder())
    }

    /// True once files of the domain were deleted while it ran.
    #[must_use]
    pub fn is_deleted(&self) -> bool {
        let peer = self.peer.as_ref();
        peer.is_some_and(|peer| peer.domain().is_deleted())
    }

    /// Makes the next process started in the seat of `role` a successor. It is not obeyed yet.
    pub fn next_epoch(&mut self, role: Role) {
        let epoch = self.new_epoch(role);
        if let Some(seat) = seat_mut(&mut self.newest, role) {
            seat.epoch = epoch;
        }
    }

    /// An epoch that no process of the seat has had.
    fn new_epoch(&mut self, role: Role) -> u32 {
        let last = self.last_epochs.entry(role).or_insert(FIRST_EPOCH);
        *last += 1;
        *last
    }

    /// Lets the newest process be obeyed in the seat of `role`. In lockstep the seat is empty from
    /// `off_tick` to before `on_tick`.
    pub fn obey_newest(&mut self, role: Role, off_tick: u64, on_tick: u64) {
        let epoch = self.epoch(role);
        if let Some(seat) = seat_mut(&mut self.roster, role) {
            seat.epoch = epoch;
            (seat.off_tick, seat.on_tick, seat.hear_tick) = (off_tick, on_tick, on_tick);
        }
        self.publish_control();
    }

    /// Says something else of the seat of `role`, when that is news: for a stack whose other seats are played.
    pub fn announce(&mut self, role: Role, change: impl FnOnce(&mut Seat)) {
        let Some(seat) = seat_mut(&mut self.roster, role) else {
            return;
        };
        let before = *seat;
        change(seat);
        if *seat != before {
            self.publish_control();
        }
    }

    /// Epoch and progress counter of the newest process of every seat that has beaten its heart,
    /// and whether it can answer.
    pub fn heartbeats(&mut self) -> Vec<(Role, u32, u64, bool)> {
        let (newest, occupants) = (&self.newest, &mut self.occupants);
        self.taps
            .health
            .iter_mut()
            .filter_map(|(role, health)| {
                health.poll(newest);
                let view = health.get().filter(|view| newest.hears(view.header))?;
                let (epoch, pid) = (view.header.id().epoch(), view.meta.pid);
                let known = occupants.get(role).map(|known| (known.epoch, known.pid));
                if known != Some((epoch, pid)) {
                    occupants.insert(*role, Occupant::of(epoch, pid));
                }
                let state = view.meta.state();
                let ready = matches!(state, Some(HealthState::Ready | HealthState::Degraded));
                Some((*role, epoch, view.meta.progress, ready))
            })
            .collect()
    }

    /// True while a process says that the zones that hold have not come to it.
    #[must_use]
    pub fn lacks_zones(&self) -> bool {
        let mut newest = self
            .taps
            .health
            .iter()
            .filter_map(|(_, health)| health.get());
        newest.any(|view| self.newest.hears(view.header) && view.meta.reasons & REASON_ZONES != 0)
    }

    /// What the kernel says of the process that answers in the seat of `role`: the one that was started, or
    /// one that it has started in turn, as a script does.
    pub fn reading(&self, role: Role) -> Option<Reading> {
        let of_role = |child: &&Child| child.role == role;
        let pid = self.children.iter().find(of_role).map(Child::pid);
        let beats = self.occupants.get(&role);
        let beats = beats.filter(|it| pid != Some(it.pid) && it.epoch == self.epoch(role));
        let other = beats.and_then(|it| Reading::of(it.pid));
        let Some(pid) = pid else { return other };
        other
            .filter(|other| other.group == pid)
            .or_else(|| Reading::of(pid))
    }

    /// True when no process of the stack runs, waits for a processor, or is held by a debugger: none of them is about
    /// to answer. Never of one that is shared.
    pub fn is_quiet(&self) -> bool {
        if self.is_shared {
            return false;
        }
        let waits = |reading: Reading| matches!(reading.doing, Doing::Runnable | Doing::Traced);
        let beside = self.beside.as_ref().map(Child::pid);
        let all = Role::SERVICES.iter().filter_map(|role| self.reading(*role));
        !all.chain(beside.and_then(Reading::of)).any(waits)
    }

    /// Seats whose heartbeat does not say yet that they can answer.
    pub fn not_ready(&mut self) -> Vec<Role> {
        let beats = self.heartbeats();
        let ready = |role: &Role| {
            beats
                .iter()
                .any(|(other, _, _, ready)| other == role && *ready)
        };
        Role::SERVICES
            .iter()
            .copied()
            .filter(|role| !ready(role))
            .collect()
    }

    /// The first process that has ended, but for those in the seat `left_out`.
    pub fn dead(&mut self, left_out: Option<Role>) -> Option<usize> {
        self.children
            .iter_mut()
            .position(|child| Some(child.role) != left_out && child.ended().is_some())
    }

    /// Delays every answer of a seat by so many steps of [`zeronav_msgs::run::DELAY_STEP_NS`], and puts
    /// its clocks forward.
    pub fn impede(&mut self, role: Role, delay: u16, clock_offset_ms: i32) {
        let mut is_new = false;
        for roster in [&mut self.roster, &mut self.newest] {
            if let Some(seat) = seat_mut(roster, role) {
                is_new |= (seat.delay, seat.clock_offset_ms) != (delay, clock_offset_ms);
                (seat.delay, seat.clock_offset_ms) = (delay, clock_offset_ms);
            }
        }
        if is_new {
            self.publish_control();
        }
    }

    /// Disturbs these topics, and no others.
    pub fn set_topic_faults(&mut self, faults: [TopicFault; TOPIC_FAULTS_MAX]) {
        if self.roster.control.topic_faults != faults {
            self.roster.control.topic_faults = faults;
            self.publish_control();
        }
    }

    /// Lets the robot go up to `tick`, lockstep only.
    pub fn extend_lease(&mut self, tick: u64) {
        if tick > self.roster.control.lease {
            self.roster.control.lease = tick;
            self.publish_control();
        }
    }

    /// Holds the time of a robot in real time, or lets it go on.
    pub fn pause(&mut self, paused: bool) {
        if self.roster.control.paused != u16::from(paused) {
            self.roster.control.paused = u16::from(paused);
            self.publish_control();
        }
    }

    /// Asks the stack to stop the robot.
    pub fn stop_robot(&mut self) {
        self.roster.control.stopping = 1;
        self.publish_control();
    }

    /// Asks mapping for a keyframe.
    pub fn ask_for_keyframe(&self) {
        self.bells.ring(Role::Mapping, EVENT_NEED_KEYFRAME);
    }

    /// Brings latched topics to readers that joined since.
    pub fn refresh(&self) {
        // Before what names them, and that before what a service begins with.
        if let Some(zones) = &self.zones {
            zones.refresh();
        }
        self.control.refresh();
        self.clock.refresh();
        self.goals.refresh();
        self.poses.refresh();
    }

    /// Rings the readers of a topic.
    fn ring_for(&self, row: &TopicRow) {
        for role in row.rings {
            self.bells.ring(*role, row.number);
        }
    }

    fn publish_control(&mut self) {
        let control = self.roster.control;
        self.control
            .publish(&Draft::default(), control, &self.roster.seats);
        self.ring_for(self.control.row());
    }

    /// Shared memory that the domain has reserved or used. [bytes]
    #[must_use]
    pub fn shared_memory_bytes(&self) -> u64 {
        let peer = self.peer.as_ref();
        peer.map_or(0, |peer| shared_memory::used_bytes(peer.domain()))
    }
}

fn seat_mut(roster: &mut Roster, role: Role) -> Option<&mut Seat> {
    roster
        .seats
        .iter_mut()
        .find(|seat| seat.role == role.code())
}
