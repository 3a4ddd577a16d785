#!/usr/bin/env python3
"""A local planner in Python: pure pursuit of the path, slower before what the scan shows.

Source: Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", 1992.
"""

import math
from dataclasses import dataclass

from zeronav import Controller, free_ahead, param, run, wrap


@dataclass(frozen=True)
class Config:
    """What can be set."""

    lookahead_m: float = param(0.6, "Distance of the pursued point along the path.", "m", 0.1, 5.0)
    v_mps: float = param(1.0, "Fastest speed, within the robot's limits.", "m/s", 0.05, 10.0)
    turn_rad: float = param(0.6, "Heading error beyond which it turns in place.", "rad", 0.1, 3.0)
    margin_m: float = param(0.3, "Distance kept to what lies ahead.", "m", 0.0, 5.0)


class PurePursuit(Controller):
    """Pure pursuit."""

    Config = Config

    def drive(self, scene):
        pose, robot = scene.pose, scene.robot
        x, y = scene.path_point(self.config.lookahead_m)
        error = wrap(math.atan2(y - pose.y_m, x - pose.x_m) - pose.yaw_rad)
        if abs(error) > self.config.turn_rad:
            return scene.turn(error)
        free_m = free_ahead(scene.scan, robot) - self.config.margin_m
        room_m = max(0.0, min(free_m, scene.remaining_m))
        # Half of the braking that can be relied on.
        v_mps = min(self.config.v_mps, robot.v_mps_max, math.sqrt(robot.brake_mps2 * room_m))
        # The circle through the robot, along its heading, and the pursued point.
        reach_m = max(0.1, math.hypot(x - pose.x_m, y - pose.y_m))
        w_radps = 2 * v_mps * math.sin(error) / reach_m
        slower = min(1.0, robot.w_radps_max / max(abs(w_radps), 1e-9))
        return v_mps * slower, w_radps * slower


if __name__ == "__main__":
    run(PurePursuit)
