"""Outputs that planners write alike: the path, and what became of the task."""

import numpy as np

from . import contract as c
from . import messages
from .inputs import Tasks

NO_WAYPOINTS = np.empty(0, np.dtype(c.Waypoint))
STATUS_TICKS = 10
END_REASONS = {
    c.PathStatus.UNREACHABLE: c.EndReason.UNREACHABLE,
    c.PathStatus.GOAL_BLOCKED: c.EndReason.GOAL_BLOCKED,
    c.PathStatus.GOAL_OUTSIDE_MAP: c.EndReason.GOAL_OUTSIDE_MAP,
}


class PathOutput:
    """Writes `plan/path`: the same path in every answer until there is another."""

    def __init__(self, peer, planner):
        """`planner` is the planner's key."""
        self.waypoints = NO_WAYPOINTS
        self.message = messages.path(planner, c.PathStatus.NO_GOAL, c.PathCause.NONE, 0, NO_WAYPOINTS)
        self._planner = planner
        self._writer = peer.writer(c.PLAN_PATH, c.PLAN_PATH.len_max)

    @property
    def goal(self):
        """Id of the goal that the path belongs to; 0 without one."""
        return self.message.goal

    def set(self, replica, status, goal=0, waypoints=NO_WAYPOINTS):
        """The path from now on, found on `replica`; a failure that goes on keeps its identity."""
        old = self.message
        if not len(waypoints) and (status, goal) == (old.status, old.goal):
            return
        cause = c.PathCause.OBSTACLE if goal == old.goal else c.PathCause.GOAL
        self.message = messages.path(self._planner, status, cause if goal else 0, goal, waypoints)
        self.message.geometry, self.message.searched_map = self._writer.next_id, replica.revision
        self.waypoints = waypoints

    def answer(self, shell, draft):
        """Answers with the path."""
        shell.answer(draft, self._writer, self.message, self.waypoints)


class TaskProgress:
    """The task of a local planner, one goal after the other, and `task/status`."""

    def __init__(self, peer):
        self.tasks = Tasks(peer)
        self.status = c.TaskStatus()
        self._ended, self._task = [], None
        self._writer = peer.writer(c.TASK_STATUS, c.TASK_STATUS.len_max)
        self._sent, self._sent_tick = b"", 0

    def poll(self, roster):
        """Takes in what has come."""
        self._writer.refresh()
        self.tasks.poll(roster)

    def begin(self, tick):
        """Takes the task that holds at `tick`; True when it is another than before."""
        task = self.tasks.at(tick) if tick else None
        if task is None or task is self._task:
            return False
        self._task, self._ended = task, []
        goes = task.kind == c.TaskKind.GO
        state = c.TaskState.ACTIVE if goes else c.TaskState.CANCELLED
        goal = task.goals[0].id if goes else 0
        self.status = c.TaskStatus(state=state, task=task.id, goal=goal)
        return True

    @property
    def goal(self):
        """The current goal; None without one."""
        if self.status.state != c.TaskState.ACTIVE:
            return None
        return self._task.goals[len(self._ended)]

    def end_goal(self, tick, state, reason=c.EndReason.NONE):
        """The current goal has ended: on to the next one, or the task has ended, too."""
        self._ended.append(c.GoalEnd(self.status.goal, tick, state, reason))
        self.status.n_ended = len(self._ended)
        if len(self._ended) < len(self._task.goals):
            self.status.goal = self._task.goals[len(self._ended)].id
        else:
            self.status.state, self.status.reason, self.status.goal = state, reason, 0

    def end_by(self, tick, path):
        """The current goal has failed if the planner says so of it in `plan/path`."""
        reason = END_REASONS.get(path.meta.status) if path else None
        if reason and path.meta.goal == self.status.goal:
            self.end_goal(tick, c.TaskState.FAILED, reason)

    def send(self, shell, draft):
        """Sends the status as part of an answer when it has changed, and every ten ticks."""
        late = draft.tick >= self._sent_tick + STATUS_TICKS or draft.tick == 0
        if late or bytes(self.status) != self._sent:
            shell.send(draft, self._writer, self.status, self._ended)
            self._sent, self._sent_tick = bytes(self.status), draft.tick

    @property
    def readers(self):
        """The readers, for `Shell.count`."""
        return [self.tasks.reader]
