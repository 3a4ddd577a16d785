"""Messages with fields that follow from others."""

import numpy as np

from . import contract as c


def path(planner, status, cause, goal, waypoints):
    """The fixed fields of `plan/path` with these waypoints; cost is length, the rest 0.

    `planner` is the planner's key in at most 24 letters, `goal` the id of the goal, `waypoints` an
    array of `Waypoint`.
    """
    legs = np.hypot(np.diff(waypoints["x_m"]), np.diff(waypoints["y_m"]))
    length_m = float(legs.sum())
    message = c.Path(status=status, cause=cause, n_waypoints=len(waypoints), goal=goal)
    message.length_m = message.cost = length_m
    key = planner.encode("ascii")[:24]
    message.planner[: len(key)] = list(key)
    return message
