//! The oracle: exact distances of a point to a disc or polygon, and a stop piece by piece.

/// [s] longest piece of a stop. In one, both accelerations are constant and the way is integrated to
/// the fifth order, so that it is exact to far less than a micrometre.
const PIECE_S: f64 = 0.01;

/// [m] by which two looks at a hit are apart at least.
const EXACT_M: f64 = 1.0e-6;

/// [m/s] and [rad/s] that are rounding.
const NOTHING: f64 = 1.0e-9;

/// A point that the lidar saw, in `base` of now. [m]
pub(crate) type Hit = [f64; 2];

/// A command, [m/s] and [rad/s], and until when it is obeyed from now. [s]
pub(crate) type Obeyed = ([f64; 2], f64);

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

/// A part of a stop with constant accelerations.
struct Piece {
    /// Since the stop began. [s]
    from_s: f64,
    lasts_s: f64,
    /// x [m], y [m], yaw [rad] in `base` of now.
    pose: [f64; 3],
    /// [m/s] and [rad/s]
    speeds: [f64; 2],
    /// [m/s^2] and [rad/s^2]
    rates: [f64; 2],
}

/// The pieces of a stop, in order.
pub(crate) struct Stop {
    pieces: Vec<Piece>,
    /// [m/s] and [rad/s], never exceeded.
    fastest: [f64; 2],
}

/// Rate and duration of a change at this rate.
fn ramp(change: f64, rate: f64) -> (f64, f64) {
    if change == 0.0 {
        (0.0, f64::INFINITY)
    } else {
        (rate.copysign(change), change.abs() / rate)
    }
}

impl Robot {
    /// Accelerations under a command, the speeds to which they lead, and how long they last.
    fn obeying(&self, [v, w]: [f64; 2], command: [f64; 2]) -> ([f64; 2], [f64; 2], f64) {
        // Whoever turns round brakes first, and speeds up from rest.
        let via = if v * command[0] < 0.0 {
            0.0
        } else {
            command[0]
        };
        let rate = if via.abs() < v.abs() {
            self.brake_mps2
        } else {
            self.a_mps2
        };
        let (a, v_s) = ramp(via - v, rate);
        let (alpha, w_s) = ramp(command[1] - w, self.alpha_radps2);
        ([a, alpha], [via, command[1]], v_s.min(w_s))
    }

    /// The same on the way to rest on the arc.
    fn braking(&self, [v, w]: [f64; 2]) -> ([f64; 2], [f64; 2], f64) {
        if v == 0.0 {
            let (alpha, w_s) = ramp(-w, self.alpha_radps2);
            return ([0.0, alpha], [0.0; 2], w_s);
        }
        let (a, v_s) = ramp(-v, self.brake_mps2);
        let on_arc = (w.abs() / v_s).min(self.alpha_radps2);
        ([a, -on_arc.copysign(w)], [0.0; 2], v_s)
    }
}

impl Piece {
    /// Speeds so long after its beginning.
    fn speeds_at(&self, since_s: f64) -> [f64; 2] {
        [0, 1].map(|i| self.speeds[i] + self.rates[i] * since_s)
    }

    /// Pose so long after its beginning, by Gauss's quadrature with two points.
    fn pose_at(&self, since_s: f64) -> [f64; 3] {
        let [x, y, yaw] = self.pose;
        let yaw_at = |s: f64| yaw + self.speeds[1] * s + 0.5 * self.rates[1] * s * s;
        let half_s = 0.5 * since_s;
        let (mut x, mut y) = (x, y);
        for sign in [-1.0, 1.0] {
            let s = half_s * (1.0 + sign / 3.0_f64.sqrt());
            let (sin, cos) = yaw_at(s).sin_cos();
            let [v, _] = self.speeds_at(s);
            x += half_s * v * cos;
            y += half_s * v * sin;
        }
        [x, y, yaw_at(since_s)]
    }
}

impl Stop {
    /// Obeys the commands, each until its moment [s], the last one until braking begins.
    pub(crate) fn new(robot: &Robot, from: [f64; 2], commands: &[Obeyed]) -> Self {
        let (mut pose, mut speeds) = ([0.0_f64; 3], from);
        let (mut from_s, mut pieces) = (0.0_f64, Vec::new());
        let mut fastest = speeds.map(f64::abs);
        let mut commands = commands.iter().copied().peekable();
        loop {
            while commands.peek().is_some_and(|next| next.1 <= from_s) {
                commands.next();
            }
            let obeyed = commands.peek().copied();
            if obeyed.is_none() && speeds == [0.0, 0.0] {
                break;
            }
            let until_s = obeyed.map_or(from_s, |(_, until_s)| until_s);
            let left_s = until_s - from_s;
            let (rates, goals, even_s) = if let Some((command, _)) = obeyed {
                let (rates, goals, even_s) = robot.obeying(speeds, command);
                (rates, goals, even_s.min(left_s))
            } else {
                robot.braking(speeds)
            };
            let lasts_s = even_s.min(PIECE_S);
            let piece = Piece {
                from_s,
                lasts_s,
                pose,
                speeds,
                rates,
            };
            pose = piece.pose_at(lasts_s);
            let there = piece.speeds_at(lasts_s);
            speeds = [0, 1].map(|i| {
                let arrived = (there[i] - goals[i]).abs() < NOTHING;
                if arrived { goals[i] } else { there[i] }
            });
            fastest = [0, 1].map(|i| fastest[i].max(speeds[i].abs()));
            // What is left of a command's time below rounding would be no piece.
            from_s = if obeyed.is_some() && (left_s - lasts_s).abs() < NOTHING {
                until_s
            } else {
                from_s + lasts_s
            };
            pieces.push(piece);
        }
        Self { pieces, fastest }
    }

    /// How far the hit stays beyond `keep_m` at the moments looked at; negative when it comes nearer at
    /// any moment by more than [`EXACT_M`], and then by two thirds of the most at least. [m]
    ///
    /// No distance changes faster than the robot moves past the hit: so far may be skipped.
    pub(crate) fn least_beyond_m(&self, outline: &Outline, hit: Hit, keep_m: f64) -> f64 {
        let mut least_m = outline.distance_m(hit) - keep_m;
        let (mut at_s, mut beyond_m, mut here) = (0.0, least_m, hit);
        for (n, piece) in self.pieces.iter().enumerate() {
            loop {
                let skip_m = beyond_m.abs().max(EXACT_M);
                // A disc that turns in its place gains nothing by it.
                let turning = match outline {
                    Outline::Disc(_) => 0.0,
                    Outline::Polygon(_) => self.fastest[1] * (here[0].hypot(here[1]) + skip_m),
                };
                let next_s = at_s + skip_m / (self.fastest[0] + turning).max(1.0e-9);
                let ends_s = piece.from_s + piece.lasts_s;
                if next_s > ends_s && n + 1 < self.pieces.len() {
                    break;
                }
                at_s = next_s.min(ends_s);
                let [x, y, yaw] = piece.pose_at(at_s - piece.from_s);
                let (sin, cos) = yaw.sin_cos();
                let [dx, dy] = [hit[0] - x, hit[1] - y];
                here = [cos * dx + sin * dy, cos * dy - sin * dx];
                beyond_m = outline.distance_m(here) - keep_m;
                least_m = least_m.min(beyond_m);
                if at_s >= ends_s {
                    break;
                }
            }
        }
        least_m
    }
}
