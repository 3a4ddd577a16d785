"""The seat of a role: one process at a time holds the lock of `ROOT/seat.ROLE`."""

import fcntl
import os
import time

from .contract import SHADOW_EPOCH_MIN
from .domain import try_lock
from .errors import UsageError

TAKE_LIMIT_S = 0.2
TAKE_PAUSE_S = 0.005


def shadow_epoch():
    """An epoch that is never obeyed, one for each shadow."""
    return SHADOW_EPOCH_MIN | (os.getpid() & (SHADOW_EPOCH_MIN - 1))


class Seat:
    """A taken seat, held until the process ends."""

    def __init__(self, domain, role):
        self._name, self._role = f"seat.{role.name.lower()}", role
        self._file = self._handed_over(domain)
        self.is_from_launch = self._file is not None
        if self._file is None:
            self._file = self._take(domain)
        owner = f"{os.getpid()}\n".encode()
        os.pwrite(self._file, owner, 0)
        os.ftruncate(self._file, len(owner))

    def _handed_over(self, domain):
        """The seat that launch gave as standard input; any other file there does not count."""
        try:
            seat = domain.open(self._name, os.O_RDONLY)
            same = os.path.samestat(os.fstat(0), os.fstat(seat))
            os.close(seat)
        except OSError:
            return None
        return os.dup(0) if same and try_lock(0, fcntl.LOCK_EX) else None

    def _take(self, domain):
        file = domain.open(self._name, os.O_CREAT | os.O_RDWR)
        deadline_s = time.monotonic() + TAKE_LIMIT_S
        # Others look at the lock by taking it for a moment.
        while not try_lock(file, fcntl.LOCK_EX):
            if time.monotonic() > deadline_s:
                owner = os.pread(file, 16, 0).decode(errors="replace").strip()
                raise UsageError(
                    f"the seat of {self._role.name.lower()} is taken by process {owner or '?'}; "
                    "with --shadow a process runs beside it and is never obeyed"
                )
            time.sleep(TAKE_PAUSE_S)
        return file
