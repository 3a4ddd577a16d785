"""Paths and scans: lengths, nearest points, and what lies ahead."""

import math
import unittest
from types import SimpleNamespace

import numpy as np

from zeronav import contract as c
from zeronav import geometry
from zeronav.planner import is_free
from zeronav.replica import MapReplica


def path(*points):
    made = np.zeros(len(points), np.dtype(c.Waypoint))
    made["x_m"], made["y_m"] = np.array(points, float).T
    return made


class Paths(unittest.TestCase):
    def test_the_nearest_point_is_found_on_the_right_leg(self):
        corner = path((0, 0), (4, 0), (4, 3))
        for x, y, at_m in [(1, 1, 1), (-2, 0, 0), (5, 2, 6), (4, 9, 7)]:
            self.assertAlmostEqual(geometry.beside(corner, c.Pose(x, y, 0)), at_m)
        self.assertEqual(geometry.beside(path((2, 2)), c.Pose(0, 0, 0)), 0)

    def test_points_beyond_the_ends_are_the_ends(self):
        x, y = geometry.along(path((0, 0), (4, 0), (4, 3)), [-1, 2, 5.5, 99])
        np.testing.assert_allclose(x, [0, 2, 4, 4])
        np.testing.assert_allclose(y, [0, 0, 1.5, 3])

    def test_a_path_is_free_until_a_cell_beyond_its_first_metre_blocks(self):
        map = MapReplica()
        map.info.geometry = c.GridGeometry(0.0, 0.0, 0.1, 50, 10)
        map.cells, map.revision = np.zeros((10, 50), map.cells.dtype), 1
        straight = path((0.05, 0.55), (4.5, 0.55))
        self.assertFalse(is_free(map, straight[:0]))
        self.assertTrue(is_free(map, straight))
        map.cells["cost"][5, 5] = c.COST_LETHAL
        self.assertTrue(is_free(map, straight))
        map.cells["cost"][5, 20] = c.COST_INSCRIBED
        self.assertFalse(is_free(map, straight))


class Scans(unittest.TestCase):
    def test_only_returns_in_the_way_count(self):
        robot = SimpleNamespace(
            base_from_laser=c.Pose(0.1, 0, math.pi), inscribed_radius_m=0.3, circumscribed_radius_m=0.4
        )
        # By beams that turn counter-clockwise from straight behind the robot, as the laser is mounted.
        meta = SimpleNamespace(
            angle_min_rad=0.0, angle_increment_rad=math.pi / 2, range_m_min=0.05, range_m_max=10.0
        )
        scan = SimpleNamespace(meta=meta, items=np.array([3.0, 0.5, 2.0, math.inf], np.float32))
        self.assertAlmostEqual(geometry.free_ahead(scan, robot), 0.1 + 2.0 - 0.4, 5)
        self.assertAlmostEqual(geometry.free_ahead(scan, robot, backwards=True), 3.0 - 0.1 - 0.4, 5)
        scan.items[2] = math.nan
        self.assertEqual(geometry.free_ahead(scan, robot), math.inf)


if __name__ == "__main__":
    unittest.main()
