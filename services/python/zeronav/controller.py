"""A local planner without its algorithm: inputs, tasks, arrival, and stops when an input is lost."""

import math
from dataclasses import dataclass

import numpy as np

from . import contract as c
from . import geometry
from .inputs import OBSTACLES_AGE_NS_MAX, MapInput, OdometryReader
from .outputs import TaskProgress
from .ports import View
from .replica import MapReplica
from .service import Service

# Age of odometry or scan at which it counts as lost. [ns]
INPUT_AGE_NS = 500_000_000
# Speed below which a request asks for nothing. [m/s] and [rad/s]
STANDING = 0.01


@dataclass(frozen=True, slots=True)
class Scene:
    """What a controller decides by. Arrays and structures are views: copy what has to stay."""

    # Where the robot is on the map: x_m, y_m, yaw_rad.
    pose: c.Pose
    # `contract.Odometry`: v_mps, w_radps and the pose in `odom`.
    odometry: c.Odometry
    # Where it shall go: `contract.Goal`.
    goal: c.Goal
    # Waypoints of the path, an array with x_m, y_m, yaw_rad and clearance_m.
    path: np.ndarray
    # How far along the path the robot is, and what remains of it. [m]
    at_m: float
    remaining_m: float
    # The newest scan: `meta` and `items`, ranges in metres.
    scan: View
    # Limits and outline: `contract.Description`.
    robot: c.Description
    # The map: `MapReplica`.
    map: MapReplica
    # What moves, an array of `contract.Obstacle`: x_m, y_m, radius_m, vx_mps, vy_mps in the map frame.
    obstacles: np.ndarray

    def clearance_m(self, x_m: float, y_m: float) -> float:
        """From a point of the map frame to the nearest obstacle, static or tracked where it is now; 0
        in one, beside the map and where nothing is known. [m]"""
        place = self.map.cell_at(x_m, y_m)
        if place is None or self.map.cells["cost"][place] == c.COST_UNKNOWN:
            return 0.0
        static_m = float(self.map.cells["clearance_mm"][place]) / 1000
        moving = self.obstacles
        gaps_m = np.hypot(moving["x_m"] - x_m, moving["y_m"] - y_m) - moving["radius_m"]
        return max(0.0, min(static_m, float(gaps_m.min(initial=math.inf))))

    def path_point(self, ahead_m: float) -> tuple[float, float]:
        """The point of the path that lies this far ahead, or its end: x and y. [m]"""
        x, y = geometry.along(self.path, self.at_m + ahead_m)
        return float(x), float(y)

    def turn(self, error_rad: float) -> tuple[float, float]:
        """Turning in place by `error_rad`, so that it can still stop: 0 m/s, and a yaw rate."""
        fast = math.sqrt(self.robot.alpha_radps2_max * abs(error_rad))
        return 0.0, math.copysign(min(self.robot.w_radps_max, fast), error_rad)


class Controller(Service):
    """A program in the local planner's seat. Derive, and write `drive`; then call `run`."""

    role = c.Role.LOCAL_PLANNER

    def __init__(self, shell, config):
        peer, self.config = shell.peer, config
        self.odometry, self.map = OdometryReader(peer), MapInput(peer)
        self.robot = peer.latest(c.ROBOT_DESCRIPTION)
        self.scan, self.path = peer.latest(c.ROBOT_SCAN), peer.latest(c.PLAN_PATH)
        self.obstacles = peer.latest(c.MAP_OBSTACLES)
        self.request = peer.writer(c.CONTROL_VELOCITY_REQUEST)
        self.task, self._is_there = TaskProgress(peer), False

    def drive(self, scene: Scene) -> tuple[float, float]:
        """Speed and yaw rate on the way to the goal. [m/s] and [rad/s]"""
        raise NotImplementedError

    def wake(self, shell, rung):
        self.odometry.poll(shell.roster)
        self.map.poll(shell)
        self.task.poll(shell.roster)
        self.robot.poll(shell.roster)
        self.obstacles.poll(shell.roster)
        news = [reader.poll(shell.roster) for reader in (self.scan, self.path)]
        readers = [self.robot, self.scan, self.path, self.obstacles, self.odometry.stream]
        shell.count(readers + self.map.readers + self.task.readers)
        tick, complete = self.odometry.tick, self._is_complete(shell.roster)
        for due in shell.due(tick, complete=complete, news=any(news)):
            self._answer(shell, due)

    def is_at_rest(self):
        return self.odometry.is_at_rest()

    def _is_complete(self, roster):
        """In lockstep the scan of the tick, the map and the path made from it are awaited."""
        tick = self.odometry.tick
        awaited = roster.awaits(c.Role.MAPPING, tick, self.map.newest.tick)
        awaited |= roster.awaits(c.Role.GLOBAL_PLANNER, tick, self.path.spoken_tick)
        with_scan = self.scan.tick >= tick and not awaited
        return not roster.lockstep or with_scan or not self.odometry.scan_due

    def _answer(self, shell, due):
        if self.task.begin(due.tick):
            self._is_there = False
        parents = {"odometry": self.odometry.id, "scan": self.scan.id, "goal": self.task.status.task}
        parents |= {"map": self.map.replica.revision, "path": self.path.id if self.path.tick else 0}
        scan = self.scan.get()
        capture_ns = scan.header.capture_ns if scan else 0
        draft = shell.begin(due, shell.run_ns(due.tick), capture_ns, parents)
        v_mps, w_radps, validity = self._decide(shell, draft, scan)
        braking_m = v_mps**2 / (2 * self.robot.get().meta.brake_mps2) if v_mps else 0
        meta = c.VelocityRequest(v_mps, w_radps, validity, braking_arc_m=braking_m)
        sent = shell.send(draft, self.request, meta)
        self.task.send(shell, draft)
        shell.finish(draft, sent)

    def _decide(self, shell, draft, scan):
        """Speed, yaw rate and what they mean."""
        if shell.roster.control.stopping:
            return 0, 0, c.Validity.STOPPED
        if self.task.goal is None:
            done = self.task.status.state == c.TaskState.REACHED
            return 0, 0, c.Validity.AT_GOAL if done else c.Validity.NO_PATH
        robot, path, lockstep = self.robot.get(), self.path.get(), shell.roster.lockstep
        ages = [one.age_ns(draft, lockstep) for one in (scan, self.odometry) if one]
        if robot is None or scan is None or max(ages) > INPUT_AGE_NS:
            return 0, 0, c.Validity.STALE
        if path is None or path.meta.goal != self.task.status.goal or not len(path.items):
            self.task.end_by(draft.tick, path)
            return 0, 0, c.Validity.NO_PATH
        scene = self._scene(path.items, scan, robot.meta)
        self.task.status.remaining_m = scene.remaining_m
        return self._arrive(draft, scene) or self._on_the_way(scene)

    def _scene(self, path, scan, robot):
        odometry = self.odometry.newest.meta
        pose, at_m = self.map.map_from_base(odometry.pose), 0.0
        at_m, end = geometry.beside(path, pose), path[-1]
        remaining_m = float(geometry.arc_of(path)[-1] - at_m)
        if len(path) == 1:
            remaining_m = math.hypot(end["x_m"] - pose.x_m, end["y_m"] - pose.y_m)
        goal, replica = self.task.goal, self.map.replica
        moving = self._moving(scan.header.run_ns)
        return Scene(
            pose, odometry, goal, path, at_m, remaining_m, scan, robot, replica, moving
        )

    def _moving(self, run_ns):
        """The tracked obstacles; none of a list that is old."""
        view = self.obstacles.get()
        if view is None or run_ns - view.header.run_ns > OBSTACLES_AGE_NS_MAX:
            return np.empty(0, np.dtype(c.Obstacle))
        return view.items

    def _arrive(self, draft, scene):
        """At the goal: the turn to its heading, and a stop; None on the way to it."""
        goal, pose = scene.goal, scene.pose
        distance_m = math.hypot(goal.pose.x_m - pose.x_m, goal.pose.y_m - pose.y_m)
        self._is_there |= distance_m < 0.5 * goal.tolerance_m
        if not self._is_there:
            return None
        error = geometry.wrap(goal.pose.yaw_rad - pose.yaw_rad)
        if abs(error) >= 0.5 * goal.yaw_tolerance_rad:
            return *scene.turn(error), c.Validity.DRIVE
        if self.is_at_rest():
            self.task.end_goal(draft.tick, c.TaskState.REACHED)
            self._is_there = False
        return 0, 0, c.Validity.AT_GOAL

    def _on_the_way(self, scene):
        v_mps, w_radps = self.drive(scene)
        stands = abs(v_mps) <= STANDING and abs(w_radps) <= STANDING
        return v_mps, w_radps, c.Validity.BLOCKED if stands else c.Validity.DRIVE
