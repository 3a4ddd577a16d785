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
//! When a pedestrian appears right in front of the robot, its inscribed disc proves too little. So the
//! moments after the contact are looked at one by one, too, with the robot's true outline: when there
//! is one at which it touches a pedestrian wherever in that box it is, no command would have helped
//! either.
//!
//! When neither is so, the contact counts as avoidable, whether a real robot could have got out of
//! it or not.

mod cells;
mod reach;
pub(super) mod robot;

use cells::FreeSet;
use reach::Reach;
use robot::{Abilities, Disc, State};
use zeronav_casts::Cast;

/// Time from look to look, at most. [s]
const STEP_S: f64 = 0.2;

/// Time after the contact for which the robot must stay clear. [s]
const AFTER_S: f64 = 1.0;

/// Time from moment to moment at which every pose is looked at [s], and how many after the contact.
const MOMENT_S: f64 = 0.02;
const MOMENTS: u32 = 15;

/// Everything that can be touched.
pub(super) struct Surroundings<'a> {
    /// What moves, at a run time [s].
    pub(super) discs_at: &'a dyn Fn(f64) -> Vec<Disc>,
    /// Distance of a point from static obstacles. [m]
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
    let mut set = FreeSet::new(state, fastest_mps * whole_s);
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

fn looks(duration_s: f64) -> u32 {
    (duration_s / STEP_S).ceil().clamp(0.0, 1000.0).to_u32()
}

#[cfg(test)]
mod tests;
