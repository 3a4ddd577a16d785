//! The oracle: exact distances of a point to a disc or polygon, and a stop in small steps.

/// [s] from one pose of a stop to the next.
const STEP_S: f64 = 0.002;

/// [m] by which two looks at a hit are apart at least.
const EXACT_M: f64 = 2.0e-4;

/// A point that the lidar saw, in `base` of now. [m]
pub(crate) type Hit = [f64; 2];

/// A footprint.
pub(crate) enum Outline {
    /// Its radius. [m]
    Disc(f64),
    /// Its corners, counter-clockwise. [m]
    Polygon(Vec<Hit>),
}

fn cross(a: Hit, b: Hit) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn between(a: Hit, b: Hit) -> Hit {
    [b[0] - a[0], b[1] - a[1]]
}

impl Outline {
    /// Signed distance, negative inside. [m]
    pub(crate) fn distance_m(&self, at: Hit) -> f64 {
        let corners = match self {
            Self::Disc(radius_m) => return at[0].hypot(at[1]) - radius_m,
            Self::Polygon(corners) => corners,
        };
        let mut inside = true;
        let mut least = f64::INFINITY;
        for (i, from) in corners.iter().enumerate() {
            let edge = between(*from, corners[(i + 1) % corners.len()]);
            let offset = between(*from, at);
            inside &= cross(edge, offset) >= 0.0;
            let squared = edge[0] * edge[0] + edge[1] * edge[1];
            let share = (offset[0] * edge[0] + offset[1] * edge[1]) / squared;
            let share = share.clamp(0.0, 1.0);
            let far = (offset[0] - share * edge[0]).hypot(offset[1] - share * edge[1]);
            least = least.min(far);
        }
        if inside { -least } else { least }
    }
}

/// What moves.
pub(crate) struct Robot {
    pub(crate) outline: Outline,
    /// [m/s^2]
    pub(crate) a_mps2: f64,
    /// [m/s^2]
    pub(crate) brake_mps2: f64,
    /// [rad/s^2]
    pub(crate) alpha_radps2: f64,
}

/// The poses of a stop: x [m], y [m], yaw [rad] in `base` of now, at most `STEP_S` apart.
pub(crate) struct Stop {
    poses: Vec<[f64; 3]>,
    /// [m/s] and [rad/s], never exceeded.
    fastest: [f64; 2],
}

/// `from` moved towards `to` by at most `most`.
fn nearer(from: f64, to: f64, most: f64) -> f64 {
    if to > from {
        to.min(from + most)
    } else {
        to.max(from - most)
    }
}

impl Robot {
    /// Speeds one step later under a command.
    fn obeying(&self, [v, w]: [f64; 2], command: [f64; 2], step_s: f64) -> [f64; 2] {
        // Braking acts where the speed falls, and on through zero.
        let slows = v != 0.0 && (command[0] - v) * v < 0.0;
        let rate = if slows { self.brake_mps2 } else { self.a_mps2 };
        [
            nearer(v, command[0], rate * step_s),
            nearer(w, command[1], self.alpha_radps2 * step_s),
        ]
    }

    /// Speeds one step later on the way to rest on the arc.
    fn braking(&self, [v, w]: [f64; 2]) -> [f64; 2] {
        let slower = nearer(v, 0.0, self.brake_mps2 * STEP_S);
        let on_arc = if v == 0.0 { 0.0 } else { w * slower / v };
        [slower, nearer(w, on_arc, self.alpha_radps2 * STEP_S)]
    }
}

impl Stop {
    /// Obeys `command` for `reaction_s`, then brakes.
    pub(crate) fn new(robot: &Robot, from: [f64; 2], command: [f64; 2], reaction_s: f64) -> Self {
        let [mut x, mut y, mut yaw] = [0.0_f64; 3];
        let (mut speeds, mut left_s, mut fastest) = (from, reaction_s, [0.0_f64; 2]);
        let mut poses = vec![[x, y, yaw]];
        while left_s > 0.0 || speeds != [0.0, 0.0] {
            let (next, step_s) = if left_s > 0.0 {
                let step_s = left_s.min(STEP_S);
                (robot.obeying(speeds, command, step_s), step_s)
            } else {
                (robot.braking(speeds), STEP_S)
            };
            let v = 0.5 * (speeds[0] + next[0]);
            let w = 0.5 * (speeds[1] + next[1]);
            let middle = yaw + 0.5 * w * step_s;
            x += v * step_s * middle.cos();
            y += v * step_s * middle.sin();
            yaw += w * step_s;
            poses.push([x, y, yaw]);
            fastest = [fastest[0].max(v.abs()), fastest[1].max(w.abs())];
            speeds = next;
            left_s -= step_s;
        }
        Self { poses, fastest }
    }

    /// The hit in `base` at this time, in steps. [m]
    fn seen(&self, hit: Hit, at: f64) -> Hit {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place in a list"
        )]
        let whole = (at.floor().max(0.0) as usize).min(self.poses.len() - 1);
        let [from, to] = [whole, (whole + 1).min(self.poses.len() - 1)].map(|i| self.poses[i]);
        let share = at - at.floor();
        let [x, y, yaw] = [0, 1, 2].map(|i| from[i] + share * (to[i] - from[i]));
        let (sin, cos) = yaw.sin_cos();
        let [dx, dy] = [hit[0] - x, hit[1] - y];
        [cos * dx + sin * dy, cos * dy - sin * dx]
    }

    /// How far the hit stays beyond `keep_m` at the moments looked at; negative when it comes nearer at
    /// any moment by more than [`EXACT_M`]. [m]
    ///
    /// No distance changes faster than the robot moves past the hit: so far may be skipped.
    pub(crate) fn least_beyond_m(&self, outline: &Outline, hit: Hit, keep_m: f64) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "a place in a list")]
        let end = (self.poses.len() - 1) as f64;
        let (mut at, mut least_m) = (0.0, f64::INFINITY);
        loop {
            let here = self.seen(hit, at);
            let beyond_m = outline.distance_m(here) - keep_m;
            least_m = least_m.min(beyond_m);
            if at >= end || beyond_m < 0.0 {
                return least_m;
            }
            let skip_m = beyond_m.max(EXACT_M);
            // A disc that turns in its place gains nothing by it.
            let turning = match outline {
                Outline::Disc(_) => 0.0,
                Outline::Polygon(_) => self.fastest[1] * (here[0].hypot(here[1]) + skip_m),
            };
            let each_m = (self.fastest[0] + turning) * STEP_S;
            at = (at + skip_m / each_m.max(1.0e-9)).min(end);
        }
    }
}
