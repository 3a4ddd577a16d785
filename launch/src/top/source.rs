//! Reads a stack as a guest: one reader per topic, no doorbell, nothing kept.

use super::model::{Heard, Model};
use crate::topics::tap::Tap;
use zeronav_msgs::header::Header;
use zeronav_msgs::message::Message;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{
    HEALTH, PlanPath, RobotCommand, RobotOdometry, TaskState, Topic, TopicRow, TopicVisitor,
    visit_topics,
};
use zeronav_shell::records::SpanReader;
use zeronav_shell::{Peer, Roster, Stream};

/// The readers of a stack.
pub(super) struct Source {
    tap: Tap,
    readers: Vec<Box<dyn Reader>>,
    spans: Option<SpanReader>,
}

/// Reads one topic.
trait Reader {
    /// Shows what has come to `model`, which knows the topic by `index`.
    fn read(&mut self, roster: &Roster, index: usize, model: &mut Model);
    /// Its topic.
    fn row(&self) -> &'static TopicRow;
}

struct TopicReader<T: Topic> {
    row: &'static TopicRow,
    stream: Stream<T>,
}

impl<T: Topic> Reader for TopicReader<T> {
    fn read(&mut self, roster: &Roster, index: usize, model: &mut Model) {
        let row = self.row;
        loop {
            let before = self.stream.missed();
            let taken = self.stream.take(roster, |view| {
                let bytes = row.envelope_bytes + size_of_val(view.items);
                let sent_ns = view.header.stamps.published_ns;
                (bytes, sent_ns, heard(row, view.header, view.meta))
            });
            let Some((bytes, sent_ns, heard)) = taken else {
                return;
            };
            let missed = self.stream.missed() - before;
            model.count(index, bytes, sent_ns, missed);
            model.ingest(&heard);
        }
    }

    fn row(&self) -> &'static TopicRow {
        self.row
    }
}

/// What the model looks into.
fn heard<M: Message>(row: &'static TopicRow, header: &Header, meta: &M) -> Heard {
    let (header, bytes) = (*header, bytemuck::bytes_of(meta));
    let is = |other: &TopicRow| row.number == other.number;
    if HEALTH.iter().any(is) {
        Heard::Beat(header, bytemuck::pod_read_unaligned(bytes))
    } else if is(PlanPath::ROW) {
        Heard::Path(header, bytemuck::pod_read_unaligned(bytes))
    } else if is(RobotCommand::ROW) {
        Heard::Command(header, bytemuck::pod_read_unaligned(bytes))
    } else if is(TaskState::ROW) {
        Heard::Task(header, bytemuck::pod_read_unaligned(bytes))
    } else if is(RobotOdometry::ROW) {
        Heard::Odometry(header, bytemuck::pod_read_unaligned::<Odometry>(bytes))
    } else {
        Heard::Other
    }
}

struct Opener<'a> {
    tap: &'a Tap,
    readers: Vec<Box<dyn Reader>>,
    spans: Option<SpanReader>,
}

impl TopicVisitor for Opener<'_> {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        let stream = self.tap.open(|peer| peer.stream_on::<T>(row))?;
        self.readers.push(Box::new(TopicReader { row, stream }));
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), String> {
        self.spans = Some(self.tap.open(Peer::span_reader)?);
        Ok(())
    }
}

impl Source {
    /// Opens a reader of every topic.
    ///
    /// # Errors
    /// One line when there is no place left.
    pub(super) fn open(tap: Tap) -> Result<Self, String> {
        let mut opener = Opener {
            tap: &tap,
            readers: Vec::new(),
            spans: None,
        };
        visit_topics(&mut opener)?;
        let Opener { readers, spans, .. } = opener;
        Ok(Self {
            tap,
            readers,
            spans,
        })
    }

    /// Names of the topics, in the order of their indices; the records are last.
    pub(super) fn names(&self) -> Vec<&'static str> {
        let rows = self.readers.iter().map(|reader| reader.row().name);
        rows.chain([zeronav_msgs::topics::SPANS.name]).collect()
    }

    /// True in lockstep.
    pub(super) fn is_lockstep(&mut self) -> bool {
        self.tap.poll().lockstep()
    }

    /// Shows everything that has come to `model`; false when the run is over.
    pub(super) fn read(&mut self, model: &mut Model) -> bool {
        // Before the last messages are read, so that they are seen.
        let is_over = self.tap.peer().domain().is_orphaned();
        let roster = self.tap.poll();
        for (index, reader) in self.readers.iter_mut().enumerate() {
            reader.read(roster, index, model);
        }
        let index = self.readers.len();
        if let Some(spans) = &mut self.spans {
            spans.drain(|span| {
                let sent_ns = span.published_ns.max(span.started_ns);
                model.count(index, size_of::<Span>(), sent_ns, 0);
                model.span(span);
            });
        }
        !is_over
    }

    /// Gives all places back.
    pub(super) fn leave(self) {
        let Self {
            tap,
            readers,
            spans,
        } = self;
        drop((readers, spans));
        tap.leave();
    }
}
