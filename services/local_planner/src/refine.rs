//! The seam by which another optimiser takes the place of the dynamic window's choice.
//!
//! Where to go, when to turn on the spot, arriving, what must stay free and the check before a twist
//! is published remain those of [`crate::dwa`], so that they exist once.

use crate::controller::Situation;
use crate::dwa::options::DwaConfig;
use crate::funnel::Funnel;
use crate::moving::Moving;
use crate::progress::{PathTracker, Place};
use crate::surroundings::Surroundings;
use zeronav_motion::Twist;

/// What the dynamic window knows when it follows the path.
#[derive(Debug)]
pub(crate) struct Sight<'a> {
    pub(crate) situation: &'a Situation<'a>,
    pub(crate) config: &'a DwaConfig,
    pub(crate) tracker: &'a PathTracker,
    pub(crate) place: Place,
    /// Twist that the motions start from.
    pub(crate) from: Twist,
    /// [m/s] fastest speed that the goal, the corners ahead and the age of the inputs allow.
    pub(crate) fastest_mps: f64,
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) moving: &'a mut Moving,
    /// Cost-to-go, where there is a map.
    pub(crate) funnel: Option<&'a Funnel>,
    /// The dynamic window's own choice, when a motion of it is admissible.
    pub(crate) best: Option<Twist>,
}

/// Chooses a twist instead of the dynamic window.
pub(crate) trait Refine {
    /// The twist to go towards before anything else is thought of but arriving; `None` = the path
    /// is followed.
    fn lead(&mut self, _sight: Sight<'_>) -> Option<Twist> {
        None
    }

    /// The twist to go towards; `None` = none that is better than the dynamic window's.
    fn refine(&mut self, sight: Sight<'_>) -> Option<Twist>;
}
