#!/usr/bin/env python3
"""A companion in Python: tells how far away the nearest return of the newest scan is.

`zeronav topics echo user/nearest` shows what it sends.
"""

import math
from dataclasses import dataclass

import numpy as np

from zeronav import Companion, param, run
from zeronav import contract as c

# Distance from the lidar, and direction in the frame of the lidar.
FORM = "distance_m: f64, bearing_rad: f64"


@dataclass(frozen=True)
class Config:
    """What can be set."""

    topic: str = param("nearest", "Name of its topic behind `user/`.")


class Nearest(Companion):
    """The distance of the nearest return."""

    Config = Config

    def __init__(self, guest, config):
        self.scan = guest.peer.latest(c.ROBOT_SCAN)
        self.nearest = guest.peer.user_writer(config.topic, FORM)

    def look(self, guest):
        if not self.scan.poll(guest.roster):
            return
        scan = self.scan.get()
        hits = (scan.items >= scan.meta.range_m_min) & (scan.items <= scan.meta.range_m_max)
        ranges_m = np.where(hits, scan.items, math.inf)
        at = int(np.argmin(ranges_m))
        bearing_rad = scan.meta.angle_min_rad + at * scan.meta.angle_increment_rad
        self.nearest.send(float(ranges_m[at]), bearing_rad)


if __name__ == "__main__":
    run(Nearest)
