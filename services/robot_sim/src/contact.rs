//! What stops the robot: the exact footprint against everything solid, at every moment of a tick.
//!
//! The robot advances by its clearance (conservative advancement, Mirtich, "Impulse-based Dynamic
//! Simulation of Rigid Body Systems", 1996): as far as the nearest thing is away it cannot meet
//! anything, so open space costs one distance and nothing is jumped over, however thin and fast.
//! At a contact the robot stops where it was still free. From there it may move wherever it does
//! not get nearer to what it touches.

use crate::drive::Motion;
use crate::drive_state::DriveState;
use crate::obstacles::Obstacle;
use crate::overlap::signed_distance_m;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_world::{Convex, Footprint, World};

/// Distance from which two things touch. [m]
const SKIN_M: f64 = 1.0e-4;

/// Distance from which they no longer do: a contact that trembles is one contact. [m]
const RELEASE_M: f64 = 1.0e-3;

/// Smallest advance near things. [m] Nothing in a world is thinner than 1 mm.
const STEP_M_MIN: f64 = 5.0e-4;

/// Most advances of a tick; a robot faster than 2 m a tick takes longer ones.
const STEPS_MAX: f64 = 4096.0;

/// What counts as not nearer than before. [m]
const ROUNDING_M: f64 = 1.0e-9;

/// Speed of the robot above which a contact is the robot's doing. [m/s]
pub const MOVING_MPS: f64 = 0.05;

/// The robot's body and its contacts so far.
#[derive(Debug, Clone)]
pub struct Body {
    footprint: Footprint,
    /// How fast its outline can move for each rad/s. [m] 0 for a disc, which turns in itself.
    swing_m: f64,
    in_contact: bool,
    contacts_moving: u32,
    contacts_standing: u32,
}

/// How a tick went.
#[derive(Debug, Clone, Copy)]
pub struct Advance {
    /// State at the end of the tick.
    pub end: DriveState,
    /// Length of the way in this tick. [m]
    pub driven_m: f64,
    /// When and where a contact stopped the robot: seconds into the tick, `map_from_base`.
    pub stopped: Option<(f64, Pose)>,
}

/// Everything solid around the robot during one tick.
struct Scene<'a> {
    world: &'a World,
    obstacles: &'a [Obstacle],
    /// Run time at which the tick begins. [ns]
    from_run_ns: u64,
    /// How far ahead it is of interest what is there. [m]
    horizon_m: f64,
}

impl Body {
    /// A body with the outline `footprint` that touches nothing.
    #[must_use]
    pub fn new(footprint: Footprint) -> Self {
        let swing_m = if footprint.form().is_disc() {
            0.0
        } else {
            footprint.circumscribed_radius_m()
        };
        Self {
            footprint,
            swing_m,
            in_contact: false,
            contacts_moving: 0,
            contacts_standing: 0,
        }
    }

    /// True when two things `distance_m` apart touch.
    #[must_use]
    pub fn touches(distance_m: f64) -> bool {
        distance_m <= SKIN_M
    }

    /// Its outline.
    #[must_use]
    pub const fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    /// True while it touches something.
    #[must_use]
    pub const fn in_contact(&self) -> bool {
        self.in_contact
    }

    /// Contacts that began while it moved faster than [`MOVING_MPS`]; a corner that swings round
    /// moves too.
    #[must_use]
    pub const fn contacts_moving(&self) -> u32 {
        self.contacts_moving
    }

    /// Contacts that began while it stood.
    #[must_use]
    pub const fn contacts_standing(&self) -> u32 {
        self.contacts_standing
    }

    /// Distance of the robot at `map_from_base` from everything static and from the obstacles
    /// that exist at `run_ns`, at most `limit_m`; 0 in contact. [m]
    #[must_use]
    pub fn clearance_m(
        &self,
        map_from_base: &Pose,
        world: &World,
        obstacles: &[Obstacle],
        run_ns: u64,
        limit_m: f64,
    ) -> f64 {
        if self.in_contact {
            return 0.0;
        }
        let scene = Scene {
            world,
            obstacles,
            from_run_ns: run_ns,
            horizon_m: limit_m,
        };
        self.nearest_m(map_from_base, 0.0, &scene)
    }

    /// Moves along `motion`, which begins at `from_run_ns`, until its end or a contact.
    pub fn advance(
        &mut self,
        motion: &Motion,
        world: &World,
        obstacles: &[Obstacle],
        from_run_ns: u64,
    ) -> Advance {
        let duration_s = motion.duration_s();
        let fastest = motion.fastest();
        let robot_mps = fastest.v_mps + fastest.w_radps * self.swing_m;
        let obstacle_mps = obstacles
            .iter()
            .map(Obstacle::speed_mps)
            .fold(0.0, f64::max);
        let closing_mps = robot_mps + obstacle_mps;
        let step_m_min = STEP_M_MIN.max(closing_mps * duration_s / STEPS_MAX);
        let scene = Scene {
            world,
            obstacles,
            from_run_ns,
            horizon_m: closing_mps * duration_s + RELEASE_M,
        };
        let mut now_s = 0.0;
        let mut nearest_m = self.nearest_m(&motion.at(now_s).pose, now_s, &scene);
        while now_s < duration_s {
            let step_s = (nearest_m - SKIN_M).max(step_m_min) / closing_mps;
            let next_s = (now_s + step_s)
                .min(scene.next_jump_s(now_s))
                .min(duration_s);
            if self.is_blocked(motion, now_s, next_s, &scene) {
                let free_s = self.last_free_s(motion, now_s, next_s, &scene);
                self.touch(&motion.at(free_s).twist);
                return Self::stop(motion, free_s);
            }
            now_s = next_s;
            let state = motion.at(now_s);
            nearest_m = self.nearest_m(&state.pose, now_s, &scene);
            if self.feel(nearest_m, &state.twist) {
                return Self::stop(motion, now_s);
            }
        }
        Advance {
            end: motion.at(duration_s),
            driven_m: motion.driven_m(duration_s),
            stopped: None,
        }
    }

    /// Looks at what has just appeared around the robot at `run_ns`; true when a contact began,
    /// which stops the robot.
    pub fn settle(
        &mut self,
        state: &DriveState,
        world: &World,
        obstacles: &[Obstacle],
        run_ns: u64,
    ) -> bool {
        let scene = Scene {
            world,
            obstacles,
            from_run_ns: run_ns,
            horizon_m: RELEASE_M,
        };
        let nearest_m = self.nearest_m(&state.pose, 0.0, &scene);
        self.feel(nearest_m, &state.twist)
    }

    /// Begins or ends a contact; true when one began.
    fn feel(&mut self, nearest_m: f64, twist: &Twist) -> bool {
        if nearest_m >= RELEASE_M {
            self.in_contact = false;
        } else if Self::touches(nearest_m) && !self.in_contact {
            self.touch(twist);
            return true;
        }
        false
    }

    /// A contact at the speed of `twist`; one that goes on is not counted again.
    fn touch(&mut self, twist: &Twist) {
        if self.in_contact {
            return;
        }
        self.in_contact = true;
        if twist.v_mps.abs() + twist.w_radps.abs() * self.swing_m > MOVING_MPS {
            self.contacts_moving = self.contacts_moving.saturating_add(1);
        } else {
            self.contacts_standing = self.contacts_standing.saturating_add(1);
        }
    }

    fn stop(motion: &Motion, at_s: f64) -> Advance {
        let pose = motion.at(at_s).pose;
        Advance {
            end: DriveState {
                pose,
                twist: Twist::REST,
            },
            driven_m: motion.driven_m(at_s),
            stopped: Some((at_s, pose)),
        }
    }

    /// True when going on from `from_s` to `to_s` brings the robot nearer to something that it
    /// touches then. What comes to the robot by itself does not block it.
    fn is_blocked(&self, motion: &Motion, from_s: f64, to_s: f64, scene: &Scene) -> bool {
        let (from, to) = (motion.at(from_s).pose, motion.at(to_s).pose);
        let (from, to) = (self.footprint.placed(&from), self.footprint.placed(&to));
        let static_m = scene.static_m(&to);
        if static_m < SKIN_M && is_nearer(static_m, scene.static_m(&from)) {
            return true;
        }
        let run_ns = scene.run_ns(to_s);
        scene.obstacles.iter().any(|obstacle| {
            if !obstacle.exists_at(run_ns) {
                return false;
            }
            let solid = obstacle.placed_at(run_ns);
            let there_m = signed_distance_m(&to, &solid);
            there_m < SKIN_M && is_nearer(there_m, signed_distance_m(&from, &solid))
        })
    }

    /// The last moment of `from_s..to_s` up to which the way is free, to 1e-9 of the stretch.
    fn last_free_s(&self, motion: &Motion, from_s: f64, to_s: f64, scene: &Scene) -> f64 {
        let (mut free_s, mut blocked_s) = (from_s, to_s);
        for _ in 0..30 {
            let middle_s = 0.5 * (free_s + blocked_s);
            if self.is_blocked(motion, from_s, middle_s, scene) {
                blocked_s = middle_s;
            } else {
                free_s = middle_s;
            }
        }
        free_s
    }

    /// Distance from everything solid `at_s` seconds into the tick, 0 when it touches or
    /// overlaps, at most the scene's horizon. [m]
    fn nearest_m(&self, map_from_base: &Pose, at_s: f64, scene: &Scene) -> f64 {
        let placed = self.footprint.placed(map_from_base);
        let run_ns = scene.run_ns(at_s);
        let mut nearest_m = scene.static_m(&placed);
        for obstacle in scene.obstacles {
            if obstacle.exists_at(run_ns) {
                nearest_m = nearest_m.min(placed.distance_m(&obstacle.placed_at(run_ns)));
            }
        }
        nearest_m
    }
}

/// True when `there_m` is nearer than `here_m` by more than rounding, which is forgiven in the
/// outer half of the skin only: many small mistakes shall not add up to a hole in a wall.
fn is_nearer(there_m: f64, here_m: f64) -> bool {
    let forgiven_m = if there_m > 0.5 * SKIN_M {
        ROUNDING_M
    } else {
        0.0
    };
    there_m < here_m - forgiven_m
}

impl Scene<'_> {
    fn static_m(&self, robot: &Convex) -> f64 {
        self.world.convex_distance_m(robot, self.horizon_m)
    }

    fn run_ns(&self, at_s: f64) -> u64 {
        self.from_run_ns + nanoseconds(at_s)
    }

    /// Seconds into the tick at which the next obstacle after `now_s` appears or is somewhere else
    /// at once.
    fn next_jump_s(&self, now_s: f64) -> f64 {
        let now_ns = self.run_ns(now_s);
        self.obstacles
            .iter()
            .filter_map(|obstacle| obstacle.next_jump_run_ns(now_ns))
            .map(|jump_ns| seconds(jump_ns - self.from_run_ns))
            .fold(f64::INFINITY, f64::min)
    }
}
