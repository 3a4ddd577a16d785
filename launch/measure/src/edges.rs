//! What was sent between processes, and what was overtaken by something newer before it was used.

use super::index::Records;
use crate::result::profile::Edge;
use std::collections::BTreeSet;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::topics::{
    ControlRequest, MapUpdate, PlanPath, RobotCommand, RobotOdometry, RobotScan, Topic,
};

/// A topic on its way to one of its readers.
#[derive(Debug, Clone, Copy)]
pub struct TopicEdge {
    /// Name of the topic.
    pub topic: &'static str,
    /// Its author.
    pub author: Role,
    /// The seat that reads it.
    pub reader: Role,
    /// Id of the message that this record of its author sent; 0 = none.
    pub sent: fn(&Span) -> u64,
    /// Id of the message that this record of its reader was made from; 0 = none.
    pub read: fn(&Span) -> u64,
}

/// Every edge whose messages are named in the records of their readers, in the order of the data
/// flow.
pub const EDGES: [TopicEdge; 9] = {
    const fn edge(
        topic: &'static str,
        [author, reader]: [Role; 2],
        sent: fn(&Span) -> u64,
        read: fn(&Span) -> u64,
    ) -> TopicEdge {
        TopicEdge {
            topic,
            author,
            reader,
            sent,
            read,
        }
    }
    use Role::{CollisionGuard, GlobalPlanner, LocalPlanner, Mapping, Robot};
    let (scan, odometry) = (RobotScan::ROW.name, RobotOdometry::ROW.name);
    [
        edge(scan, [Robot, Mapping], |it| it.scan, |it| it.scan),
        edge(scan, [Robot, LocalPlanner], |it| it.scan, |it| it.scan),
        edge(scan, [Robot, CollisionGuard], |it| it.scan, |it| it.scan),
        edge(
            odometry,
            [Robot, LocalPlanner],
            |it| it.output,
            |it| it.odometry,
        ),
        edge(
            odometry,
            [Robot, CollisionGuard],
            |it| it.output,
            |it| it.odometry,
        ),
        edge(
            MapUpdate::ROW.name,
            [Mapping, GlobalPlanner],
            |it| it.output,
            |it| it.map,
        ),
        edge(
            PlanPath::ROW.name,
            [GlobalPlanner, LocalPlanner],
            |it| it.output,
            |it| it.path,
        ),
        edge(
            ControlRequest::ROW.name,
            [LocalPlanner, CollisionGuard],
            |it| it.output,
            |it| it.request,
        ),
        edge(
            RobotCommand::ROW.name,
            [CollisionGuard, Robot],
            |it| it.output,
            |it| it.request,
        ),
    ]
};

impl TopicEdge {
    /// True when the record says what its process sent here.
    #[must_use]
    pub fn is_sent_by(&self, span: &Span) -> bool {
        span.role == self.author.code()
            && span.kind() != Some(SpanKind::Applied)
            && (self.sent)(span) != 0
    }

    /// True when the record says what its process used from here. The robot uses a command when it
    /// applies it.
    #[must_use]
    pub fn is_read_by(&self, span: &Span) -> bool {
        let applies = span.kind() == Some(SpanKind::Applied);
        span.role == self.reader.code()
            && applies == (self.reader == Role::Robot)
            && (self.read)(span) != 0
    }
}

/// The messages of every edge.
#[must_use]
pub fn edges(records: &Records) -> Vec<Edge> {
    let edge = |way: &TopicEdge| {
        let ids = |is: &dyn Fn(&Span) -> bool, id: fn(&Span) -> u64| -> BTreeSet<u64> {
            let spans = records.spans.iter().filter(|span| is(span));
            spans.map(id).collect()
        };
        let sent = ids(&|span| way.is_sent_by(span), way.sent);
        let read = ids(&|span| way.is_read_by(span), way.read);
        // What came before the first and after the last was not overtaken: the records begin and
        // end there.
        let between = read.first().zip(read.last());
        let sent: Vec<u64> = between.map_or_else(Vec::new, |(first, last)| {
            sent.range(first..=last).copied().collect()
        });
        let superseded = sent.iter().filter(|id| !read.contains(id)).count();
        Edge {
            topic: way.topic.to_owned(),
            reader: way.reader.to_string(),
            sent: sent.len() as u64,
            superseded: superseded as u64,
        }
    };
    EDGES.iter().map(edge).collect()
}

/// Several rounds as one.
#[must_use]
pub fn of_rounds<'a>(rounds: impl Iterator<Item = &'a [Edge]>) -> Vec<Edge> {
    let mut all: Vec<Edge> = Vec::new();
    for round in rounds {
        if all.is_empty() {
            all = round.to_vec();
            continue;
        }
        for (all, edge) in all.iter_mut().zip(round) {
            all.sent += edge.sent;
            all.superseded += edge.superseded;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_that_no_answer_was_made_of_was_superseded() {
        let span = |role: Role, scan, output| Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            scan,
            output,
            ..Span::default()
        };
        let mut records = Records::default();
        for scan in 1..=6 {
            records.spans.push(span(Role::Robot, scan, scan));
        }
        // Of the first and the last nothing is known.
        for (scan, output) in [(2, 1), (2, 2), (5, 3)] {
            records.spans.push(span(Role::Mapping, scan, output));
        }
        let of = |edges: &[Edge]| (edges[0].sent, edges[0].superseded, edges[1].sent);
        let edges = edges(&records);
        assert_eq!(of(&edges), (4, 2, 0), "{edges:#?}");
        let both = of_rounds([&edges[..], &edges[..]].into_iter());
        assert_eq!(of(&both), (8, 4, 0));
    }
}
