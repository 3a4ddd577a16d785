//! For tests: launch's side of a run, and shells in the seats of it, all in this process.

use crate::domain::{self, Domain};
use crate::error::StartError;
use crate::flags::Flags;
use crate::peer::{Peer, Topics};
use crate::reader::Stream;
use crate::roster::Roster;
use crate::shell::Shell;
use crate::writer::{Draft, Writer};
use clap::Parser;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;
use zeronav_msgs::health::Health;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};
use zeronav_msgs::topics::{HealthTopic, RunClockTopic, RunControlTopic, health_of};

/// Time from tick to tick. [ns]
pub(crate) const TICK_NS: u64 = 20_000_000;

/// What launch says of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Words {
    pub(crate) clock: RunClock,
    pub(crate) control: RunControl,
    pub(crate) seats: Vec<Seat>,
}

impl Words {
    /// A run in `mode` with these roles, each with the epoch that is obeyed.
    pub(crate) fn of(mode: RunMode, seats: &[(Role, u32)]) -> Self {
        let seat = |(role, epoch): &(Role, u32)| Seat {
            role: role.code(),
            epoch: *epoch,
            ..Seat::default()
        };
        Self {
            clock: RunClock {
                mode: mode.code(),
                tick_ns: TICK_NS,
                ..RunClock::default()
            },
            control: RunControl::default(),
            seats: seats.iter().map(seat).collect(),
        }
    }

    /// What a reader that is no service hears by.
    pub(crate) fn roster(&self) -> Roster {
        Roster {
            clock: self.clock,
            control: self.control,
            seats: self.seats.clone(),
            ..Roster::default()
        }
    }
}

/// Launch's voice.
#[derive(Debug)]
struct Voice {
    clock: Writer<RunClockTopic>,
    control: Writer<RunControlTopic>,
}

impl Voice {
    fn of(launch: &Peer) -> Self {
        Self {
            clock: launch.writer(0).expect("a writer"),
            control: launch.writer(16).expect("a writer"),
        }
    }

    fn say(&mut self, words: &Words) {
        let draft = Draft::default();
        let control = RunControl {
            n_seats: u32::try_from(words.seats.len()).expect("a few"),
            ..words.control
        };
        assert!(self.clock.publish(&draft, words.clock, &[]).is_some());
        let sent = self.control.publish(&draft, control, &words.seats);
        assert!(sent.is_some());
    }
}

/// A domain with all topics, and launch. It is removed whatever happens; what joined it is dropped
/// before.
#[derive(Debug)]
pub(crate) struct Stage {
    voice: Option<Voice>,
    topics: Option<Topics>,
    launch: Option<Peer>,
    root: PathBuf,
    words: Words,
    /// The other ends of what wakes the shells on signals.
    signals: Vec<UnixStream>,
}

impl Stage {
    /// A run of which launch has said this.
    pub(crate) fn new(words: Words) -> Self {
        let launch = Peer::join(Domain::create().expect("a domain"), Role::Launch, 2);
        let launch = launch.expect("launch joins");
        let root = launch.domain().root().to_owned();
        let topics = launch.create_topics().expect("topics");
        let mut stage = Self {
            voice: Some(Voice::of(&launch)),
            topics: Some(topics),
            launch: Some(launch),
            root,
            words: Words::default(),
            signals: Vec::new(),
        };
        stage.say(words);
        stage
    }

    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    pub(crate) fn words(&self) -> &Words {
        &self.words
    }

    pub(crate) fn join(&self, role: Role, epoch: u32) -> Peer {
        Peer::join(Domain::join(&self.root).expect("the domain"), role, epoch).expect("a peer")
    }

    /// Launch says something else; the shells that are open read it at their next wake.
    pub(crate) fn say(&mut self, words: Words) {
        self.voice.as_mut().expect("launch").say(&words);
        self.words = words;
    }

    /// Launch ends without a word, as when it is killed.
    pub(crate) fn lose_launch(&mut self) {
        self.voice = None;
        self.topics = None;
        self.launch = None;
    }

    /// The shell of the process that launch obeys in this seat.
    pub(crate) fn open(&mut self, role: Role, epoch: u32) -> Shell {
        let flags = self.flags(&["--epoch", &epoch.to_string()]);
        self.open_with(&flags, role).expect("a shell")
    }

    /// The shell of a process beside it.
    pub(crate) fn open_shadow(&mut self, role: Role) -> Shell {
        let flags = self.flags(&["--shadow"]);
        self.open_with(&flags, role).expect("a shell")
    }

    /// The flags of a service of this run, and `more`.
    pub(crate) fn flags(&self, more: &[&str]) -> Flags {
        let root = self.root.to_str().expect("a path of text");
        let words = ["service", "--domain", root].into_iter();
        Flags::try_parse_from(words.chain(more.iter().copied())).expect("flags")
    }

    /// Opens a shell while launch wakes: that brings what it has said to one that joins late.
    pub(crate) fn open_with(&mut self, flags: &Flags, role: Role) -> Result<Shell, StartError> {
        let (own, other) = UnixStream::pair().expect("a pair");
        own.set_nonblocking(true).expect("a flag");
        self.signals.push(other);
        self.while_launch_wakes(|| Shell::open(flags, role, own))
    }

    /// Does something that waits for launch's words.
    pub(crate) fn while_launch_wakes<R>(&self, done: impl FnOnce() -> R) -> R {
        let (root, words) = (&self.root, &self.words);
        let (until, is_done) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                let domain = Domain::join(root).expect("the domain");
                let launch = Peer::join(domain, Role::Launch, 1).expect("launch joins");
                let mut voice = Voice::of(&launch);
                voice.say(words);
                let pause = Duration::from_millis(1);
                while is_done.recv_timeout(pause) == Err(mpsc::RecvTimeoutError::Timeout) {
                    voice.clock.refresh();
                    voice.control.refresh();
                }
            });
            let result = done();
            drop(until);
            result
        })
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.lose_launch();
        let swept = domain::sweep(&self.root);
        assert!(
            matches!(swept, Ok(true)) || std::thread::panicking(),
            "{} is left: {swept:?}",
            self.root.display()
        );
    }
}

/// Reads the heartbeat of a role.
#[derive(Debug)]
pub(crate) struct Beats {
    stream: Stream<HealthTopic>,
    roster: Roster,
    _tap: Peer,
}

/// A heartbeat, and the moments in its header. [ns]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beat {
    pub(crate) health: Health,
    pub(crate) woken_ns: u64,
    pub(crate) started_ns: u64,
}

impl Beats {
    /// The heartbeat of `role`, from now on.
    pub(crate) fn of(stage: &Stage, role: Role) -> Self {
        let tap = stage.join(Role::Tap, 1);
        let row = health_of(role).expect("a row");
        Self {
            stream: tap.stream_on(row).expect("a reader"),
            roster: stage.words.roster(),
            _tap: tap,
        }
    }

    /// What has come since this was last asked.
    pub(crate) fn take(&mut self) -> Vec<Beat> {
        let mut beats = Vec::new();
        self.stream.drain(&self.roster, |view| {
            beats.push(Beat {
                health: *view.meta,
                woken_ns: view.header.stamps.woken_ns,
                started_ns: view.header.stamps.started_ns,
            });
        });
        beats
    }

    /// The one that has come.
    pub(crate) fn one(&mut self) -> Health {
        let beats = self.take();
        assert_eq!(beats.len(), 1, "{beats:?}");
        beats[0].health
    }
}
