//! A private domain in which the kit is launch and every seat but one, and the program in that seat.

use super::others::{Others, TASK_GOAL};
use super::program::{Program, last_line};
use super::raw::{RawPeer, RawReader, Received};
use super::robot::TICK_NS;
use rustix::process::Signal;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitStatus;
use std::time::{Duration, Instant};
use zeronav_files::Folder;
use zeronav_msgs::health::{Health, HealthState};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};
use zeronav_msgs::seats::{SEATS, SeatRow};
use zeronav_msgs::span::Span;
use zeronav_msgs::task::{Task, TaskKind};
use zeronav_msgs::topics::{
    HealthTopic, RunClockTopic, RunControlTopic, TaskGoal, Topic, TopicRow, TopicVisitor,
    health_of, visit_topics,
};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Bells;
use zeronav_shell::peer::Topics;
use zeronav_shell::records::SpanReader;
use zeronav_shell::seat::SeatLock;
use zeronav_shell::{Domain, Draft, Peer, StartError, Writer};
use zeronav_supervise::child::Start;
use zeronav_supervise::child_log::LogPlace;
use zeronav_supervise::{Child, descendants, warden};

/// Epoch of the program in the tested seat: not 1, so that it has to be read from the flags.
pub(crate) const EPOCH: u32 = 3;

/// Epoch of the other seats.
pub(crate) const OTHERS_EPOCH: u32 = 2;

/// How long the program may take to be ready.
pub(crate) const READY_LIMIT: Duration = Duration::from_secs(15);

const PAUSE: Duration = Duration::from_micros(200);

/// Launch's side.
struct Launch {
    clock: Writer<RunClockTopic>,
    control: Writer<RunControlTopic>,
    goals: Writer<TaskGoal>,
    bells: Bells,
    seat: Option<SeatLock>,
    _topics: Topics,
    peer: Peer,
}

/// The domain of one test.
pub(crate) struct Bench {
    /// The program in the seat.
    pub program: Program,
    /// Its process.
    pub child: Option<Child>,
    /// Everything that the program sent and that was not taken yet.
    pub seen: Vec<Received>,
    /// Every record of the seat that was not taken yet.
    pub records: Vec<Span>,
    /// Its heartbeats: when they were sent, and what they said. [ns]
    pub beats: Vec<(u64, Health)>,
    /// The other seats.
    pub others: Others,
    /// Membership for ports that check nothing.
    pub raw: RawPeer,
    /// Root folder of the domain.
    pub root: PathBuf,
    /// `None` once launch is gone.
    launch: Option<Launch>,
    readers: Vec<RawReader>,
    health: RawReader,
    spans: SpanReader,
    _guest: Peer,
}

/// The row of a seat.
pub(crate) fn seat_row(role: Role) -> &'static SeatRow {
    let found = SEATS.iter().find(|seat| seat.role == role);
    found.unwrap_or(&SEATS[0])
}

struct Opener<'a> {
    raw: &'a RawPeer,
    role: Role,
    readers: Vec<RawReader>,
}

impl TopicVisitor for Opener<'_> {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        let is_written = seat_row(self.role).writes();
        if is_written.iter().any(|written| written.name == row.name) {
            self.readers.push(self.raw.reader::<T>(row)?);
        }
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), String> {
        Ok(())
    }
}

impl Bench {
    /// Makes the domain; the topic called `foreign` is of another contract.
    ///
    /// # Errors
    /// What the middleware or the system says.
    pub(crate) fn make(program: &Program, mode: RunMode, foreign: &str) -> Result<Self, String> {
        let text = |error: StartError| error.to_string();
        let role = program.role;
        let peer = Domain::create().and_then(|domain| Peer::join(domain, Role::Launch, 1));
        let peer = peer.map_err(text)?;
        let root = peer.domain().root().to_owned();
        warden::watch_domain(&root);
        let topics = peer.create_topics_but(foreign).map_err(text)?;
        let raw = RawPeer::join(Domain::join(&root).map_err(text)?)?;
        let mut opener = Opener {
            raw: &raw,
            role,
            readers: Vec::new(),
        };
        let is_foreign = !foreign.is_empty();
        if !is_foreign {
            visit_topics(&mut opener)?;
        }
        let readers = opener.readers;
        let row = health_of(role).ok_or("a seat without a heartbeat")?;
        let health = raw.reader::<HealthTopic>(row)?;
        let guest = Domain::join(&root).and_then(|domain| Peer::join(domain, Role::Tap, 1));
        let guest = guest.map_err(text)?;
        let lockstep = mode == RunMode::Lockstep;
        let others = Others::open(&root, role, OTHERS_EPOCH, lockstep).map_err(text)?;
        let spans = guest.span_reader().map_err(text)?;
        let launch = Launch::open(peer, topics, role).map_err(text)?;
        let mut bench = Self {
            program: program.clone(),
            child: None,
            seen: Vec::new(),
            records: Vec::new(),
            beats: Vec::new(),
            others,
            raw,
            root,
            launch: Some(launch),
            readers,
            health,
            spans,
            _guest: guest,
        };
        bench.announce(mode);
        bench.others.introduce();
        Ok(bench)
    }

    /// Says how time runs and who is obeyed.
    fn announce(&mut self, mode: RunMode) {
        let Some(launch) = &mut self.launch else {
            return;
        };
        let clock = RunClock {
            mode: mode.code(),
            seed: 1,
            zero_ns: now_ns(),
            tick_ns: TICK_NS,
            ..RunClock::default()
        };
        launch.clock.publish(&Draft::default(), clock, &[]);
        let seats = Role::SERVICES.map(|role| Seat {
            role: role.code(),
            epoch: if role == self.program.role {
                EPOCH
            } else {
                OTHERS_EPOCH
            },
            ..Seat::default()
        });
        let control = RunControl {
            lease: u64::from(u32::MAX),
            n_seats: u32::try_from(seats.len()).unwrap_or(0),
            ..RunControl::default()
        };
        launch.control.publish(&Draft::default(), control, &seats);
    }

    /// Flags of a service of this domain.
    pub(crate) fn flags(&self, epoch: u32) -> Vec<OsString> {
        vec![
            "--domain".into(),
            self.root.clone().into(),
            "--epoch".into(),
            epoch.to_string().into(),
            "--config".into(),
            self.program.config.clone().into(),
            "--log-level".into(),
            "warn".into(),
        ]
    }

    /// Starts the program in its seat, as launch does.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn start(&mut self) -> Result<(), String> {
        let seat = self.launch.as_ref().and_then(|launch| launch.seat.as_ref());
        let seat = seat.ok_or("the seat is not held")?;
        let stdin = seat.for_child().map_err(|error| error.to_string())?;
        let arguments = self.program.with(&self.flags(EPOCH));
        let folder = Folder::open(&self.program.folder).map_err(|error| error.to_string())?;
        let log = LogPlace::new(&folder, "program.log");
        let start = Start {
            binary: &self.program.binary,
            arguments: &arguments,
            root: &self.root,
            log: &log,
            scheduling: None,
        };
        let child = Child::start(self.program.role, EPOCH, stdin, &start);
        self.child = Some(child.map_err(|error| error.to_string())?);
        Ok(())
    }

    /// Lets go of the seat, so that a program to which it was not given can take it.
    pub(crate) fn free_seat(&mut self) {
        if let Some(launch) = &mut self.launch {
            launch.seat = None;
        }
    }

    /// Takes in what has come from the program.
    pub(crate) fn poll(&mut self) {
        // First: what a record names was sent before it, and so is seen when its record is.
        let role = self.program.role.code();
        while let Some(span) = self.spans.take() {
            if span.role == role {
                self.records.push(span);
            }
        }
        for reader in &mut self.readers {
            reader(&mut self.seen);
        }
        let mut beats = Vec::new();
        (self.health)(&mut beats);
        self.beats.extend(beats.iter().filter_map(|beat| {
            // Its row has another name than that of the type.
            let whole = beat.refusal.is_none() && beat.meta.len() == size_of::<Health>();
            let health = whole.then(|| bytemuck::pod_read_unaligned(&beat.meta))?;
            Some((beat.header.stamps.published_ns, health))
        }));
    }

    /// Polls until `done` or `limit`; true when it was done.
    pub(crate) fn wait(
        &mut self,
        limit: Duration,
        mut done: impl FnMut(&mut Self) -> bool,
    ) -> bool {
        let started = Instant::now();
        loop {
            self.poll();
            if done(self) {
                return true;
            }
            if started.elapsed() > limit || self.ended().is_some() {
                self.poll();
                return done(self);
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// Waits until the program says that it can answer.
    ///
    /// # Errors
    /// That it does not, and what it said.
    pub(crate) fn await_ready(&mut self) -> Result<(), String> {
        let ready = self.wait(READY_LIMIT, |bench| {
            bench.refresh();
            bench.beats.last().is_some_and(|(_, beat)| {
                matches!(
                    beat.state(),
                    Some(HealthState::Ready | HealthState::Degraded)
                )
            })
        });
        if ready {
            return Ok(());
        }
        let words = self.last_words();
        Err(match self.ended() {
            Some(status) => format!("it ended ({status}) before it was ready: {words}"),
            None => format!(
                "its heartbeat did not say `ready` within {} s: {words}",
                READY_LIMIT.as_secs()
            ),
        })
    }

    /// Brings latched messages to the program.
    pub(crate) fn refresh(&self) {
        if let Some(launch) = &self.launch {
            launch.clock.refresh();
            launch.control.refresh();
            launch.goals.refresh();
        }
        self.others.refresh();
    }

    /// Sends the goal, which holds from this tick on.
    pub(crate) fn send_goal(&mut self, from_tick: u64) {
        let role = self.program.role;
        let Some(launch) = &mut self.launch else {
            return;
        };
        let task = Task {
            kind: TaskKind::Go.code(),
            n_goals: 1,
            from_tick,
            ..Task::default()
        };
        launch.goals.publish(&Draft::default(), task, &[TASK_GOAL]);
        launch.bells.ring(role, TaskGoal::ROW.number);
    }

    /// Launch is gone: its locks and its ports.
    pub(crate) fn leave_launch(&mut self) {
        self.launch = None;
    }

    /// How the program ended, once it has.
    pub(crate) fn ended(&mut self) -> Option<ExitStatus> {
        self.child.as_mut().and_then(Child::ended)
    }

    /// Sends it a signal.
    pub(crate) fn signal(&mut self, signal: Signal) {
        if let Some(child) = &mut self.child {
            child.signal(signal);
        }
    }

    /// The last line of its log.
    pub(crate) fn last_words(&self) -> String {
        const LINES: usize = 20;
        let text = self.child.as_ref().map(|child| child.log_tail(LINES));
        last_line(&text.unwrap_or_default().join("\n")).to_owned()
    }

    /// Ends the program and removes the domain.
    pub(crate) fn close(self) {
        let root = self.root.clone();
        drop(self);
        descendants::end(&root);
        if let Err(error) = zeronav_shell::domain::sweep(&root) {
            tracing::warn!(root = %root.display(), %error, "the domain could not be removed");
        }
    }

    /// Readers and writers of every topic now: name, writers, readers.
    ///
    /// # Errors
    /// What the middleware says.
    pub(crate) fn ports(&self) -> Result<Vec<(&'static TopicRow, [usize; 2])>, String> {
        let launch = self.launch.as_ref().ok_or("launch is gone")?;
        let mut counter = Counter {
            peer: &launch.peer,
            ports: Vec::new(),
        };
        visit_topics(&mut counter).map_err(|error: StartError| error.to_string())?;
        Ok(counter.ports)
    }
}

impl Launch {
    fn open(peer: Peer, topics: Topics, role: Role) -> Result<Self, StartError> {
        Ok(Self {
            clock: peer.writer(1)?,
            control: peer.writer(zeronav_msgs::run::SEATS_MAX)?,
            goals: peer.writer(1)?,
            bells: Bells::open(&peer)?,
            seat: Some(SeatLock::take_free(peer.domain(), role)?),
            _topics: topics,
            peer,
        })
    }
}

struct Counter<'a> {
    peer: &'a Peer,
    ports: Vec<(&'static TopicRow, [usize; 2])>,
}

impl TopicVisitor for Counter<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        self.ports.push((row, self.peer.ports::<T>(row)?));
        Ok(())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        self.ports.push((row, self.peer.span_ports()?));
        Ok(())
    }
}
