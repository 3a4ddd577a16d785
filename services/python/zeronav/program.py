"""What the main programs of services and companions share: flags, configuration, logs, signals."""

import argparse
import logging
import signal
import socket
import sys
from dataclasses import dataclass

from . import parameters
from .contract import SHADOW_EPOCH_MIN
from .errors import EXIT_STOPPED, UsageError

LEVELS = {"error": 40, "warn": 30, "info": 20, "debug": 10, "trace": 5, "off": 100}
LOG_BYTES_MAX = 8 << 20


@dataclass(frozen=True)
class NoConfig:
    """The configuration of a program that has nothing to set."""


class Program:
    """What `run` needs of a program."""

    Config = NoConfig

    @classmethod
    def add_flags(cls, parser):
        """Adds the flags that only this kind of program has."""

    @classmethod
    def check_flags(cls, flags):
        """Accepts flags with which it can be started; UsageError otherwise."""

    @classmethod
    def serve(cls, flags, config):
        """Does its work until the end, and returns the exit code."""
        raise NotImplementedError


def run(kind):
    """`main` of a service or a companion: flags, configuration, ports, loop, exit code."""
    try:
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
        _start_log(flags.level)
        sys.exit(kind.serve(flags, config))
    sys.exit(EXIT_STOPPED)


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise UsageError(message)


def _flags(kind):
    parser = _Parser(description=(kind.__doc__ or "").split("\n")[0], allow_abbrev=False)
    parser.add_argument("--domain", metavar="ROOT", help="root folder of the run")
    parser.add_argument("--epoch", metavar="N", type=int, help="which start of it this is")
    parser.add_argument("--config", metavar="FILE", help="TOML; without it, defaults")
    parser.add_argument("--log-level", metavar="LEVEL", default="info", help=", ".join(LEVELS))
    parser.add_argument("--print-config", action="store_true", help="print the configuration")
    parser.add_argument("--print-params", action="store_true", help="print the parameters")
    kind.add_flags(parser)
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
        kind.check_flags(flags)
        if flags.epoch is not None and not 1 <= flags.epoch < SHADOW_EPOCH_MIN:
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


def catch_signals():
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
