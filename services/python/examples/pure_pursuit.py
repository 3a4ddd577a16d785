#!/usr/bin/env python3
"""A local planner in Python: pure pursuit of the path, slower before what the scan shows.

Source: Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", 1992.
"""

import math
from dataclasses import dataclass

import numpy as np

from zeronav import MapInput, OdometryReader, Service, TaskProgress, param, run, wrap
from zeronav import contract as c


@dataclass(frozen=True)
class Config:
    """What can be set."""

    lookahead_m: float = param(0.6, "Distance of the pursued point along the path.", "m", 0.1, 5.0)
    v_mps: float = param(1.0, "Fastest speed, within the robot's limits.", "m/s", 0.05, 10.0)
    turn_rad: float = param(0.6, "Heading error beyond which it turns in place.", "rad", 0.1, 3.0)
    margin_m: float = param(0.3, "Distance kept to what lies ahead.", "m", 0.0, 5.0)
    age_s: float = param(0.5, "Age of odometry or scan at which it stops.", "s", 0.1, 10.0)


class PurePursuit(Service):
    """Pure pursuit."""

    role = c.Role.LOCAL_PLANNER
    Config = Config

    def __init__(self, shell, config):
        peer, self.config = shell.peer, config
        self.odometry, self.map = OdometryReader(peer), MapInput(peer)
        self.robot = peer.latest(c.ROBOT_DESCRIPTION)
        self.scan, self.path = peer.latest(c.ROBOT_SCAN), peer.latest(c.PLAN_PATH)
        self.request = peer.writer(c.CONTROL_VELOCITY_REQUEST)
        self.task, self.is_there = TaskProgress(peer), False

    def wake(self, shell, rung):
        self.odometry.poll(shell.roster)
        self.map.poll(shell)
        self.task.poll(shell.roster)
        self.robot.poll(shell.roster)
        news = [reader.poll(shell.roster) for reader in (self.scan, self.path)]
        readers = [self.robot, self.scan, self.path, self.odometry.stream]
        shell.count(readers + self.map.readers + self.task.readers)
        tick, complete = self.odometry.tick, self.is_complete(shell.roster)
        for due in shell.due(tick, complete=complete, news=any(news)):
            self.answer(shell, due)

    def is_complete(self, roster):
        """In lockstep the scan of the tick, the map and the path made from it are awaited."""
        tick = self.odometry.tick
        awaited = roster.awaits(c.Role.MAPPING, tick, self.map.newest.tick)
        awaited |= roster.awaits(c.Role.GLOBAL_PLANNER, tick, self.path.spoken_tick)
        with_scan = self.scan.tick >= tick and not awaited
        return not roster.lockstep or with_scan or not self.odometry.scan_due

    def is_at_rest(self):
        return self.odometry.is_at_rest()

    def answer(self, shell, due):
        if self.task.begin(due.tick):
            self.is_there = False
        parents = {"odometry": self.odometry.id, "scan": self.scan.id, "goal": self.task.status.task}
        parents |= {"map": self.map.replica.revision, "path": self.path.id if self.path.tick else 0}
        scan = self.scan.get()
        capture_ns = scan.header.capture_ns if scan else 0
        draft = shell.begin(due, shell.run_ns(due.tick), capture_ns, parents)
        v_mps, w_radps, validity = self.decide(shell, draft, scan)
        braking_m = v_mps**2 / (2 * self.robot.get().meta.brake_mps2) if v_mps else 0
        meta = c.VelocityRequest(v_mps, w_radps, validity, braking_arc_m=braking_m)
        sent = shell.send(draft, self.request, meta)
        self.task.send(shell, draft)
        shell.finish(draft, sent)

    def decide(self, shell, draft, scan):
        """Speed, yaw rate and what they mean."""
        if shell.roster.control.stopping:
            return 0, 0, c.Validity.STOPPED
        if self.task.goal is None:
            done = self.task.status.state == c.TaskState.REACHED
            return 0, 0, c.Validity.AT_GOAL if done else c.Validity.NO_PATH
        robot, path, lockstep = self.robot.get(), self.path.get(), shell.roster.lockstep
        ages = [one.age_ns(draft, lockstep) for one in (scan, self.odometry) if one]
        if robot is None or scan is None or max(ages) > self.config.age_s * 1e9:
            return 0, 0, c.Validity.STALE
        if path is None or path.meta.goal != self.task.status.goal or not len(path.items):
            self.task.end_by(draft.tick, path)
            return 0, 0, c.Validity.NO_PATH
        return self.follow(draft, robot.meta, path.items, scan)

    def follow(self, draft, robot, waypoints, scan):
        goal = self.task.goal
        pose = self.map.map_from_base(self.odometry.newest.meta.pose)
        distance_m = math.hypot(goal.pose.x_m - pose.x_m, goal.pose.y_m - pose.y_m)
        self.is_there |= distance_m < 0.5 * goal.tolerance_m
        turn = math.copysign
        if self.is_there:
            error = wrap(goal.pose.yaw_rad - pose.yaw_rad)
            if abs(error) < 0.5 * goal.yaw_tolerance_rad:
                if self.is_at_rest():
                    self.task.end_goal(draft.tick, c.TaskState.REACHED)
                    self.is_there = False
                return 0, 0, c.Validity.AT_GOAL
            return 0, turn(self.turn_rate(robot, error), error), c.Validity.DRIVE
        (x, y), remaining_m = pursue(waypoints, pose, self.config.lookahead_m)
        self.task.status.remaining_m = remaining_m
        error = wrap(math.atan2(y - pose.y_m, x - pose.x_m) - pose.yaw_rad)
        if abs(error) > self.config.turn_rad:
            return 0, turn(self.turn_rate(robot, error), error), c.Validity.DRIVE
        free_m = ahead(scan, robot) - robot.circumscribed_radius_m - self.config.margin_m
        room_m = max(0.0, min(free_m, remaining_m))
        v_mps = min(self.config.v_mps, robot.v_mps_max, math.sqrt(robot.brake_mps2 * room_m))
        reach_m = max(0.1, math.hypot(x - pose.x_m, y - pose.y_m))
        w_radps = 2 * v_mps * math.sin(error) / reach_m
        slower = min(1.0, robot.w_radps_max / max(abs(w_radps), 1e-9))
        validity = c.Validity.DRIVE if v_mps > 0.01 else c.Validity.BLOCKED
        return v_mps * slower, w_radps * slower, validity

    def turn_rate(self, robot, error):
        return min(robot.w_radps_max, math.sqrt(robot.alpha_radps2_max * abs(error)))


def pursue(waypoints, pose, lookahead_m):
    """The point `lookahead_m` further along the path than the robot, and what remains of it."""
    x, y = waypoints["x_m"], waypoints["y_m"]
    if len(x) == 1:
        return (x[0], y[0]), math.hypot(x[0] - pose.x_m, y[0] - pose.y_m)
    dx, dy = np.diff(x), np.diff(y)
    square = np.maximum(dx**2 + dy**2, 1e-12)
    share = np.clip(((pose.x_m - x[:-1]) * dx + (pose.y_m - y[:-1]) * dy) / square, 0, 1)
    beside = np.hypot(x[:-1] + share * dx - pose.x_m, y[:-1] + share * dy - pose.y_m)
    leg, arc = int(beside.argmin()), np.concatenate(([0], np.cumsum(np.sqrt(square))))
    at = arc[leg] + share[leg] * (arc[leg + 1] - arc[leg])
    point = (np.interp(at + lookahead_m, arc, axis) for axis in (x, y))
    return tuple(float(one) for one in point), float(arc[-1] - at)


def ahead(scan, robot):
    """Distance along x to the nearest return in the strip that the robot will sweep. [m]"""
    angles = scan.meta.angle_min_rad + np.arange(len(scan.items)) * scan.meta.angle_increment_rad
    laser = robot.base_from_laser
    hit = (scan.items >= scan.meta.range_m_min) & (scan.items <= scan.meta.range_m_max)
    x = laser.x_m + scan.items[hit] * np.cos(angles[hit] + laser.yaw_rad)
    y = laser.y_m + scan.items[hit] * np.sin(angles[hit] + laser.yaw_rad)
    in_strip = (np.abs(y) < robot.inscribed_radius_m) & (x > 0)
    return float(x[in_strip].min(initial=math.inf))


if __name__ == "__main__":
    run(PurePursuit)
