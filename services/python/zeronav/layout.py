"""What messages and topics are made of, and the hash by which two contracts are told apart."""

import ctypes
from dataclasses import dataclass
from functools import cache

import numpy as np

f32, f64 = ctypes.c_float, ctypes.c_double
u8, u16, u32, u64 = ctypes.c_uint8, ctypes.c_uint16, ctypes.c_uint32, ctypes.c_uint64
i32 = ctypes.c_int32

NUMBERS = {u8: "u8", u16: "u16", u32: "u32", u64: "u64", i32: "i32", f32: "f32", f64: "f64"}

FNV_OFFSET = 0xCBF2_9CE4_8422_2325
FNV_PRIME = 0x0000_0100_0000_01B3
U64_MAX = 0xFFFF_FFFF_FFFF_FFFF


def fnv1a(state, data):
    """64-bit FNV-1a of the bytes `data`, continued from `state` (start with `FNV_OFFSET`)."""
    for byte in data:
        state = ((state ^ byte) * FNV_PRIME) & U64_MAX
    return state


_FIRST, _STEP = 0x9E37_79B9_7F4A_7C15, 0x3C6E_F372_FE94_F82A
_HEADER_BYTES = 120


@cache
def _factors(count):
    return np.uint64(_FIRST) + np.uint64(_STEP) * np.arange(count, dtype=np.uint64)


def checksum(envelope, items):
    """Checksum of a message by the bytes of its header and fixed fields, and its slice, an array: the
    sum of all words of 8 bytes, each times an odd factor of its place, modulo 2^64.

    Source: Lemire, Kaser, "Strongly universal string hashing is fast", 2014."""
    items = np.frombuffer(items, np.uint8) if isinstance(items, bytes) else items.view(np.uint8)
    parts = (len(items).to_bytes(8, "little"), envelope[:_HEADER_BYTES], envelope[_HEADER_BYTES + 8 :])
    head = b"".join(part + bytes(-len(part) % 8) for part in map(bytes, parts))
    head = np.frombuffer(head, np.uint64)
    whole = len(items) // 8 * 8
    words = items[:whole].view(np.uint64) if whole else np.empty(0, np.uint64)
    factors = _factors(len(head) + len(words) + 1)
    total = int((head * factors[: len(head)]).sum(dtype=np.uint64))
    total += int((words * factors[len(head) : -1]).sum(dtype=np.uint64))
    if whole < len(items):
        rest = int.from_bytes(items[whole:].tobytes(), "little")
        total += rest * int(factors[-1])
    return total & U64_MAX


class Message(ctypes.Structure):
    """A message, or a part of one, as it lies in shared memory. All zero when made without values."""

    @classmethod
    def type_name(cls):
        """The name that the middleware compares."""
        return cls.NAME

    def copy(self):
        """A copy outside shared memory."""
        return type(self).from_buffer_copy(self)

    def __repr__(self):
        values = (f"{name}={getattr(self, name)!r}" for name, _ in self._fields_)
        return f"{type(self).__name__}({', '.join(values)})"


def _is_array(kind):
    return issubclass(kind, ctypes.Array)


@cache
def schema(kind):
    """The schema hash of a number, an array or a message: over names, order, types, offsets."""
    if kind in NUMBERS:
        return fnv1a(FNV_OFFSET, NUMBERS[kind].encode())
    if _is_array(kind):
        return fnv1a(fnv1a(schema(kind._type_), b"["), kind._length_.to_bytes(8, "little"))
    state = fnv1a(FNV_OFFSET, kind.NAME.encode())
    for name, part in kind._fields_:
        state = fnv1a(state, name.encode())
        state = fnv1a(state, schema(part).to_bytes(8, "little"))
        state = fnv1a(state, getattr(kind, name).offset.to_bytes(8, "little"))
    return state


def verify(kind):
    """Accepts a message class whose layout is what the contract says; ImportError otherwise."""
    offsets = tuple(getattr(kind, name).offset for name, _ in kind._fields_)
    found = (ctypes.sizeof(kind), offsets, schema(kind))
    if found != (kind.SIZE, kind.OFFSETS, kind.SCHEMA):
        raise ImportError(f"{kind.NAME}: size, offsets and schema hash are {found} here")


@dataclass(frozen=True, eq=False)
class Topic:
    """A topic: its name, its types, who writes it and whose doorbell it rings."""

    number: int
    name: str
    discipline: str
    envelope: type
    item: type
    writers: tuple
    rings: tuple
    rings_in_lockstep: tuple
    len_max: int
    buffer: int
    pool: int
    schema: int

    @property
    def meta(self):
        """The class of the fixed fields."""
        return dict(self.envelope._fields_)["meta"]

    def segment_bytes(self, length):
        """Bytes of shared memory that a writer takes with slices of `length` items."""
        envelope = ctypes.sizeof(self.envelope) if self.envelope else 0

        def padded(size):
            return -(-size // 8) * 8

        return self.pool * (64 + padded(envelope) + padded(length * ctypes.sizeof(self.item)))

    def verify(self):
        """Accepts a topic whose schema hash is what the contract says; ImportError otherwise."""
        envelope = schema(self.envelope) if self.envelope else 0
        state = fnv1a(FNV_OFFSET, self.name.encode())
        state = fnv1a(state, envelope.to_bytes(8, "little"))
        found = fnv1a(state, schema(self.item).to_bytes(8, "little"))
        if found != self.schema:
            raise ImportError(f"{self.name}: the schema hash is {found:016x} here")
