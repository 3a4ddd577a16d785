"""A companion: a process beside a stack that reads its topics, and on which nothing in it waits."""

import contextlib
import logging
import os
import select
from typing import ClassVar

from .clock import now_ns
from .contract import Role
from .domain import Domain
from .errors import EXIT_CRASH, EXIT_STOPPED, StartError
from .peer import Peer
from .program import Program, catch_signals
from .roster_reader import RosterReader

log = logging.getLogger("zeronav")

# How much lower than that of the stack the priority of a companion is.
NICER = 5


class Guest:
    """Membership in a stack as a companion has it: `peer` opens ports, `roster` is for `poll`."""

    def __init__(self, flags):
        self.domain = Domain(flags.domain)
        self.peer = Peer(self.domain, Role.TAP, flags.epoch or 1)
        self._reader = RosterReader(self.peer)
        self._reader.await_known()

    @property
    def roster(self):
        """Which processes are obeyed and how time runs, as of this look."""
        return self._reader.roster

    def poll(self):
        """Takes in what launch says."""
        self.roster.woken_ns = now_ns()
        self._reader.poll()


class Companion(Program):
    """A program that runs beside a stack. Derive, then call `run` on the class."""

    # Time between two looks. [s]
    PAUSE_S: ClassVar[float] = 0.008

    def __init__(self, guest, config):
        """Opens the ports, of a stack whose services may not have been started yet."""
        raise NotImplementedError

    def look(self, guest):
        """One look: takes in what has come."""
        raise NotImplementedError

    @classmethod
    def serve(cls, flags, config):
        asked, (signals, _writer) = catch_signals()
        # The stack comes first.
        with contextlib.suppress(OSError):
            os.nice(NICER)
        try:
            guest = Guest(flags)
            companion = cls(guest, config)
            while not (asked or guest.domain.is_orphaned()):
                guest.poll()
                companion.look(guest)
                select.select((signals,), (), (), cls.PAUSE_S)
        except StartError as error:
            log.error("%s", error)
            return error.exit_code
        except Exception:
            log.exception("the companion crashed")
            return EXIT_CRASH
        del companion
        guest.peer.leave()
        guest.domain.close()
        return EXIT_STOPPED
