"""Messages that are lost, late or corrupted on purpose."""

import ctypes
import unittest

from zeronav import checks
from zeronav import contract as c
from zeronav.layout import checksum
from zeronav.link import Link, draw, flip
from zeronav.ports import Latest
from zeronav.roster import Roster

TOPIC = c.CONTROL_VELOCITY_REQUEST


class Sample:
    """What a subscriber returns, in memory of its own."""

    def __init__(self, count, tick=0, v_mps=0.0):
        envelope = TOPIC.envelope()
        head = envelope.header
        head.role, head.id, head.tick = c.Role.LOCAL_PLANNER, 1 << 40 | count, tick
        envelope.meta.v_mps = v_mps
        head.schema = TOPIC.schema & 0xFFFF_FFFF
        envelope.meta.validity = c.Validity.DRIVE
        head.checksum = checksum(bytes(envelope), b"")
        self.header = type("Header", (), {"number_of_elements": 0})
        self._kept = envelope
        self.user_header_ptr = ctypes.addressof(envelope)
        self.payload_ptr = self.user_header_ptr


class Subscriber:
    """The middleware's end, with so many messages."""

    def __init__(self, count):
        self.samples = [Sample(n) for n in range(1, count + 1)]

    @property
    def has_samples(self):
        return bool(self.samples)

    def receive(self):
        return self.samples.pop(0) if self.samples else None


def roster(kind, share=0, delay_us=0):
    found = Roster(c.Role.COLLISION_GUARD, 1)
    fault = found.control.topic_faults[2]
    fault.topic, fault.kind, fault.seed = TOPIC.number, kind, 11
    fault.share, fault.delay_us = share, delay_us
    return found


def envelope(message):
    return TOPIC.envelope.from_address(message.user_header_ptr)


class TopicFaults(unittest.TestCase):
    def test_the_same_messages_are_hit_as_in_rust(self):
        fault = c.TopicFault(topic=6, seed=11)
        self.assertEqual(draw(fault, 4, 7), 0x224A_FE67_07A4_E6F8)

    def test_one_bit_flips(self):
        for drawn in range(0, 1 << 20, 997):
            head, items = bytearray(160), bytearray(8)
            flip(drawn, memoryview(head), memoryview(items))
            self.assertEqual(sum(byte.bit_count() for byte in head + items), 1)

    def test_a_share_is_lost(self):
        link = Link(TOPIC, Subscriber(1000))
        lossy = roster(c.TopicFaultKind.DROP, share=300_000)
        heard = 0
        while link.receive(lossy) is not None:
            heard += 1
        self.assertTrue(650 <= heard <= 750, heard)

    def test_a_flipped_bit_is_rejected(self):
        link = Link(TOPIC, Subscriber(100))
        corrupt = roster(c.TopicFaultKind.CORRUPT, share=c.SHARE_ALL)
        for _ in range(100):
            message = link.receive(corrupt)
            with self.assertRaises(checks.Refused):
                checks.decode(TOPIC, envelope(message), b"")
        right = Sample(1)
        checks.decode(TOPIC, envelope(right), b"")

    def test_a_delay_keeps_the_order_and_ends_with_the_fault(self):
        link = Link(TOPIC, Subscriber(3))
        late = roster(c.TopicFaultKind.DELAY, delay_us=50)
        late.woken_ns = 1000
        self.assertIsNone(link.receive(late))
        late.woken_ns = 51_000
        self.assertEqual(envelope(link.receive(late)).header.id & 0xFF, 1)
        late.control.topic_faults[2].kind = c.TopicFaultKind.NONE
        self.assertEqual(envelope(link.receive(late)).header.id & 0xFF, 2)
        self.assertEqual(envelope(link.receive(late)).header.id & 0xFF, 3)
        self.assertIsNone(link.receive(late))


class RejectedMessages(unittest.TestCase):
    def test_one_counts_as_an_answer_until_the_next_one(self):
        found = Roster(c.Role.COLLISION_GUARD, 1)
        found.clock.mode, found.lockstep = c.RunMode.LOCKSTEP, True
        found.seats[c.Role.LOCAL_PLANNER] = c.Seat(role=c.Role.LOCAL_PLANNER, epoch=1)
        subscriber = Subscriber(0)
        reader = Latest(TOPIC, subscriber)

        def spoken_after(number, tick, v_mps=0.0):
            subscriber.samples.append(Sample(number, tick, v_mps))
            reader.poll(found)
            return reader.spoken_tick

        bad, most = float("nan"), 2**64 - 1
        self.assertEqual(spoken_after(1, 8), 8)
        self.assertEqual(spoken_after(2, 9, bad), 9)
        self.assertEqual(spoken_after(3, most, bad), most)
        self.assertEqual(spoken_after(4, 10), 10)
        self.assertEqual(spoken_after(5, most, bad), most)
        self.assertEqual(spoken_after(6, 11, bad), 11)
        self.assertEqual(spoken_after(7, 3, bad), 10)
        self.assertEqual(reader.refused, 5)


if __name__ == "__main__":
    unittest.main()
