"""A service, and the loop that all of them share."""

import ctypes
import gc
import logging
import time

from .clock import now_ns
from .contract import Role
from .errors import EXIT_CRASH, EXIT_STOPPED, StartError, UsageError
from .peer import WAKE_AT_LEAST_NS
from .program import Program, catch_signals
from .shell import Shell

log = logging.getLogger("zeronav")

PR_SET_TIMERSLACK = 29
SEATS = (Role.MAPPING, Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER, Role.COLLISION_GUARD)
LOOK_NS = 50_000_000
GRACE_NS = 100_000_000
SOON_NS = 5_000_000
REST_LIMIT_NS = 1_500_000_000


class Service(Program):
    """A program that takes the seat `role`. Derive, then call `run` on the class."""

    role: Role

    def __init__(self, shell, config):
        """Opens the ports. Nothing is known yet about the run."""
        raise NotImplementedError

    def wake(self, shell, rung):
        """One wake: poll the inputs, odometry first, and give the answers that are due."""
        raise NotImplementedError

    def is_at_rest(self):
        """True when the robot is stopped, as far as this service knows."""
        return False

    @classmethod
    def add_flags(cls, parser):
        if cls.role not in SEATS:
            raise UsageError(f"no service in Python can take the seat {cls.role.name.lower()}")
        parser.add_argument(
            "--shadow", action="store_true", help="run beside the seat, never obeyed"
        )

    @classmethod
    def check_flags(cls, flags):
        if flags.shadow == (flags.epoch is not None):
            raise UsageError("either --epoch N or --shadow is needed")

    @classmethod
    def serve(cls, flags, config):
        return _serve(cls, flags, config)


def _serve(kind, flags, config):
    asked, (signals, _writer) = catch_signals()
    # The default slack of 50 us would be a large part of every wait.
    ctypes.CDLL(None).prctl(PR_SET_TIMERSLACK, 1)
    try:
        shell = Shell(flags, kind.role, signals)
        service = kind(shell, config)
    except StartError as error:
        log.error("%s", error)
        return error.exit_code
    except OSError as error:
        log.error("starting the service: %s", error)
        return EXIT_CRASH
    # What has been made so far stays for life: the collector need not look at it again.
    gc.collect()
    gc.freeze()
    leaving = _Leaving(asked, kind.role)
    try:
        _loop(shell, service, leaving)
    except StartError as error:
        log.error("%s", error)
        return error.exit_code
    except Exception:
        log.exception("the service crashed")
        return EXIT_CRASH
    shell.stopping()
    del service
    domain = shell.leave()
    if leaving.is_orphaned:
        domain.close()
    return EXIT_STOPPED


def _loop(shell, service, leaving):
    deadline_ns = 0
    while True:
        rung = shell.wait(deadline_ns)
        if leaving.look(shell):
            return
        shell.progress()
        # Before it is known who is obeyed, every message on a stream would be refused and lost.
        if shell.roster.is_known:
            service.wake(shell, rung)
        shell.ring()
        shell.beat()
        if leaving.rests(shell, service):
            return
        deadline_ns = now_ns() + WAKE_AT_LEAST_NS
        for other_ns in (shell.wake_by_ns, leaving.deadline_ns()):
            if other_ns is not None:
                deadline_ns = min(deadline_ns, other_ns)


class _Leaving:
    """When a service leaves: soon when it is asked to, with the robot at rest when launch is gone."""

    def __init__(self, asked, role):
        self._asked, self._role = asked, role
        self._asked_ns = self._orphaned_ns = None
        self._look_ns = 0

    @property
    def is_orphaned(self):
        """True when launch is gone."""
        return self._orphaned_ns is not None

    def look(self, shell):
        """One look before a wake; True when the service shall leave at once."""
        host_ns = time.monotonic_ns()
        if self.is_orphaned:
            return False
        if self._asked and self._asked_ns is None:
            self._asked_ns = host_ns
        if self._asked_ns is not None or host_ns >= self._look_ns:
            self._look_ns = host_ns + LOOK_NS
            if shell.domain.is_orphaned():
                log.warning("launch is gone, leaving role=%s", self._role.name.lower())
                self._orphaned_ns = host_ns
                shell.come_to_rest()
                return not self._brings_to_rest(shell)
        # The signal may be the kernel's, and the lock of a launch that dies may last a little longer.
        at_rest = not shell.roster.is_known or shell.roster.control.stopping == 1
        return self._asked_ns is not None and (at_rest or host_ns >= self._asked_ns + GRACE_NS)

    def _brings_to_rest(self, shell):
        """True between the requests and the wheels of a robot that runs in real time."""
        at_the_wheels = self._role in (Role.LOCAL_PLANNER, Role.COLLISION_GUARD)
        known = shell.roster.is_known and not shell.roster.lockstep
        return at_the_wheels and shell.seat is not None and known

    def rests(self, shell, service):
        """One look after a wake; True when launch is gone and nothing is left to do."""
        if not self.is_orphaned:
            return False
        if time.monotonic_ns() >= self._orphaned_ns + REST_LIMIT_NS:
            log.warning("the robot did not come to rest in time")
            return True
        return service.is_at_rest()

    def deadline_ns(self):
        """When the next look is due at the latest."""
        soon = self._asked_ns is not None or self.is_orphaned
        return now_ns() + SOON_NS if soon else None
