"""The common part of a running service: what is due, and how it is answered."""

import logging
import os
import time
from typing import NamedTuple

from . import contract as c
from .clock import now_ns, put_forward
from .domain import Domain
from .errors import UsageError
from .layout import FNV_PRIME, U64_MAX
from .link import LOOK_NS
from .peer import Peer
from .ports import Draft
from .roster_reader import RosterReader
from .seat import Seat, shadow_epoch

log = logging.getLogger("zeronav")

BEAT_NS = 20_000_000
U32_MAX = 0xFFFF_FFFF


class Due(NamedTuple):
    """An answer that is due: the tick (0 = idle output) and what kind of answer it is."""

    tick: int
    kind: c.SpanKind


IDLE = Due(0, c.SpanKind.IDLE)


class Shell:
    """The common part of a running service.

    An answer goes like this: `due` says which are due, `begin` starts one, `send` sends each of its
    messages, `finish` rings for them and leaves the record.
    """

    def __init__(self, flags, role, signals):
        domain = Domain(flags.domain)
        # Held for life; a shadow has none.
        self.seat = None if flags.shadow else Seat(domain, role)
        epoch = shadow_epoch() if flags.shadow else flags.epoch
        self.role, self.domain = role, domain
        self.peer = Peer(domain, role, epoch)
        self._roster_reader = RosterReader(self.peer)
        self.roster = self._roster_reader.roster
        if self.seat is not None and not self.seat.is_from_launch:
            self._check_epoch(epoch)
        self._doorbell = self.peer.doorbell(signals)
        self._ring = self.peer.bells()
        self._spans = self.peer.span_writer()
        self._health = self.peer.writer(c.HEALTH[role])
        self._beat, self._last_beat = c.Health(pid=os.getpid()), c.Health()
        self._last_beat_ns = self._superseded_in_spans = 0
        self._rung, self._hash = [], 0
        self._idle_sent, self.answered_tick = False, 0
        self.woken_ns, self._woken_cpu_ns = now_ns(), time.thread_time_ns()
        self.wake_by_ns = None

    def leave(self):
        """Closes the ports; the domain is returned."""
        self.peer.leave()
        return self.domain

    @property
    def is_orphaned(self):
        """True when launch is gone: the robot comes to rest, whatever is requested."""
        return self._roster_reader.rests

    def come_to_rest(self):
        """Behaves from now on as if launch had asked for a stop."""
        self._roster_reader.rests = True
        self._roster_reader.poll()

    def _check_epoch(self, epoch):
        """Accepts the epoch that launch expects in this seat."""
        self._roster_reader.await_known()
        seat, name = self.roster.seats.get(self.role), self.role.name.lower()
        if seat is None:
            raise UsageError(f"this run has no seat for {name}")
        if seat.epoch != epoch:
            raise UsageError(
                f"--epoch {epoch}: the seat of {name} expects --epoch {seat.epoch}, "
                "no other is obeyed"
            )

    def wait(self, deadline_ns):
        """Sleeps until a ring or `deadline_ns`, then reads the roster; the events that rang."""
        rung = self._doorbell.wait(deadline_ns)
        self.woken_ns, self._woken_cpu_ns = now_ns(), time.thread_time_ns()
        self.wake_by_ns = None
        self.roster.woken_ns = self.woken_ns
        self._roster_reader.poll()
        put_forward(self.roster.clock_offset_ns())
        if self.roster.has_delays():
            self.wake_by_ns = self.woken_ns + LOOK_NS
        return rung

    def wake_by(self, at_ns):
        """The next wake comes at `at_ns` of the monotonic clock at the latest."""
        self.wake_by_ns = at_ns if self.wake_by_ns is None else min(at_ns, self.wake_by_ns)

    def run_ns(self, tick):
        """Run time of a tick. [ns]"""
        return tick * self.roster.clock.tick_ns

    def due(self, tick, complete=True, news=False, deadline_ns=None):
        """The answers that are due: the idle output first of all, then that to `tick`.

        In lockstep every tick is answered once, when `complete`; in real time the newest tick,
        incomplete at `deadline_ns`, and the same tick again when there is `news`.
        """
        dues = []
        if self.roster.has_clock:
            if not self._idle_sent:
                dues.append(IDLE)
            kind = self._next(tick, complete, news, deadline_ns)
            if kind is not None:
                dues.append(Due(tick, kind))
        return dues

    def _next(self, tick, complete, news, deadline_ns):
        lockstep = self.roster.lockstep
        if tick <= self.answered_tick:
            return c.SpanKind.EXTRA if news and tick > 0 and not lockstep else None
        if lockstep and not self.roster.owes(tick):
            return None
        if complete:
            return c.SpanKind.ANSWER
        if deadline_ns is not None and not lockstep:
            if now_ns() >= deadline_ns:
                return c.SpanKind.ANSWER
            self.wake_by(deadline_ns)
        return None

    def begin(self, due, run_ns, capture_ns=0, parents=None):
        """Begins an answer: all inputs are taken in. `parents` holds fields of `Parents`."""
        draft = Draft(
            kind=due.kind,
            tick=due.tick,
            run_ns=run_ns,
            capture_ns=capture_ns,
            parents=parents or {},
            woken_ns=self.woken_ns,
            started_ns=now_ns(),
            hashed=due.tick > 0 and self.roster.lockstep,
        )
        delay_ns = self.roster.delay_ns() if due.tick > 0 else 0
        if delay_ns:
            time.sleep(delay_ns * 1e-9)
        return draft

    def send(self, draft, writer, meta, items=()):
        """Sends a message of an answer; None when it was dropped."""
        return self._note(writer, writer.too_long, writer.publish(draft, meta, items))

    def send_with(self, draft, writer, length, fill):
        """Like `send`; `fill(array)` writes the items in shared memory and returns `meta`."""
        return self._note(writer, writer.too_long, writer.publish_with(draft, length, fill))

    def _note(self, writer, too_long, sent):
        if sent is not None:
            self._hash = ((self._hash * FNV_PRIME) & U64_MAX) ^ sent.hash
            self._rung.append(writer.topic)
        elif writer.too_long > too_long:
            self.reason(c.REASON_TOO_LONG, True)
        else:
            self.reason(c.REASON_NO_LOAN, True)
        return sent

    def answer(self, draft, writer, meta, items=()):
        """Answers with one message and no more."""
        sent = self.send(draft, writer, meta, items)
        self.finish(draft, sent)
        return sent

    def ring(self):
        """Rings for everything sent since the last time; `finish` does it, too."""
        for topic in self._rung:
            more = topic.rings_in_lockstep if self.roster.lockstep else ()
            for role in (*topic.rings, *more):
                self._ring(role, topic.number)
        self._rung.clear()

    def ring_event(self, role, event):
        """Rings `role` with an event that belongs to no message."""
        self._ring(role, event)

    def finish(self, draft, output, work=0):
        """Ends an answer: rings, then leaves the record with its main message and the `work`."""
        self.ring()
        if draft.kind == c.SpanKind.IDLE and output is not None:
            self._idle_sent = True
            self.ready()
        elif draft.kind == c.SpanKind.ANSWER:
            self.answered_tick = max(self.answered_tick, draft.tick)
        superseded = self._beat.superseded - self._superseded_in_spans
        self._superseded_in_spans = self._beat.superseded
        ran_ns = time.thread_time_ns() - self._woken_cpu_ns
        off_ns = max(0, now_ns() - self.woken_ns - ran_ns)
        self._spans.write(
            c.Span(
                role=self.role,
                kind=draft.kind,
                epoch=self.peer.epoch,
                tick=draft.tick,
                **draft.parents,
                output=output.id if output else 0,
                capture_ns=draft.capture_ns,
                woken_ns=draft.woken_ns,
                started_ns=draft.started_ns,
                published_ns=output.published_ns if output else 0,
                superseded=min(superseded, U32_MAX),
                work=min(work, U32_MAX),
                hash=self._hash,
                off_processor_ns=off_ns,
            )
        )
        self._hash = 0
        if self.roster.lockstep:
            for role in c.RUN_SPANS.rings_in_lockstep:
                self._ring(role, c.RUN_SPANS.number)

    def reason(self, bit, holds):
        """Sets or clears a reason in the heartbeat."""
        self._beat.reasons = self._beat.reasons | bit if holds else self._beat.reasons & ~bit

    def count(self, readers):
        """Counts for heartbeat and records what the readers refused and what was superseded."""
        refused = sum(reader.refused for reader in readers)
        self.reason(c.REASON_REFUSED, refused > self._last_beat.refused)
        self._beat.refused = refused
        superseded = sum(reader.superseded for reader in readers)
        self._beat.superseded = max(self._beat.superseded, superseded)

    def progress(self):
        """Shows that long work goes on. Cheap enough for every thousand steps."""
        self._beat.progress += 1
        self.beat()

    def ready(self):
        """The service is ready."""
        if self._beat.state == c.HealthState.STARTING:
            self._beat.state = c.HealthState.READY

    def stopping(self):
        """The service goes away because it was asked to."""
        self._beat.state = c.HealthState.STOPPING
        self.beat()

    def beat(self):
        """Beats at once when state or reasons changed, and otherwise every 20 ms."""
        beat, at_ns = self._beat.copy(), now_ns()
        if beat.state == c.HealthState.READY and beat.reasons:
            beat.state = c.HealthState.DEGRADED
        last = self._last_beat
        changed = (beat.state, beat.reasons) != (last.state, last.reasons)
        if not changed and abs(at_ns - self._last_beat_ns) < BEAT_NS:
            return
        draft = Draft(woken_ns=self.woken_ns, started_ns=at_ns)
        if self._health.publish(draft, beat) is not None:
            self._last_beat, self._last_beat_ns = beat, at_ns
            self._beat.reasons &= ~c.REASON_NO_LOAN
