//! The numbered worlds of `zeronav suite generated`: static clutter of rising density, cylinders on
//! circles and people who walk, three levels each. World N is of class N modulo 9 and drawn from
//! seed N, so any range of numbers holds all classes about equally often.

use super::clutter::{self, Clutter};
use super::crowd;
use super::orbits::{self, circle};
use super::passage::{Disc, Robot, crossing_s};
use super::{NoPassage, first_passable};
use crate::barn;
use crate::pedestrians::Playback;
use nalgebra::Point2;
use rand::RngExt as _;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_world::spec::{ObstacleSpec, ShapeSpec};
use zeronav_world::track::Track;
use zeronav_world::{World, WorldSpec};

/// Radius of a cylinder and of a person. [m]
const DISC_M: f64 = 0.3;

/// The room of what moves, inside of its walls. [m]
const ROOM_M: [[f64; 2]; 2] = [[0.0, 0.0], [14.0, 7.0]];

/// Where things move in it: start and goal lie beside. [m]
const FIELD_M: [[f64; 2]; 2] = [[2.5, 0.3], [11.5, 6.7]];

/// Start and goal of that room.
const START: Pose = Pose::new(1.0, 3.5, 0.0);
const GOAL: Pose = Pose::new(13.0, 3.5, 0.0);

/// Run time that a robot has, and in which a drive must have been found. [s]
const LIMITS_S: [f64; 2] = [60.0, 45.0];

/// Moments of the rounds from which a run may begin. [s]
const PHASE_S_MAX: f64 = 600.0;

/// Phases or walks that are tried.
const TRIES: u32 = 100;

/// What is in the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Cylinders that stand, see [`clutter`].
    Static,
    /// Cylinders on circles, see [`orbits`].
    Orbits,
    /// People, see [`crowd`].
    Walkers,
}

/// How much of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Little.
    Easy,
    /// More.
    Medium,
    /// Much.
    Hard,
}

/// A sort of worlds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Class {
    /// What is in the way.
    pub kind: Kind,
    /// How much of it.
    pub level: Level,
}

impl Class {
    /// How many there are.
    pub const COUNT: u32 = 9;

    /// That of a world.
    #[must_use]
    pub const fn of(number: u32) -> Self {
        let kind = match number % 3 {
            0 => Kind::Static,
            1 => Kind::Orbits,
            _ => Kind::Walkers,
        };
        let level = match number / 3 % 3 {
            0 => Level::Easy,
            1 => Level::Medium,
            _ => Level::Hard,
        };
        Self { kind, level }
    }

    /// Its name.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match (self.kind, self.level) {
            (Kind::Static, Level::Easy) => "static_1_easy",
            (Kind::Static, Level::Medium) => "static_2_medium",
            (Kind::Static, Level::Hard) => "static_3_hard",
            (Kind::Orbits, Level::Easy) => "orbits_1_easy",
            (Kind::Orbits, Level::Medium) => "orbits_2_medium",
            (Kind::Orbits, Level::Hard) => "orbits_3_hard",
            (Kind::Walkers, Level::Easy) => "walkers_1_easy",
            (Kind::Walkers, Level::Medium) => "walkers_2_medium",
            (Kind::Walkers, Level::Hard) => "walkers_3_hard",
        }
    }

    /// One of three by the level.
    fn by_level<T>(self, [easy, medium, hard]: [T; 3]) -> T {
        match self.level {
            Level::Easy => easy,
            Level::Medium => medium,
            Level::Hard => hard,
        }
    }
}

/// A world to be crossed.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// The world for a scenario.
    pub spec: WorldSpec,
    /// `map_from_base` at the start.
    pub start: Pose,
    /// `map_from_base` at the end, any yaw.
    pub goal: Pose,
    /// How near the goal counts. [m]
    pub goal_tolerance_m: f64,
    /// Run time. [s]
    pub time_limit_s: f64,
    /// Length of a drive that is known. [m]
    pub reference_m: f64,
    /// True when something moves.
    pub moves: bool,
}

/// Draws world `number`. What moves does so in another way for each `seed`: another moment of the
/// same rounds, another walk; static obstacles are the same.
///
/// # Errors
/// [`NoPassage`] when none of many worlds, phases or walks can be passed.
pub fn draw(number: u32, seed: u64, robot: Robot) -> Result<Course, NoPassage> {
    let class = Class::of(number);
    let of_run = (u64::from(number) << 32) ^ seed;
    match class.kind {
        Kind::Static => stand(class, number, robot),
        Kind::Orbits => go_round(class, number, of_run, robot),
        Kind::Walkers => walk(class, of_run, robot),
    }
}

fn stand(class: Class, number: u32, robot: Robot) -> Result<Course, NoPassage> {
    let [fill_ratio, smoothings] = class.by_level([[0.12, 3.0], [0.18, 3.0], [0.24, 2.0]]);
    let rule = clutter::Rule {
        fill_ratio,
        smoothings: smoothings.to_u32(),
    };
    let Clutter {
        world,
        path_length_m,
    } = clutter::draw(rule, robot, number.into())?;
    Ok(Course {
        spec: world.spec(),
        start: barn::START,
        goal: barn::GOAL,
        goal_tolerance_m: barn::GOAL_TOLERANCE_M,
        time_limit_s: barn::TIME_LIMIT_S,
        reference_m: path_length_m,
        moves: false,
    })
}

fn go_round(class: Class, number: u32, of_run: u64, robot: Robot) -> Result<Course, NoPassage> {
    let rule = orbits::Rule {
        n: class.by_level([3, 6, 9]),
        speed_mps: class.by_level([0.3..0.6, 0.4..0.8, 0.5..1.0]),
    };
    let box_m = FIELD_M.map(Point2::from);
    let rounds = first_passable(number.into(), 1, |rng| {
        let rounds: Vec<_> = (0..rule.n).map(|_| circle(&rule, box_m, rng)).collect();
        Some(rounds)
    })?;
    first_passable(of_run, TRIES, |rng| {
        let phase_s = super::millimetres(rng.random_range(0.0..PHASE_S_MAX));
        let obstacle = |(index, round): (usize, &Vec<[f64; 3]>)| {
            let at = Track::new(round, true, phase_s).at(0.0);
            ObstacleSpec {
                track: round.clone(),
                track_from_s: phase_s,
                repeat: true,
                ..ObstacleSpec::standing(format!("cylinder {index}"), disc(at))
            }
        };
        let obstacles = rounds.iter().enumerate().map(obstacle).collect();
        let discs_at = orbits::discs(&rounds, phase_s, DISC_M);
        in_room(obstacles, robot, &discs_at)
    })
}

fn walk(class: Class, of_run: u64, robot: Robot) -> Result<Course, NoPassage> {
    let rule = crowd::Rule {
        n: class.by_level([3, 6, 9]),
        room_m: FIELD_M,
        lasts_s: LIMITS_S[0] + crowd::SAMPLE_S,
    };
    first_passable(of_run, TRIES, |rng| {
        let scene = crowd::walk(&rule, rng)?;
        let playback = Playback {
            from_s: 0.0,
            duration_s: None,
            radius_m: DISC_M,
        };
        let tracks: Vec<Track> = scene
            .walkers
            .values()
            .map(|samples| Track::new(samples, false, 0.0))
            .collect();
        let discs_at = |t_s| tracks.iter().map(|track| (track.at(t_s), DISC_M)).collect();
        in_room(scene.obstacles(&playback), robot, &discs_at)
    })
}

fn disc(at: Point2<f64>) -> ShapeSpec {
    ShapeSpec::Disc {
        centre_m: [at.x, at.y],
        radius_m: DISC_M,
    }
}

/// A walled room with obstacles; `None` when no drive through it was found.
fn in_room(
    obstacles: Vec<ObstacleSpec>,
    robot: Robot,
    discs_at: &dyn Fn(f64) -> Vec<Disc>,
) -> Option<Course> {
    /// Thickness of a wall. [m]
    const WALL_M: f64 = 0.2;
    let [[left, low], [right, high]] = ROOM_M;
    let (width, height) = (right - left + 2.0 * WALL_M, high - low);
    let (middle_x, middle_y) = (0.5 * (left + right), 0.5 * (low + high));
    let wall = |centre_m, size_m| ShapeSpec::Box {
        centre_m,
        size_m,
        yaw_rad: 0.0,
    };
    let spec = WorldSpec {
        shapes: vec![
            wall([middle_x, low - 0.5 * WALL_M], [width, WALL_M]),
            wall([middle_x, high + 0.5 * WALL_M], [width, WALL_M]),
            wall([left - 0.5 * WALL_M, middle_y], [WALL_M, height]),
            wall([right + 0.5 * WALL_M, middle_y], [WALL_M, height]),
        ],
        obstacles,
        ..WorldSpec::area([left - 0.5, low - 0.5], [right + 0.5, high + 0.5])
    };
    let world = World::new(&spec, None).ok()?;
    let ends = [START.point(), GOAL.point()];
    let tolerance_m = barn::GOAL_TOLERANCE_M;
    crossing_s(
        &world,
        robot,
        ends,
        0.5 * tolerance_m,
        LIMITS_S[1],
        discs_at,
    )?;
    Some(Course {
        spec,
        start: START,
        goal: GOAL,
        goal_tolerance_m: tolerance_m,
        time_limit_s: LIMITS_S[0],
        reference_m: START.distance_m(&GOAL),
        moves: true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use zeronav_world::Footprint;

    /// The outline of a Jackal.
    fn outline() -> Footprint {
        let (x, y) = (0.254, 0.215);
        Footprint::polygon(&[[-x, -y], [x, -y], [x, y], [-x, y]]).unwrap()
    }

    fn jackal() -> Robot {
        Robot {
            radius_m: outline().circumscribed_radius_m(),
        }
    }

    #[test]
    fn nine_numbers_are_nine_classes_and_the_same_seed_gives_the_same_bytes() {
        let mut labels = BTreeSet::new();
        for number in 0..Class::COUNT {
            let class = Class::of(number);
            labels.insert(class.label());
            let text = |seed| toml::to_string(&draw(number, seed, jackal()).unwrap().spec).unwrap();
            assert_eq!(text(1), text(1), "{}", class.label());
            // Static obstacles are the same for every seed, dynamic ones are not.
            assert_eq!(
                text(1) == text(2),
                class.kind == Kind::Static,
                "{}",
                class.label()
            );
            assert_eq!(Class::of(number + Class::COUNT), class);
        }
        assert_eq!(labels.len(), 9);
    }

    #[test]
    fn more_is_in_the_way_the_harder_it_is() {
        let n = |number| {
            let spec = draw(number, 1, jackal()).unwrap().spec;
            spec.shapes.len() + spec.obstacles.len()
        };
        for kind in 0..3 {
            let levels = [n(kind), n(kind + 3), n(kind + 6)];
            assert!(levels.is_sorted_by(|a, b| a < b), "{levels:?}");
        }
    }

    #[test]
    fn the_robot_fits_at_start_and_goal_with_its_outline() {
        let footprint = outline();
        for number in 0..2 * Class::COUNT {
            let course = draw(number, 3, jackal()).unwrap();
            let world = World::new(&course.spec, None).unwrap();
            for pose in [course.start, course.goal] {
                let obstacles = world.obstacles().iter().enumerate();
                let placed = obstacles.map(|(index, obstacle)| (index, obstacle.shape.pose()));
                let apart_m = world.distance_with_obstacles_m(&footprint, &pose, placed);
                assert!(apart_m > 0.2, "world {number}: {apart_m} m at {pose:?}");
            }
        }
    }
}
