"""Which processes are obeyed, which roles have to answer, and how the run keeps time."""

from .contract import DELAY_STEP_NS, Role, RunClock, RunControl, RunMode


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
        seat = self.seats.get(header.role)
        if seat is None:
            return False
        obeyed = seat.other if 0 < header.tick < seat.since_tick else seat.epoch
        if obeyed == 0 or obeyed != header.id >> 40:
            return False
        own = self.seats.get(self.own)
        if header.tick == 0 or own is None:
            return True
        return header.tick >= (own.other_tick if self._is_other(own) else own.hear_tick)

    def is_current(self, header):
        """True when the author is the process that is obeyed in its seat from now on."""
        seat = self.seats.get(header.role)
        return seat is None or seat.epoch == header.id >> 40

    def _is_other(self, own):
        return self.epoch != 0 and self.epoch == own.other

    def owes(self, tick):
        """True when this process has to answer `tick`, obeyed or not."""
        own = self.seats.get(self.own)
        if own is not None and self._is_other(own):
            return tick >= own.other_tick
        return self.answers(self.own, tick)

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
