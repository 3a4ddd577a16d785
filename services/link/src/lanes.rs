//! All topics, and whose doorbells their messages ring here.

use crate::lane::{Lane, Parts, Records, WithHeader};
use zeronav_msgs::role::Role;
use zeronav_msgs::seats::SEATS;
use zeronav_msgs::topics::{
    Discipline, RunClockTopic, RunControlTopic, Topic, TopicRow, TopicVisitor, visit_topics,
};
use zeronav_shell::{Peer, StartError};

/// Every topic, in the order of the table.
#[derive(Debug)]
pub struct Lanes {
    all: Vec<Lane>,
    /// What was read and was written a moment too late to be sent, with the numbers of the topics.
    held: Vec<(u64, u8, Parts)>,
    /// Bits of the topics that somebody reads here, or has read.
    read: u64,
}

struct Collect(Vec<Lane>);

impl TopicVisitor for Collect {
    type Error = core::convert::Infallible;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Self::Error> {
        self.0.push(Lane::new(Box::new(WithHeader::<T>::new(row))));
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), Self::Error> {
        self.0.push(Lane::new(Box::new(Records)));
        Ok(())
    }
}

impl Default for Lanes {
    fn default() -> Self {
        let mut collect = Collect(Vec::new());
        let Ok(()) = visit_topics(&mut collect);
        Self {
            all: collect.0,
            held: Vec::new(),
            read: 0,
        }
    }
}

impl Lanes {
    /// Bits of the numbers of the topics that somebody reads here, or has read since the link began.
    pub fn read(&mut self, peer: &Peer) -> u64 {
        let known = self.read;
        let others = self.all.iter().filter(|lane| known & bit(lane.row()) == 0);
        let read = others.filter(|lane| lane.is_read(peer));
        self.read = read.fold(known, |bits, lane| bits | bit(lane.row()));
        self.read
    }

    /// Reads the topics with these bits from now on, besides those that it reads already.
    ///
    /// # Errors
    /// As [`Peer::raw_on`].
    pub fn listen(&mut self, peer: &Peer, bits: u64) -> Result<(), StartError> {
        let wanted = self.all.iter_mut();
        for lane in wanted.filter(|lane| bits & bit(lane.row()) != 0) {
            lane.listen(peer)?;
        }
        Ok(())
    }

    /// Lets what is latched come again: another link listens on the other host, or it has lost something.
    ///
    /// # Errors
    /// As [`Peer::raw_on`].
    pub fn repeat(&mut self, peer: &Peer) -> Result<(), StartError> {
        self.all.iter_mut().try_for_each(|lane| lane.repeat(peer))
    }

    /// What was written here, with the topics' numbers, so that nothing comes before what it was made from: a host that
    /// heard of a tick before the goal, or the command, that was there before it would drive otherwise than this one.
    ///
    /// Records are read first and come last: they say that all messages of an answer are sent. Of the rest, what was
    /// written before `now_ns` is read then, in the order of its stamps. What was written later waits for the next call, since
    /// what it was made from may lie in a topic that was read before.
    pub fn take(&mut self, now_ns: impl FnOnce() -> u64) -> Vec<(u8, Parts)> {
        let (mut records, mut messages) = (Vec::new(), Vec::new());
        let of_records = |lane: &&mut Lane| lane.row().discipline == Discipline::Records;
        for lane in self.all.iter_mut().filter(of_records) {
            let number = number_of(lane.row());
            records.extend(lane.take().into_iter().map(|(_, parts)| (number, parts)));
        }
        let until_ns = now_ns();
        for lane in self.all.iter_mut().filter(|lane| !of_records(lane)) {
            let number = number_of(lane.row());
            let written = lane.take().into_iter();
            messages.extend(written.map(|(ns, parts)| (ns, number, parts)));
        }
        let (mut due, late): (Vec<_>, Vec<_>) =
            (messages.into_iter()).partition(|(written_ns, ..)| *written_ns <= until_ns);
        // What waited for one call is due, whatever its stamp says.
        due.extend(core::mem::replace(&mut self.held, late));
        // Stable: an author's messages of one topic stay in order, those that waited first.
        due.sort_by_key(|(written_ns, ..)| *written_ns);
        due.into_iter()
            .map(|(_, number, parts)| (number, parts))
            .chain(records)
            .collect()
    }

    /// The topic with this number.
    pub fn lane(&mut self, number: u8) -> Option<&mut Lane> {
        let number = usize::from(number);
        self.all.iter_mut().find(|lane| lane.row().number == number)
    }

    /// Brings latched topics to readers that joined since.
    pub fn refresh(&self) {
        self.all.iter().for_each(Lane::refresh);
    }
}

/// Bits of the topics that the seats of `roles` read by the contract: there before any of them says so, unless they open them
/// at need.
#[must_use]
pub fn read_by(roles: &[Role]) -> u64 {
    let seats = SEATS.iter().filter(|seat| roles.contains(&seat.role));
    let rows = seats.flat_map(|seat| {
        let at_need = |row: &&TopicRow| seat.reads_at_need.iter().any(|it| it.name == row.name);
        (seat.reads.iter().copied()).filter(move |row| !at_need(row))
    });
    rows.chain([RunClockTopic::ROW, RunControlTopic::ROW])
        .fold(0, |bits, row| bits | bit(row))
}

/// Whom a message of a topic rings.
pub fn rung(row: &TopicRow, lockstep: bool) -> impl Iterator<Item = Role> {
    let more = if lockstep { row.rings_in_lockstep } else { &[] };
    row.rings.iter().chain(more).copied()
}

fn number_of(row: &TopicRow) -> u8 {
    u8::try_from(row.number).unwrap_or(u8::MAX)
}

fn bit(row: &TopicRow) -> u64 {
    1_u64 << row.number.min(63)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::topics::{ControlRequest, MapUpdate, topics};

    #[test]
    fn every_topic_has_a_lane_and_a_bit_of_its_own() {
        let mut lanes = Lanes::default();
        let rows = topics();
        assert_eq!(lanes.all.len(), rows.len());
        let bits = rows.iter().fold(0_u64, |bits, row| bits | bit(row));
        assert_eq!(bits.count_ones() as usize, rows.len());
        for row in rows {
            let number = u8::try_from(row.number).expect("small");
            let lane = lanes.lane(number).expect("a lane");
            assert_eq!(lane.row().name, row.name);
        }
        assert!(lanes.lane(200).is_none());
    }

    #[test]
    fn seats_read_what_the_contract_says_and_what_launch_says() {
        let guard = read_by(&[Role::CollisionGuard]);
        assert_eq!(guard & bit(RunControlTopic::ROW), bit(RunControlTopic::ROW));
        assert_ne!(guard & bit(ControlRequest::ROW), 0);
        assert_eq!(guard & bit(MapUpdate::ROW), 0, "it has no zones yet");
        assert_ne!(read_by(&[Role::GlobalPlanner]) & bit(MapUpdate::ROW), 0);
    }
}
