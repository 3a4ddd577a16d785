//! What the README of the guard calls dust.

use super::Draw;
use crate::past::{Past, apart, placed};
use crate::slow::Hit;
use zeronav_casts::Cast;

/// [m] Beams lie at most so far apart where a hit that the scans before deny is dust.
const DUST_APART_M: f64 = 0.03;

impl Draw {
    /// True when the README makes the guard take this hit of the newest scan for dust.
    pub(super) fn is_dust(&self, newest: &Past, beam: usize) -> bool {
        let (_, at, _, range_m) = newest.beams[beam];
        let apart_m = self.description.angle_increment_rad * range_m;
        let Some([last, earlier]) = self.past.first_chunk() else {
            return false;
        };
        let side = (0.005 / apart_m).to_usize().clamp(1, 32);
        if apart_m > DUST_APART_M
            || newest.beside(beam, side, apart_m) >= side
            || !self.went_on_behind(last, at)
        {
            return false;
        }
        let laser = placed(
            &self.scan_pose,
            self.description.base_from_laser.point().coords.into(),
        );
        let range_to_m = apart(at, laser);
        let along = [0, 1].map(|i| (at[i] - laser[i]) / range_to_m);
        let same = |end: Hit, there: Hit| {
            let off = [0, 1].map(|i| end[i] - there[i]);
            (off[0] * along[0] + off[1] * along[1]).abs() <= 0.03
                && (off[0] * along[1] - off[1] * along[0]).abs() <= 0.01 + 2.0 * apart_m
        };
        let recent = |past: &&Past| newest.run_ns - past.run_ns <= 220_000_000;
        let asked = self.past.iter().take_while(recent).count().max(2);
        let shows = |past: &&Past| past.beams.iter().any(|beam| same(beam.1, at));
        let shown = self.past[..asked].iter().filter(shows).count();
        2 * shown < asked && !self.came_evenly(newest.run_ns, [last, earlier], at, same)
    }

    /// True when two of the three beams of a scan whose directions are nearest to that of a place went on
    /// behind it, at one of the moments at which the lidar looked there.
    fn went_on_behind(&self, past: &Past, place: Hit) -> bool {
        let n = past.beams.len();
        let aside = past.beams.iter().map(|(from, _, yaw, _)| {
            let [dx, dy] = [place[0] - from[0], place[1] - from[1]];
            let (sin, cos) = (yaw - dy.atan2(dx)).sin_cos();
            sin.atan2(cos).abs()
        });
        let aside: Vec<f64> = aside.collect();
        let behind = |beam: usize| {
            let (from, _, _, range_m) = past.beams[beam];
            let away_m = apart(from, place);
            away_m >= 0.1 && range_m > away_m + 0.1
        };
        (0..n).any(|beam| {
            let [before, after] = [(beam + n - 1) % n, (beam + 1) % n];
            // Before its first beam and after its last one a lidar that turns with the robot looked elsewhere.
            let seam = beam == 0 || beam == n - 1;
            let turned = past.turned && self.scan.time_increment_s > 0.0;
            let nearest = aside[beam] <= aside[before].min(aside[after])
                && aside[beam] <= self.description.angle_increment_rad;
            let asked = [before, beam, after].into_iter();
            let through = asked.filter(|asked| behind(*asked)).count();
            nearest && !(seam && turned) && through >= 2
        })
    }

    /// True when three thin things of the three scans are on one even way of at most 2 m/s.
    fn came_evenly(
        &self,
        run_ns: u64,
        [last, earlier]: [&Past; 2],
        at: Hit,
        same: impl Fn(Hit, Hit) -> bool,
    ) -> bool {
        let [since_s, before_s] =
            [run_ns - last.run_ns, last.run_ns - earlier.run_ns].map(|ns| ns.to_f64() / 1.0e9);
        let mut came_from = last.thin(&self.description);
        came_from.retain(|was| apart(*was, at) <= 2.0 * since_s + 0.03);
        let first = earlier.thin(&self.description);
        came_from.len() > 32
            || came_from.iter().any(|was| {
                let velocity = [0, 1].map(|i| (at[i] - was[i]) / since_s);
                let there = [0, 1].map(|i| was[i] - velocity[i] * before_s);
                first.iter().any(|end| same(*end, there))
            })
    }
}
