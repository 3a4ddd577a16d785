//! Reads which processes are obeyed and how the run keeps time.

use crate::error::StartError;
use crate::peer::Peer;
use crate::reader::Latest;
use crate::roster::Roster;
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{RunClockTopic, RunControlTopic};

/// How long launch may take to publish which processes are obeyed.
const KNOWN_LIMIT: Duration = Duration::from_secs(5);

/// Time between two looks at what launch says.
const KNOWN_PAUSE: Duration = Duration::from_millis(5);

/// Reads `run/clock` and `run/control`.
#[derive(Debug)]
pub struct RosterReader {
    clock: Latest<RunClockTopic>,
    control: Latest<RunControlTopic>,
    roster: Roster,
    /// Launch is gone: the robot stops, whatever `run/control` said last.
    rest: bool,
}

impl RosterReader {
    /// Opens both topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            clock: peer.latest()?,
            control: peer.latest()?,
            roster: Roster {
                own: Some((peer.role(), peer.epoch())),
                ..Roster::default()
            },
            rest: false,
        })
    }

    /// From now on the roster says that the robot shall stop.
    pub(crate) fn come_to_rest(&mut self) {
        self.rest = true;
        self.poll();
    }

    /// Waits until launch has published which processes are obeyed.
    ///
    /// # Errors
    /// [`StartError::System`] when it does not.
    pub fn await_known(&mut self) -> Result<(), StartError> {
        let started = Instant::now();
        while !self.roster.is_known() {
            if started.elapsed() > KNOWN_LIMIT {
                return Err(StartError::system(
                    "reading run/control",
                    "launch says nothing",
                ));
            }
            std::thread::sleep(KNOWN_PAUSE);
            self.poll();
        }
        Ok(())
    }

    /// Makes sure that `epoch` is the one that is obeyed in the seat of `role`, once launch has
    /// published that.
    ///
    /// # Errors
    /// [`StartError::Usage`] naming the epoch that launch expects.
    pub fn expects(&mut self, role: Role, epoch: u32) -> Result<(), StartError> {
        self.await_known()?;
        match self.roster.seat(role) {
            Some(seat) if seat.epoch == epoch => Ok(()),
            Some(seat) => Err(StartError::Usage(format!(
                "--epoch {epoch}: the seat of {role} expects --epoch {}, no other is obeyed",
                seat.epoch
            ))),
            None => Err(StartError::Usage(format!(
                "this run has no seat for {role}"
            ))),
        }
    }

    /// Takes in what has come, after a wake. [ns]
    pub(crate) fn woken(&mut self, woken_ns: u64) {
        self.roster.woken_ns = woken_ns;
        self.poll();
    }

    /// Takes in what has come.
    pub fn poll(&mut self) {
        if self.clock.poll(&self.roster)
            && let Some(clock) = self.clock.get()
        {
            self.roster.clock = *clock.meta;
        }
        if self.control.poll(&self.roster)
            && let Some(control) = self.control.get()
        {
            self.roster.control = *control.meta;
            self.roster.seats.clear();
            self.roster.seats.extend_from_slice(control.items);
        }
        if self.rest {
            (self.roster.control.stopping, self.roster.control.paused) = (1, 0);
        }
    }

    /// What was read last.
    #[must_use]
    pub fn roster(&self) -> &Roster {
        &self.roster
    }
}
