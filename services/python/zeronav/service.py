"""A service, and the loop that all of them share."""

import argparse
import ctypes
import gc
import logging
import signal
import socket
import sys
import time
from dataclasses import dataclass

from . import parameters
from .clock import now_ns
from .contract import SHADOW_EPOCH_MIN, Role
from .errors import EXIT_CRASH, EXIT_STOPPED, StartError, UsageError
from .peer import WAKE_AT_LEAST_NS
from .shell import Shell

log = logging.getLogger("zeronav")

LEVELS = {"error": 40, "warn": 30, "info": 20, "debug": 10, "trace": 5, "off": 100}
LOG_BYTES_MAX = 8 << 20
PR_SET_TIMERSLACK = 29
SEATS = (Role.MAPPING, Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER, Role.COLLISION_GUARD)
LOOK_NS = 50_000_000
GRACE_NS = 100_000_000
SOON_NS = 5_000_000
REST_LIMIT_NS = 1_500_000_000


@dataclass(frozen=True)
class NoConfig:
    """The configuration of a service that has nothing to set."""


class Service:
    """A program that takes the seat `role`. Derive, then call `run` on the class."""

    role: Role
    Config = NoConfig

    def __init__(self, shell, config):
        """Opens the ports. Nothing is known yet about the run."""
        raise NotImplementedError

    def wake(self, shell, rung):
        """One wake: poll the inputs, odometry first, and give the answers that are due."""
        raise NotImplementedError

    def is_at_rest(self):
        """True when the robot is stopped, as far as this service knows."""
        return False


def run(kind):
    """`main` of a service: flags, configuration, ports, loop, exit code."""
    try:
        if kind.role not in SEATS:
            raise UsageError(f"no service in Python can take the seat {kind.role.name.lower()}")
        flags = _flags(kind)
        config = parameters.read(kind.Config, flags.config)
    except UsageError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)
    if flags.print_params:
        print(parameters.as_json(kind.Config))
    elif flags.print_config:
        print(parameters.as_toml(config), end="")
    else:
        sys.exit(_serve(kind, flags, config))
    sys.exit(EXIT_STOPPED)


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise UsageError(message)


def _flags(kind):
    parser = _Parser(description=(kind.__doc__ or "").split("\n")[0], allow_abbrev=False)
    parser.add_argument("--domain", metavar="ROOT", help="root folder of the run")
    parser.add_argument("--epoch", metavar="N", type=int, help="which start of this role it is")
    parser.add_argument("--shadow", action="store_true", help="run beside the seat, never obeyed")
    parser.add_argument("--config", metavar="FILE", help="TOML; without it, defaults")
    parser.add_argument("--log-level", metavar="LEVEL", default="info", help=", ".join(LEVELS))
    parser.add_argument("--print-config", action="store_true", help="print the configuration")
    parser.add_argument("--print-params", action="store_true", help="print the parameters")
    flags = parser.parse_args()
    # Directives of one module, as in `warn,zeronav_mapping=debug`, are for the others.
    words = [word.strip().lower() for word in flags.log_level.split(",") if "=" not in word]
    for word in words:
        if word not in LEVELS:
            raise UsageError(f"--log-level: there is no level `{word}`; known are {', '.join(LEVELS)}")
    flags.level = LEVELS[words[-1]] if words else LEVELS["info"]
    if not (flags.print_config or flags.print_params):
        if flags.domain is None:
            raise UsageError("--domain ROOT is needed")
        if flags.shadow == (flags.epoch is not None):
            raise UsageError("either --epoch N or --shadow is needed")
        if not flags.shadow and not 1 <= flags.epoch < SHADOW_EPOCH_MIN:
            raise UsageError(f"--epoch {flags.epoch}: must be 1 to {SHADOW_EPOCH_MIN - 1}")
    return flags


class _Bounded:
    """Standard error up to a size; a log must not stop its process."""

    def __init__(self):
        self._left = LOG_BYTES_MAX

    def write(self, text):
        size = len(text.encode(errors="replace"))
        if self._left <= 0:
            return
        if size >= self._left:
            text = "the log is full, nothing more is written\n"
        self._left = self._left - size if size < self._left else 0
        try:
            sys.stderr.write(text)
        except OSError:
            pass

    def flush(self):
        try:
            sys.stderr.flush()
        except OSError:
            pass


def _start_log(level):
    handler = logging.StreamHandler(_Bounded())
    handler.setFormatter(
        logging.Formatter("%(asctime)s %(levelname)5s %(message)s", "%Y-%m-%dT%H:%M:%S")
    )
    logging.basicConfig(level=level, handlers=[handler])


def _catch_signals():
    """A set that gets the signals that ask the process to stop, and a socket that they wake."""
    asked, (reader, writer) = set(), socket.socketpair()
    for end in (reader, writer):
        end.setblocking(False)
    signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    stopping = [signal.SIGTERM, signal.SIGINT, signal.SIGQUIT]
    # A hang-up that is ignored from the start (nohup) stays ignored.
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        stopping.append(signal.SIGHUP)
    for number in stopping:
        signal.signal(number, lambda number, _frame: asked.add(number))
    return asked, (reader, writer)


def _serve(kind, flags, config):
    _start_log(flags.level)
    asked, (signals, _writer) = _catch_signals()
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
