"""What a controller decides by: obstacles and the distance to them."""

import typing
import unittest

import numpy as np

from zeronav import Scene
from zeronav import contract as c
from zeronav.replica import MapReplica


def scene(*discs):
    """A map of 5 m x 1 m, all of it 2 m from anything, and what moves: x, y and radius."""
    replica = MapReplica()
    replica.info.geometry = c.GridGeometry(0.0, 0.0, 0.1, 50, 10)
    replica.cells, replica.revision = np.zeros((10, 50), replica.cells.dtype), 1
    replica.cells["clearance_mm"] = 2000
    moving = np.zeros(len(discs), np.dtype(c.Obstacle))
    for row, disc in zip(moving, discs):
        row["x_m"], row["y_m"], row["radius_m"] = disc
    return Scene(None, None, None, None, 0.0, 0.0, None, None, replica, moving)


class Scenes(unittest.TestCase):
    def test_clearance_is_that_of_the_nearest_obstacle_static_or_tracked(self):
        self.assertAlmostEqual(scene().clearance_m(1.0, 0.5), 2.0)
        one = scene((3.0, 0.5, 0.25), (4.5, 0.5, 0.25))
        self.assertAlmostEqual(one.clearance_m(2.0, 0.5), 0.75)
        self.assertEqual(one.clearance_m(3.1, 0.5), 0.0)

    def test_no_clearance_is_known_beside_the_map_and_in_unknown_cells(self):
        one = scene()
        one.map.cells["cost"][5, 10] = c.COST_UNKNOWN
        for x_m, y_m in [(-0.1, 0.5), (1.0, 1.5), (1.05, 0.55)]:
            self.assertEqual(one.clearance_m(x_m, y_m), 0.0)

    def test_every_field_has_a_type(self):
        self.assertNotIn(typing.Any, typing.get_type_hints(Scene).values())


if __name__ == "__main__":
    unittest.main()
