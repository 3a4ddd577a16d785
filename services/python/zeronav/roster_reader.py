"""Reads which processes are obeyed and how the run keeps time."""

import time

from . import contract as c
from .errors import StartError
from .roster import Roster

KNOWN_LIMIT_S = 60.0
KNOWN_PAUSE_S = 0.005


class RosterReader:
    """Reads `run/clock` and `run/control` into `roster`."""

    def __init__(self, peer):
        self.roster = Roster(peer.role, peer.epoch)
        # Launch is gone: the robot stops, whatever `run/control` said last.
        self.rests = False
        self._clock = peer.latest(c.RUN_CLOCK)
        self._control = peer.latest(c.RUN_CONTROL)

    def poll(self):
        """Takes in what has come."""
        roster = self.roster
        if self._clock.poll(roster):
            roster.clock = self._clock.get().meta.copy()
            roster.lockstep = roster.clock.mode == c.RunMode.LOCKSTEP
        if self._control.poll(roster):
            view = self._control.get()
            roster.control = view.meta.copy()
            data = view.items.tobytes()
            places = range(0, len(data), c.Seat.SIZE)
            seats = [c.Seat.from_buffer_copy(data, place) for place in places]
            roster.seats = {c.Role(seat.role): seat for seat in seats}
        if self.rests:
            roster.control.stopping, roster.control.paused = 1, 0

    def await_known(self):
        """Waits until launch has published which processes are obeyed."""
        deadline_s = time.monotonic() + KNOWN_LIMIT_S
        while not self.roster.is_known:
            if time.monotonic() > deadline_s:
                raise StartError("reading run/control: no message from launch")
            time.sleep(KNOWN_PAUSE_S)
            self.poll()
