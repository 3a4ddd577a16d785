"""A domain: the private corner of shared memory in which one robot's stack lives.

Every user of the machine may make files in /dev/shm, so a folder or file counts only when it is a
real one that belongs to the caller. Members hold a shared lock on `ROOT/lock`; the maker of the
domain holds `ROOT/launch` for as long as it lives.
"""

import contextlib
import fcntl
import os
import shutil
import stat
import time

import iceoryx2 as iox2

from .errors import StartError, UsageError
from .memory import shortage

SHM = "/dev/shm"
NODE_COUNTER = "_node.0_10_0.global_mgmt"
NODE_COUNTER_BYTES = 16
TURN_LIMIT_S = 1.0
CREATION_LIMIT_S = 60


def _open_own(name, flags, folder=None):
    """Descriptor of a regular file of the caller. Follows no link and waits for nothing."""
    flags |= os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    descriptor = os.open(name, flags, 0o600, dir_fd=folder)
    status = os.fstat(descriptor)
    if status.st_uid != os.geteuid() or not stat.S_ISREG(status.st_mode):
        os.close(descriptor)
        raise PermissionError(f"{name} is not a file of this user")
    return descriptor


def try_lock(descriptor, how):
    """Takes a lock without waiting; True when it was free."""
    try:
        fcntl.flock(descriptor, how | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def segments(prefix):
    """The caller's own files in /dev/shm whose names begin with `prefix`."""
    for entry in os.scandir(SHM):
        if not entry.name.startswith(prefix):
            continue
        with contextlib.suppress(FileNotFoundError):
            status = entry.stat(follow_symlinks=False)
            if stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid():
                yield entry


class Domain:
    """Membership in the domain whose root folder is `root`."""

    def __init__(self, root):
        name = os.path.basename(root)
        if os.path.dirname(root) != SHM or not 4 <= len(name) <= 40:
            problem = "not a folder directly under /dev/shm with a name of 4 to 40 letters"
            raise UsageError(f"--domain {root}: {problem}")
        self.root, self.prefix = root, f"{name}_"
        self._folder = self._open_folder()
        self._member = self._lock()
        try:
            self._launch = self.open("launch", os.O_RDONLY)
            self._check_node_counter()
        except OSError as error:
            raise StartError(f"--domain {root}: {error}") from error

    def _open_folder(self):
        flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            folder = os.open(self.root, flags)
        except FileNotFoundError:
            problem = "no such folder; the run is over or was never started"
            raise UsageError(f"--domain {self.root}: {problem}") from None
        except OSError as error:
            raise UsageError(f"--domain {self.root}: {error.strerror}") from None
        status = os.fstat(folder)
        if status.st_uid != os.geteuid() or stat.S_IMODE(status.st_mode) != 0o700:
            raise UsageError(f"--domain {self.root}: not a run of this user")
        return folder

    def _lock(self):
        for _ in range(100):
            try:
                lock = self.open("lock", os.O_RDWR | os.O_CREAT)
            except OSError as error:
                raise UsageError(f"--domain {self.root}: {error}") from None
            if not try_lock(lock, fcntl.LOCK_SH):
                break
            # A sweeper may have unlinked the file between open and lock: then try again.
            with contextlib.suppress(FileNotFoundError):
                there = os.stat("lock", dir_fd=self._folder, follow_symlinks=False)
                if os.path.samestat(there, os.fstat(lock)):
                    return lock
            os.close(lock)
        raise UsageError(f"--domain {self.root}: the domain is being removed")

    def _check_node_counter(self):
        # The middleware waits for ever for an empty one.
        for entry in segments(self.prefix):
            if entry.name.endswith(NODE_COUNTER) and entry.stat().st_size >= NODE_COUNTER_BYTES:
                return
        raise OSError("the counter of nodes is missing or corrupt")

    def open(self, name, flags):
        """Descriptor of a file of the domain's folder."""
        return _open_own(name, flags, self._folder)

    def is_orphaned(self):
        """True when the maker of the domain is gone; never False again after that."""
        return try_lock(self._launch, fcntl.LOCK_SH)

    def config(self):
        """The middleware's configuration for this domain."""
        config = iox2.config.default()
        # What dead members left is removed by a process of its own.
        config.global_cfg.node.cleanup_dead_nodes_on_creation = False
        config.global_cfg.node.cleanup_dead_nodes_on_destruction = False
        config.global_cfg.service.cleanup_dead_nodes_on_open = False
        # Another member that makes something may get no processor for a while.
        config.global_cfg.creation_timeout = iox2.Duration.from_secs(CREATION_LIMIT_S)
        config.global_cfg.prefix = iox2.FileName.new(self.prefix)
        config.global_cfg.root_path = iox2.Path.new(self.root)
        return config

    def reserve(self, publisher, topic):
        """Reserves the segment of a writer: a full /dev/shm would kill it in the middle of a drive."""
        tail, reserved = f"_{publisher}.data", False
        for entry in segments(self.prefix):
            if entry.name.endswith(tail):
                descriptor = _open_own(entry.path, os.O_RDWR)
                size = os.fstat(descriptor).st_size
                try:
                    os.posix_fallocate(descriptor, 0, size)
                except OSError as error:
                    raise shortage(size, error) from error
                finally:
                    os.close(descriptor)
                reserved = True
        if not reserved:
            raise StartError(f"reserving shared memory of {topic}: segment not found")

    def close(self):
        """Leaves the domain and removes it, if this was its last member."""
        os.close(self._member)
        os.close(self._launch)
        deadline_s = time.monotonic() + TURN_LIMIT_S
        while not try_lock(self._folder, fcntl.LOCK_EX):
            if time.monotonic() > deadline_s:
                return
            time.sleep(0.001)
        with contextlib.suppress(OSError):
            if os.fstat(self._folder).st_nlink > 0:
                lock = self.open("lock", os.O_RDWR | os.O_CREAT)
                if try_lock(lock, fcntl.LOCK_EX):
                    for entry in list(segments(self.prefix)):
                        os.remove(entry.path)
                    shutil.rmtree(self.root)
                os.close(lock)
        os.close(self._folder)
