//! Whether the robot still is where it takes itself to be, by how much of its scans the static map explains.
//!
//! A robot that was carried away, or was told a wrong place, sees walls where there are none and looks through those that
//! there are. Furniture that was moved does the same to some beams, people and boxes end many of them short: so what counts
//! is that the map explains little *and* is contradicted, and for a while.

use crate::explained::Explained;

/// What a beam counts that has met something new, beside one that is explained or contradicts the map.
const NEW_COUNTS: f64 = 0.3;

/// Share of the judged beams that must contradict the map, their number, and that of those that ended somewhere: a lidar
/// that sees nothing is blind.
const CONTRADICTS: f64 = 0.12;
const JUDGED_MIN: f64 = 25.0;

/// Share of the beams that end where nothing is known from which on a place is off the map, unless the map has explained
/// what is seen from there before.
const OFF: f64 = 0.7;

/// How long, in scans that say so, the robot must seem to be lost. [s]
const LASTS_S: f64 = 2.0;

/// How much faster it is forgotten than it is believed.
const FORGETS: f64 = 2.0;

/// Scans of which one is looked at closely, however well it lies on the map: it may lie on the far sides of its walls.
const CLOSELY_EVERY: u32 = 10;

/// Takes in what the map explains of every scan.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LostWatch {
    /// How long the robot has seemed to be lost. [s]
    seems_s: f64,
    /// The map has explained what is seen.
    confirmed: bool,
    /// Scans since the last close look.
    n_glances: u32,
}

/// True when the map is contradicted by what is seen, and explains less than the share `below` of it.
pub(crate) fn seems_elsewhere(explained: &Explained, below: f64) -> bool {
    let contradicts = explained.through >= CONTRADICTS * explained.judged();
    contradicts && explained.share(NEW_COUNTS) < below
}

impl LostWatch {
    /// Of a robot of which the map has explained what it sees.
    pub(crate) fn confirmed() -> Self {
        Self {
            confirmed: true,
            ..Self::default()
        }
    }

    /// Takes in a scan that lies on the map at a first look; false when that is not enough: one in ten, and every
    /// one of a robot that seems to be lost, wants a closer look.
    pub(crate) fn is_fine(&mut self) -> bool {
        self.n_glances += 1;
        self.seems_s <= 0.0 && self.n_glances < CLOSELY_EVERY
    }

    /// Takes in what the map says of a scan, `elapsed_s` after the last one, of which `n_ends` beams ended where beams count; true
    /// when the robot is lost: the map explains less than the share `below`, and has for long. Where all that is seen is
    /// new, as in a hall that the lidar does not reach across, nothing says that the robot is elsewhere.
    pub(crate) fn is_lost(
        &mut self,
        explained: &Explained,
        n_ends: f64,
        below: f64,
        elapsed_s: f64,
    ) -> bool {
        self.n_glances = 0;
        let is_judged = explained.judged().min(n_ends) >= JUDGED_MIN;
        let is_elsewhere = is_judged && seems_elsewhere(explained, below);
        let is_off =
            !self.confirmed && n_ends >= JUDGED_MIN && explained.judged() < (1.0 - OFF) * n_ends;
        if is_elsewhere || is_off {
            self.seems_s += elapsed_s;
        } else if is_judged {
            self.confirmed |= explained.share(1.0) >= below;
            self.seems_s = (self.seems_s - FORGETS * elapsed_s).max(0.0);
        }
        self.seems_s >= LASTS_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the map says of a scan that lies on it.
    const FITS: Explained = Explained {
        on: 60.0,
        new: 0.0,
        through: 0.0,
    };

    /// After how many scans of 0.1 s with so many beams explained, new and through walls the robot is lost.
    fn lost_after(on: f64, new: f64, through: f64) -> Option<usize> {
        let mut watch = LostWatch::default();
        let seen = Explained { on, new, through };
        (1..100).find(|_| watch.is_lost(&seen, on + new + through, 0.6, 0.1))
    }

    #[test]
    fn who_sees_through_walls_and_explains_little_is_lost() {
        let after = lost_after(10.0, 40.0, 40.0).expect("lost");
        assert!((20..=21).contains(&after), "{after}");
    }

    #[test]
    fn moved_furniture_crowds_and_bare_halls_are_not_lost() {
        assert_eq!(lost_after(60.0, 20.0, 20.0), None, "furniture was moved");
        assert_eq!(lost_after(10.0, 80.0, 2.0), None, "people stand around");
        assert_eq!(lost_after(2.0, 2.0, 15.0), None, "too few beams");
        assert_eq!(lost_after(0.0, 60.0, 0.0), None, "all that is seen is new");
    }

    /// Laid on the other sides of its walls a scan looks fine at first.
    #[test]
    fn now_and_then_it_looks_closely() {
        let mut watch = LostWatch::default();
        let through = Explained {
            through: 60.0,
            ..Explained::default()
        };
        let lost = (1..100).find(|_| !watch.is_fine() && watch.is_lost(&through, 60.0, 0.6, 0.1));
        assert!(lost.is_some_and(|n| n <= 30), "{lost:?}");
    }

    #[test]
    fn a_place_off_the_map_is_not_believed_unless_it_was_on_it_before() {
        let nothing = Explained::default();
        let after =
            |watch: &mut LostWatch| (1..100).find(|_| watch.is_lost(&nothing, 60.0, 0.6, 0.1));
        let mut watch = LostWatch::default();
        assert!(!watch.is_lost(&FITS, 60.0, 0.6, 0.1));
        assert_eq!(after(&mut watch), None);
        assert!(after(&mut LostWatch::default()).is_some());
    }

    #[test]
    fn a_blind_lidar_does_not_make_a_robot_lost() {
        let mut watch = LostWatch::default();
        let nothing = Explained {
            through: 30.0,
            ..Explained::default()
        };
        assert!((1..100).all(|_| !watch.is_lost(&nothing, 3.0, 0.6, 0.1)));
    }

    #[test]
    fn a_moment_is_forgotten() {
        let mut watch = LostWatch::default();
        let bad = Explained {
            through: 90.0,
            ..Explained::default()
        };
        for _ in 0..100 {
            for _ in 0..12 {
                assert!(!watch.is_lost(&bad, 90.0, 0.6, 0.1));
            }
            for _ in 0..7 {
                assert!(!watch.is_lost(&FITS, 60.0, 0.6, 0.1));
            }
        }
    }
}
