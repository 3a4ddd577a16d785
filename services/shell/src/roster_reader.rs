//! Reads which processes are obeyed and how the run keeps time.

use crate::error::StartError;
use crate::peer::Peer;
use crate::reader::Latest;
use crate::roster::Roster;
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{RunClockTopic, RunControlTopic};

/// How long launch may take to publish which processes are obeyed: on a busy machine it may get no
/// processor for seconds, which must not decide how a lockstep run goes on.
const KNOWN_LIMIT: Duration = Duration::from_secs(60);

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
        self.known_within(KNOWN_LIMIT)
    }

    /// [`Self::await_known`], which gives up after `limit`.
    fn known_within(&mut self, limit: Duration) -> Result<(), StartError> {
        let started = Instant::now();
        while !self.roster.is_known() {
            if started.elapsed() > limit {
                return Err(StartError::system(
                    "reading run/control",
                    "no message from launch",
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Stage, TICK_NS, Words};
    use zeronav_msgs::run::{RunControl, RunMode};

    fn words() -> Words {
        Words::of(RunMode::Lockstep, &[(Role::Mapping, 3)])
    }

    #[test]
    fn it_says_what_launch_said_last_and_to_whom() {
        let mut stage = Stage::new(words());
        let mapping = stage.join(Role::Mapping, 3);
        let mut reader = RosterReader::open(&mapping).expect("a reader");
        assert!(!reader.roster().is_known());
        assert_eq!(reader.roster().own, Some((Role::Mapping, 3)));
        stage.say(Words {
            control: RunControl {
                lease: 7,
                ..RunControl::default()
            },
            ..Words::of(RunMode::Lockstep, &[(Role::Mapping, 3), (Role::Robot, 2)])
        });
        reader.poll();
        let roster = reader.roster();
        assert!(roster.is_known() && roster.lockstep());
        assert_eq!((roster.clock.tick_ns, roster.control.lease), (TICK_NS, 7));
        assert_eq!(roster.seats, stage.words().seats);
        stage.say(words());
        reader.poll();
        assert_eq!(reader.roster().seats, words().seats, "a seat is gone");
    }

    #[test]
    fn what_comes_in_has_the_moment_of_the_wake() {
        let mut stage = Stage::new(words());
        let mapping = stage.join(Role::Mapping, 3);
        let mut reader = RosterReader::open(&mapping).expect("a reader");
        stage.say(words());
        reader.woken(1234);
        assert_eq!(reader.roster().woken_ns, 1234);
        assert!(reader.roster().is_known());
    }

    #[test]
    fn once_it_comes_to_rest_no_word_of_launch_sets_the_robot_moving() {
        let mut stage = Stage::new(words());
        let robot = stage.join(Role::Robot, 1);
        let mut reader = RosterReader::open(&robot).expect("a reader");
        let paused = RunControl {
            paused: 1,
            ..RunControl::default()
        };
        let say = |stage: &mut Stage| {
            stage.say(Words {
                control: paused,
                ..words()
            });
        };
        let stops = |reader: &RosterReader| {
            let control = &reader.roster().control;
            (control.stopping, control.paused)
        };
        say(&mut stage);
        reader.poll();
        assert_eq!(stops(&reader), (0, 1));
        reader.come_to_rest();
        assert_eq!(stops(&reader), (1, 0));
        say(&mut stage);
        reader.poll();
        assert_eq!(stops(&reader), (1, 0));
    }

    #[test]
    fn a_launch_that_says_nothing_is_named_after_the_limit() {
        let stage = Stage::new(words());
        let mapping = stage.join(Role::Mapping, 3);
        let mut reader = RosterReader::open(&mapping).expect("a reader");
        let limit = Duration::from_millis(20);
        let began = Instant::now();
        let error = reader.known_within(limit).expect_err("nothing was said");
        assert!(began.elapsed() >= limit, "it did not wait");
        assert!(
            error.to_string().contains("no message from launch"),
            "{error}"
        );
    }

    #[test]
    fn it_waits_until_launch_has_said_who_is_obeyed() {
        let stage = Stage::new(words());
        let mapping = stage.join(Role::Mapping, 3);
        let mut reader = RosterReader::open(&mapping).expect("a reader");
        stage
            .while_launch_wakes(|| reader.await_known())
            .expect("launch speaks");
        assert_eq!(reader.roster().seats, words().seats);
        reader
            .known_within(Duration::ZERO)
            .expect("what is known is not waited for");
    }

    #[test]
    fn another_epoch_or_seat_than_launch_expects_is_refused_by_name() {
        let stage = Stage::new(words());
        let mapping = stage.join(Role::Mapping, 3);
        let mut reader = RosterReader::open(&mapping).expect("a reader");
        let mut expects = |role, epoch| stage.while_launch_wakes(|| reader.expects(role, epoch));
        expects(Role::Mapping, 3).expect("it is obeyed");
        for (role, epoch, problem) in [
            (
                Role::Mapping,
                2,
                "--epoch 2: the seat of mapping expects --epoch 3",
            ),
            (Role::Robot, 3, "this run has no seat for robot"),
        ] {
            let error = expects(role, epoch).expect_err(problem);
            assert!(matches!(error, StartError::Usage(_)), "{error}");
            assert!(error.to_string().starts_with(problem), "{error}");
        }
    }
}
