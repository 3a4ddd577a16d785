"""The reading and writing ends of topics. Foreign bytes are checked here and nowhere else.

`items` of a message are numpy views of shared memory. A view keeps its message, and the middleware
lets a reader keep two at a time: copy what has to stay.
"""

import ctypes
import logging
from dataclasses import dataclass, field

import numpy as np

from . import contract as c
from .checks import CHECKSUM, Refused, decode, header
from .clock import now_ns
from .layout import FNV_OFFSET, checksum, fnv1a
from .link import Link

log = logging.getLogger("zeronav")


def _view(address, item, count, owner):
    """`count` items at `address` as a read-only array that keeps `owner`."""
    dtype = np.dtype(item)
    if count == 0:
        return np.empty(0, dtype)
    memory = (ctypes.c_char * (count * dtype.itemsize)).from_address(address)
    memory.owner = owner
    array = np.ndarray((count,), dtype, memory)
    array.flags.writeable = False
    return array


class View:
    """A message as it lies in shared memory: `header`, `meta` (the fixed fields), `items`."""

    __slots__ = ("came_ns", "envelope", "header", "items", "meta")

    def __init__(self, topic, sample, came_ns):
        self.envelope = topic.envelope.from_address(sample.user_header_ptr)
        self.envelope.owner = sample
        self.header, self.meta = self.envelope.header, self.envelope.meta
        # The middleware's own slice counts bytes; its header counts items.
        count = sample.header.number_of_elements
        self.items = _view(sample.payload_ptr, topic.item, count, sample)
        # When it came in, by this process's clock. [ns]
        self.came_ns = came_ns

    @property
    def id(self):
        """Identity of the message."""
        return self.header.id

    @property
    def tick(self):
        """Tick of the message."""
        return self.header.tick

    def age_ns(self, draft, lockstep):
        """Age at the beginning of an answer: in run time, or by the own clock since capture."""
        if lockstep:
            return max(0, draft.run_ns - self.header.run_ns)
        return max(0, draft.started_ns - min(self.header.capture_ns, self.came_ns))

    def arrival_age_ns(self, draft, lockstep):
        """The same since it came in: what counts is that its author still sends."""
        if lockstep:
            return max(0, draft.run_ns - self.header.run_ns)
        return max(0, draft.started_ns - self.came_ns)


class _Reader:
    def __init__(self, topic, subscriber):
        self.topic, self._link = topic, Link(topic, subscriber)
        self.refused = self.superseded = self.refused_tick = 0
        self._said = set()

    def _receive(self, roster):
        """The next message that is heard; None when nothing more has come."""
        while True:
            try:
                sample = self._link.receive(roster)
            except Exception as error:
                raise RuntimeError(
                    f"{self.topic.name}: {error}: views of earlier messages are still in use; "
                    "copy what has to stay"
                ) from error
            if sample is None:
                return None
            view = View(self.topic, sample, roster.woken_ns)
            if self._admits(view, roster):
                return view
            # Given back before the next one is asked for.
            del sample, view

    def _admits(self, view, roster):
        try:
            decode(self.topic, view.envelope, view.items)
        except Refused as refusal:
            self._note(view, roster, str(refusal))
            return False
        if not self._hears(view.header, roster):
            return False
        # A rejected message answers until the next one comes: its tick may be any number.
        self.refused_tick = 0
        return True

    def _hears(self, header, roster):
        """In lockstep an idle output would take effect at a tick that depends on the speed of the
        machine: it is heard of the first process in a seat only. The map is also heard from before
        the reader's own first tick, as it is the sum of its updates."""
        if header.tick == 0 and roster.lockstep and roster.is_taken_over(header):
            return False
        is_map = self.topic in (c.MAP_UPDATE, c.MAP_KEYFRAME)
        return roster.hears(header) or (is_map and roster.obeys(header))

    def _note(self, view, roster, why):
        self.refused += 1
        try:
            header(self.topic, view.header)
            # A header in which a bit was changed may name anything.
            if why != CHECKSUM and self._hears(view.header, roster):
                self.refused_tick = view.tick
        except Refused:
            pass
        if why not in self._said:
            self._said.add(why)
            log.warning("message refused topic=%s id=%d refusal=%s", self.topic.name, view.id, why)


class Latest(_Reader):
    """Keeps the newest message of a latest or latched topic, in place in shared memory."""

    def __init__(self, topic, subscriber):
        super().__init__(topic, subscriber)
        self._held = None
        self._from_launch = c.Role.LAUNCH in topic.writers

    def poll(self, roster):
        """Takes in what has come; True when there is a newer message than before."""
        # Before the roster is known, messages of services would be dropped, latched ones for good.
        if not (roster.seats or self._from_launch):
            return False
        fresh = False
        while (view := self._receive(roster)) is not None:
            held = self._held
            # Messages of several writers come writer by writer: the newest has the highest id, and
            # those of the process that is obeyed now are newer than those of the one before it.
            rank = lambda view: (roster.is_current(view.header), view.id)  # noqa: E731
            if held is None or rank(view) > rank(held) or not roster.hears(held.header):
                self.superseded += fresh
                self._held, fresh = view, True
            else:
                self.superseded += 1
            del view, held
        return fresh

    def waits(self):
        """True when something has come that `poll` has not taken in yet."""
        return self._link.waits()

    def get(self):
        """The newest message, or None."""
        return self._held

    def release(self):
        """Gives the newest message back to its writer."""
        self._held = None

    @property
    def id(self):
        """Identity of the newest message; 0 before the first."""
        return self._held.id if self._held else 0

    @property
    def tick(self):
        """Tick of the newest message; 0 before the first."""
        return self._held.tick if self._held else 0

    @property
    def spoken_tick(self):
        """Tick up to which the writer has answered, accepted or not."""
        return max(self.tick, self.refused_tick)


class Stream(_Reader):
    """Sees every message of a topic in order."""

    def drain(self, roster, see):
        """Shows every message that has come to `see`, which copies what it keeps."""
        while (view := self._receive(roster)) is not None:
            see(view)
            del view


@dataclass(slots=True)
class Draft:
    """What the author knows about a message before it has an identity."""

    kind: c.SpanKind = c.SpanKind.IDLE
    tick: int = 0
    run_ns: int = 0
    capture_ns: int = 0
    parents: dict = field(default_factory=dict)
    woken_ns: int = 0
    started_ns: int = 0
    hashed: bool = False


@dataclass(frozen=True, slots=True)
class Sent:
    """A message that is out: identity, clock reading in its header, hash (0 when not hashed)."""

    id: int
    published_ns: int
    hash: int


class Writer:
    """The writing end of a topic, with slices of up to `len_max` items."""

    def __init__(self, topic, publisher, role, epoch, len_max):
        self.topic, self._publisher, self.len_max = topic, publisher, len_max
        self._role, self._epoch, self._count = role, epoch, 0
        self._dtype = np.dtype(topic.item)
        self.failed = self.too_long = 0

    @property
    def next_id(self):
        """Identity that the next message will have."""
        return self._epoch << 40 | self._count + 1

    def publish(self, draft, meta, items=()):
        """Sends `meta` with `items`, an array of the topic's type or a list of its structures."""
        array = items
        if not isinstance(items, np.ndarray):
            array = np.frombuffer(b"".join(map(bytes, items)), self._dtype)

        def fill(slot):
            slot[:] = array
            return meta

        return self.publish_with(draft, len(array), fill)

    def publish_with(self, draft, length, fill):
        """Like `publish`; `fill(array)` writes the items in shared memory and returns `meta`."""
        if length > self.len_max:
            self.too_long += 1
            self._fail(f"longer than its writer was opened for: {length} > {self.len_max}")
            return None
        try:
            sample = self._publisher.loan_slice_uninit(length)
        except Exception as error:
            self._fail(f"no free memory: {error}")
            return None
        size = length * self._dtype.itemsize
        memory = (ctypes.c_char * size).from_address(sample.payload_ptr)
        items = np.ndarray((length,), self._dtype, memory)
        meta = fill(items)
        envelope = self.topic.envelope(meta=meta)
        head = envelope.header
        head.role, head.schema = self._role, self.topic.schema & 0xFFFF_FFFF
        head.id, head.tick, head.run_ns = self.next_id, draft.tick, draft.run_ns
        head.parents = c.Parents(**draft.parents)
        state = 0
        if draft.hashed:
            state = fnv1a(fnv1a(FNV_OFFSET, bytes(head)), bytes(meta))
            state = fnv1a(state, bytes(memory))
        head.capture_ns = draft.capture_ns
        published_ns = now_ns()
        head.stamps = c.Stamps(draft.woken_ns, draft.started_ns, published_ns)
        head.checksum = checksum(bytes(envelope), items)
        ctypes.memmove(sample.user_header_ptr, ctypes.byref(envelope), ctypes.sizeof(envelope))
        sent = Sent(head.id, published_ns, state)
        try:
            sample.assume_init().send()
        except Exception as error:
            self._fail(str(error))
            return None
        self._count += 1
        return sent

    def _fail(self, why):
        self.failed += 1
        if self.failed == 1:
            log.error("dropped topic=%s: %s; said once", self.topic.name, why)

    def refresh(self):
        """Brings the last message of a latched topic to readers that joined since."""
        self._publisher.update_connections()


class SpanWriter:
    """The writing end of `run/spans`."""

    def __init__(self, publisher):
        self._publisher = publisher
        self.failed = 0

    def write(self, span):
        """Sends one record."""
        try:
            self._publisher.send_copy(span)
        except Exception:
            self.failed += 1
