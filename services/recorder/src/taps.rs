//! The topics of a stack as they are read: every message once, with what its header says.

use crate::accepted::{Check, accepted};
use crate::native::NativeTopic;
use crate::user_taps::{FoundTopic, UserTopics};
use crate::verdict::Tally;
use std::collections::VecDeque;
use zeronav_msgs::header::Header;
use zeronav_msgs::topics::{
    DebugRollouts, MapKeyframe, RobotOdometry, RunClockTopic, RunControlTopic, Topic, TopicRow,
    TopicVisitor, visit_topics,
};
use zeronav_msgs::user::UserTopic;
use zeronav_shell::{Peer, RawReader, StartError};

/// A message as it was read.
#[derive(Debug)]
pub(crate) struct Message {
    /// Place of its topic in [`Taps::rows`].
    pub topic: usize,
    /// Its header, if the message is accepted; `None` for a record, too.
    pub header: Option<Header>,
    /// Header and fixed fields, then items.
    pub bytes: Vec<u8>,
    /// How many bytes the first part has.
    pub envelope_bytes: usize,
}

#[derive(Debug)]
struct Tap {
    row: &'static TopicRow,
    reader: RawReader,
    /// `None` for a topic of records.
    check: Option<Check>,
    /// True of a user's own, which several programs may write that call themselves the same.
    is_users: bool,
    tally: Tally,
}

/// Every topic.
#[derive(Debug)]
pub(crate) struct Taps {
    /// Newest tick of the robot that was read before everything else of it.
    tick: u64,
    all: Vec<Tap>,
    /// The order in which they are read: who is obeyed first.
    order: Vec<usize>,
    users: UserTopics,
}

impl Taps {
    /// Opens every topic, `debug/rollouts` only when asked: the local planner makes them only while they
    /// are read.
    pub(crate) fn open(peer: &Peer, rollouts: bool) -> Result<Self, StartError> {
        let mut opener = Opener {
            peer,
            rollouts,
            all: Vec::new(),
        };
        visit_topics(&mut opener)?;
        let all = opener.all;
        let rank = |at: &usize| {
            let number = all[*at].row.number;
            let first = [
                RunControlTopic::ROW.number,
                RunClockTopic::ROW.number,
                // Few places are there for keyframes: they are given back soon.
                MapKeyframe::ROW.number,
                RobotOdometry::ROW.number,
            ];
            let place = first.iter().position(|it| *it == number);
            (place.unwrap_or(first.len()), *at)
        };
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by_key(rank);
        Ok(Self {
            tick: 0,
            all,
            order,
            users: UserTopics::new(),
        })
    }

    /// The topics, in the order of the contract's table.
    pub(crate) fn rows(&self) -> Vec<&'static TopicRow> {
        self.all.iter().map(|tap| tap.row).collect()
    }

    /// Opens the topics of users that were made since the last time; they come behind all others, in this order.
    pub(crate) fn open_users(&mut self, peer: &Peer) -> Vec<NativeTopic> {
        let found = self.users.look(peer);
        let opened = found.into_iter().map(|FoundTopic { row, form, reader }| {
            self.order.push(self.all.len());
            self.all.push(Tap {
                row,
                reader,
                check: Some(accepted::<UserTopic>),
                is_users: true,
                tally: Tally::default(),
            });
            NativeTopic::of_user(row, &form)
        });
        opened.collect()
    }

    /// Takes what has come, at most as much of a topic as its queue holds; how many messages.
    pub(crate) fn drain(&mut self, to: &mut VecDeque<Message>) -> usize {
        let before = to.len();
        for topic in self.order.iter().copied() {
            let Tap {
                row,
                reader,
                check,
                is_users,
                tally,
            } = &mut self.all[topic];
            let check = *check;
            for _ in 0..row.buffer() {
                let message = reader.take(|envelope, items| {
                    let header = check.and_then(|check| check(row, envelope, items));
                    Message {
                        topic,
                        header,
                        bytes: [envelope, items].concat(),
                        envelope_bytes: envelope.len(),
                    }
                });
                let Some(message) = message else { break };
                match (&message.header, check) {
                    (Some(header), _) if *is_users => tally.see_of_any(header.id()),
                    (Some(header), _) => {
                        tally.see(header.id());
                        if row.number == RobotOdometry::ROW.number {
                            self.tick = self.tick.max(header.tick);
                        }
                    }
                    (None, Some(_)) => tally.reject(),
                    (None, None) => tally.see_record(),
                }
                to.push_back(message);
            }
        }
        to.len() - before
    }

    /// Tick before which everything was read, in lockstep: the robot begins one when all have answered
    /// the one before, and is read before the others.
    pub(crate) fn tick(&self) -> u64 {
        self.tick
    }

    /// A topic that could not be read.
    pub(crate) fn problem(&self) -> Option<&str> {
        self.users.problem.as_deref()
    }

    /// What was read of each topic.
    pub(crate) fn tallies(&self) -> impl Iterator<Item = (&'static TopicRow, &Tally)> {
        self.all.iter().map(|tap| (tap.row, &tap.tally))
    }
}

struct Opener<'a> {
    peer: &'a Peer,
    rollouts: bool,
    all: Vec<Tap>,
}

impl TopicVisitor for Opener<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        if row.number == DebugRollouts::ROW.number && !self.rollouts {
            return Ok(());
        }
        self.all.push(Tap {
            row,
            reader: self.peer.raw_on::<T>(row)?,
            check: Some(accepted::<T>),
            is_users: false,
            tally: Tally::default(),
        });
        Ok(())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        self.all.push(Tap {
            row,
            reader: self.peer.raw_spans()?,
            check: None,
            is_users: false,
            tally: Tally::default(),
        });
        Ok(())
    }
}
