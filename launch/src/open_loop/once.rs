//! One answer of a stage to a tick, of a recording in real time, in which it answers again when something comes.

use crate::recorded::notes::Note;
use std::collections::BTreeMap;
use zeronav_msgs::header::{Header, Id, Parents};
use zeronav_msgs::topics::{ControlRequest, PlanPath, RobotCommand, Topic};

/// What a stage sends once in a tick.
const ONE_A_TICK: [&str; 3] = [
    PlanPath::ROW.name,
    ControlRequest::ROW.name,
    RobotCommand::ROW.name,
];

/// Messages that were left out, by topic, and how the others are numbered so that none is missed.
#[derive(Debug, Default)]
pub(super) struct LeftOut(BTreeMap<&'static str, Vec<u64>>);

/// Keeps one answer of each stage behind mapping to a tick, of messages in their order. That is the first: the others
/// answer what came later. Of the guard it is the first that rests on the request that is kept.
pub(super) fn once(notes: Vec<Note>) -> (Vec<Note>, LeftOut) {
    let mut kept: BTreeMap<(u64, &str), usize> = BTreeMap::new();
    for (at, note) in notes.iter().enumerate() {
        let first = *kept.entry((note.tick, note.row.name)).or_insert(at);
        if first != at && note.row.number == RobotCommand::ROW.number {
            // Requests stand before the commands of their tick.
            let request = kept.get(&(note.tick, ControlRequest::ROW.name));
            let request = request.map(|request| notes[*request].header().id);
            let rests_on_it = |at: usize| Some(notes[at].header().parents.request) == request;
            if rests_on_it(at) && !rests_on_it(first) {
                kept.insert((note.tick, note.row.name), at);
            }
        }
    }
    let mut left_out = LeftOut::default();
    let mut stay = Vec::with_capacity(notes.len());
    for (at, note) in notes.into_iter().enumerate() {
        let is_one = note.tick > 0 && ONE_A_TICK.contains(&note.row.name);
        if !is_one || kept.get(&(note.tick, note.row.name)) == Some(&at) {
            stay.push(note);
        } else {
            let of_topic = left_out.0.entry(note.row.name).or_default();
            of_topic.push(note.header().id);
        }
    }
    for of_topic in left_out.0.values_mut() {
        of_topic.sort_unstable();
    }
    (stay, left_out)
}

impl LeftOut {
    /// The new number of a message, and of one that was left out that of the last before it.
    fn number(&self, topic: &str, id: u64) -> u64 {
        let Some(all) = self.0.get(topic) else {
            return id;
        };
        let start = Id::new(Id(id).epoch(), 0).0;
        let before = all.partition_point(|it| *it <= id) - all.partition_point(|it| *it < start);
        id.saturating_sub(before as u64)
    }

    /// The new number of the path that brought a geometry, and when it was left out, of the next, which brings it now.
    pub(super) fn geometry(&self, id: u64) -> u64 {
        let topic = PlanPath::ROW.name;
        let is_left_out = self
            .0
            .get(topic)
            .is_some_and(|all| all.binary_search(&id).is_ok());
        self.number(topic, id) + u64::from(is_left_out)
    }

    /// The header of a message on `topic` with the new numbers.
    pub(super) fn header(&self, topic: &str, header: Header) -> Header {
        let parents = header.parents;
        // A path is asked for on another topic.
        let request = if topic == PlanPath::ROW.name {
            parents.request
        } else {
            self.number(ControlRequest::ROW.name, parents.request)
        };
        Header {
            id: self.number(topic, header.id),
            parents: Parents {
                path: self.number(PlanPath::ROW.name, parents.path),
                request,
                ..parents
            },
            ..header
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::role::Role;
    use zeronav_msgs::topics::TopicRow;

    fn note(row: &'static TopicRow, role: Role, tick: u64, count: u64, request: u64) -> Note {
        let header = Header {
            tick,
            id: Id::new(1, count).0,
            parents: Parents {
                request: Id::new(1, request).0,
                ..Parents::default()
            },
            ..Header::default()
        };
        let mut bytes = bytemuck::bytes_of(&header).to_vec();
        bytes.resize(row.envelope_bytes, 0);
        Note {
            row,
            role,
            epoch: 1,
            tick,
            sent_ns: 0,
            bytes,
        }
    }

    #[test]
    fn of_several_answers_to_a_tick_one_stays_and_numbers_have_no_gap() {
        let request = |tick, count| note(ControlRequest::ROW, Role::LocalPlanner, tick, count, 0);
        let command =
            |tick, count, of| note(RobotCommand::ROW, Role::CollisionGuard, tick, count, of);
        let (stay, left_out) = once(vec![
            request(0, 1),
            request(8, 2),
            request(8, 3),
            // The second command of the tick is the one for the request that stays.
            command(8, 1, 1),
            command(8, 2, 2),
            command(8, 3, 3),
            request(9, 4),
            command(9, 4, 3),
        ]);
        let seen: Vec<_> = stay
            .iter()
            .map(|note| {
                let header = left_out.header(note.row.name, note.header());
                let [count, of] = [header.id, header.parents.request].map(|id| Id(id).count());
                (note.tick, note.row.name, count, of)
            })
            .collect();
        let (requests, commands) = (ControlRequest::ROW.name, RobotCommand::ROW.name);
        let expected = [
            (0, requests, 1, 0),
            (8, requests, 2, 0),
            (8, commands, 1, 2),
            (9, requests, 3, 0),
            // The request that it rests on was left out.
            (9, commands, 2, 2),
        ];
        assert_eq!(seen, expected);
    }

    #[test]
    fn a_geometry_whose_path_is_left_out_is_that_of_the_next() {
        let path = |tick, count| note(PlanPath::ROW, Role::GlobalPlanner, tick, count, 0);
        let (stay, left_out) = once(vec![path(5, 2), path(5, 3), path(10, 4), path(15, 5)]);
        assert_eq!(stay.len(), 3);
        let id = |count| Id::new(1, count).0;
        let new: Vec<u64> = (2..=5).map(|n| left_out.geometry(id(n))).collect();
        assert_eq!(new, [id(2), id(3), id(3), id(4)]);
        assert_eq!(left_out.geometry(0), 0);
        assert_eq!(left_out.geometry(Id::new(2, 7).0), Id::new(2, 7).0);
    }
}
