"""Poses, paths and scans: plain functions of what a message holds."""

import math

import numpy as np

from . import contract as c


def wrap(angle_rad):
    """`angle_rad` wrapped to [-pi, pi]."""
    return math.remainder(angle_rad, math.tau)


def then(pose, point):
    """Where `point`, (x, y) in the frame of `pose`, lies in the parent of that frame. [m]"""
    sin, cos = math.sin(pose.yaw_rad), math.cos(pose.yaw_rad)
    x, y = point
    return pose.x_m + cos * x - sin * y, pose.y_m + sin * x + cos * y


def compose(outer, inner):
    """`compose(map_from_odom, odom_from_base)` is `map_from_base`."""
    x_m, y_m = then(outer, (inner.x_m, inner.y_m))
    return c.Pose(x_m, y_m, wrap(outer.yaw_rad + inner.yaw_rad))


def returns(scan, robot):
    """Where the beams of a scan that hit something ended: arrays of x and y in `base`. [m]"""
    angles = scan.meta.angle_min_rad + np.arange(len(scan.items)) * scan.meta.angle_increment_rad
    laser = robot.base_from_laser
    hit = (scan.items >= scan.meta.range_m_min) & (scan.items <= scan.meta.range_m_max)
    x = laser.x_m + scan.items[hit] * np.cos(angles[hit] + laser.yaw_rad)
    y = laser.y_m + scan.items[hit] * np.sin(angles[hit] + laser.yaw_rad)
    return x, y


def free_ahead(scan, robot, backwards=False):
    """Distance that the robot can go straight until its outline may touch what the scan shows in the
    strip of its inscribed radius; infinite when nothing is there. [m]"""
    x, y = returns(scan, robot)
    ahead = (-x if backwards else x)[np.abs(y) < robot.inscribed_radius_m]
    return float(ahead[ahead > 0].min(initial=math.inf)) - robot.circumscribed_radius_m


def arc_of(waypoints):
    """Length of a path up to each of its waypoints. [m]"""
    legs = np.hypot(np.diff(waypoints["x_m"]), np.diff(waypoints["y_m"]))
    return np.concatenate(([0.0], np.cumsum(legs)))


def beside(waypoints, pose):
    """How far along a path its nearest point to `pose` lies. [m]"""
    x, y = waypoints["x_m"], waypoints["y_m"]
    if len(x) < 2:
        return 0.0
    dx, dy = np.diff(x), np.diff(y)
    square = np.maximum(dx**2 + dy**2, 1e-12)
    share = np.clip(((pose.x_m - x[:-1]) * dx + (pose.y_m - y[:-1]) * dy) / square, 0, 1)
    away = np.hypot(x[:-1] + share * dx - pose.x_m, y[:-1] + share * dy - pose.y_m)
    leg, arc = int(away.argmin()), arc_of(waypoints)
    return float(arc[leg] + share[leg] * (arc[leg + 1] - arc[leg]))


def along(waypoints, at_m):
    """Points at these lengths of a path, its ends beyond them: x and y. [m]"""
    arc = arc_of(waypoints)
    return np.interp(at_m, arc, waypoints["x_m"]), np.interp(at_m, arc, waypoints["y_m"])
