#!/usr/bin/env python3
"""A collision guard in Python: stops before whatever the scan shows straight ahead.

It passes on what is asked, within the robot's acceleration. Turning is not checked.
"""

import math

from zeronav import OdometryReader, Service, free_ahead, run
from zeronav import contract as c

# How long after odometry the request that belongs to it is awaited. [ns]
PATIENCE_NS = 5_000_000
# Age at which a request, a scan or odometry counts as lost. [ns]
REQUEST_AGE_NS, SCAN_AGE_NS, ODOMETRY_AGE_NS = 100_000_000, 350_000_000, 100_000_000
# Distance that is kept to what lies in the way. [m]
MARGIN_M = 0.1
REASONS = {
    c.Intervention.REQUEST_STALE: c.REASON_REQUEST,
    c.Intervention.SCAN_STALE: c.REASON_SCAN,
    c.Intervention.ODOMETRY_STALE: c.REASON_ODOMETRY,
    c.Intervention.ZONES_MISSING: c.REASON_ZONES,
}


class Guard(Service):
    """A guard that looks straight ahead."""

    role = c.Role.COLLISION_GUARD

    def __init__(self, shell, _config):
        peer = shell.peer
        self.odometry = OdometryReader(peer)
        self.robot, self.scan = peer.latest(c.ROBOT_DESCRIPTION), peer.latest(c.ROBOT_SCAN)
        self.request = peer.latest(c.CONTROL_VELOCITY_REQUEST)
        self.command = peer.writer(c.ROBOT_VELOCITY_COMMAND)
        # What was commanded last: what the robot does, as far as it can.
        self.v_mps = self.w_radps = None
        # When the command before was decided. [ns]
        self.answered_ns = 0

    def wake(self, shell, rung):
        roster = shell.roster
        self.odometry.poll(roster)
        self.robot.poll(roster)
        self.scan.poll(roster)
        asked = self.request.poll(roster)
        shell.count([self.robot, self.scan, self.request, self.odometry.stream])
        tick, newest = self.odometry.tick, self.odometry.newest
        if roster.lockstep:
            asked_all = not roster.awaits(c.Role.LOCAL_PLANNER, tick, self.request.spoken_tick)
        else:
            asked_all = asked
        deadline_ns = newest.came_ns + PATIENCE_NS if newest else None
        for due in shell.due(tick, complete=asked_all, news=asked, deadline_ns=deadline_ns):
            self.answer(shell, due)

    def is_at_rest(self):
        return self.odometry.is_at_rest()

    def answer(self, shell, due):
        if self.v_mps is None and self.odometry.newest:
            # The robot may move already when a successor begins.
            meta = self.odometry.newest.meta
            self.v_mps, self.w_radps = meta.v_mps, meta.w_radps
        parents = {"odometry": self.odometry.id, "scan": self.scan.id, "request": self.request.id}
        scan = self.scan.get()
        capture_ns = scan.header.capture_ns if scan else 0
        draft = shell.begin(due, shell.run_ns(due.tick), capture_ns, parents)
        command = self.decide(shell, draft, scan, 1e-9 * self.elapsed_ns(shell, draft))
        if self.v_mps is not None:
            self.v_mps, self.w_radps = command.v_mps, command.w_radps
        for intervention, reason in REASONS.items():
            shell.reason(reason, command.intervention == intervention)
        shell.answer(draft, self.command, command)

    def elapsed_ns(self, shell, draft):
        """Time since the command before: from tick to tick, one tick for a successor's first. While
        odometry is late the ticks stand still, and the robot has to come to rest all the same."""
        ticks = max(0, draft.tick - shell.answered_tick) if shell.answered_tick else min(1, draft.tick)
        before_ns, self.answered_ns = self.answered_ns, draft.started_ns
        newest = self.odometry.newest
        is_late = newest and draft.started_ns - newest.came_ns > shell.run_ns(1)
        if ticks == 0 and is_late and not shell.roster.lockstep:
            return draft.started_ns - before_ns
        return shell.run_ns(ticks)

    def decide(self, shell, draft, scan, elapsed_s):
        """The command, `elapsed_s` after the one before."""
        robot, request = self.robot.get(), self.request.get()
        validity, intervention, v_mps, w_radps = c.Validity.STALE, c.Intervention.NONE, 0.0, 0.0
        if shell.roster.control.stopping:
            validity = c.Validity.STOPPED
        elif draft.tick == 0 or None in (robot, request, self.v_mps):
            return c.VelocityCommand(validity=c.Validity.NO_REQUEST)
        elif shell.roster.control.zones:
            # It does not know how to keep out of them.
            intervention = c.Intervention.ZONES_MISSING
        elif stale := self.lost(draft, scan, request, shell.roster.lockstep):
            intervention = stale
        else:
            validity = c.Validity(request.meta.validity)
        if robot is None or self.v_mps is None:
            return c.VelocityCommand(validity=validity, intervention=intervention)
        if validity == c.Validity.DRIVE:
            v_mps, w_radps = request.meta.v_mps, request.meta.w_radps
            room_m = max(0.0, free_ahead(scan, robot.meta, v_mps < 0) - MARGIN_M)
            safe_mps = math.sqrt(2 * robot.meta.brake_mps2 * room_m)
            if abs(v_mps) > safe_mps:
                v_mps = math.copysign(safe_mps, v_mps)
                short = safe_mps == 0
                intervention = c.Intervention.STOPPED_SHORT if short else c.Intervention.SLOWED
        v, w = self.limited(robot.meta, v_mps, w_radps, elapsed_s)
        if (v, w) != (v_mps, w_radps) and intervention == c.Intervention.NONE:
            intervention = c.Intervention.CLAMPED
        return c.VelocityCommand(v, w, validity, intervention)

    def lost(self, draft, scan, request, lockstep):
        """Which input is missing or too old; None when all are there."""
        if request.arrival_age_ns(draft, lockstep) > REQUEST_AGE_NS:
            return c.Intervention.REQUEST_STALE
        if scan is None or scan.arrival_age_ns(draft, lockstep) > SCAN_AGE_NS:
            return c.Intervention.SCAN_STALE
        if self.odometry.age_ns(draft, lockstep) > ODOMETRY_AGE_NS:
            return c.Intervention.ODOMETRY_STALE
        return None

    def limited(self, robot, v_mps, w_radps, elapsed_s):
        """Speeds within the robot's limits and what it can change in `elapsed_s`."""
        rate_mps2 = robot.brake_mps2 if abs(v_mps) < abs(self.v_mps) else robot.a_mps2_max
        dv, dw = elapsed_s * rate_mps2, elapsed_s * robot.alpha_radps2_max
        v = min(max(v_mps, self.v_mps - dv), self.v_mps + dv)
        w = min(max(w_radps, self.w_radps - dw), self.w_radps + dw)
        v = min(max(v, robot.v_mps_min), robot.v_mps_max)
        return v, min(max(w, -robot.w_radps_max), robot.w_radps_max)


if __name__ == "__main__":
    run(Guard)
