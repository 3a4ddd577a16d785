//! Who knows the future of everything that moves: could the robot still have avoided a contact?
//!
//! The answer is a proof in one direction. The set of places where the robot can be without having
//! touched anything is followed in time, from its state some seconds before the contact to some
//! time after it, and every step errs on the side of the robot: it is a disc of its inscribed
//! radius, it may jump between the moments that are looked at, and in each of them it goes any way
//! within its top speed (a grid of positions over time), as long as it stays in the box that its
//! accelerations, its yaw rate and its state at the beginning leave it. When nothing is left of the
//! set, no command at all would have helped.
//!
//! Of somebody who appears right before the robot a disc is too little of it to tell. So the moments
//! after the contact are looked at one by one, too, with the robot's true outline: when there is one
//! at which it touches somebody wherever in that box it is, no command would have helped either.
//!
//! When neither is so, the contact counts as avoidable, whether a real robot could have got out of
//! it or not.

mod reach;

use reach::Reach;
use zeronav_world::{Convex, Footprint, RobotSpec};

/// Side of a cell. [m]
const CELL_M: f64 = 0.06;

/// Time from look to look, at most. [s]
const STEP_S: f64 = 0.2;

/// Time after the contact for which the robot must stay clear. [s]
const AFTER_S: f64 = 1.0;

/// Time from moment to moment at which every pose is looked at [s], and how many after the contact.
const MOMENT_S: f64 = 0.02;
const MOMENTS: u32 = 15;

/// Most cells along a side of the window, for robots that are faster than any here.
const SIDE_MAX: usize = 1024;

/// What the robot can do, at best.
#[derive(Debug, Clone)]
pub(super) struct Abilities {
    /// Its outline in `base`.
    pub(super) outline: Convex,
    /// How far that reaches from its centre. [m]
    pub(super) reach_m: f64,
    /// Radius of a disc that is within its outline everywhere. [m]
    pub(super) radius_m: f64,
    /// Least and largest forward speed. [m/s]
    pub(super) v_mps: [f64; 2],
    /// Largest yaw rate. [rad/s]
    pub(super) w_radps_max: f64,
    /// Largest change of speed, faster or slower. [m/s^2]
    pub(super) a_mps2_max: f64,
    /// Largest change of the yaw rate. [rad/s^2]
    pub(super) alpha_radps2_max: f64,
}

impl Abilities {
    /// Those of a robot with this outline.
    pub(super) fn new(robot: &RobotSpec, footprint: &Footprint) -> Self {
        Self {
            outline: footprint.form().clone(),
            reach_m: footprint.circumscribed_radius_m(),
            radius_m: footprint.inscribed_radius_m(),
            v_mps: [robot.v_mps_min.min(0.0), robot.v_mps_max],
            w_radps_max: robot.w_radps_max,
            a_mps2_max: robot.brake_mps2.unwrap_or(0.0).max(robot.a_mps2_max),
            alpha_radps2_max: robot.alpha_radps2_max,
        }
    }
}

/// The robot at a moment of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State {
    /// Run time. [s]
    pub(super) t_s: f64,
    /// Position of its centre. [m]
    pub(super) at_m: [f64; 2],
    /// [rad]
    pub(super) yaw_rad: f64,
    /// Forward speed. [m/s]
    pub(super) v_mps: f64,
    /// Yaw rate. [rad/s]
    pub(super) w_radps: f64,
}

/// A disc at a moment: centre and radius. [m]
pub(super) type Disc = ([f64; 2], f64);

/// Everything that can be touched.
pub(super) struct Surroundings<'a> {
    /// What moves, at a run time [s].
    pub(super) discs_at: &'a dyn Fn(f64) -> Vec<Disc>,
    /// Distance of a point from what stands. [m]
    pub(super) fixed_m: &'a dyn Fn([f64; 2]) -> f64,
}

/// True when the robot, whatever it does from `state` on, touches something before the run time
/// `contact_s` and [`AFTER_S`] more.
#[must_use]
pub(super) fn is_unavoidable(
    state: &State,
    contact_s: f64,
    abilities: &Abilities,
    around: &Surroundings<'_>,
) -> bool {
    if touches_anyhow(state, contact_s, abilities, around) {
        return true;
    }
    // The moment of the contact is one of those that are looked at.
    let spans = [
        (state.t_s, contact_s - state.t_s),
        (contact_s.max(state.t_s), AFTER_S),
    ];
    let fastest_mps = abilities.v_mps[1].max(-abilities.v_mps[0]);
    let whole_s: f64 = spans.iter().map(|(_, lasts_s)| lasts_s.max(0.0)).sum();
    let mut set = Set::new(state, fastest_mps * whole_s);
    let mut box_m = Reach::new(state, abilities);
    for (from_s, lasts_s) in spans {
        let looks = looks(lasts_s);
        let step_s = lasts_s / f64::from(looks.max(1));
        for look in 1..=looks {
            box_m.advance(step_s);
            set.grow(fastest_mps * step_s);
            set.retain(
                &box_m,
                abilities.radius_m,
                &(around.discs_at)(from_s + f64::from(look) * step_s),
                around.fixed_m,
            );
            if set.is_empty() {
                return true;
            }
        }
    }
    false
}

/// True when there is a moment at or soon after `contact_s` at which the robot touches something that
/// moves, wherever it can be then.
fn touches_anyhow(
    state: &State,
    contact_s: f64,
    abilities: &Abilities,
    around: &Surroundings<'_>,
) -> bool {
    let mut box_m = Reach::new(state, abilities);
    box_m.advance((contact_s - state.t_s).max(0.0));
    (0..=MOMENTS).any(|moment| {
        if moment > 0 {
            box_m.advance(MOMENT_S);
        }
        let t_s = contact_s.max(state.t_s) + MOMENT_S * f64::from(moment);
        box_m.touches_anyhow(&(around.discs_at)(t_s))
    })
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few seconds in steps of a fifth"
)]
fn looks(duration_s: f64) -> u32 {
    (duration_s / STEP_S).ceil().clamp(0.0, 1000.0) as u32
}

/// The cells that hold a place where the robot may be.
#[derive(Debug)]
struct Set {
    corner_m: [f64; 2],
    side: usize,
    cells: Vec<bool>,
    /// Columns and rows that may hold any: first and last.
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Set {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a window of some metres in cells"
    )]
    fn new(state: &State, reach_m: f64) -> Self {
        let half = ((reach_m / CELL_M).ceil() as usize + 2).min(SIDE_MAX / 2);
        let side = 2 * half + 1;
        let mut cells = vec![false; side * side];
        cells[half * side + half] = true;
        // The robot is in the middle of the middle cell.
        let to_corner_m = (half as f64 + 0.5) * CELL_M;
        Self {
            corner_m: [state.at_m[0] - to_corner_m, state.at_m[1] - to_corner_m],
            side,
            cells,
            columns: [half; 2],
            rows: [half; 2],
        }
    }

    /// Adds every cell with a point that is within `by_m` of a point of one that is in it.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a few cells"
    )]
    fn grow(&mut self, by_m: f64) {
        let by = by_m / CELL_M;
        let whole = by.ceil() as usize + 1;
        // How far to either side a row that is `dy` away reaches.
        let reach: Vec<usize> = (0..=whole)
            .map(|dy| {
                let between = dy.saturating_sub(1) as f64;
                if between > by {
                    0
                } else {
                    (by * by - between * between).sqrt().floor() as usize + 1
                }
            })
            .collect();
        let old = self.cells.clone();
        let (last, columns, rows) = (self.side - 1, self.columns, self.rows);
        for y in rows[0]..=rows[1] {
            for x in columns[0]..=columns[1] {
                if !old[y * self.side + x] {
                    continue;
                }
                // A cell among cells adds nothing that they do not add.
                let inner = x > 0
                    && x < last
                    && y > 0
                    && y < last
                    && old[y * self.side + x - 1]
                    && old[y * self.side + x + 1]
                    && old[(y - 1) * self.side + x]
                    && old[(y + 1) * self.side + x];
                if inner {
                    continue;
                }
                for to in y.saturating_sub(whole)..=(y + whole).min(last) {
                    let far = reach[to.abs_diff(y)];
                    if far == 0 {
                        continue;
                    }
                    let from = to * self.side;
                    let (left, right) = (x.saturating_sub(far), (x + far).min(last));
                    self.cells[from + left..=from + right].fill(true);
                }
            }
        }
        let wider =
            |range: [usize; 2]| [range[0].saturating_sub(whole), (range[1] + whole).min(last)];
        (self.columns, self.rows) = (wider(columns), wider(rows));
    }

    /// Leaves the cells with a point in the box where a disc of `radius_m` touches nothing.
    #[allow(clippy::cast_precision_loss, reason = "a few hundred cells")]
    fn retain(
        &mut self,
        within: &Reach,
        radius_m: f64,
        discs: &[Disc],
        fixed_m: &dyn Fn([f64; 2]) -> f64,
    ) {
        let slack_m = CELL_M * core::f64::consts::FRAC_1_SQRT_2;
        let mut columns = [usize::MAX, 0];
        let mut rows = [usize::MAX, 0];
        for y in self.rows[0]..=self.rows[1] {
            for x in self.columns[0]..=self.columns[1] {
                let cell = &mut self.cells[y * self.side + x];
                if !*cell {
                    continue;
                }
                let at_m = [
                    self.corner_m[0] + (x as f64 + 0.5) * CELL_M,
                    self.corner_m[1] + (y as f64 + 0.5) * CELL_M,
                ];
                // Only a cell in which every place touches something is lost.
                let is_free = |(centre, radius): &Disc| {
                    let apart_m = (centre[0] - at_m[0]).hypot(centre[1] - at_m[1]);
                    apart_m > radius + radius_m - slack_m
                };
                *cell = within.holds(at_m, slack_m)
                    && discs.iter().all(is_free)
                    && fixed_m(at_m) > radius_m - slack_m;
                if *cell {
                    columns = [columns[0].min(x), columns[1].max(x)];
                    rows = [rows[0].min(y), rows[1].max(y)];
                }
            }
        }
        if columns[0] == usize::MAX {
            // Empty: ranges with nothing in them.
            (columns, rows) = ([1, 0], [1, 0]);
        }
        (self.columns, self.rows) = (columns, rows);
    }

    fn is_empty(&self) -> bool {
        self.rows[0] > self.rows[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;
    use zeronav_msgs::Pose;

    const RADIUS_M: f64 = 0.215;

    /// Those of a robot of 0.508 m by 0.43 m.
    fn abilities() -> Abilities {
        let corners = [
            [-0.254, -0.215],
            [0.254, -0.215],
            [0.254, 0.215],
            [-0.254, 0.215],
        ];
        let footprint = Footprint::polygon(&corners).unwrap();
        Abilities {
            outline: footprint.form().clone(),
            reach_m: footprint.circumscribed_radius_m(),
            radius_m: footprint.inscribed_radius_m(),
            v_mps: [0.0, 2.0],
            w_radps_max: 4.0,
            a_mps2_max: 3.0,
            alpha_radps2_max: 8.0,
        }
    }

    const fn state(v_mps: f64) -> State {
        State {
            t_s: 5.0,
            at_m: [1.0, 2.0],
            yaw_rad: 0.0,
            v_mps,
            w_radps: 0.0,
        }
    }

    fn unavoidable(state: &State, contact_s: f64, discs_at: &dyn Fn(f64) -> Vec<Disc>) -> bool {
        let around = Surroundings {
            discs_at,
            fixed_m: &|_| f64::INFINITY,
        };
        is_unavoidable(state, contact_s, &abilities(), &around)
    }

    /// A wall of discs across the way, `ahead_m` before the robot's nose.
    fn wall(ahead_m: f64) -> Vec<Disc> {
        let x = 1.0 + RADIUS_M + ahead_m + 0.3;
        (-20..=20)
            .map(|i| ([x, 2.0 + 0.2 * f64::from(i)], 0.3))
            .collect()
    }

    #[test]
    fn what_cannot_be_braked_for_is_unavoidable_and_what_can_is_not() {
        // 2 m/s and 3 m/s^2: 0.67 m to stand still. One cell and half a diagonal are forgiven.
        assert!(unavoidable(&state(2.0), 5.2, &|_| wall(0.30)));
        assert!(!unavoidable(&state(2.0), 5.2, &|_| wall(0.70)));
        assert!(!unavoidable(&state(0.0), 5.2, &|_| wall(0.05)));
        // A post of that width is not passed either: turning takes longer than braking.
        let post = |_| vec![([1.0 + 0.215 + 0.2 + 0.3, 2.0], 0.3)];
        assert!(unavoidable(&state(2.0), 5.1, &post));
    }

    #[test]
    fn who_is_walked_at_in_the_open_can_step_aside_and_who_is_surrounded_cannot() {
        let walker = |t: f64| vec![([4.0 - (t - 5.0), 2.0], 0.3)];
        assert!(!unavoidable(&state(0.0), 8.0, &walker));
        let closing = |t: f64| -> Vec<Disc> {
            let radius = (2.0 - 0.9 * (t - 5.0)).max(0.0);
            (0..32)
                .map(|i| f64::from(i) * core::f64::consts::TAU / 32.0)
                .map(|a| ([1.0 + radius * a.cos(), 2.0 + radius * a.sin()], 0.3))
                .collect()
        };
        assert!(unavoidable(&state(0.0), 7.0, &closing));
        // From far before there is time to get out, of a ring that is open.
        let open = |t: f64| closing(t)[2..].to_vec();
        assert!(!unavoidable(&state(0.0), 5.5, &open));
    }

    #[test]
    fn who_appears_on_top_of_the_robot_cannot_be_avoided() {
        // There for 50 ms only: it is the moment of the contact that tells.
        let passing = |ahead_m: f64| {
            move |t: f64| -> Vec<Disc> {
                let there = (t < 5.05).then_some(([1.0 + ahead_m, 2.0], 0.3));
                there.into_iter().collect()
            }
        };
        assert!(unavoidable(&state(1.5), 5.012, &passing(0.4)));
        assert!(!unavoidable(&state(1.5), 5.012, &passing(0.6)));
    }

    #[test]
    fn walls_count_too() {
        let none = |_: f64| Vec::new();
        let corridor = |at: [f64; 2]| (0.3 - (at[1] - 2.0).abs()).max(0.0);
        let dead_end = |at: [f64; 2]| corridor(at).min((1.6 - at[0]).max(0.0));
        let run = |fixed_m: &dyn Fn([f64; 2]) -> f64| {
            let around = Surroundings {
                discs_at: &none,
                fixed_m,
            };
            is_unavoidable(&state(2.0), 5.4, &abilities(), &around)
        };
        assert!(!run(&corridor));
        assert!(run(&dead_end));
    }

    /// The proof is one: when it says unavoidable, no drive that the robot can make gets through.
    #[test]
    fn no_drive_escapes_what_is_called_unavoidable() {
        let mut dice = Pcg64Mcg::seed_from_u64(6);
        let (mut proved, mut escapes) = (0, 0);
        for _ in 0..60 {
            let start = State {
                w_radps: dice.random_range(-2.0..2.0),
                ..state(dice.random_range(0.0..2.0))
            };
            let walkers: Vec<([f64; 2], [f64; 2])> = (0..25)
                .map(|_| {
                    let at = [dice.random_range(-1.0..4.0), dice.random_range(0.0..4.0)];
                    let v = [dice.random_range(-1.5..1.5), dice.random_range(-1.5..1.5)];
                    (at, v)
                })
                .collect();
            let discs_at = |t: f64| -> Vec<Disc> {
                let along = t - start.t_s;
                walkers
                    .iter()
                    .map(|(at, v)| ([at[0] + v[0] * along, at[1] + v[1] * along], 0.3))
                    .filter(|(at, _)| along > 0.0 || (at[0] - 1.0).hypot(at[1] - 2.0) > 0.6)
                    .collect()
            };
            let contact_s = start.t_s + 0.6;
            let verdict = unavoidable(&start, contact_s, &discs_at);
            proved += usize::from(verdict);
            let escaped =
                (0..300).any(|_| drive(&start, contact_s + AFTER_S, &discs_at, &mut dice));
            escapes += usize::from(escaped);
            assert!(!(verdict && escaped), "{start:?}");
        }
        // Both happen, so the test can fail.
        assert!(
            proved >= 5 && escapes >= 5,
            "{proved} proved, {escapes} escapes"
        );
    }

    /// Goes towards a speed and a yaw rate for a moment.
    fn go(now: &mut State, (v, w): (f64, f64), step_s: f64) {
        now.v_mps += (v - now.v_mps).clamp(-3.0 * step_s, 3.0 * step_s);
        now.w_radps += (w - now.w_radps).clamp(-8.0 * step_s, 8.0 * step_s);
        now.yaw_rad += now.w_radps * step_s;
        now.at_m[0] += now.v_mps * now.yaw_rad.cos() * step_s;
        now.at_m[1] += now.v_mps * now.yaw_rad.sin() * step_s;
        now.t_s += step_s;
    }

    /// The same of the other proof, with the robot's outline and somebody who has just appeared.
    #[test]
    fn no_drive_escapes_who_is_touched_anyhow() {
        let abilities = abilities();
        let mut dice = Pcg64Mcg::seed_from_u64(9);
        let (mut proved, mut escaped) = (0, 0);
        for _ in 0..300 {
            let start = State {
                yaw_rad: dice.random_range(-3.0..3.0),
                w_radps: dice.random_range(-2.0..2.0),
                ..state(dice.random_range(0.0..2.0))
            };
            let (sin, cos) = (start.yaw_rad + dice.random_range(-1.0..1.0_f64)).sin_cos();
            let (far_m, speed_mps) = (dice.random_range(0.5..1.2), dice.random_range(0.0..1.5));
            let discs_at = |t: f64| -> Vec<Disc> {
                let far_m = far_m - speed_mps * (t - start.t_s);
                vec![([1.0 + far_m * cos, 2.0 + far_m * sin], 0.3)]
            };
            let lead_s = MOMENT_S * f64::from(dice.random_range(0..12_u8));
            let around = Surroundings {
                discs_at: &discs_at,
                fixed_m: &|_| f64::INFINITY,
            };
            let verdict = touches_anyhow(&start, start.t_s + lead_s, &abilities, &around);
            let mut gets_away = || {
                let mut now = start;
                let asked = [(0.0, 2.0), (-4.0, 4.0)]
                    .map(|(low, high)| [low, high, dice.random_range(low..=high)]);
                let which = [0, 1].map(|n| asked[n][dice.random_range(0..3_usize)]);
                while now.t_s < start.t_s + lead_s + MOMENT_S * f64::from(MOMENTS) + 1e-9 {
                    let pose = Pose::new(now.at_m[0], now.at_m[1], now.yaw_rad);
                    let body = abilities.outline.placed(&pose);
                    let looked_at = now.t_s > start.t_s + lead_s - 1e-9;
                    let touches = |([x, y], radius_m): &Disc| {
                        body.distance_to_point_m(Point2::new(*x, *y)) < *radius_m
                    };
                    if looked_at && discs_at(now.t_s).iter().any(touches) {
                        return false;
                    }
                    for _ in 0..20 {
                        go(&mut now, (which[0], which[1]), MOMENT_S / 20.0);
                    }
                }
                true
            };
            let got_away = (0..60).any(|_| gets_away());
            assert!(!(verdict && got_away), "{start:?} {lead_s}");
            proved += usize::from(verdict);
            escaped += usize::from(got_away);
        }
        assert!(proved >= 30 && escaped >= 30, "{proved} {escaped}");
    }

    /// A drive with commands at random, every fifth of a second; true when it touches nothing at
    /// the moments that the oracle looks at.
    fn drive(
        start: &State,
        until_s: f64,
        discs_at: &dyn Fn(f64) -> Vec<Disc>,
        dice: &mut Pcg64Mcg,
    ) -> bool {
        let mut now = *start;
        while now.t_s < until_s - 1e-9 {
            let (v, w) = (dice.random_range(0.0..=2.0), dice.random_range(-4.0..=4.0));
            let step_s = STEP_S / 100.0;
            for _ in 0..100 {
                go(&mut now, (v, w), step_s);
            }
            let touches = |(at, radius): &Disc| {
                (at[0] - now.at_m[0]).hypot(at[1] - now.at_m[1]) <= radius + RADIUS_M
            };
            if discs_at(now.t_s).iter().any(touches) {
                return false;
            }
        }
        true
    }
}
