"""The A* example at the edge of a map whose sides are no multiple of its blocks."""

import sys
import unittest
from pathlib import Path

import numpy as np

from zeronav import contract as c
from zeronav.planner import as_waypoints
from zeronav.replica import MapReplica

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
import astar  # noqa: E402


def replica(height=33, width=42):
    made = MapReplica()
    made.info.geometry = c.GridGeometry(-1.0, 2.0, 0.05, width, height)
    made.cells = np.zeros((height, width), made.cells.dtype)
    made.revision = 1
    return made


class Edges(unittest.TestCase):
    def test_every_cell_can_be_start_and_end(self):
        map = replica()
        # The last row and column of blocks lie partly outside: a path leads out of them, not in.
        for start, end, leads in [
            ((0, 0), (31, 39), True),
            ((32, 20), (0, 0), True),
            ((2, 41), (0, 0), True),
            ((0, 0), (32, 41), False),
            ((32, 41), (0, 0), False),
        ]:
            blocks = astar.search(map.cells, start, end, lambda: None)
            self.assertEqual(blocks is not None, leads, (start, end))
            if blocks:
                self.assertEqual(blocks[0], tuple(at // 4 for at in start))

    def test_waypoints_lie_on_the_map(self):
        map, goal = replica(), c.Pose(0.0, 2.2, 0.0)
        end = map.cell_at(0.0, 2.2)
        cells = astar.AStar.search(None, map.cells, (32, 20), end, lambda: None)
        waypoints = as_waypoints(map, cells, goal)
        places = zip(waypoints["x_m"], waypoints["y_m"])
        self.assertTrue(all(map.cell_at(x + 1e-9, y + 1e-9) for x, y in places))

    def test_what_lies_beyond_the_edge_is_not_free(self):
        map = replica()
        self.assertIsNone(astar.search(map.cells, (2, 2), (32, 20), lambda: None))


if __name__ == "__main__":
    unittest.main()
