#!/usr/bin/env python3
"""A global planner in Python: A* on blocks of four by four cells.

A path stays while it is free and leads to the current goal; the next one begins at the robot.
"""

import heapq
import math

import numpy as np

from zeronav import CurrentGoal, MapInput, OdometryReader, PathOutput, Service, run
from zeronav.contract import COST_INSCRIBED, COST_LETHAL, PathStatus, Role, Waypoint

BLOCK = 4
STEPS = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]


class AStar(Service):
    """A* on a coarse grid."""

    role = Role.GLOBAL_PLANNER

    def __init__(self, shell, _config):
        self.odometry = OdometryReader(shell.peer)
        self.map = MapInput(shell.peer, obstacles=True)
        self.goal = CurrentGoal(shell.peer)
        self.path, self.is_old = PathOutput(shell.peer, "astar_py"), False

    def wake(self, shell, rung):
        self.odometry.poll(shell.roster)
        mapped, asked = self.map.poll(shell), self.goal.poll(shell.roster)
        # A wake may bring a change without an answer that is due.
        self.is_old |= self.map.changed
        shell.count([self.odometry.stream, *self.map.readers, *self.goal.readers])
        for due in shell.due(**self.map.trigger(shell, self.odometry, mapped or asked)):
            self.goal.advance(shell.roster, due.tick)
            revision = self.map.replica.revision
            parents = {"odometry": self.odometry.id, "map": revision, "goal": self.goal.task}
            draft = self.map.begin(shell, due, parents)
            self.plan(shell)
            self.path.answer(shell, draft)

    def plan(self, shell):
        goal, newest, replica = self.goal.goal, self.odometry.newest, self.map.replica
        if goal is None or newest is None or replica.revision == 0:
            return self.path.set(replica, PathStatus.NO_GOAL)
        if goal.id == self.path.goal and not self.is_old:
            return None
        self.is_old = False
        if goal.id == self.path.goal and len(self.path.waypoints) and self.is_free(replica):
            return None
        robot = self.map.map_from_base(newest.meta.pose)
        start, end = (replica.cell_at(pose.x_m, pose.y_m) for pose in (robot, goal.pose))
        if start is None or end is None:
            outside = PathStatus.START_OUTSIDE_MAP if start is None else PathStatus.GOAL_OUTSIDE_MAP
            return self.path.set(replica, outside, goal.id)
        blocks = search(replica.cells, start, end, shell.progress)
        if blocks is None:
            return self.path.set(replica, PathStatus.UNREACHABLE, goal.id)
        waypoints = as_waypoints(replica, blocks, goal.pose)
        return self.path.set(replica, PathStatus.FOUND, goal.id, waypoints)

    def is_free(self, replica):
        """True when the robot's centre may be everywhere on the path but on its first metre."""
        path, grid = self.path.waypoints, replica.info.geometry
        x, y = path["x_m"], path["y_m"]
        arc = np.concatenate(([0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
        at = np.arange(min(1.0, arc[-1]), arc[-1], grid.resolution_m / 2)
        columns = (np.interp(at, arc, x) - grid.origin_x_m) / grid.resolution_m
        rows = (np.interp(at, arc, y) - grid.origin_y_m) / grid.resolution_m
        cost = replica.cells["cost"][nearest(replica.cells, rows, columns)]
        return not ((cost == COST_INSCRIBED) | (cost == COST_LETHAL)).any()


def search(cells, start, end, progress):
    """Blocks from the cell `start` to the cell `end`; None when there is no way."""
    # Beyond the edge of the map lies an obstacle.
    beyond = [(0, -side % BLOCK) for side in cells.shape]
    cost = np.pad(cells["cost"], beyond, constant_values=COST_LETHAL)
    height, width = (side // BLOCK for side in cost.shape)
    parts = cost.reshape(height, BLOCK, width, BLOCK)
    blocked = ((parts == COST_INSCRIBED) | (parts == COST_LETHAL)).any((1, 3))
    start, end = ((row // BLOCK, column // BLOCK) for row, column in (start, end))
    # The robot may stand closer to an obstacle than a path would lead it.
    near = (slice(max(0, start[0] - 3), start[0] + 4), slice(max(0, start[1] - 3), start[1] + 4))
    blocked[near] = (parts == COST_LETHAL).any((1, 3))[near]
    blocked[start] = False
    blocked = np.pad(blocked, 1, constant_values=True)
    weight = np.pad(1 + parts.max((1, 3)) / 64, 1).tolist()
    (row, column), (end_row, end_column) = ((y + 1, x + 1) for y, x in (start, end))
    costs, parents, free = {(row, column): 0.0}, {}, (~blocked).tolist()
    queue = [(0.0, row, column)]
    for expanded in range(blocked.size * 8):
        if not queue:
            return None
        _, row, column = heapq.heappop(queue)
        if (row, column) == (end_row, end_column):
            break
        if expanded % 500 == 0:
            progress()
        for dy, dx in STEPS:
            y, x = row + dy, column + dx
            if not (free[y][x] and free[row][x] and free[y][column]):
                continue
            cost = costs[row, column] + math.hypot(dy, dx) * weight[y][x]
            if cost < costs.get((y, x), math.inf):
                costs[y, x], parents[y, x] = cost, (row, column)
                rest = math.hypot(end_row - y, end_column - x)
                heapq.heappush(queue, (cost + rest, y, x))
    blocks = [(end_row, end_column)]
    while blocks[-1] in parents:
        blocks.append(parents[blocks[-1]])
    return [(y - 1, x - 1) for y, x in reversed(blocks)]


def nearest(cells, rows, columns):
    """Indices of the cells of the map that are nearest to these places, in cells."""
    axes = zip((rows, columns), cells.shape)
    return tuple(np.clip(np.asarray(axis).astype(int), 0, side - 1) for axis, side in axes)


def as_waypoints(replica, blocks, goal):
    """Waypoints where the blocks change direction, and at both ends."""
    cells, grid = np.array(blocks) * BLOCK + BLOCK // 2, replica.info.geometry
    steps = np.diff(cells, axis=0)
    corner = np.ones(len(cells), bool)
    corner[1:-1] = (steps[1:] != steps[:-1]).any(axis=1)
    rows, columns = nearest(replica.cells, *cells[corner].T)
    waypoints = np.empty(len(rows), np.dtype(Waypoint))
    waypoints["x_m"] = grid.origin_x_m + columns * grid.resolution_m
    waypoints["y_m"] = grid.origin_y_m + rows * grid.resolution_m
    waypoints["clearance_m"] = replica.cells["clearance_mm"][rows, columns] / 1000
    waypoints["x_m"][-1], waypoints["y_m"][-1] = goal.x_m, goal.y_m
    yaw = np.arctan2(np.diff(waypoints["y_m"]), np.diff(waypoints["x_m"]))
    waypoints["yaw_rad"] = np.append(yaw, goal.yaw_rad)
    return waypoints


if __name__ == "__main__":
    run(AStar)
