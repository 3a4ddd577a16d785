//! One topic in both directions: what is written here goes to the other host, what comes from there is written
//! here, with its stamps in the time of this host's clock.

use bytemuck::{bytes_of, cast_slice, pod_collect_to_vec, pod_read_unaligned};
use core::any::Any;
use core::marker::PhantomData;
use std::collections::{BTreeMap, BTreeSet};
use zeronav_msgs::header::Header;
use zeronav_msgs::message::{Refusal, ensure};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunClock;
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{Discipline, Envelope, SPANS, Topic, TopicRow, decode, seal};
use zeronav_msgs::truth::TruthObstacle;
use zeronav_shell::{Peer, RawReader, RawUnsent, RawWriter, StartError};

/// Role and epoch of an author, as messages name it.
pub type Author = (u16, u32);

/// Most authors of a topic in a run: launch gives up restarting long before.
const AUTHORS_MAX: usize = 4096;

/// A message as it goes over the wire: header with fixed fields, and slice.
pub type Parts = (Vec<u8>, Vec<u8>);

/// A message that was written here, and when. [ns]
pub type Written = (u64, Parts);

/// What depends on the type of a topic.
pub trait Typed {
    /// Its row.
    fn row(&self) -> &'static TopicRow;
    /// Opens a reader of all its messages.
    ///
    /// # Errors
    /// As [`Peer::raw_on`].
    fn reader(&self, peer: &Peer) -> Result<RawReader, StartError>;
    /// Opens a writer of messages with up to `len` items.
    ///
    /// # Errors
    /// As [`Peer::raw_writer_on`].
    fn writer(&self, peer: &Peer, len: usize) -> Result<RawWriter, StartError>;
    /// How many readers it has here.
    ///
    /// # Errors
    /// As [`Peer::ports`].
    fn readers(&self, peer: &Peer) -> Result<usize, StartError>;
    /// Who wrote a message, and when [ns]; `None` for bytes that are no message of this topic.
    fn author(&self, envelope: &[u8], items: &[u8]) -> Option<(Author, u64)>;
    /// Accepts a message and puts its stamps into the time of another clock.
    ///
    /// # Errors
    /// What is wrong with it.
    fn retimed(&self, envelope: &[u8], items: &[u8], ahead_ns: i64) -> Result<Parts, Refusal>;
}

/// A moment by a clock that is `ahead_ns` ahead, by the own clock. [ns] 0 is no moment.
fn own_time(ns: u64, ahead_ns: i64) -> u64 {
    if ns == 0 {
        return 0;
    }
    let own = i128::from(ns) - i128::from(ahead_ns);
    // Before the own clock began there is only its beginning.
    u64::try_from(own.max(1)).unwrap_or(u64::MAX)
}

fn retime_header(header: &mut Header, ahead_ns: i64) {
    let stamps = &mut header.stamps;
    for ns in [
        &mut header.capture_ns,
        &mut stamps.woken_ns,
        &mut stamps.started_ns,
        &mut stamps.published_ns,
    ] {
        *ns = own_time(*ns, ahead_ns);
    }
}

/// A topic whose messages have a header.
pub(crate) struct WithHeader<T>(&'static TopicRow, PhantomData<fn() -> T>);

impl<T: Topic> WithHeader<T> {
    pub(crate) fn new(row: &'static TopicRow) -> Self {
        Self(row, PhantomData)
    }

    fn parse(envelope: &[u8], items: &[u8]) -> Option<(T::Envelope, Vec<T::Item>)> {
        let fits = envelope.len() == size_of::<T::Envelope>()
            && items.len().is_multiple_of(size_of::<T::Item>().max(1));
        fits.then(|| (pod_read_unaligned(envelope), pod_collect_to_vec(items)))
    }
}

impl<T: Topic> Typed for WithHeader<T> {
    fn row(&self) -> &'static TopicRow {
        self.0
    }

    fn reader(&self, peer: &Peer) -> Result<RawReader, StartError> {
        peer.raw_on::<T>(self.0)
    }

    fn writer(&self, peer: &Peer, len: usize) -> Result<RawWriter, StartError> {
        peer.raw_writer_on::<T>(self.0, len)
    }

    fn readers(&self, peer: &Peer) -> Result<usize, StartError> {
        peer.ports::<T>(self.0).map(|[_, readers]| readers)
    }

    fn author(&self, envelope: &[u8], items: &[u8]) -> Option<(Author, u64)> {
        let (envelope, _) = Self::parse(envelope, items)?;
        let header = envelope.header();
        let author = (header.role, header.id().epoch());
        Some((author, header.stamps.published_ns))
    }

    fn retimed(&self, envelope: &[u8], items: &[u8], ahead_ns: i64) -> Result<Parts, Refusal> {
        let (envelope, mut items) = Self::parse(envelope, items).ok_or(Refusal::Length("bytes"))?;
        decode::<T>(self.0, &envelope, &items)?;
        let (mut header, mut meta) = (*envelope.header(), *envelope.meta());
        retime_header(&mut header, ahead_ns);
        if let Some(clock) = (&mut meta as &mut dyn Any).downcast_mut::<RunClock>() {
            clock.zero_ns = own_time(clock.zero_ns, ahead_ns);
        }
        if let Some(truth) = (&mut items as &mut dyn Any).downcast_mut::<Vec<TruthObstacle>>() {
            for obstacle in truth {
                obstacle.appeared_ns = own_time(obstacle.appeared_ns, ahead_ns);
            }
        }
        let sealed = seal::<T>(header, meta, &items);
        Ok((
            bytes_of(&sealed).to_vec(),
            cast_slice::<_, u8>(&items).to_vec(),
        ))
    }
}

/// The topic of records.
pub(crate) struct Records;

impl Records {
    fn parse(envelope: &[u8], items: &[u8]) -> Option<Span> {
        let fits = envelope.is_empty() && items.len() == size_of::<Span>();
        fits.then(|| pod_read_unaligned(items))
    }
}

impl Typed for Records {
    fn row(&self) -> &'static TopicRow {
        &SPANS
    }

    fn reader(&self, peer: &Peer) -> Result<RawReader, StartError> {
        peer.raw_spans()
    }

    fn writer(&self, peer: &Peer, _: usize) -> Result<RawWriter, StartError> {
        peer.raw_span_writer()
    }

    fn readers(&self, peer: &Peer) -> Result<usize, StartError> {
        peer.span_ports().map(|[_, readers]| readers)
    }

    fn author(&self, envelope: &[u8], items: &[u8]) -> Option<(Author, u64)> {
        let span = Self::parse(envelope, items)?;
        Some(((span.role, span.epoch), span.published_ns))
    }

    fn retimed(&self, envelope: &[u8], items: &[u8], ahead_ns: i64) -> Result<Parts, Refusal> {
        let mut span = Self::parse(envelope, items).ok_or(Refusal::Length("bytes"))?;
        span.check()?;
        for ns in [
            &mut span.capture_ns,
            &mut span.woken_ns,
            &mut span.started_ns,
            &mut span.published_ns,
        ] {
            *ns = own_time(*ns, ahead_ns);
        }
        Ok((Vec::new(), bytes_of(&span).to_vec()))
    }
}

/// One topic.
pub struct Lane {
    typed: Box<dyn Typed>,
    /// Open once the other host has wanted its messages.
    reader: Option<RawReader>,
    /// Open once a message has come, with the most items that it can send.
    writer: Option<(usize, RawWriter)>,
    /// Authors on the other host: what they wrote does not go back there.
    foreign: BTreeSet<Author>,
}

impl Lane {
    pub(crate) fn new(typed: Box<dyn Typed>) -> Self {
        Self {
            typed,
            reader: None,
            writer: None,
            foreign: BTreeSet::new(),
        }
    }

    /// The topic's row.
    #[must_use]
    pub fn row(&self) -> &'static TopicRow {
        self.typed.row()
    }

    /// True when somebody else reads the topic here.
    #[must_use]
    pub fn is_read(&self, peer: &Peer) -> bool {
        let readers = self.typed.readers(peer).unwrap_or(0);
        readers > usize::from(self.reader.is_some())
    }

    /// Begins to read the topic, for good. Who begins gets the last message of a latched one.
    ///
    /// # Errors
    /// As [`Peer::raw_on`].
    pub fn listen(&mut self, peer: &Peer) -> Result<(), StartError> {
        if self.reader.is_none() {
            self.reader = Some(self.typed.reader(peer)?);
        }
        Ok(())
    }

    /// Lets the last message of a latched topic come again.
    ///
    /// # Errors
    /// As [`Peer::raw_on`].
    pub fn repeat(&mut self, peer: &Peer) -> Result<(), StartError> {
        if self.reader.is_some() && self.row().discipline == Discipline::Latched {
            self.reader = None;
            self.listen(peer)?;
        }
        Ok(())
    }

    /// What was written here since the last call. Of a topic of which the newest message matters alone, the
    /// newest of each author.
    pub fn take(&mut self) -> Vec<Written> {
        let Some(reader) = &mut self.reader else {
            return Vec::new();
        };
        let mut all: Vec<(Author, Written)> = Vec::new();
        while let Some(parts) = reader.take(|envelope, items| (envelope.to_vec(), items.to_vec())) {
            if let Some((author, written_ns)) = self.typed.author(&parts.0, &parts.1)
                && !self.foreign.contains(&author)
            {
                all.push((author, (written_ns, parts)));
            }
        }
        let newest_alone = matches!(
            self.row().discipline,
            Discipline::Latest | Discipline::Latched
        );
        if newest_alone {
            // Later messages of an author take the place of earlier ones.
            let newest: BTreeMap<Author, Written> = all.into_iter().collect();
            return newest.into_values().collect();
        }
        all.into_iter().map(|(_, written)| written).collect()
    }

    /// Accepts a message that has come, by one of `authors`: its parts in the own time, and its author.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn accept(
        &mut self,
        envelope: &[u8],
        items: &[u8],
        ahead_ns: i64,
        authors: &[Role],
    ) -> Result<(Author, Parts), Refusal> {
        let parts = self.typed.retimed(envelope, items, ahead_ns)?;
        let author = self.typed.author(&parts.0, &parts.1);
        let (author, _) = author.ok_or(Refusal::Length("bytes"))?;
        let role = Role::from_code(author.0);
        ensure(
            role.is_some_and(|role| authors.contains(&role)),
            Refusal::Foreign("its author"),
        )?;
        ensure(
            self.foreign.contains(&author) || self.foreign.len() < AUTHORS_MAX,
            Refusal::Length("authors"),
        )?;
        self.foreign.insert(author);
        Ok((author, parts))
    }

    /// Writes a message here. False when readers hold all memory of the topic.
    ///
    /// # Errors
    /// As [`Peer::raw_writer_on`].
    pub fn write(&mut self, peer: &Peer, parts: &Parts) -> Result<bool, StartError> {
        let row = self.row();
        let len = parts.1.len() / row.item_bytes.max(1);
        if self.writer.as_ref().is_none_or(|(most, _)| *most < len) {
            // Of all but whole maps the most at once: readers find messages of two writers in no order.
            let most = if row.discipline == Discipline::Latched {
                len.next_power_of_two().clamp(1, row.len_max.max(1))
            } else {
                row.len_max
            };
            // The one before goes first: a topic has few places for writers.
            self.writer = None;
            self.writer = Some((most, self.typed.writer(peer, most)?));
        }
        let sent = self
            .writer
            .as_mut()
            .map(|(_, writer)| writer.send(&parts.0, &parts.1));
        Ok(!matches!(sent, Some(Err(RawUnsent::NoMemory))))
    }

    /// Brings the last message of a latched topic to readers that joined since.
    pub fn refresh(&self) {
        if let Some((_, writer)) = &self.writer
            && self.row().discipline == Discipline::Latched
        {
            writer.refresh();
        }
    }
}

impl core::fmt::Debug for Lane {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Lane")
            .field("topic", &self.row().name)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_casts::low_u32;
    use zeronav_msgs::header::{Id, Stamps};
    use zeronav_msgs::odometry::Odometry;
    use zeronav_msgs::run::RunMode;
    use zeronav_msgs::span::SpanKind;
    use zeronav_msgs::topics::{RobotOdometry, RunClockTopic};

    fn header<T: Topic>(role: Role) -> Header {
        Header {
            role: role.code(),
            schema: low_u32(T::ROW.schema),
            id: Id::new(3, 5).0,
            capture_ns: 70,
            stamps: Stamps {
                woken_ns: 100,
                started_ns: 200,
                published_ns: 0,
            },
            ..Header::default()
        }
    }

    fn bytes<T: Topic>(header: Header, meta: T::Meta) -> Vec<u8> {
        bytes_of(&seal::<T>(header, meta, &[])).to_vec()
    }

    #[test]
    fn moments_are_put_into_the_own_time_and_the_message_stays_whole() {
        let typed = WithHeader::<RobotOdometry>::new(RobotOdometry::ROW);
        let before =
            bytes::<RobotOdometry>(header::<RobotOdometry>(Role::Robot), Odometry::default());
        let (after, items) = typed.retimed(&before, &[], 30).expect("accepted");
        assert!(items.is_empty());
        assert_eq!(
            typed.author(&after, &[]),
            Some(((Role::Robot.code(), 3), 0))
        );
        let envelope: <RobotOdometry as Topic>::Envelope = pod_read_unaligned(&after);
        decode::<RobotOdometry>(RobotOdometry::ROW, &envelope, &[]).expect("whole");
        let header = envelope.header();
        assert_eq!(header.capture_ns, 40);
        assert_eq!(
            (header.stamps.woken_ns, header.stamps.started_ns),
            (70, 170)
        );
        // No moment stays none, and nothing is before the own clock's beginning.
        assert_eq!(header.stamps.published_ns, 0);
        assert_eq!(own_time(20, 30), 1);
        assert_eq!(own_time(20, -30), 50);
        // A flipped bit is found before the checksum is made anew.
        for at in [8, before.len() - 1] {
            let mut flipped = before.clone();
            flipped[at] ^= 4;
            assert!(typed.retimed(&flipped, &[], 30).is_err(), "byte {at}");
        }
        assert_eq!(
            typed.retimed(&before[1..], &[], 0),
            Err(Refusal::Length("bytes"))
        );
    }

    #[test]
    fn only_who_is_on_the_other_host_writes() {
        let typed = WithHeader::<RobotOdometry>::new(RobotOdometry::ROW);
        let mut lane = Lane::new(Box::new(typed));
        let header = header::<RobotOdometry>(Role::Robot);
        let message = bytes::<RobotOdometry>(header, Odometry::default());
        let mut accept = |authors: &[Role]| lane.accept(&message, &[], 0, authors);
        let refused = accept(&[Role::Launch, Role::Mapping]);
        assert_eq!(refused, Err(Refusal::Foreign("its author")));
        let (author, _) = accept(&[Role::Robot]).expect("accepted");
        assert_eq!(author, (Role::Robot.code(), 3));
    }

    #[test]
    fn the_beginning_of_run_time_and_records_are_put_into_the_own_time() {
        let typed = WithHeader::<RunClockTopic>::new(RunClockTopic::ROW);
        let clock = RunClock {
            mode: RunMode::RealTime.code(),
            zero_ns: 1_000,
            tick_ns: 20_000_000,
            ..RunClock::default()
        };
        let before = bytes::<RunClockTopic>(header::<RunClockTopic>(Role::Launch), clock);
        let (after, _) = typed.retimed(&before, &[], -500).expect("accepted");
        let envelope: <RunClockTopic as Topic>::Envelope = pod_read_unaligned(&after);
        assert_eq!(envelope.meta().zero_ns, 1_500);
        let span = Span {
            role: Role::Mapping.code(),
            kind: SpanKind::Answer.code(),
            epoch: 2,
            woken_ns: 10,
            started_ns: 20,
            published_ns: 30,
            off_processor_ns: 7,
            ..Span::default()
        };
        let (_, items) = Records.retimed(&[], bytes_of(&span), -5).expect("accepted");
        let after: Span = pod_read_unaligned(&items);
        assert_eq!(
            (after.woken_ns, after.started_ns, after.published_ns),
            (15, 25, 35)
        );
        // A time that has passed is not a moment.
        assert_eq!((after.capture_ns, after.off_processor_ns), (0, 7));
        assert_eq!(
            Records.author(&[], &items),
            Some(((Role::Mapping.code(), 2), 35))
        );
    }
}
