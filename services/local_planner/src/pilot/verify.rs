//! The check that no command goes without: a stop from it must be free.

use zeronav_motion::Twist;

/// The first of the candidates from which a stop is free, with the arc of that stop. [m]
/// `stop_arc_m` is `None` where it is not.
pub(crate) fn first_with_free_stop(
    mut candidates: impl Iterator<Item = Twist>,
    stop_arc_m: impl Fn(Twist) -> Option<f64>,
) -> Option<(Twist, f64)> {
    candidates.find_map(|twist| Some((twist, stop_arc_m(twist)?)))
}
