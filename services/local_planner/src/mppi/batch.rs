//! A batch of samples: their twists within the accelerations, and where these lead.
//!
//! Samples lie side by side in lanes, step after step, and a batch is small enough for the nearest
//! cache. The heading is turned by polynomials of the small angle of a step, so nothing depends on
//! the platform's mathematics: the same numbers on every machine.

use super::limits::Limits;
use crate::footprint::DISCS_MAX;
use crate::lanes::data::{Projections, Sheet, least, narrow};
use crate::lanes::{least_nearest_m, lower_space};
use crate::local_path::LocalPath;
use crate::surroundings::Surroundings;
use zeronav_casts::Cast;

/// Samples of a batch: whole vectors, and not more than can be projected at once.
pub(crate) const LANES: usize = 40;

/// Steps from one place that is looked at to the next, in the nearer part of a sample and beyond.
const STRIDES: (usize, usize) = (2, 4);

/// Share of the steps that belong to the nearer part.
const NEARER: f64 = 0.43;

/// Places along a sample that are compared with the path.
pub(crate) const STATIONS: usize = 5;

/// One number per sample.
pub(crate) type Lanes = [f32; LANES];

/// The samples; buffers are reused.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    /// Steps of a sample.
    pub(crate) steps: usize,
    /// Twists asked for in each step. [m/s], [rad/s]
    pub(crate) asked_v: Vec<Lanes>,
    pub(crate) asked_w: Vec<Lanes>,
    /// Twists at the ends of the steps. [m/s], [rad/s]
    pub(crate) v: Vec<Lanes>,
    pub(crate) w: Vec<Lanes>,
    /// Positions at the ends of the steps, relative to the robot along the axes of the map. [m]
    pub(crate) x: Vec<Lanes>,
    pub(crate) y: Vec<Lanes>,
    /// Headings there.
    pub(crate) cos: Vec<Lanes>,
    pub(crate) sin: Vec<Lanes>,
    /// Steps at whose ends obstacles are looked for.
    pub(crate) looks: Vec<usize>,
    /// Space around the roughly covered outline there, at most the soft clearance. [m]
    pub(crate) space: Vec<Lanes>,
    /// First step that is not free of the map and the scan; infinite for none.
    pub(crate) hit: Lanes,
    /// Stations before that, at least one.
    pub(crate) free: [usize; LANES],
    /// Places on the path at the ends of the stations.
    pub(crate) projections: Vec<Projections>,
}

impl Batch {
    pub(crate) fn new(steps: usize) -> Self {
        let lanes = || vec![[0.0; LANES]; steps];
        let nearer = (NEARER * steps.to_f64()).to_usize();
        let near = (STRIDES.0..=nearer).step_by(STRIDES.0);
        let far = (nearer + STRIDES.1..=steps).step_by(STRIDES.1);
        Self {
            steps,
            looks: near.chain(far).map(|end| end - 1).collect(),
            asked_v: lanes(),
            asked_w: lanes(),
            v: lanes(),
            w: lanes(),
            x: lanes(),
            y: lanes(),
            cos: lanes(),
            sin: lanes(),
            space: lanes(),
            hit: [0.0; LANES],
            free: [0; LANES],
            projections: vec![Projections::default(); STATIONS],
        }
    }

    /// The last step of a station.
    pub(crate) const fn station(&self, index: usize) -> usize {
        (index + 1) * self.steps / STATIONS - 1
    }

    /// Follows what is asked for from a twist, at a heading in the map with this sine and cosine:
    /// each step is the chord of the exact arc of its mean twist.
    pub(crate) fn roll(&mut self, limits: &Limits, from: (f32, f32), heading: (f32, f32)) {
        let (mut v, mut w) = ([from.0; LANES], [from.1; LANES]);
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        let (mut sin, mut cos) = ([heading.0; LANES], [heading.1; LANES]);
        let mut arc = [0.0; LANES];
        for step in 0..self.steps {
            let (asked_v, asked_w) = (&self.asked_v[step], &self.asked_w[step]);
            for lane in 0..LANES {
                let (v0, w0) = (v[lane], w[lane]);
                let asked = (asked_v[lane], asked_w[lane]);
                let (v1, w1) = limits.follow((v0, w0), asked, arc[lane]);
                let half = 0.25 * limits.step_s * (w0 + w1);
                let (half_sin, half_cos) = sin_cos(half);
                let driven = 0.5 * limits.step_s * (v0 + v1);
                arc[lane] += driven;
                let chord = driven * sinc(half);
                // The chord points along half the step's turn.
                let along = (
                    cos[lane] * half_cos - sin[lane] * half_sin,
                    sin[lane] * half_cos + cos[lane] * half_sin,
                );
                x[lane] += chord * along.0;
                y[lane] += chord * along.1;
                cos[lane] = along.0 * half_cos - along.1 * half_sin;
                sin[lane] = along.1 * half_cos + along.0 * half_sin;
                (v[lane], w[lane]) = (v1, w1);
            }
            (self.v[step], self.w[step]) = (v, w);
            (self.x[step], self.y[step]) = (x, y);
            (self.cos[step], self.sin[step]) = (cos, sin);
        }
    }

    /// Looks along the samples: space and hits.
    pub(crate) fn look(&mut self, surroundings: &Surroundings, soft_m: f64) {
        let sheet = surroundings.field.sheet();
        let need = narrow(surroundings.need_m());
        let soft = narrow(soft_m).max(need);
        let footprint = &surroundings.footprint;
        let is_disc = footprint.is_disc();
        let enough = narrow(footprint.circumscribed_m) + soft + surroundings.field.slack_m();
        let mut discs = [[0.0; 3]; DISCS_MAX];
        for (to, disc) in discs.iter_mut().zip(&footprint.rough) {
            *to = [disc.centre.x, disc.centre.y, disc.radius_m].map(narrow);
        }
        let discs = &discs[..footprint.rough.len().clamp(1, DISCS_MAX)];
        self.hit = [f32::INFINITY; LANES];
        for &step in &self.looks {
            let mut space = [soft; LANES];
            let at = (&self.x[step][..], &self.y[step][..]);
            let heading = (&self.cos[step][..], &self.sin[step][..]);
            if is_disc {
                lower_space(&sheet, at.0, at.1, discs[0][2], &mut space);
            } else {
                lower_space_rough(&sheet, at, heading, (discs, enough), &mut space);
            }
            let number = step.to_f32();
            for (hit, space) in self.hit.iter_mut().zip(&space) {
                let first = if *space < need { number } else { f32::INFINITY };
                *hit = least(*hit, first);
            }
            self.space[step] = space;
        }
        self.free = [1; LANES];
        for station in 1..STATIONS {
            let ends = self.station(station).to_f32();
            for (free, hit) in self.free.iter_mut().zip(&self.hit) {
                *free += usize::from(ends < *hit);
            }
        }
    }

    /// Compares the stations with the path.
    pub(crate) fn project(&mut self, path: &LocalPath) {
        for station in 0..STATIONS {
            let step = self.station(station);
            path.project_all(&self.x[step], &self.y[step], &mut self.projections[station]);
        }
    }
}

/// Lowers `space` around a roughly covered outline, where anything is near at all.
fn lower_space_rough(
    sheet: &Sheet<'_>,
    (x, y): (&[f32], &[f32]),
    (cos, sin): (&[f32], &[f32]),
    (discs, enough): (&[[f32; 3]], f32),
    space: &mut Lanes,
) {
    if least_nearest_m(sheet, x, y) >= enough {
        return;
    }
    for disc in discs {
        let (mut disc_x, mut disc_y) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            disc_x[lane] = x[lane] + cos[lane] * disc[0] - sin[lane] * disc[1];
            disc_y[lane] = y[lane] + sin[lane] * disc[0] + cos[lane] * disc[1];
        }
        lower_space(sheet, &disc_x, &disc_y, disc[2], space);
    }
}

/// Sine and cosine of a step's half turn, some tenths of a radian at most: 1e-8 off at 0.3 rad.
fn sin_cos(angle: f32) -> (f32, f32) {
    let squared = angle * angle;
    let sin = angle * (1.0 - squared * (1.0 / 6.0 - squared * (1.0 / 120.0 - squared / 5040.0)));
    let cos = 1.0 - squared * (0.5 - squared * (1.0 / 24.0 - squared / 720.0));
    (sin, cos)
}

/// `sin(x) / x` of the same.
fn sinc(angle: f32) -> f32 {
    let squared = angle * angle;
    1.0 - squared * (1.0 / 6.0 - squared * (1.0 / 120.0 - squared / 5040.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_robot::robot;
    use nalgebra::Point2;
    use zeronav_motion::Twist;
    use zeronav_msgs::Pose;
    use zeronav_msgs::description::Description;

    fn asking(twists: impl Fn(usize) -> (f32, f32)) -> Batch {
        let mut batch = Batch::new(56);
        for step in 0..56 {
            let (v, w) = twists(step);
            batch.asked_v[step].fill(v);
            batch.asked_w[step].fill(w);
        }
        batch
    }

    #[test]
    fn a_held_twist_drives_its_arc() {
        let mut batch = asking(|_| (0.8, -1.3));
        let limits = Limits::new(&robot(), 1.0, 0.05, (100.0, 1.0));
        batch.roll(&limits, (0.8, -1.3), (0.0, 1.0));
        let arc = Twist::new(0.8, -1.3).arc(2.8);
        assert!((f64::from(batch.x[55][7]) - arc.x_m).abs() < 1e-4);
        assert!((f64::from(batch.y[55][7]) - arc.y_m).abs() < 1e-4);
        assert!((f64::from(batch.cos[55][7]) - arc.yaw_rad.cos()).abs() < 1e-4);
        assert!((f64::from(batch.sin[55][7]) - arc.yaw_rad.sin()).abs() < 1e-4);
    }

    #[test]
    fn samples_are_within_the_limits_whatever_is_asked_for() {
        let mut batch = asking(|step| {
            if step % 14 < 7 {
                (9.0, 9.0)
            } else {
                (-9.0, -9.0)
            }
        });
        let limits = Limits::new(&robot(), 0.7, 0.05, (100.0, 1.0));
        batch.roll(&limits, (0.3, 0.0), (0.0, 1.0));
        let (mut v, mut w) = (0.3_f32, 0.0_f32);
        for step in 0..56 {
            let (next_v, next_w) = (batch.v[step][0], batch.w[step][0]);
            assert!((-0.2 - 1e-6..=0.7 + 1e-6).contains(&next_v), "{next_v}");
            assert!(next_w.abs() <= 2.0);
            assert!((next_v - v).abs() <= 0.1 + 1e-6 && (next_w - w).abs() <= 0.2 + 1e-6);
            assert!(v < 0.0 || next_v - v <= 0.05 + 1e-6, "{v} to {next_v}");
            (v, w) = (next_v, next_w);
        }
    }

    #[test]
    fn samples_come_to_rest_at_the_goal() {
        let mut batch = asking(|_| (1.0, 0.0));
        let limits = Limits::new(&robot(), 1.0, 0.05, (1.2, 1.0));
        batch.roll(&limits, (1.0, 0.0), (1.0, 0.0));
        // Along the map's y axis, since that is where the heading points.
        assert!((batch.y[55][0] - 1.2).abs() < 0.06, "{}", batch.y[55][0]);
        assert!(batch.x[55][0].abs() < 1e-6);
        assert!(batch.v[55][0] < 0.1, "{}", batch.v[55][0]);
    }

    #[test]
    fn a_post_is_hit_when_it_is_reached() {
        let robot = Description {
            inscribed_radius_m: 0.2,
            circumscribed_radius_m: 0.2,
            ..robot()
        };
        let mut surroundings = Surroundings::default();
        surroundings.describe(&robot, &[]);
        let reach = crate::surroundings::Reach {
            field_m: 3.0,
            stop_m: 0.5,
            soft_m: 0.2,
            margin_m: 0.02,
        };
        let post = [Point2::new(1.2, 0.0)];
        surroundings.look(None, &Pose::default(), (&post, &[]), &post, reach);
        let mut batch = asking(|_| (1.0, 0.0));
        for step in 0..56 {
            batch.asked_v[step][1] = 0.2;
        }
        batch.roll(
            &Limits::new(&robot, 1.0, 0.05, (100.0, 1.0)),
            (1.0, 0.0),
            (0.0, 1.0),
        );
        batch.look(&surroundings, 0.2);
        // 0.98 m at 1 m/s.
        assert!((17.0..=21.0).contains(&batch.hit[0]), "{}", batch.hit[0]);
        assert!(batch.hit[1].is_infinite(), "slow and braking");
        assert!(batch.free[0] < batch.free[1] && batch.free[1] == STATIONS);
        assert!(batch.looks.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(batch.looks.last(), Some(&55));
    }
}
