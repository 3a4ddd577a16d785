//! `debug/rollouts`: motions that the local planner looked at, the chosen one and why it is none of
//! the others. Nothing that is carried out depends on it; it is sent only while somebody reads it.

use crate::message::{COORDINATE_M_MAX, Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::pose::Pose;
use crate::{codes, message};

/// Most rollouts of a message.
pub const ROLLOUTS_MAX: usize = 64;

/// Most points of a rollout.
pub const ROLLOUT_POINTS_MAX: usize = 12;

/// Largest cost that a message may carry, either sign.
pub const ROLLOUT_COST_MAX: f64 = 1.0e9;

codes! {
    /// Why a rollout was not chosen: of several reasons the one that weighs most, the last of this
    /// list first.
    pub enum RolloutOutcome: u16 {
        /// Not told.
        None = 0 => "none",
        /// It was chosen: the velocity request is its first step.
        Chosen = 1 => "chosen",
        /// Nothing is in its way, but another one costs less.
        Costlier = 2 => "costlier",
        /// It leads into a static obstacle, of the map or the scan.
        Collision = 3 => "collision",
        /// It leads into a dynamic obstacle where that will be.
        MovingCollision = 4 => "moving_collision",
        /// What it leads into is nearer than the robot can stop.
        NoStop = 5 => "no_stop",
    }
}

message! {
    /// Fixed fields of the rollouts of a control period: a spread over all, with the chosen one and
    /// the cheapest of every reason. A period that goes on with an older choice sends none.
    pub struct Rollouts = "zeronav.Rollouts.v1" {
        /// [count] Number of rollouts, equal to the length of the slice.
        pub n_rollouts: u64,
        /// [count] Motions that the local planner looked at, 0 = not told.
        pub n_looked_at: u64,
        /// Where the rollouts begin: the robot in the map.
        pub map_from_base: Pose,
    }
}

message! {
    /// A motion as far as it was looked at, at most as far as what it leads into.
    pub struct Rollout = "zeronav.Rollout.v1" {
        /// [m/s] forward speed that it goes towards at first, in `base`.
        pub v_mps: f32,
        /// [rad/s] yaw rate that it goes towards at first, in `base`.
        pub w_radps: f32,
        /// [-] what it costs, in the controller's own unit; less is better. 0 = not rated.
        pub cost: f32,
        /// Code of [`RolloutOutcome`].
        pub outcome: u16,
        /// [count] Number of points, at most [`ROLLOUT_POINTS_MAX`]; the others are 0.
        pub n_points: u16,
        /// [m] x of its points in the `map` frame; the first one is where the robot is.
        pub x_m: [f32; ROLLOUT_POINTS_MAX],
        /// [m] y of its points in the `map` frame.
        pub y_m: [f32; ROLLOUT_POINTS_MAX],
    }
}

impl Rollout {
    /// Why it was not chosen.
    #[must_use]
    pub const fn outcome(&self) -> Option<RolloutOutcome> {
        RolloutOutcome::from_code(self.outcome)
    }

    /// Its points in the `map` frame. [m]
    pub fn points_m(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        let points = self.x_m.iter().zip(&self.y_m);
        points
            .take(usize::from(self.n_points))
            .map(|(x, y)| [*x, *y])
    }

    fn check(&self) -> Result<(), Refusal> {
        self.outcome().ok_or(Refusal::Code("outcome"))?;
        number(f64::from(self.v_mps), -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(f64::from(self.w_radps), -SPEED_MAX, SPEED_MAX, "w_radps")?;
        number(
            f64::from(self.cost),
            -ROLLOUT_COST_MAX,
            ROLLOUT_COST_MAX,
            "cost",
        )?;
        ensure(
            (1..=ROLLOUT_POINTS_MAX).contains(&usize::from(self.n_points)),
            Refusal::OutOfRange("n_points"),
        )?;
        let limit = COORDINATE_M_MAX;
        for along in self.x_m {
            number(f64::from(along), -limit, limit, "x_m")?;
        }
        for along in self.y_m {
            number(f64::from(along), -limit, limit, "y_m")?;
        }
        Ok(())
    }
}

impl Rollouts {
    /// Accepts finite rollouts, at most one of them chosen.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, rollouts: &[Rollout]) -> Result<(), Refusal> {
        ensure(
            rollouts.len() as u64 == self.n_rollouts && rollouts.len() <= ROLLOUTS_MAX,
            Refusal::Length("rollouts"),
        )?;
        self.map_from_base.check("map_from_base")?;
        for rollout in rollouts {
            rollout.check()?;
        }
        let chosen = (rollouts.iter()).filter(|one| one.outcome() == Some(RolloutOutcome::Chosen));
        ensure(chosen.count() <= 1, Refusal::Length("chosen rollouts"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rollout(outcome: RolloutOutcome) -> Rollout {
        Rollout {
            v_mps: 0.5,
            outcome: outcome.code(),
            n_points: 2,
            ..Rollout::default()
        }
    }

    fn check(rollouts: &[Rollout]) -> Result<(), Refusal> {
        let meta = Rollouts {
            n_rollouts: rollouts.len() as u64,
            ..Rollouts::default()
        };
        meta.check(rollouts)
    }

    #[test]
    fn one_is_chosen_at_most() {
        let [chosen, other] = [RolloutOutcome::Chosen, RolloutOutcome::Collision].map(rollout);
        assert_eq!(check(&[]), Ok(()));
        assert_eq!(check(&[other, chosen, other]), Ok(()));
        let twice = check(&[chosen, other, chosen]);
        assert_eq!(twice, Err(Refusal::Length("chosen rollouts")));
    }

    #[test]
    fn what_means_nothing_is_rejected_by_its_name() {
        let right = rollout(RolloutOutcome::Costlier);
        let wrong = |change: fn(&mut Rollout)| {
            let mut one = right;
            change(&mut one);
            check(&[right, one])
        };
        assert_eq!(wrong(|one| one.outcome = 99), Err(Refusal::Code("outcome")));
        assert_eq!(
            wrong(|one| one.cost = f32::NAN),
            Err(Refusal::NotFinite("cost"))
        );
        assert_eq!(
            wrong(|one| one.n_points = 13),
            Err(Refusal::OutOfRange("n_points"))
        );
        assert_eq!(
            wrong(|one| one.n_points = 0),
            Err(Refusal::OutOfRange("n_points"))
        );
        assert_eq!(
            wrong(|one| one.y_m[11] = f32::INFINITY),
            Err(Refusal::NotFinite("y_m"))
        );
        let told = Rollouts {
            n_rollouts: 2,
            ..Rollouts::default()
        };
        assert_eq!(told.check(&[right]), Err(Refusal::Length("rollouts")));
        assert_eq!(check(&[right; 65]), Err(Refusal::Length("rollouts")));
    }
}
