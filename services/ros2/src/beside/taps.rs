//! The topics of the stack that ROS 2 is shown.

use zeronav_msgs::topics::decode;
use zeronav_msgs::topics::{
    GroundTruth, MapKeyframe, MapUpdate, RobotOdometry, RunControlTopic, SimForesight,
    SimPlacement, Topic, TopicRow, TopicVisitor, visit_topics,
};
use zeronav_shell::{Peer, RawReader, StartError};

/// A message: its topic, header and fixed fields, and items.
pub(super) struct Message {
    pub(super) row: &'static TopicRow,
    pub(super) envelope: Vec<u8>,
    pub(super) items: Vec<u8>,
}

type Check = fn(&'static TopicRow, &[u8], &[u8]) -> bool;

struct Tap {
    row: &'static TopicRow,
    reader: RawReader,
    check: Check,
}

/// Readers of all that is shown, who is obeyed first.
pub(super) struct Taps(Vec<Tap>);

/// What nobody is shown: the truth of a simulation.
const LEFT_OUT: [&TopicRow; 3] = [GroundTruth::ROW, SimForesight::ROW, SimPlacement::ROW];

fn is_accepted<T: Topic>(row: &'static TopicRow, envelope: &[u8], items: &[u8]) -> bool {
    let Ok(envelope) = bytemuck::try_pod_read_unaligned::<T::Envelope>(envelope) else {
        return false;
    };
    if !items.len().is_multiple_of(size_of::<T::Item>().max(1)) {
        return false;
    }
    let items: Vec<T::Item> = bytemuck::pod_collect_to_vec(items);
    decode::<T>(row, &envelope, &items).is_ok()
}

struct Opener<'a> {
    peer: &'a Peer,
    taps: Vec<Tap>,
}

impl TopicVisitor for Opener<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        let is_left_out = LEFT_OUT.iter().any(|it| it.number == row.number);
        // The local planner makes rollouts only while somebody reads them.
        if is_left_out || row.name.starts_with("debug/") {
            return Ok(());
        }
        self.taps.push(Tap {
            row,
            reader: self.peer.raw_on::<T>(row)?,
            check: is_accepted::<T>,
        });
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), StartError> {
        Ok(())
    }
}

impl Taps {
    pub(super) fn open(peer: &Peer) -> Result<Self, StartError> {
        let taps = Vec::new();
        let mut opener = Opener { peer, taps };
        visit_topics(&mut opener)?;
        let mut taps = opener.taps;
        let first = [
            RunControlTopic::ROW.number,
            // Few places are there for keyframes: they are given back soon.
            MapKeyframe::ROW.number,
            MapUpdate::ROW.number,
            RobotOdometry::ROW.number,
        ];
        taps.sort_by_key(|tap| {
            first
                .iter()
                .position(|it| *it == tap.row.number)
                .unwrap_or(4)
        });
        Ok(Self(taps))
    }

    /// Passes on what has come, at most as much of a topic as its queue holds.
    pub(super) fn drain(&mut self, mut each: impl FnMut(Message)) {
        for Tap { row, reader, check } in &mut self.0 {
            for _ in 0..row.buffer() {
                let message = reader.take(|envelope, items| {
                    check(row, envelope, items).then(|| (envelope.to_vec(), items.to_vec()))
                });
                match message {
                    Some(Some((envelope, items))) => each(Message {
                        row,
                        envelope,
                        items,
                    }),
                    Some(None) => {}
                    None => break,
                }
            }
        }
    }
}
