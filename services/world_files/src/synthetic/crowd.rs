//! People who walk to and fro and avoid each other and the walls by social forces (Helbing,
//! Molnár, "Social force model for pedestrian dynamics", Physical Review E 51(5), 1995), in the
//! form of a recording. Nobody sees the robot, as in a recording.
//!
//! Of the model: the pull towards the target (Eq. 2), the repulsion by others and by walls with
//! the paper's strengths and ranges (Eqs. 3 and 5, section III), halved for those out of sight
//! (Eqs. 7 and 8), the top speed (Eq. 10). Repulsion is round instead of elliptical and counts from
//! body to body, so that no two walk through each other; there are no groups. A new target is drawn
//! at random on the other side, which takes the place of the model's fluctuations.

use super::{NoPassage, first_passable, millimetres};
use crate::pedestrians::Scene;
use nalgebra::{Point2, Vector2};
use rand::RngExt as _;
use rand_pcg::Pcg64Mcg;

/// Time from sample to sample, as in the recordings. [s]
pub const SAMPLE_S: f64 = 0.4;

/// Steps of the integration per sample.
const STEPS: u32 = 8;

/// Time in which a walker comes back to the speed that he wants, tau. [s]
const RELAX_S: f64 = 0.5;

/// Repulsion by another, V0 / sigma [m/s^2], and its range, sigma [m].
const OTHERS: [f64; 2] = [2.1 / 0.3, 0.3];

/// Repulsion by a wall, U0 / R [m/s^2], and its range, R [m].
const WALLS: [f64; 2] = [10.0 / 0.2, 0.2];

/// Diameter of a body. [m]
const BODY_M: f64 = 0.4;

/// Weight of what is out of sight, and the cosine of the edge of sight, 100 deg.
const BEHIND: f64 = 0.5;
const SIGHT_COS: f64 = -0.173_648_177_666_930_33;

/// Mean of the speeds that walkers want, and how far they are from it at most. [m/s]
const WANTED_MPS: [f64; 2] = [1.34, 0.4];

/// Top speed per wanted speed.
const HURRY: f64 = 1.3;

/// Nearer than this a target counts as reached. [m]
const THERE_M: f64 = 0.5;

/// Distance between two at the beginning, at least. [m]
const APART_M: f64 = 0.8;

/// Tries to place everybody.
const TRIES: u32 = 100;

/// Who walks, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Walkers.
    pub n: usize,
    /// Lower left and upper right corner of a room with walls. [m]
    pub room_m: [[f64; 2]; 2],
    /// Length of the recording. [s]
    pub lasts_s: f64,
}

/// A walker between two samples.
struct Walker {
    at: Point2<f64>,
    v_mps: Vector2<f64>,
    wanted_mps: f64,
    /// 0 walks along x, 1 along y.
    axis: usize,
    target: Point2<f64>,
}

/// Records a walk.
///
/// # Errors
/// [`NoPassage`] when the room has no place for so many.
pub fn record(rule: &Rule, seed: u64) -> Result<Scene, NoPassage> {
    first_passable(seed, TRIES, |rng| walk(rule, rng))
}

/// A walk from a random beginning; `None` when the room is too small for all.
pub(super) fn walk(rule: &Rule, rng: &mut Pcg64Mcg) -> Option<Scene> {
    let mut walkers: Vec<Walker> = Vec::new();
    for index in 0..rule.n {
        let axis = index % 2;
        let at = (0..100)
            .map(|_| anywhere(rule, rng))
            .find(|at| walkers.iter().all(|other| (other.at - at).norm() > APART_M))?;
        let target = beyond(rule, at, axis, rng);
        walkers.push(Walker {
            at,
            v_mps: Vector2::zeros(),
            wanted_mps: WANTED_MPS[0] + rng.random_range(-WANTED_MPS[1]..WANTED_MPS[1]),
            axis,
            target,
        });
    }
    let mut scene = Scene {
        walkers: (0..)
            .zip(&walkers)
            .map(|(id, _)| (id, Vec::new()))
            .collect(),
    };
    let step_s = SAMPLE_S / f64::from(STEPS);
    let mut sample = 0_u32;
    while f64::from(sample) * SAMPLE_S <= rule.lasts_s {
        let t_s = millimetres(f64::from(sample) * SAMPLE_S);
        for (samples, walker) in scene.walkers.values_mut().zip(&walkers) {
            samples.push([t_s, millimetres(walker.at.x), millimetres(walker.at.y)]);
        }
        for _ in 0..STEPS {
            let pushes: Vec<Vector2<f64>> = (0..walkers.len())
                .map(|index| push(rule, &walkers, index))
                .collect();
            for (walker, push) in walkers.iter_mut().zip(pushes) {
                walker.v_mps += push * step_s;
                let fastest_mps = HURRY * walker.wanted_mps;
                walker.v_mps = walker.v_mps.cap_magnitude(fastest_mps);
                walker.at += walker.v_mps * step_s;
                if (walker.target - walker.at).norm() < THERE_M {
                    walker.target = beyond(rule, walker.at, walker.axis, rng);
                }
            }
        }
        sample += 1;
    }
    Some(scene)
}

/// Acceleration of a walker. [m/s^2]
fn push(rule: &Rule, walkers: &[Walker], index: usize) -> Vector2<f64> {
    let walker = &walkers[index];
    let ahead = (walker.target - walker.at).try_normalize(1.0e-9);
    let ahead = ahead.unwrap_or_else(Vector2::x);
    let mut sum = (ahead * walker.wanted_mps - walker.v_mps) / RELAX_S;
    let others = walkers.iter().enumerate();
    for (_, other) in others.filter(|(other, _)| *other != index) {
        let apart = walker.at - other.at;
        let apart_m = apart.norm().max(1.0e-3);
        let away = apart / apart_m;
        let seen = ahead.dot(&-away) >= SIGHT_COS;
        let weight = if seen { 1.0 } else { BEHIND };
        sum += away * (weight * OTHERS[0] * ((BODY_M - apart_m) / OTHERS[1]).exp());
    }
    let [lower, upper] = rule.room_m;
    for axis in 0..2 {
        let from = |wall: f64| WALLS[0] * (-(walker.at[axis] - wall).abs() / WALLS[1]).exp();
        sum[axis] += from(lower[axis]) - from(upper[axis]);
    }
    sum
}

/// Room beside the walls in which targets lie. [m]
const BESIDE_M: f64 = 0.8;

fn anywhere(rule: &Rule, rng: &mut Pcg64Mcg) -> Point2<f64> {
    let [lower, upper] = rule.room_m;
    let along = |axis: usize, rng: &mut Pcg64Mcg| {
        rng.random_range(lower[axis] + BESIDE_M..upper[axis] - BESIDE_M)
    };
    let x = along(0, rng);
    Point2::new(x, along(1, rng))
}

/// A target at the other end of the room along `axis`.
fn beyond(rule: &Rule, at: Point2<f64>, axis: usize, rng: &mut Pcg64Mcg) -> Point2<f64> {
    let [lower, upper] = rule.room_m;
    let middle = 0.5 * (lower[axis] + upper[axis]);
    let mut target = anywhere(rule, rng);
    target[axis] = if at[axis] < middle {
        upper[axis] - BESIDE_M
    } else {
        lower[axis] + BESIDE_M
    };
    target
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walkers_keep_apart_stay_inside_and_get_somewhere() {
        let rule = Rule {
            n: 8,
            room_m: [[1.0, -2.0], [10.0, 5.0]],
            lasts_s: 60.0,
        };
        let scene = record(&rule, 4).unwrap();
        assert_eq!(scene, record(&rule, 4).unwrap());
        assert_ne!(scene, record(&rule, 5).unwrap());
        let walks: Vec<&Vec<[f64; 3]>> = scene.walkers.values().collect();
        assert_eq!((walks.len(), walks[0].len()), (8, 151));
        let mut nearest_m = f64::INFINITY;
        for (index, walk) in walks.iter().enumerate() {
            let mut walked_m = 0.0;
            for (n, [_, x, y]) in walk.iter().enumerate() {
                assert!(
                    (1.0..10.0).contains(x) && (-2.0..5.0).contains(y),
                    "{x} {y}"
                );
                for other in &walks[..index] {
                    nearest_m = (other[n][1] - x).hypot(other[n][2] - y).min(nearest_m);
                }
                if n > 0 {
                    walked_m += (x - walk[n - 1][1]).hypot(y - walk[n - 1][2]);
                }
            }
            let mean_mps = walked_m / 60.0;
            assert!((0.6..1.8).contains(&mean_mps), "{mean_mps} m/s");
        }
        assert!(nearest_m > 0.2, "{nearest_m} m");
    }

    #[test]
    fn a_room_without_place_is_an_error() {
        let rule = Rule {
            n: 100,
            room_m: [[0.0, 0.0], [3.0, 3.0]],
            lasts_s: 1.0,
        };
        assert_eq!(record(&rule, 1).unwrap_err().tried, TRIES);
    }
}
