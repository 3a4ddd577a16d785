"""The one clock of a host, and the fault that a process reads another time than the others."""

import logging
import time

log = logging.getLogger("zeronav")

_offset_ns = 0


def now_ns():
    """`CLOCK_MONOTONIC`, comparable between all processes of this host, unless launch puts the clock
    of this one forward on purpose. [ns]"""
    return time.monotonic_ns() + _offset_ns


def put_forward(offset_ns):
    """Puts the clock of this process forward, or back. [ns]"""
    global _offset_ns
    if offset_ns != _offset_ns:
        log.warning("the clock of this process is put forward offset_ns=%d", offset_ns)
        _offset_ns = offset_ns
