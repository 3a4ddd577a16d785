"""Who is obeyed, and what a successor hears and owes."""

import unittest

from zeronav import contract as c
from zeronav.contract import Role, RunMode, Seat
from zeronav.roster import Roster


def header(role, epoch, tick):
    found = c.Header()
    found.role, found.id, found.tick = role, epoch << 40 | 7, tick
    return found


def seat(role, epoch, off_tick=0, on_tick=0):
    found = Seat()
    found.role, found.epoch = role, epoch
    found.off_tick, found.on_tick, found.hear_tick = off_tick, on_tick, on_tick
    return found


def roster(epoch):
    found = Roster(Role.LOCAL_PLANNER, epoch)
    found.clock.mode, found.lockstep = RunMode.LOCKSTEP, True
    found.seats = {
        Role.MAPPING: seat(Role.MAPPING, 2, 10, 15),
        Role.LOCAL_PLANNER: seat(Role.LOCAL_PLANNER, 3, 8, 12),
    }
    return found


class Successors(unittest.TestCase):
    def test_one_that_its_seat_does_not_name_yet_hears_and_owes_nothing(self):
        unnamed, named, shadow = roster(4), roster(3), roster(c.SHADOW_EPOCH_MIN)
        message = header(Role.MAPPING, 2, 20)
        self.assertFalse(unnamed.hears(message) or unnamed.owes(20))
        self.assertTrue(unnamed.obeys(message))
        for other in (named, shadow):
            self.assertTrue(other.hears(message) and other.owes(20))
        self.assertFalse(named.hears(header(Role.MAPPING, 1, 20)))

    def test_the_map_of_a_mapping_that_was_gone_at_the_first_tick_does_not_count(self):
        named = roster(3)
        self.assertTrue(named.began_after(Role.MAPPING, 1))
        self.assertFalse(named.began_after(Role.MAPPING, 2))
        named.seats[Role.LOCAL_PLANNER].hear_tick = 15
        self.assertFalse(named.began_after(Role.MAPPING, 1))

    def test_a_seat_is_taken_over_by_a_restart_and_by_a_swap(self):
        found = roster(3)
        of_robot = header(Role.ROBOT, 1, 0)
        found.seats[Role.ROBOT] = seat(Role.ROBOT, 1)
        self.assertFalse(found.is_taken_over(of_robot))
        self.assertTrue(found.is_taken_over(header(Role.MAPPING, 2, 0)))
        found.seats[Role.ROBOT].since_tick = 5
        self.assertTrue(found.is_taken_over(of_robot))


if __name__ == "__main__":
    unittest.main()
