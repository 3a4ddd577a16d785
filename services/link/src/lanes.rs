//! All topics, and whose doorbells their messages ring here.

use crate::lane::{Lane, Parts, Records, WithHeader};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{
    DebugRollouts, MapKeyframe, MapUpdate, Topic, TopicRow, TopicVisitor, visit_topics,
};
use zeronav_shell::{Peer, StartError};

/// Every topic in the order of the table, those with large messages last: where the way is narrow, commands come first.
#[derive(Debug)]
pub struct Lanes(Vec<Lane>);

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
        collect.0.sort_by_key(|lane| is_large(lane.row()));
        Self(collect.0)
    }
}

impl Lanes {
    /// Bits of the numbers of the topics that somebody reads here.
    #[must_use]
    pub fn read(&self, peer: &Peer) -> u64 {
        let read = self.0.iter().filter(|lane| lane.is_read(peer));
        read.fold(0, |bits, lane| bits | bit(lane.row()))
    }

    /// Reads the topics with these bits, and no others.
    ///
    /// # Errors
    /// As [`Peer::raw_on`].
    pub fn listen(&mut self, peer: &Peer, bits: u64) -> Result<(), StartError> {
        for lane in &mut self.0 {
            let is_wanted = bits & bit(lane.row()) != 0;
            lane.listen(peer, is_wanted)?;
        }
        Ok(())
    }

    /// Reads nothing until it is told again what to read.
    pub fn restart(&mut self) {
        self.0.iter_mut().for_each(Lane::restart);
    }

    /// Hands what was written here to `send`, while `has_room`; the rest stays in the topics' queues.
    ///
    /// What launch says is read last and sent first: the robot ticks because of it, and a host that heard of a tick
    /// before the goal that holds from it on would drive otherwise than the robot's.
    pub fn take(&mut self, mut has_room: impl FnMut() -> bool, mut send: impl FnMut(u8, Parts)) {
        let mut taken = Vec::new();
        let mut of_launch = Vec::new();
        for is_launch in [false, true] {
            let lanes = self.0.iter_mut();
            for lane in lanes.filter(|lane| is_of_launch(lane.row()) == is_launch) {
                if is_large(lane.row()) && !has_room() {
                    continue;
                }
                let number = u8::try_from(lane.row().number).unwrap_or(u8::MAX);
                let to = if is_launch {
                    &mut of_launch
                } else {
                    &mut taken
                };
                to.extend(lane.take().into_iter().map(|parts| (number, parts)));
            }
        }
        for (number, parts) in of_launch.into_iter().chain(taken) {
            send(number, parts);
        }
    }

    /// The topic with this number.
    pub fn lane(&mut self, number: u8) -> Option<&mut Lane> {
        let number = usize::from(number);
        self.0.iter_mut().find(|lane| lane.row().number == number)
    }

    /// Messages that came and were rejected, of all topics.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.0.iter().map(Lane::rejected).sum()
    }

    /// Brings latched topics to readers that joined since.
    pub fn refresh(&self) {
        self.0.iter().for_each(Lane::refresh);
    }
}

/// True for the topics of whole maps and of what is looked at for debugging.
fn is_large(row: &TopicRow) -> bool {
    let large = [MapUpdate::ROW, MapKeyframe::ROW, DebugRollouts::ROW];
    large.iter().any(|other| other.number == row.number)
}

/// True for the topics that launch writes.
fn is_of_launch(row: &TopicRow) -> bool {
    row.writers == [Role::Launch].as_slice()
}

/// Whom a message of a topic rings.
pub fn rung(row: &TopicRow, lockstep: bool) -> impl Iterator<Item = Role> {
    let more = if lockstep { row.rings_in_lockstep } else { &[] };
    row.rings.iter().chain(more).copied()
}

fn bit(row: &TopicRow) -> u64 {
    1_u64 << row.number.min(63)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::topics::topics;

    #[test]
    fn every_topic_has_a_lane_and_a_bit_of_its_own() {
        let mut lanes = Lanes::default();
        let rows = topics();
        assert_eq!(lanes.0.len(), rows.len());
        let bits = rows.iter().fold(0_u64, |bits, row| bits | bit(row));
        assert_eq!(bits.count_ones() as usize, rows.len());
        let last = &lanes.0[lanes.0.len() - 3..];
        assert!(last.iter().all(|lane| is_large(lane.row())), "{last:?}");
        for row in rows {
            let number = u8::try_from(row.number).expect("small");
            let lane = lanes.lane(number).expect("a lane");
            assert_eq!(lane.row().name, row.name);
        }
        assert!(lanes.lane(200).is_none());
    }
}
