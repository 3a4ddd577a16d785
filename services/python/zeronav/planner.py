"""A global planner without its search: inputs, when to plan again, and the path as waypoints."""

import numpy as np

from . import contract as c
from . import geometry
from .inputs import CurrentGoal, MapInput, OdometryReader
from .outputs import PathOutput
from .service import Service

# Length of the beginning of a path on which the robot may stand closer to things. [m]
BEGINNING_M = 1.0


class Planner(Service):
    """A program in the global planner's seat. Derive, name `key`, and write `search`; then call `run`.

    A path stays while it is free and leads to the current goal; the next one begins at the robot.
    """

    role = c.Role.GLOBAL_PLANNER
    # How the planner signs its paths: 24 letters at most.
    key = "python"

    def __init__(self, shell, config):
        self.config = config
        self.odometry = OdometryReader(shell.peer)
        self.map = MapInput(shell.peer, obstacles=True)
        self.goal = CurrentGoal(shell.peer)
        self.path, self._is_old = PathOutput(shell.peer, self.key), False

    def search(self, cells, start, end, progress):
        """Cells from `start` to `end`, each (row, column), or None when there is no way.

        `cells[row, column]` has the fields `cost`, `flags` and `clearance_mm`. A search calls
        `progress()` now and then: a service that shows none is taken for hanging.
        """
        raise NotImplementedError

    def wake(self, shell, rung):
        self.odometry.poll(shell.roster)
        mapped, asked = self.map.poll(shell), self.goal.poll(shell.roster)
        # A wake may bring a change without an answer that is due.
        self._is_old |= self.map.changed
        shell.count([self.odometry.stream, *self.map.readers, *self.goal.readers])
        for due in shell.due(**self.map.trigger(shell, self.odometry, mapped or asked)):
            self.goal.advance(shell.roster, due.tick)
            revision = self.map.replica.revision
            parents = {"odometry": self.odometry.id, "map": revision, "goal": self.goal.task}
            draft = self.map.begin(shell, due, parents)
            self._plan(shell)
            self.path.answer(shell, draft)

    def _plan(self, shell):
        goal, newest, replica = self.goal.goal, self.odometry.newest, self.map.replica
        if goal is None or newest is None or replica.revision == 0:
            return self.path.set(replica, c.PathStatus.NO_GOAL)
        if goal.id == self.path.goal and not self._is_old:
            return None
        self._is_old = False
        if goal.id == self.path.goal and is_free(replica, self.path.waypoints):
            return None
        robot = self.map.map_from_base(newest.meta.pose)
        start, end = (replica.cell_at(pose.x_m, pose.y_m) for pose in (robot, goal.pose))
        if start is None:
            return self.path.set(replica, c.PathStatus.START_OUTSIDE_MAP, goal.id)
        if end is None:
            return self.path.set(replica, c.PathStatus.GOAL_OUTSIDE_MAP, goal.id)
        cells = self.search(replica.cells, start, end, shell.progress)
        if not cells:
            return self.path.set(replica, c.PathStatus.UNREACHABLE, goal.id)
        waypoints = as_waypoints(replica, cells, goal.pose)
        if len(waypoints) > c.PLAN_PATH.len_max:
            return self.path.set(replica, c.PathStatus.TOO_LONG, goal.id)
        return self.path.set(replica, c.PathStatus.FOUND, goal.id, waypoints)


def blocks_centre(cost):
    """True where the robot's centre may not be."""
    return (cost == c.COST_INSCRIBED) | (cost == c.COST_LETHAL)


def is_free(replica, waypoints):
    """True when the robot's centre may be everywhere on a path but on its first metre."""
    if not len(waypoints):
        return False
    grid, length_m = replica.info.geometry, geometry.arc_of(waypoints)[-1]
    at_m = np.arange(min(BEGINNING_M, length_m), length_m, grid.resolution_m / 2)
    x, y = geometry.along(waypoints, at_m)
    columns = (x - grid.origin_x_m) / grid.resolution_m
    rows = (y - grid.origin_y_m) / grid.resolution_m
    return not blocks_centre(replica.cells["cost"][_nearest(replica.cells, rows, columns)]).any()


def as_waypoints(replica, cells, goal):
    """Waypoints where the cells change direction, and at both ends; the last one is the pose `goal`."""
    cells, grid = np.array(cells), replica.info.geometry
    steps = np.diff(cells, axis=0)
    corner = np.ones(len(cells), bool)
    corner[1:-1] = (steps[1:] != steps[:-1]).any(axis=1)
    rows, columns = _nearest(replica.cells, *cells[corner].T)
    waypoints = np.empty(len(rows), np.dtype(c.Waypoint))
    waypoints["x_m"] = grid.origin_x_m + columns * grid.resolution_m
    waypoints["y_m"] = grid.origin_y_m + rows * grid.resolution_m
    waypoints["clearance_m"] = replica.cells["clearance_mm"][rows, columns] / 1000
    waypoints["x_m"][-1], waypoints["y_m"][-1] = goal.x_m, goal.y_m
    yaw = np.arctan2(np.diff(waypoints["y_m"]), np.diff(waypoints["x_m"]))
    waypoints["yaw_rad"] = np.append(yaw, goal.yaw_rad)
    return waypoints


def _nearest(cells, rows, columns):
    """Indices of the cells of the map that are nearest to these places, in cells."""
    axes = zip((rows, columns), cells.shape)
    return tuple(np.clip(np.asarray(axis).astype(int), 0, side - 1) for axis, side in axes)
