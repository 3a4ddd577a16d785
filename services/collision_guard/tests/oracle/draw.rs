//! Random robots, scans, odometry and requests, and the oracle's own view of the hits.

mod dust;

use crate::past::{Past, placed};
use crate::slow::{Hit, Obeyed, Outline, Robot};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;
use zeronav_collision_guard::GuardConfig;
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

/// [ns] from call to call.
pub(crate) const PERIOD_NS: u64 = 20_000_000;
const PERIOD_S: f64 = 0.02;

/// [m] Ranges of neighbouring beams on one thing differ by less; a hit inside without is dust.
const SAME_M: f64 = 0.1;

/// One robot that is driven at random.
pub(crate) struct Draw {
    random: Pcg32,
    pub(crate) config: GuardConfig,
    pub(crate) robot: Robot,
    pub(crate) description: Description,
    pub(crate) corners: Vec<Corner>,
    pub(crate) scan: Scan,
    pub(crate) ranges: Vec<f32>,
    pub(crate) scan_id: u64,
    pub(crate) scan_ns: u64,
    pub(crate) scan_pose: Pose,
    pub(crate) odometry: Odometry,
    pub(crate) run_ns: u64,
    pub(crate) request: VelocityRequest,
    /// Of the last two scans, in `odom`.
    sights: [Vec<Hit>; 2],
    /// The last eight scans, the newest one first.
    past: Vec<Past>,
    /// What stands around a robot with many beams, in `odom`.
    things: Vec<Hit>,
    /// Hits that were dust so far.
    pub(crate) dust: u64,
    /// When each command was sent [ns], and its speeds.
    sent: Vec<(u64, [f64; 2])>,
}

/// A disc, a rectangle around the axle or anywhere near it, or corners on an ellipse.
fn footprint(random: &mut Pcg32) -> Vec<Hit> {
    let back_m = random.random_range(-0.5..-0.05);
    let front_m = random.random_range(0.05..0.6);
    let side_m = random.random_range(0.06..0.4);
    match random.random_range(0..3) {
        0 => Vec::new(),
        1 => vec![
            [front_m, side_m],
            [back_m, side_m],
            [back_m, -side_m],
            [front_m, -side_m],
        ],
        _ => {
            let n = random.random_range(4..13);
            let turn = std::f64::consts::TAU / f64::from(n);
            (0..n)
                .map(|i| {
                    let angle = turn * (f64::from(i) + random.random_range(0.0..0.6));
                    let middle_m = 0.5 * (front_m + back_m) * 0.5;
                    let half_m = 0.5 * (front_m - back_m);
                    [middle_m + half_m * angle.cos(), side_m * angle.sin()]
                })
                .collect()
        }
    }
}

/// The pose after `elapsed_s` of constant speeds, in ten small steps.
fn driven(pose: &Pose, [v, w]: [f64; 2], elapsed_s: f64) -> Pose {
    let (mut at, mut yaw) = ([pose.x_m, pose.y_m], pose.yaw_rad);
    let step_s = elapsed_s / 10.0;
    for _ in 0..10 {
        let (sin, cos) = (yaw + 0.5 * w * step_s).sin_cos();
        at = [at[0] + v * step_s * cos, at[1] + v * step_s * sin];
        yaw += w * step_s;
    }
    Pose::new(at[0], at[1], yaw)
}

/// How late a robot obeys: every other one at once, the others by up to 0.6 s, some of them by a whole
/// number of periods. [ns]
fn late_ns(seed: u64) -> u64 {
    let mut random = Pcg32::seed_from_u64(!seed);
    match random.random_range(0..4) {
        0 | 1 => 0,
        2 => random.random_range(1..31) * PERIOD_NS,
        _ => random.random_range(1..600_000_000),
    }
}

/// A fine lidar for every third robot, with which a single hit can be dust.
fn many_beams(seed: u64) -> Option<u32> {
    let mut random = Pcg32::seed_from_u64(seed ^ 0xd057);
    let fine = random.random_bool(1.0 / 3.0);
    fine.then(|| random.random_range(150..500))
}

impl Draw {
    // long: one draw of all that a call needs
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Pcg32::seed_from_u64(seed);
        let (points, inner_m) = loop {
            let points = footprint(&mut random);
            let inner_m = if points.is_empty() {
                random.random_range(0.1..0.5)
            } else {
                -Outline::Polygon(points.clone()).distance_m([0.0, 0.0])
            };
            if inner_m > 0.02 {
                break (points, inner_m);
            }
        };
        let outer_m = points.iter().map(|at| at[0].hypot(at[1]));
        let outer_m = outer_m.fold(inner_m, f64::max);
        let n_beams = many_beams(seed).unwrap_or(random.random_range(8..40));
        let step_rad = std::f64::consts::TAU / f64::from(n_beams);
        let corners: Vec<Corner> = points
            .iter()
            .map(|at| Corner {
                x_m: at[0],
                y_m: at[1],
            })
            .collect();
        let description = Description {
            inscribed_radius_m: inner_m,
            circumscribed_radius_m: outer_m,
            v_mps_max: random.random_range(0.2..3.0),
            v_mps_min: -random.random_range(0.0..1.5_f64),
            w_radps_max: random.random_range(0.3..4.0),
            a_mps2_max: random.random_range(0.3..4.0),
            brake_mps2: random.random_range(0.3..4.0),
            alpha_radps2_max: random.random_range(0.5..10.0),
            base_from_laser: Pose::new(
                random.random_range(-0.5..0.5) * inner_m,
                random.random_range(-0.5..0.5) * inner_m,
                random.random_range(-3.0..3.0),
            ),
            angle_increment_rad: step_rad,
            range_m_max: 20.0,
            scan_period_ns: PERIOD_NS,
            n_beams,
            actuation_delay_ns: late_ns(seed),
            n_corners: u32::try_from(corners.len()).unwrap_or(0),
            ..Description::default()
        };
        let config = GuardConfig {
            reaction_s: random.random_range(0.0..0.3),
            margin_m: 0.01 + random.random_range(0.0_f64..0.1).powi(2) * 10.0,
            slow_zone_m: random.random_range(0.0..0.1),
            slow_mps: random.random_range(0.05..1.0),
            frozen_m: 1000.0,
            frozen_rad: 1000.0,
            ..GuardConfig::default()
        };
        let robot = Robot {
            outline: if points.is_empty() {
                Outline::Disc(outer_m)
            } else {
                Outline::Polygon(points)
            },
            a_mps2: description.a_mps2_max,
            brake_mps2: description.brake_mps2,
            alpha_radps2: description.alpha_radps2_max,
        };
        let scan = Scan {
            n_beams,
            angle_increment_rad: step_rad.to_f32(),
            time_increment_s: random.random_range(0.0..0.001_f64).max(0.0005).to_f32() - 0.0005,
            range_m_max: 20.0,
            ..Scan::default()
        };
        Self {
            config,
            robot,
            description,
            corners,
            scan,
            ranges: vec![f32::INFINITY; n_beams as usize],
            scan_id: 0,
            scan_ns: 0,
            scan_pose: Pose::default(),
            odometry: Odometry::default(),
            run_ns: 0,
            request: VelocityRequest::default(),
            sights: [Vec::new(), Vec::new()],
            past: Vec::new(),
            things: Vec::new(),
            dust: 0,
            sent: Vec::new(),
            random,
        }
    }

    /// One period later: moved as it was going, with other speeds, mostly a new scan and another
    /// request.
    pub(crate) fn step(&mut self) {
        self.run_ns += PERIOD_NS;
        let speeds = [self.odometry.v_mps, self.odometry.w_radps];
        self.odometry.pose = driven(&self.odometry.pose, speeds, PERIOD_S);
        let limits = &self.description;
        let random = &mut self.random;
        let mut twist = |share: f64| {
            let still = random.random_bool(0.1);
            let v_mps = random.random_range(share * limits.v_mps_min..share * limits.v_mps_max);
            let w_radps = share * random.random_range(-1.0..1.0) * limits.w_radps_max;
            match random.random_range(0..4) {
                _ if still => [0.0, 0.0],
                0 => [0.0, w_radps],
                1 => [v_mps, 0.0],
                _ => [v_mps, w_radps],
            }
        };
        [self.odometry.v_mps, self.odometry.w_radps] = twist(1.05);
        let asked = twist(1.3);
        self.request = VelocityRequest {
            v_mps: asked[0],
            w_radps: asked[1],
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        if self.scan_id == 0 || self.random.random_bool(0.8) {
            self.look();
        }
    }

    /// A new scan, which shows a few near things.
    fn look(&mut self) {
        let random = &mut self.random;
        self.ranges.fill(f32::INFINITY);
        let outer_m = self.description.circumscribed_radius_m;
        let far_m = outer_m + random.random_range(0.05..2.0);
        let n = self.ranges.len();
        for _ in 0..random.random_range(0..6) {
            let beam = random.random_range(0..n);
            // Inside the outline now and then, just outside, or somewhere.
            let range_m = (match random.random_range(0..12) {
                0 => random.random_range(0.01..outer_m),
                1 => outer_m + random.random_range(0.0..0.05),
                _ => random.random_range(outer_m..far_m),
            })
            .to_f32();
            self.ranges[beam] = range_m;
            if random.random_bool(0.5) {
                self.ranges[(beam + 1) % n] = range_m + random.random_range(-0.12_f32..0.12).abs();
            }
        }
        if n >= 150 {
            self.stand(n);
        }
        self.scan_id += 1;
        (self.scan_ns, self.scan_pose) = (self.run_ns, self.odometry.pose);
        self.sights.swap(0, 1);
        self.sights[0] = self.seen();
    }

    /// Things that stay for a few scans: what was new becomes one, some of the others go.
    fn stand(&mut self, n: usize) {
        let pose = self.odometry.pose;
        let at = placed(&pose, placed(&self.description.base_from_laser, [0.0, 0.0]));
        let yaw = pose.yaw_rad + self.description.base_from_laser.yaw_rad;
        let step_rad = self.description.angle_increment_rad;
        let random = &mut self.random;
        self.things.retain(|_| random.random_bool(0.8));
        let new: Vec<usize> = (0..n)
            .filter(|beam| self.ranges[*beam].is_finite())
            .collect();
        for thing in &self.things {
            let [dx, dy] = [thing[0] - at[0], thing[1] - at[1]];
            let turns = (dy.atan2(dx) - yaw).rem_euclid(std::f64::consts::TAU) / step_rad;
            let (beam, range_m) = (turns.round().to_usize() % n, dx.hypot(dy).to_f32());
            self.ranges[beam] = self.ranges[beam].min(range_m);
        }
        for beam in new {
            let (sin, cos) = (yaw + self.scan.angle_of(beam)).sin_cos();
            let range_m = f64::from(self.ranges[beam]);
            self.things
                .push([at[0] + range_m * cos, at[1] + range_m * sin]);
        }
    }

    /// The hits of the newest scan in `odom`: each from where the robot was when its beam looked.
    fn seen(&mut self) -> Vec<Hit> {
        let newest = self.beams();
        let last = self.ranges.len() - 1;
        let same = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|beam| f64::from(self.ranges[beam]));
            (a - b).abs() < SAME_M
        };
        let mut hits = Vec::new();
        for (beam, range_m) in self.ranges.iter().enumerate() {
            if !range_m.is_finite() {
                continue;
            }
            let (sin, cos) = self.scan.angle_of(beam).sin_cos();
            let range_m = f64::from(*range_m);
            let laser = &self.description.base_from_laser;
            let in_base = placed(laser, [range_m * cos, range_m * sin]);
            let lone =
                (beam == 0 || !same(beam, beam - 1)) && (beam == last || !same(beam, beam + 1));
            if lone && self.robot.outline.distance_m(in_base) < 0.0 {
                continue;
            }
            if self.is_dust(&newest, beam) {
                self.dust += 1;
                continue;
            }
            hits.push(newest.beams[beam].1);
        }
        self.past.insert(0, newest);
        self.past.truncate(8);
        hits
    }

    /// The beams of the newest scan.
    fn beams(&self) -> Past {
        let speeds = [self.odometry.v_mps, self.odometry.w_radps];
        let last = self.ranges.len() - 1;
        let laser = &self.description.base_from_laser;
        let (mut then, beam_s) = (self.scan_pose, f64::from(self.scan.time_increment_s));
        let mut of = |beam: usize, range_m: f64| {
            if beam < last {
                then = driven(&then, speeds, -beam_s);
            }
            let angle_rad = self.scan.angle_of(beam);
            let end = [range_m * angle_rad.cos(), range_m * angle_rad.sin()];
            let end = if range_m.is_finite() {
                placed(&then, placed(laser, end))
            } else {
                [f64::NAN; 2]
            };
            let from = placed(&then, laser.point().coords.into());
            (from, end, then.yaw_rad + laser.yaw_rad + angle_rad, range_m)
        };
        // From the last one, whose pose is the scan's, to the first.
        let ranges = self.ranges.iter().map(|range_m| f64::from(*range_m));
        let beams = ranges.enumerate().rev();
        let mut beams: Vec<_> = beams.map(|(beam, range_m)| of(beam, range_m)).collect();
        beams.reverse();
        Past {
            run_ns: self.scan_ns,
            turned: speeds != [0.0, 0.0],
            beams,
        }
    }

    /// The hits of the last two scans in `base` of now.
    pub(crate) fn hits_in_base(&self) -> Vec<Hit> {
        let pose = self.odometry.pose;
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let hits = self.sights.iter().flatten();
        hits.map(|at| {
            let [dx, dy] = [at[0] - pose.x_m, at[1] - pose.y_m];
            [cos * dx + sin * dy, cos * dy - sin * dx]
        })
        .collect()
    }

    /// The command of this period.
    pub(crate) fn sent(&mut self, v_mps: f64, w_radps: f64) {
        self.sent.push((self.run_ns, [v_mps, w_radps]));
    }

    /// What the robot obeys until a command of now takes effect, each with its end from now. [s]
    pub(crate) fn on_their_way(&self) -> Vec<Obeyed> {
        let delay_ns = self.description.actuation_delay_ns;
        if delay_ns == 0 {
            return Vec::new();
        }
        // Before it obeys anything the robot goes on as it does.
        let as_it_does = [self.odometry.v_mps, self.odometry.w_radps];
        let mut obeyed = vec![(0, as_it_does)];
        obeyed.extend(
            self.sent
                .iter()
                .map(|(at_ns, speeds)| (at_ns + delay_ns, *speeds)),
        );
        let ends = obeyed.iter().skip(1).map(|next| next.0);
        let ends = ends.chain([self.run_ns + delay_ns]);
        let from_now = |at_ns: u64| (at_ns.to_f64() - self.run_ns.to_f64()) / 1.0e9;
        (obeyed.iter().zip(ends))
            .map(|((_, speeds), end_ns)| (*speeds, from_now(end_ns)))
            .filter(|(_, end_s)| *end_s > 0.0)
            .collect()
    }

    /// The request within the limits, on its arc.
    pub(crate) fn clamped(&self) -> [f64; 2] {
        let limits = &self.description;
        let asked = [self.request.v_mps, self.request.w_radps];
        let most_mps = if asked[0] > 0.0 {
            limits.v_mps_max
        } else {
            -limits.v_mps_min
        };
        let share = |asked: f64, most: f64| {
            if asked.abs() > most {
                most / asked.abs()
            } else {
                1.0
            }
        };
        let share = share(asked[0], most_mps).min(share(asked[1], limits.w_radps_max));
        asked.map(|number| number * share)
    }

    /// True for a command within the limits.
    pub(crate) fn holds(&self, v_mps: f64, w_radps: f64) -> bool {
        let limits = &self.description;
        (limits.v_mps_min..=limits.v_mps_max).contains(&v_mps)
            && w_radps.abs() <= limits.w_radps_max
    }
}
