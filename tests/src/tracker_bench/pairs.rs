//! Which track is which obstacle.

use nalgebra::Point2;
use zeronav_measure::SAME_M;

/// By how much a pair of the scan before counts as nearer: two who pass each other closely are not
/// exchanged by the noise of their places. [m]
const KEPT_M: f64 = 0.2;

/// For every true place the index of its track: the nearest pair of all first, each at most once,
/// none farther than [`SAME_M`]. `was_pair` says of a place and a track, by their indices, that they
/// were a pair before.
pub(super) fn pairs(
    places: &[Point2<f64>],
    tracks: &[Point2<f64>],
    was_pair: impl Fn(usize, usize) -> bool,
) -> Vec<Option<usize>> {
    let mut near: Vec<(f64, usize, usize)> = Vec::new();
    for (p, place) in places.iter().enumerate() {
        for (t, track) in tracks.iter().enumerate() {
            let away_m = (track - place).norm();
            if away_m <= SAME_M {
                let kept_m = if was_pair(p, t) { KEPT_M } else { 0.0 };
                near.push((away_m - kept_m, p, t));
            }
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut of_place = vec![None; places.len()];
    let mut taken = vec![false; tracks.len()];
    for (_, p, t) in near {
        if of_place[p].is_none() && !taken[t] {
            of_place[p] = Some(t);
            taken[t] = true;
        }
    }
    of_place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_pair_comes_first_and_what_is_far_has_none() {
        let at = |x: f64| Point2::new(x, 0.0);
        let places = [at(0.0), at(0.4), at(5.0)];
        let found = pairs(&places, &[at(0.3), at(-0.2), at(4.3)], |_, _| false);
        assert_eq!(found, [Some(1), Some(0), None]);
    }

    #[test]
    fn who_was_a_pair_stays_one_until_another_is_clearly_nearer() {
        let at = |x: f64| Point2::new(x, 0.0);
        let was = |p: usize, t: usize| p == t;
        let close = pairs(&[at(0.0), at(0.1)], &[at(0.06), at(0.04)], was);
        assert_eq!(close, [Some(0), Some(1)]);
        let exchanged = pairs(&[at(0.0), at(0.5)], &[at(0.5), at(0.0)], was);
        assert_eq!(exchanged, [Some(1), Some(0)]);
    }
}
