//! Cylinders that go round whatever the robot does: in an arena as in `DynaBARN`, and on circles.

use super::passage::{Disc, Robot, crossing_s};
use super::{NoPassage, first_passable, millimetres};
use crate::dynabarn::{self, DynabarnWorld};
use core::f64::consts::TAU;
use core::ops::Range;
use nalgebra::Point2;
use rand::RngExt as _;
use rand_pcg::Pcg64Mcg;
use zeronav_world::World;
use zeronav_world::track::Track;

/// Worlds that are drawn until one can be passed.
const TRIES: u32 = 100;

/// Half the side of the arena. [m]
const HALF_M: f64 = 10.0;

/// Rows of a circle; the last is the first again.
const CIRCLE_ROWS: u32 = 32;

/// Moments of the rounds at which a run may begin and that are looked at. [s]
const PHASES_S: [f64; 3] = [0.0, 17.0, 41.0];

/// How much goes round.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Cylinders.
    pub n: usize,
    /// Their speeds. [m/s]
    pub speed_mps: Range<f64>,
}

/// Draws a world in the form of `DynaBARN` that `robot` can cross within the challenge's time.
/// Each cylinder enters the arena on its edge, bends towards a point inside and leaves on the
/// edge; then it begins again.
///
/// # Errors
/// [`NoPassage`] when none of many can be crossed.
pub fn arena(rule: &Rule, robot: Robot, seed: u64) -> Result<DynabarnWorld, NoPassage> {
    first_passable(seed, TRIES, |rng| {
        let world = DynabarnWorld {
            rounds: (0..rule.n).map(|_| bend(rule, rng)).collect(),
        };
        let asked = World::new(&world.spec(0.0), None).ok()?;
        let ends = [dynabarn::START.point(), dynabarn::GOAL.point()];
        let (tolerance_m, limit_s) = (dynabarn::GOAL_TOLERANCE_M, dynabarn::TIME_LIMIT_S);
        let crossed = PHASES_S.iter().all(|phase_s| {
            let discs_at = discs(&world.rounds, *phase_s, dynabarn::RADIUS_M);
            crossing_s(&asked, robot, ends, tolerance_m, limit_s, &discs_at).is_some()
        });
        crossed.then_some(world)
    })
}

/// Where the cylinders of `rounds` are at moments of a run that begins at `phase_s`.
pub(super) fn discs(
    rounds: &[Vec<[f64; 3]>],
    phase_s: f64,
    radius_m: f64,
) -> impl Fn(f64) -> Vec<Disc> + use<> {
    let tracks: Vec<Track> = rounds
        .iter()
        .map(|round| Track::new(round, true, phase_s))
        .collect();
    move |t_s| {
        let disc = |track: &Track| (track.at(t_s), radius_m);
        tracks.iter().map(disc).collect()
    }
}

/// A curve of second order from edge to edge, in steps of half a second.
fn bend(rule: &Rule, rng: &mut Pcg64Mcg) -> Vec<[f64; 3]> {
    const ROW_S: f64 = 0.5;
    let edge = |rng: &mut Pcg64Mcg| {
        let along = rng.random_range(-HALF_M..HALF_M);
        match rng.random_range(0..4_u32) {
            0 => Point2::new(along, -HALF_M),
            1 => Point2::new(HALF_M, along),
            2 => Point2::new(along, HALF_M),
            _ => Point2::new(-HALF_M, along),
        }
    };
    let from = edge(rng);
    let to = loop {
        let to = edge(rng);
        if (to - from).norm() > HALF_M {
            break to;
        }
    };
    let inner = 0.8 * HALF_M;
    let through = Point2::new(
        rng.random_range(-inner..inner),
        rng.random_range(-inner..inner),
    );
    let speed_mps = rng.random_range(rule.speed_mps.clone());
    let at = |share: f64| {
        let first = from + (through - from) * share;
        let second = through + (to - through) * share;
        first + (second - first) * share
    };
    let length_m: f64 = (0..100)
        .map(|n| (at(f64::from(n + 1) / 100.0) - at(f64::from(n) / 100.0)).norm())
        .sum();
    let n_rows = (length_m / speed_mps / ROW_S).ceil().max(1.0);
    let mut rows = Vec::new();
    let mut row = 0.0;
    while row <= n_rows {
        let point = at(row / n_rows);
        rows.push([row * ROW_S, millimetres(point.x), millimetres(point.y)]);
        row += 1.0;
    }
    rows
}

/// Draws a round on a circle that stays within the box from `lower` to `upper`.
pub(super) fn circle(
    rule: &Rule,
    [lower, upper]: [Point2<f64>; 2],
    rng: &mut Pcg64Mcg,
) -> Vec<[f64; 3]> {
    let most_m = 0.5 * (upper.x - lower.x).min(upper.y - lower.y);
    let radius_m = rng.random_range(0.3 * most_m..most_m);
    let centre = [(lower.x, upper.x), (lower.y, upper.y)]
        .map(|(low, high)| rng.random_range(low + radius_m..=high - radius_m));
    let speed_mps = rng.random_range(rule.speed_mps.clone());
    let from_rad = rng.random_range(0.0..TAU);
    let way = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let period_s = TAU * radius_m / speed_mps;
    (0..=CIRCLE_ROWS)
        .map(|row| {
            let share = f64::from(row % CIRCLE_ROWS) / f64::from(CIRCLE_ROWS);
            let (sin, cos) = (from_rad + way * TAU * share).sin_cos();
            let t_s = millimetres(period_s * f64::from(row) / f64::from(CIRCLE_ROWS));
            let x = millimetres(centre[0] + radius_m * cos);
            [t_s, x, millimetres(centre[1] + radius_m * sin)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;

    fn rule() -> Rule {
        Rule {
            n: 6,
            speed_mps: 0.5..1.0,
        }
    }

    #[test]
    fn rounds_of_an_arena_begin_and_end_on_its_edge_at_the_speed_asked_for() {
        let world = arena(&rule(), Robot { radius_m: 0.33 }, 3).unwrap();
        assert_eq!(world, arena(&rule(), Robot { radius_m: 0.33 }, 3).unwrap());
        assert_eq!(world.rounds.len(), 6);
        for round in &world.rounds {
            Track::check(round).unwrap();
            for end in [round[0], round[round.len() - 1]] {
                let edge_m = end[1].abs().max(end[2].abs());
                assert!((edge_m - HALF_M).abs() < 1e-9, "{end:?}");
            }
            let length_m: f64 = round
                .windows(2)
                .map(|rows| (rows[1][1] - rows[0][1]).hypot(rows[1][2] - rows[0][2]))
                .sum();
            let mean_mps = length_m / round[round.len() - 1][0];
            assert!((0.45..=1.0).contains(&mean_mps), "{mean_mps} m/s");
        }
    }

    #[test]
    fn a_circle_closes_and_stays_in_its_box() {
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        let corners = [Point2::new(2.0, 1.0), Point2::new(9.0, 5.0)];
        for _ in 0..50 {
            let round = circle(&rule(), corners, &mut rng);
            Track::check(&round).unwrap();
            assert_eq!(round[0][1..], round[round.len() - 1][1..]);
            assert!(Track::new(&round, true, 0.0).next_jump_s(0.0).is_none());
            for [_, x, y] in &round {
                assert!(
                    (2.0..=9.0).contains(x) && (1.0..=5.0).contains(y),
                    "{x} {y}"
                );
            }
            let speed_mps = Track::new(&round, true, 0.0).speed_mps_max();
            assert!((0.48..1.02).contains(&speed_mps), "{speed_mps} m/s");
        }
    }
}
