"""The inputs of services: numpy views, the copy of the map, odometry between two messages."""

import ctypes
import unittest

import numpy as np

from zeronav import contract as c
from zeronav import inputs, messages
from zeronav.checks import Refused, decode
from zeronav.layout import FNV_OFFSET, checksum, fnv1a
from zeronav.replica import MapReplica, cost_of

TILE = np.dtype(c.MapTile)


def info(revision, width=40, height=33, n_tiles=0, part=0, parts=1):
    grid = c.GridGeometry(-1.0, 2.0, 0.05, width, height)
    model = c.CostModel(0.2, 0.05, 0.6, 10.0)
    message = c.MapInfo(geometry=grid, revision=revision, n_tiles=n_tiles, cost_model=model)
    message.part, message.parts, message.clearance_limit_mm, message.current = part, parts, 1000, 1
    return message


def tiles(*places, cost=7):
    array = np.zeros(len(places), TILE)
    array["tile_x"], array["tile_y"] = [x for x, _ in places], [y for _, y in places]
    array["cells"]["cost"], array["cells"]["clearance_mm"] = cost, 1000
    return array


ALL = [(0, 0), (1, 0), (0, 1), (1, 1)]
FIRST = 1 << 40 | 5


class Replica(unittest.TestCase):
    def setUp(self):
        self.replica = MapReplica()
        self.replica.keyframe(info(FIRST), tiles(*ALL))

    def test_tiles_beyond_the_edge_are_cut(self):
        self.assertEqual(self.replica.cells.shape, (33, 40))
        self.replica.update(FIRST + 1, info(FIRST + 1), tiles((1, 1), cost=99))
        self.assertEqual(int((self.replica.cells["cost"] == 99).sum()), 8)
        self.assertEqual(self.replica.revision, FIRST + 1)
        self.assertTrue(self.replica.take_changed())
        self.assertFalse(self.replica.take_changed())

    def test_after_a_gap_updates_wait_for_a_keyframe(self):
        self.replica.update(FIRST + 2, info(FIRST + 2), tiles((0, 0), cost=50))
        self.assertFalse(self.replica.in_step)
        self.assertEqual(int((self.replica.cells["cost"] == 50).sum()), 0)
        self.replica.keyframe(info(FIRST + 1), tiles(*ALL, cost=8))
        self.assertTrue(self.replica.in_step)
        self.assertEqual(self.replica.revision, FIRST + 2)
        self.assertEqual(int((self.replica.cells["cost"] == 50).sum()), 32 * 32)

    def test_a_revision_counts_with_its_last_part(self):
        first, last = info(FIRST + 2, part=0, parts=2), info(FIRST + 2, part=1, parts=2)
        self.replica.update(FIRST + 1, first, tiles((0, 0), cost=50))
        self.assertEqual(self.replica.revision, FIRST)
        self.assertEqual(int((self.replica.cells["cost"] == 50).sum()), 0)
        self.replica.update(FIRST + 2, last, tiles((1, 0), cost=60))
        self.assertEqual(self.replica.revision, FIRST + 2)
        self.assertEqual(int((self.replica.cells["cost"] == 50).sum()), 32 * 32)

    def test_stamped_obstacles_are_lifted_again(self):
        before = self.replica.cells.copy()
        obstacle = np.zeros(1, np.dtype(c.Obstacle))
        obstacle["x_m"], obstacle["y_m"], obstacle["radius_m"] = 0.0, 3.0, 0.2
        self.replica.stamp(obstacle)
        row, column = self.replica.cell_at(0.0, 3.0)
        self.assertEqual(self.replica.cells["cost"][row, column], c.COST_LETHAL)
        self.assertEqual(self.replica.cells["cost"][row, column + 6], c.COST_INSCRIBED)
        self.replica.stamp(())
        self.assertTrue((self.replica.cells == before).all())

    def test_costs_fall_with_clearance(self):
        model = info(FIRST).cost_model
        costs = cost_of(model, np.array([0.0, 0.1, 0.2, 0.24, 0.25, 0.35, 0.6, 0.61]))
        self.assertEqual(costs.tolist(), [254, 253, 253, 253, 252, 92, 7, 0])


class Decoding(unittest.TestCase):
    def path(self, **changes):
        envelope = c.PLAN_PATH.envelope()
        head, meta = envelope.header, envelope.meta
        head.role, head.schema, head.id = c.Role.GLOBAL_PLANNER, c.PLAN_PATH.schema & 0xFFFFFFFF, 1 << 40 | 1
        meta.status, meta.n_waypoints = c.PathStatus.FOUND, 2
        for name, value in changes.items():
            setattr(head if hasattr(head, name) else meta, name, value)
        points = np.zeros(2, np.dtype(c.Waypoint))
        head.checksum = checksum(bytes(envelope), points)
        return envelope, points

    def test_one_bad_field_is_enough(self):
        decode(c.PLAN_PATH, *self.path())
        for name, value, why in [
            ("schema", 1, "schema"),
            ("role", c.Role.MAPPING, "role"),
            ("role", 99, "code"),
            ("id", 1, "identity"),
            ("clock", 1, "domain"),
            ("status", 77, "status"),
            ("n_waypoints", 3, "number"),
            ("length_m", float("nan"), "length_m"),
            ("cost", -1.0, "cost"),
        ]:
            with self.assertRaisesRegex(Refused, why, msg=name):
                decode(c.PLAN_PATH, *self.path(**{name: value}))
        envelope, waypoints = self.path()
        waypoints["x_m"][1] = np.inf
        with self.assertRaisesRegex(Refused, "checksum"):
            decode(c.PLAN_PATH, envelope, waypoints)
        envelope.header.checksum = checksum(bytes(envelope), waypoints)
        with self.assertRaisesRegex(Refused, "x_m is not"):
            decode(c.PLAN_PATH, envelope, waypoints)


class Pieces(unittest.TestCase):
    def test_the_hash_is_fnv1a(self):
        self.assertEqual(fnv1a(FNV_OFFSET, b"foobar"), 0x85944171F73967E8)

    def test_poses_compose_and_angles_wrap(self):
        pose = inputs.compose(c.Pose(1.0, 2.0, np.pi / 2), c.Pose(3.0, 0.0, np.pi))
        self.assertAlmostEqual(pose.x_m, 1.0)
        self.assertAlmostEqual(pose.y_m, 5.0)
        self.assertAlmostEqual(pose.yaw_rad, -np.pi / 2)

    def test_a_path_describes_its_waypoints(self):
        waypoints = np.zeros(3, np.dtype(c.Waypoint))
        waypoints["x_m"] = [0.0, 3.0, 3.0]
        waypoints["y_m"] = [0.0, 4.0, 5.0]
        path = messages.path("mine", c.PathStatus.FOUND, c.PathCause.GOAL, 4, waypoints)
        self.assertEqual((path.length_m, path.n_waypoints, path.goal), (6.0, 3, 4))
        self.assertEqual(bytes(path.planner), b"mine".ljust(24, b"\0"))

    def test_a_copy_outlives_its_source(self):
        goal = c.Goal(tolerance_m=0.5)
        copy = goal.copy()
        ctypes.memset(ctypes.addressof(goal), 0xFF, ctypes.sizeof(goal))
        self.assertEqual(copy.tolerance_m, 0.5)


if __name__ == "__main__":
    unittest.main()
