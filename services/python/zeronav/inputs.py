"""Inputs that several services read alike: odometry, the map, the current goal."""

from collections import deque

from . import contract as c
from .geometry import compose, wrap
from .replica import MapReplica

HISTORY = 64
REST_MESSAGES = 5
REST_MPS, REST_RADPS = 0.02, 0.05
ASK_PAUSE_NS = 20_000_000
OBSTACLES_AGE_NS_MAX = 500_000_000


class OdometryReader:
    """Reads `robot/odometry`. Every service polls it before its other inputs."""

    def __init__(self, peer):
        self.stream = peer.stream(c.ROBOT_ODOMETRY)
        self._history = deque(maxlen=HISTORY)

    def poll(self, roster):
        """Takes in what has come; True when there is newer odometry than before."""
        before = self.id

        def see(view):
            message = view.envelope.copy()
            message.came_ns = view.came_ns
            last = self._history[-1] if self._history else None
            head = message.header
            if last and (last.header.id >> 40 != head.id >> 40 or last.header.run_ns >= head.run_ns):
                self._history.clear()
            self._history.append(message)

        self.stream.drain(roster, see)
        return self.id != before

    @property
    def newest(self):
        """The newest message, with `header`, `meta` and `came_ns`; None before the first."""
        return self._history[-1] if self._history else None

    @property
    def id(self):
        """Identity of the newest message; 0 before the first."""
        return self._history[-1].header.id if self._history else 0

    @property
    def tick(self):
        """Tick of the newest message; 0 before the first."""
        return self._history[-1].header.tick if self._history else 0

    @property
    def scan_due(self):
        """True when the newest message came with a scan."""
        return bool(self._history) and self._history[-1].meta.scan_due == 1

    def age_ns(self, draft, lockstep):
        """Age of the newest message at the beginning of an answer; None before the first. [ns]"""
        newest = self.newest
        if newest is None:
            return None
        if lockstep:
            return max(0, draft.run_ns - newest.header.run_ns)
        return max(0, draft.started_ns - min(newest.header.capture_ns, newest.came_ns))

    def is_at_rest(self):
        """True when the robot is stopped, by the newest messages."""
        last = list(self._history)[-REST_MESSAGES:]
        return len(last) == REST_MESSAGES and all(
            abs(one.meta.v_mps) < REST_MPS and abs(one.meta.w_radps) < REST_RADPS for one in last
        )

    def pose_at(self, run_ns):
        """`odom_from_base` at a run time within the history; None outside of it."""
        earlier = None
        for one in self._history:
            if one.header.run_ns >= run_ns:
                break
            earlier = one
        else:
            return None
        pose = one.meta.pose
        if one.header.run_ns == run_ns:
            return pose
        if earlier is None:
            return None
        span_ns = one.header.run_ns - earlier.header.run_ns
        share, start = (run_ns - earlier.header.run_ns) / span_ns, earlier.meta.pose
        return c.Pose(
            start.x_m + share * (pose.x_m - start.x_m),
            start.y_m + share * (pose.y_m - start.y_m),
            wrap(start.yaw_rad + share * wrap(pose.yaw_rad - start.yaw_rad)),
        )


class MapInput:
    """Reads `map/update` and `map/keyframe` into a copy of the map, `replica`."""

    def __init__(self, peer, obstacles=False):
        """With `obstacles`, the tracked ones are written on the copy as static discs."""
        # Updates before the keyframe, so that none is missed between the two.
        self.updates = peer.stream(c.MAP_UPDATE)
        self.keyframe = peer.latest(c.MAP_KEYFRAME)
        self.obstacles = peer.latest(c.MAP_OBSTACLES) if obstacles else None
        self.replica = MapReplica()
        self.changed = False
        # Header of the newest complete update, and when it came in.
        self.newest, self.came_ns = c.Header(), 0
        self._asked_ns = -ASK_PAUSE_NS

    def poll(self, shell):
        """Takes in what has come and asks for a keyframe if only that helps; True when the last
        part of a revision came in."""
        roster, completed = shell.roster, False
        # Whether a map that its author left before this process began came in on the way depends on
        # the speed of the machine.
        author = self.replica.revision >> 40
        if author and roster.lockstep and roster.began_after(c.Role.MAPPING, author):
            self.replica, self.newest = MapReplica(), c.Header()

        def see(view):
            nonlocal completed
            self.replica.update(view.id, view.meta, view.items)
            if view.meta.part + 1 == view.meta.parts:
                self.newest, self.came_ns = view.header.copy(), view.came_ns
                completed = True

        self.updates.drain(roster, see)
        if self.keyframe.poll(roster):
            view = self.keyframe.get()
            self.replica.keyframe(view.meta, view.items)
            del view
        self.keyframe.release()
        self.changed = self.replica.take_changed()
        if self.obstacles is not None:
            self._stamp(roster)
        late = shell.woken_ns - self._asked_ns >= ASK_PAUSE_NS
        if not self.replica.in_step and roster.has_clock and late:
            self._asked_ns = shell.woken_ns
            shell.ring_event(c.Role.MAPPING, c.EVENT_NEED_KEYFRAME)
        return completed

    def _stamp(self, roster):
        if not self.obstacles.poll(roster) and not self.changed:
            return
        view = self.obstacles.get()
        old = view is None or self.newest.run_ns - view.header.run_ns > OBSTACLES_AGE_NS_MAX
        self.replica.stamp(() if old else view.items)
        self.changed = self.replica.take_changed() or self.changed

    def trigger(self, shell, odometry, news):
        """The trigger of a service that answers every map: arguments of `Shell.due`."""
        roster, newest = shell.roster, self.newest
        if roster.lockstep:
            tick = odometry.tick if odometry.scan_due else 0
            complete = not roster.answers(c.Role.MAPPING, tick) or (
                newest.tick >= tick and self.replica.in_step
            )
            return {"tick": tick, "complete": complete}
        return {"tick": newest.tick, "news": news}

    def begin(self, shell, due, parents):
        """Begins an answer to the newest map."""
        newest = self.newest
        run_ns = newest.run_ns if due.tick == newest.tick else shell.run_ns(due.tick)
        return shell.begin(due, run_ns, newest.capture_ns, parents)

    def map_from_base(self, odom_from_base):
        """Where the robot is on the map."""
        return compose(self.replica.info.map_from_odom, odom_from_base)

    @property
    def is_current(self):
        """True when there is a map without a gap and mapping still receives scans."""
        return self.replica.in_step and self.replica.info.current == 1

    @property
    def readers(self):
        """The readers, for `Shell.count`."""
        return [self.updates, self.keyframe] + ([self.obstacles] if self.obstacles else [])


class Tasks:
    """Reads `task/goal`. In lockstep a task holds from a named tick."""

    def __init__(self, peer):
        self.reader = peer.latest(c.TASK_GOAL)
        self.current = self._next = None

    def poll(self, roster):
        """Takes in what has come; True when there is a new task."""
        if not self.reader.poll(roster):
            return False
        self._next = Task(self.reader.get())
        return True

    def at(self, tick):
        """The task that holds at `tick`; None before the first."""
        if self._next is not None and self._next.from_tick <= tick:
            self.current, self._next = self._next, None
        return self.current


class Task:
    """A task, copied out of shared memory: `id`, `kind`, `from_tick`, `goals`."""

    def __init__(self, view):
        self.id, self.kind, self.from_tick = view.id, view.meta.kind, view.meta.from_tick
        size = c.Goal.SIZE
        data = view.items.tobytes()
        self.goals = [
            c.Goal.from_buffer_copy(data, place) for place in range(0, len(data), size)
        ]


class CurrentGoal:
    """Reads `task/goal` and `task/status`: where the robot has to go now."""

    def __init__(self, peer):
        self.tasks = Tasks(peer)
        self.status = peer.stream(c.TASK_STATUS)
        # Tick, task, goal and state of the last two statuses.
        self._statuses = deque([(0, 0, 0, 0)] * 2, maxlen=2)
        self._before_tick = None

    def poll(self, roster):
        """Takes in what has come; True when there is a new task, or another goal or state of it."""
        news = self.tasks.poll(roster)

        def see(view):
            nonlocal news
            meta = view.meta
            status = (view.tick, meta.task, meta.goal, meta.state)
            news = news or status[1:] != self._statuses[-1][1:]
            self._statuses.append(status)

        self.status.drain(roster, see)
        return news

    def advance(self, roster, tick):
        """Takes the task that holds at `tick`. In lockstep a status counts from the next tick on."""
        if tick > 0:
            self.tasks.at(tick)
            self._before_tick = tick if roster.lockstep else None

    @property
    def goal(self):
        """The goal; None without a task, or when it is over."""
        task = self.tasks.current
        if task is None or task.kind != c.TaskKind.GO:
            return None
        current = 0
        for tick, of, goal, state in reversed(self._statuses):
            if of == task.id and (self._before_tick is None or tick < self._before_tick):
                if state not in (c.TaskState.IDLE, c.TaskState.ACTIVE):
                    return None
                current = goal
                break
        return next((goal for goal in task.goals if goal.id == current), task.goals[0])

    @property
    def task(self):
        """Identity of the task that holds; 0 before the first."""
        return self.tasks.current.id if self.tasks.current else 0

    @property
    def readers(self):
        """The readers, for `Shell.count`."""
        return [self.tasks.reader, self.status]
