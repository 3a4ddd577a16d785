"""The way of the messages of a topic to one reader, which launch may disturb on purpose: some are
lost, late, or have a bit flipped. Otherwise they are read in place, in shared memory."""

import ctypes
from collections import deque

import numpy as np

from . import contract as c

# Most messages that are on their way; the oldest arrive early.
LATE_MAX = 64
# How often a process looks for late messages. [ns]
LOOK_NS = 1_000_000

_MASK = 2**64 - 1


def draw(fault, role, id):
    """A number that decides about the message with this id in the eyes of `role`.

    Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", the mixing function
    of SplitMix64."""
    mixed = fault.seed << 32 | fault.topic << 16 | role
    mixed ^= id * 0x9E37_79B9_7F4A_7C15 & _MASK
    mixed = (mixed ^ mixed >> 30) * 0xBF58_476D_1CE4_E5B9 & _MASK
    mixed = (mixed ^ mixed >> 27) * 0x94D0_49BB_1331_11EB & _MASK
    return mixed ^ mixed >> 31


def flip(drawn, envelope, items):
    """Flips one bit: of the header in front of the fixed fields, of these, or of the slice. Both are
    writable arrays of bytes."""
    head = min(c.Header.SIZE, len(envelope))
    parts = [part for part in (envelope[:head], envelope[head:], items) if len(part)]
    part, drawn = parts[drawn % len(parts)], drawn >> 8
    bit = drawn % (8 * len(part))
    part[bit // 8] ^= 1 << bit % 8


class Copy:
    """A copied message; it has what a view takes from a sample."""

    def __init__(self, topic, sample):
        size = ctypes.sizeof(topic.envelope)
        count = sample.header.number_of_elements
        item_size = np.dtype(topic.item).itemsize
        self.header = sample.header
        self.envelope = bytearray(ctypes.string_at(sample.user_header_ptr, size))
        self.items = bytearray(ctypes.string_at(sample.payload_ptr, count * item_size) + b"\0")
        self.user_header_ptr = _address(self.envelope)
        self.payload_ptr = _address(self.items)

    def corrupted(self, drawn):
        """With one bit flipped."""
        flip(drawn, memoryview(self.envelope), memoryview(self.items)[:-1])
        return self


def _address(data):
    return ctypes.addressof((ctypes.c_char * len(data)).from_buffer(data))


class Link:
    """The receiving end."""

    def __init__(self, topic, subscriber):
        self._topic, self._subscriber = topic, subscriber
        # When each message arrives [ns], the next one first.
        self._late = deque()

    def waits(self):
        """True when something has come that `receive` has not returned yet."""
        return self._subscriber.has_samples

    def receive(self, roster):
        """The next message, as it lies in shared memory or a copy; None when there is no more."""
        fault = roster.topic_fault(self._topic)
        if fault is None and not self._late:
            return self._subscriber.receive()
        delay_ns = fault.delay_us * 1000 if fault else 0
        if delay_ns:
            while (sample := self._subscriber.receive()) is not None:
                self._late.append((roster.woken_ns + delay_ns, Copy(self._topic, sample)))
                del sample
        if self._late:
            is_due = not delay_ns or self._late[0][0] <= roster.woken_ns
            return self._late.popleft()[1] if is_due or len(self._late) > LATE_MAX else None
        if delay_ns:
            return None
        while (sample := self._subscriber.receive()) is not None:
            envelope = self._topic.envelope.from_address(sample.user_header_ptr)
            drawn = draw(fault, int(roster.own), envelope.header.id)
            if drawn % c.SHARE_ALL >= fault.share:
                return sample
            if fault.kind == c.TopicFaultKind.CORRUPT:
                return Copy(self._topic, sample).corrupted((drawn << 32 | drawn >> 32) & _MASK)
            del sample, envelope
        return None
