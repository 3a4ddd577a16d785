//! The common part of a running service: what is due, and how it is answered.

use crate::clock::{self, now_ns, thread_cpu_ns};
use crate::domain::Domain;
use crate::doorbell::{Bells, Doorbell, Rung, Waker};
use crate::due::{self, Due, Next, Trigger};
use crate::error::StartError;
use crate::flags::Flags;
use crate::heartbeat::Heartbeat;
use crate::input::Input;
use crate::link;
use crate::peer::Peer;
use crate::received::Received;
use crate::records::SpanWriter;
use crate::roster::Roster;
use crate::roster_reader::RosterReader;
use crate::seat::{self, SeatLock};
use crate::writer::{Draft, Sent, Writer};
use std::os::unix::net::UnixStream;
use std::time::Duration;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_NO_LOAN, REASON_TOO_LONG};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::Seat;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::stages::{STAGES_MAX, StageTimer};
use zeronav_msgs::topics::{SPANS, Topic, TopicRow};

/// The common part of a running service.
///
/// An answer goes like this: [`Self::due`] says which are due, [`Self::begin`] starts one,
/// [`Self::send`] sends each of its messages, [`Self::finish`] rings for them and leaves the span.
#[derive(Debug)]
pub struct Shell {
    /// Held for life; a shadow has none.
    seat: Option<SeatLock>,
    peer: Peer,
    roster: RosterReader,
    doorbell: Doorbell,
    bells: Bells,
    spans: SpanWriter,
    pub(crate) heartbeat: Heartbeat,
    woken_ns: u64,
    /// Processor time of this thread at `woken_ns`. [ns]
    woken_cpu_ns: u64,
    wake_by_ns: u64,
    rings: Vec<&'static TopicRow>,
    hash: u64,
    idle_sent: bool,
    answered_tick: u64,
    orphaned: bool,
}

impl Shell {
    pub(crate) fn open(flags: &Flags, role: Role, signals: UnixStream) -> Result<Self, StartError> {
        let root = flags
            .member
            .domain
            .as_ref()
            .ok_or_else(|| StartError::Usage("--domain is missing".to_owned()))?;
        let domain = Domain::join(root)?;
        let (seat, epoch) = match flags.epoch {
            Some(epoch) if !flags.shadow => (Some(SeatLock::take(&domain, role)?), epoch),
            _ => (None, seat::shadow_epoch()),
        };
        let peer = Peer::join(domain, role, epoch)?;
        let mut roster = RosterReader::open(&peer)?;
        if seat.as_ref().is_some_and(|seat| !seat.is_from_launch()) {
            roster.expects(role, epoch)?;
        }
        Ok(Self {
            seat,
            orphaned: false,
            roster,
            doorbell: Doorbell::open(&peer, signals)?,
            bells: Bells::open(&peer)?,
            spans: peer.span_writer()?,
            heartbeat: Heartbeat::open(&peer)?,
            woken_ns: now_ns(),
            woken_cpu_ns: thread_cpu_ns(),
            wake_by_ns: u64::MAX,
            rings: Vec::with_capacity(8),
            hash: 0,
            idle_sent: false,
            answered_tick: 0,
            peer,
        })
    }

    /// Closes the own ports, then leaves the middleware.
    pub(crate) fn leave(self) -> Domain {
        let Self {
            peer,
            roster,
            doorbell,
            bells,
            spans,
            heartbeat,
            ..
        } = self;
        drop((roster, doorbell, bells, spans, heartbeat));
        peer.leave()
    }

    /// The membership, to open ports with.
    #[must_use]
    pub fn peer(&self) -> &Peer {
        &self.peer
    }

    /// Which processes are obeyed and how time runs.
    #[must_use]
    pub fn roster(&self) -> &Roster {
        self.roster.roster()
    }

    /// True when launch is gone: the robot comes to rest, whatever is requested.
    #[must_use]
    pub fn is_orphaned(&self) -> bool {
        self.orphaned
    }

    /// True when this process holds its seat; a shadow does not.
    pub(crate) fn is_obeyable(&self) -> bool {
        self.seat.is_some()
    }

    /// Behaves from now on as if launch had asked for a stop.
    pub(crate) fn come_to_rest(&mut self) {
        self.orphaned = true;
        self.roster.come_to_rest();
    }

    /// Sleeps until a ring or `deadline_ns`, then reads the roster.
    pub(crate) fn wait(&mut self, deadline_ns: u64) -> Rung {
        let rung = self.doorbell.wait(deadline_ns);
        self.woken_ns = now_ns();
        self.woken_cpu_ns = thread_cpu_ns();
        self.wake_by_ns = u64::MAX;
        self.roster.woken(self.woken_ns);
        let roster = self.roster.roster();
        let seat = roster.seat(self.peer.role());
        clock::put_forward(seat.map_or(0, Seat::clock_offset_ns));
        if roster.has_delays() {
            self.wake_by_ns = self.woken_ns + link::LOOK_NS;
        }
        rung
    }

    /// What wakes this process from another of its threads, as for what comes over a network.
    ///
    /// # Errors
    /// [`StartError::System`] when the system has no room.
    pub fn waker(&mut self) -> Result<Waker, StartError> {
        let waker = self.doorbell.waker();
        waker.map_err(|error| StartError::system("making a waker", error))
    }

    /// Moment of the return from the wait. [ns]
    #[must_use]
    pub fn woken_ns(&self) -> u64 {
        self.woken_ns
    }

    /// The next wake comes at `at_ns` of the monotonic clock at the latest; at once when that is
    /// over, as for work ahead between two inputs. [ns]
    pub fn wake_by(&mut self, at_ns: u64) {
        self.wake_by_ns = self.wake_by_ns.min(at_ns);
    }

    pub(crate) fn wake_by_ns(&self) -> u64 {
        self.wake_by_ns
    }

    /// Run time of a tick. [ns]
    #[must_use]
    pub fn run_ns(&self, tick: u64) -> u64 {
        tick.saturating_mul(self.roster().clock.tick_ns)
    }

    /// Newest tick that was answered; 0 before the first.
    #[must_use]
    pub fn answered_tick(&self) -> u64 {
        self.answered_tick
    }

    /// The answers that are due: first of all, once the clock is known, the idle output, then what
    /// `trigger` asks for. An answer that waits for its inputs no longer than a deadline brings the
    /// next wake forward to it.
    pub fn due(&mut self, trigger: &Trigger) -> impl Iterator<Item = Due> + use<> {
        let roster = self.roster();
        let mut dues = [None, None];
        if roster.has_clock() {
            let next = due::next(roster, self.answered_tick, trigger, now_ns);
            dues[0] = (!self.idle_sent).then_some(Due::IDLE);
            match next {
                Next::Now(due) => dues[1] = Some(due),
                Next::By(deadline_ns) => self.wake_by(deadline_ns),
                Next::Later => {}
            }
        }
        dues.into_iter().flatten()
    }

    /// Begins an answer: all inputs are taken in. In lockstep, answers to ticks count for the
    /// run's hash. A delay that launch injects into this seat is spent here, as if the work took
    /// longer.
    #[must_use]
    pub fn begin(&self, due: Due, run_ns: u64, capture_ns: u64, parents: Parents) -> Draft {
        let Due { tick, kind } = due;
        let draft = Draft {
            kind,
            tick,
            run_ns,
            capture_ns,
            parents,
            woken_ns: self.woken_ns,
            started_ns: now_ns(),
            raw_ns: 0,
            stages_ns: [0; STAGES_MAX],
            hashed: tick > 0 && self.roster().lockstep(),
        };
        std::thread::sleep(self.delay(tick));
        draft
    }

    /// The delay that launch injects into an answer to `tick`; none into what belongs to no tick.
    fn delay(&self, tick: u64) -> Duration {
        let seat = self.roster().seat(self.peer.role());
        let delayed = seat.filter(|_| tick > 0);
        Duration::from_nanos(delayed.map_or(0, Seat::delay_ns))
    }

    /// What takes the times of the stages of an answer that began at `started_ns`, for its draft:
    /// marks that come before the main message is sent. Off unless launch asks for times. [ns]
    #[must_use]
    pub fn stage_timer(&self, started_ns: u64) -> StageTimer {
        if self.roster().clock.stages == 1 && !self.roster().lockstep() {
            StageTimer::new(now_ns, started_ns)
        } else {
            StageTimer::default()
        }
    }

    /// Age of what a message says at the beginning of an answer: since its capture. [ns]
    #[must_use]
    pub fn age_ns(&self, draft: &Draft, message: &Received) -> u64 {
        message.age_ns(self.roster().lockstep(), draft.run_ns, draft.started_ns)
    }

    /// Sends a message of an answer. `None` as [`Writer::publish`].
    pub fn send<T: Topic>(
        &mut self,
        draft: &Draft,
        writer: &mut Writer<T>,
        meta: T::Meta,
        items: &[T::Item],
    ) -> Option<Sent> {
        let too_long = writer.too_long();
        let sent = writer.publish(draft, meta, items);
        self.note(writer, too_long, sent)
    }

    /// Like [`Self::send`], but the slice of `len` items is filled in place, in shared memory; what
    /// `fill` returns are the fixed fields.
    pub fn send_with<T: Topic>(
        &mut self,
        draft: &Draft,
        writer: &mut Writer<T>,
        len: usize,
        fill: impl FnOnce(&mut [T::Item]) -> T::Meta,
    ) -> Option<Sent> {
        let too_long = writer.too_long();
        let sent = writer.publish_with(draft, len, fill);
        self.note(writer, too_long, sent)
    }

    /// Sends a message that belongs to no answer: it rings nobody, is not part of the run's hash, and
    /// when it finds no memory it is dropped without a reason in the heartbeat.
    pub fn send_aside<T: Topic>(
        &self,
        draft: &Draft,
        writer: &mut Writer<T>,
        meta: T::Meta,
        items: &[T::Item],
    ) -> Option<Sent> {
        let aside = Draft {
            hashed: false,
            ..*draft
        };
        writer.publish(&aside, meta, items)
    }

    /// Notes a sent message: the readers to ring, and its share of the answer's hash; or why it was
    /// not sent. `too_long` is what the writer had counted before.
    fn note<T: Topic>(
        &mut self,
        writer: &Writer<T>,
        too_long: u64,
        sent: Option<Sent>,
    ) -> Option<Sent> {
        match sent {
            Some(sent) => {
                self.hash = self.hash.wrapping_mul(0x0000_0100_0000_01b3) ^ sent.hash;
                self.rings.push(writer.row());
            }
            None if writer.too_long() > too_long => self.reason(REASON_TOO_LONG, true),
            None => self.reason(REASON_NO_LOAN, true),
        }
        sent
    }

    /// Answers with one message and no more: [`Self::send`] and [`Self::finish`].
    pub fn answer<T: Topic>(
        &mut self,
        draft: &Draft,
        writer: &mut Writer<T>,
        meta: T::Meta,
        items: &[T::Item],
    ) -> Option<Sent> {
        let sent = self.send(draft, writer, meta, items);
        self.finish(draft, sent, 0);
        sent
    }

    /// Rings for everything sent since the last time. [`Self::finish`] does it, too.
    pub fn ring(&mut self) {
        let lockstep = self.roster().lockstep();
        for row in self.rings.drain(..) {
            let more: &[Role] = if lockstep { row.rings_in_lockstep } else { &[] };
            for role in row.rings.iter().chain(more) {
                self.bells.ring(*role, row.number);
            }
        }
    }

    /// Rings `role` with an event that belongs to no message.
    pub(crate) fn ring_event(&self, role: Role, event: usize) {
        self.bells.ring(role, event);
    }

    /// Ends an answer: rings, then leaves the span with its main message, `output`, and the `work`
    /// done in the role's own unit. With its idle output the service is ready.
    pub fn finish(&mut self, draft: &Draft, output: Option<Sent>, work: u64) {
        self.ring();
        match draft.kind {
            SpanKind::Idle if output.is_some() => {
                self.idle_sent = true;
                self.ready();
            }
            SpanKind::Answer => self.answered_tick = self.answered_tick.max(draft.tick),
            _ => {}
        }
        let Parents {
            odometry,
            scan,
            map,
            path,
            request,
            goal,
        } = draft.parents;
        self.spans.write(Span {
            role: self.peer.role().code(),
            kind: draft.kind.code(),
            epoch: self.peer.epoch(),
            tick: draft.tick,
            odometry,
            scan,
            map,
            path,
            request,
            goal,
            output: output.map_or(0, |sent| sent.id.0),
            capture_ns: draft.capture_ns,
            woken_ns: draft.woken_ns,
            started_ns: draft.started_ns,
            published_ns: output.map_or(0, |sent| sent.published_ns),
            superseded: u32::try_from(self.heartbeat.take_superseded()).unwrap_or(u32::MAX),
            work: u32::try_from(work).unwrap_or(u32::MAX),
            hash: core::mem::take(&mut self.hash),
            off_processor_ns: self.off_processor_ns(),
            raw_ns: draft.raw_ns,
            stages_ns: draft.stages_ns,
        });
        if self.roster().lockstep() {
            for role in SPANS.rings_in_lockstep {
                self.bells.ring(*role, SPANS.number);
            }
        }
    }

    /// Time since the wake in which this thread did not run. [ns]
    fn off_processor_ns(&self) -> u64 {
        let ran_ns = thread_cpu_ns().saturating_sub(self.woken_cpu_ns);
        now_ns()
            .saturating_sub(self.woken_ns)
            .saturating_sub(ran_ns)
    }

    /// Sets or clears a reason in the heartbeat.
    pub fn reason(&mut self, bit: u32, holds: bool) {
        self.heartbeat.reason(bit, holds);
    }

    /// Counts for heartbeat and spans what the inputs rejected and what was superseded.
    pub fn count(&mut self, inputs: &[&dyn Input]) {
        let rejected = inputs.iter().map(|input| input.refused()).sum();
        let superseded = inputs.iter().map(|input| input.superseded()).sum();
        self.heartbeat.totals(rejected, superseded);
    }

    /// Run time that was lost because the process was late, for the heartbeat. [ns]
    pub fn slipped(&mut self, slipped_ns: u64) {
        self.heartbeat.slipped(slipped_ns);
    }

    /// Shows that long work goes on. Cheap enough for every thousand steps.
    pub fn progress(&mut self) {
        self.heartbeat.progress();
        self.beat(now_ns());
    }

    /// The service is ready, before or without an idle output.
    pub fn ready(&mut self) {
        self.heartbeat.ready();
    }

    pub(crate) fn beat(&mut self, now_ns: u64) {
        self.heartbeat.publish(self.woken_ns, now_ns);
    }
}

#[cfg(test)]
mod tests;
