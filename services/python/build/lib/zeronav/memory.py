"""Shared memory is checked before the first port and reserved before the service is ready."""

import errno
import os

from .errors import MemoryShortage, StartError

HEADROOM_BYTES = 1 << 20


def free_bytes():
    """Bytes free in /dev/shm."""
    status = os.statvfs("/dev/shm")
    return status.f_bavail * status.f_frsize


def check(needed):
    """Accepts `needed` more bytes and the headroom, which connections need."""
    needed, free = needed + HEADROOM_BYTES, free_bytes()
    if free < needed:
        raise MemoryShortage(needed, free)


def shortage(needed, error):
    """The error of a reservation."""
    if error.errno == errno.ENOSPC:
        return MemoryShortage(needed, free_bytes())
    return StartError(f"reserving shared memory: {error}")
