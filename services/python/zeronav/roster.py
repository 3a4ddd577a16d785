"""Which processes are obeyed, which roles have to answer, and how the run keeps time."""

from .contract import (
    DELAY_STEP_NS,
    SHADOW_EPOCH_MIN,
    Role,
    RunClock,
    RunControl,
    RunMode,
    TopicFaultKind,
)

TICK_MAX = 2**64 - 1


class Roster:
    """What `run/clock` and `run/control` say, as this process last read it."""

    def __init__(self, own, epoch):
        self.own, self.epoch = own, epoch
        self.clock, self.control = RunClock(), RunControl()
        # Seats by role.
        self.seats = {}
        self.lockstep = False
        # When the reader woke: what it polls came in by then. [ns]
        self.woken_ns = 0

    @property
    def has_clock(self):
        """True when launch has published how time runs."""
        return self.clock.mode != RunMode.NONE

    @property
    def is_known(self):
        """True when launch has also published which processes are obeyed."""
        return self.has_clock and bool(self.seats)

    def hears(self, header):
        """True when the author is obeyed, and the message not of a tick before this reader."""
        if header.role == Role.LAUNCH:
            return True
        return self.obeys(header) and (header.tick == 0 or header.tick >= self._first_tick())

    def _first_tick(self):
        """First tick of which this process hears messages; a successor that the seat does not name
        yet hears none."""
        own = self.seats.get(self.own)
        if own is None:
            return 0
        if self._is_other(own):
            return own.other_tick
        return own.hear_tick if self._is_named(own) else TICK_MAX

    def began_after(self, role, epoch):
        """True when this process began at a tick at which the seat of `role` was empty, which the
        process with this epoch had left."""
        seat = self.seats.get(role)
        if seat is None or seat.epoch == epoch:
            return False
        first_tick = self._first_tick()
        return first_tick > 0 and not self.answers(role, first_tick)

    def obeys(self, header):
        """True when the author is obeyed in its seat at the tick of the message."""
        seat = self.seats.get(header.role)
        if seat is None:
            return False
        obeyed = seat.other if 0 < header.tick < seat.since_tick else seat.epoch
        return obeyed != 0 and obeyed == header.id >> 40

    def is_taken_over(self, header):
        """True when the author's seat has been taken over since the run began."""
        seat = self.seats.get(header.role)
        return seat is not None and max(seat.hear_tick, seat.since_tick) > 0

    def is_current(self, header):
        """True when the author is the process that is obeyed in its seat from now on."""
        seat = self.seats.get(header.role)
        return seat is None or seat.epoch == header.id >> 40

    def _is_other(self, own):
        return self.epoch != 0 and self.epoch == own.other

    def _is_named(self, own):
        return self.epoch == own.epoch or self.epoch >= SHADOW_EPOCH_MIN

    def owes(self, tick):
        """True when this process has to answer `tick`, obeyed or not. A successor that the seat does
        not name yet answers none; a shadow started by hand answers as the seat does."""
        own = self.seats.get(self.own)
        if own is None:
            return False
        if self._is_other(own):
            return tick >= own.other_tick
        return self._is_named(own) and self.answers(self.own, tick)

    def answers(self, role, tick):
        """True when `role` has to answer `tick`."""
        seat = self.seats.get(role)
        return (
            seat is not None
            and seat.epoch != 0
            and not seat.off_tick <= tick < seat.on_tick
        )

    def awaits(self, role, tick, spoken_tick):
        """True when an answer to `tick` waits for that of `role`; lockstep only."""
        return self.lockstep and self.answers(role, tick) and spoken_tick < tick

    def delay_ns(self):
        """By how much launch delays each answer of this seat on purpose. [ns]"""
        own = self.seats.get(self.own)
        return own.delay * DELAY_STEP_NS if own else 0

    def clock_offset_ns(self):
        """By how much launch puts the clock of this process forward on purpose. [ns]"""
        own = self.seats.get(self.own)
        return own.clock_offset_ms * 1_000_000 if own else 0

    def topic_fault(self, topic):
        """What is done on purpose to the messages of `topic` on their way here, in real time."""
        for fault in self.control.topic_faults:
            if fault.kind != TopicFaultKind.NONE and fault.topic == topic.number:
                return None if self.lockstep else fault
        return None

    def has_delays(self):
        """True while messages are late on purpose, and have to be looked for between two rings."""
        return any(fault.kind == TopicFaultKind.DELAY for fault in self.control.topic_faults)
