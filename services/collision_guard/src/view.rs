//! What the lidar shows: the hits of the last two scans, carried by odometry to where the robot is.
//! What is dust ([`crate::dust`]) is left out.

use crate::dust::{BEFORE_MAX, Looked, Stance};
use crate::hits::Hits;
use crate::outline::Outline;
use crate::swept::Swept;
use nalgebra::{Isometry2, Point2, Vector2};
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::scan::{BEAMS_MAX, BeamDirections, Scan};

/// Ranges of neighbouring beams on one thing differ by less. [m]
const SAME_M: f32 = 0.1;

/// True when no beam beside this one has about its range.
fn is_lone(ranges: &[f32], beam: usize) -> bool {
    let here_m = ranges[beam];
    let beside = [beam.checked_sub(1), beam.checked_add(1)];
    let mut beside = beside.into_iter().flatten();
    beside.all(|beam| {
        let there_m = ranges.get(beam).copied().unwrap_or(f32::NAN);
        let same = (there_m - here_m).abs() < SAME_M;
        !same
    })
}

/// What a beam says of where it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Said {
    /// Nothing: it hit nothing, or dust inside the outline.
    Nothing,
    /// It hit something that was not near enough to matter yet.
    Hit,
    /// Something is there.
    Obstacle,
    /// Dust.
    Dust,
}

/// One scan.
#[derive(Debug, Clone, Default)]
struct Sight {
    /// By beam.
    said: Vec<Said>,
    /// Hits of which it took long to tell whether they are dust.
    compared: usize,
    looked: Looked,
}

/// Scans that are kept: two whose hits count, and those before each.
const SIGHTS: usize = 2 + BEFORE_MAX;

/// The hits of the newest scan and of the one before.
///
/// A motion must be free of both: one scan is enough to show an obstacle, and it takes two in a
/// row without it to be rid of it (debounce 1 to trigger, 2 to release), place by place, so that
/// a vanishing obstacle on one side never holds back a motion to the other. The scans before
/// these are kept to tell dust by.
#[derive(Debug, Clone)]
pub(crate) struct View {
    sights: [Sight; SIGHTS],
    newest: usize,
    directions: BeamDirections,
    /// Hits near the robot, in `base` of now. [m]
    pub(crate) near: Hits,
}

impl Default for View {
    fn default() -> Self {
        let sight = || Sight {
            said: Vec::with_capacity(BEAMS_MAX),
            compared: 0,
            looked: Looked::with_capacity(),
        };
        Self {
            sights: core::array::from_fn(|_| sight()),
            newest: 0,
            directions: BeamDirections::with_capacity(),
            near: Hits::with_capacity(2 * BEAMS_MAX),
        }
    }
}

impl View {
    /// Directions of the beams of a scan, in the laser's frame.
    pub(crate) fn directions(&mut self, scan: &Scan) -> &[Vector2<f64>] {
        self.directions.of(scan)
    }

    /// Takes in a scan that passed its check. `odom_from_base` holds at its capture, run time `run_ns`, the
    /// time of the last beam; `twist` is the robot's while the lidar turned. Ranges that are no hits give
    /// no point, and neither does dust: a hit inside the outline that no neighbouring beam shares, and,
    /// once it is near enough to matter, one that the scans before deny.
    pub(crate) fn take(
        &mut self,
        scan: &Scan,
        ranges: &[f32],
        (base_from_laser, outline): (&Pose, &Outline),
        odom_from_base: &Pose,
        (twist, run_ns): (Twist, u64),
    ) {
        self.newest = (self.newest + 1) % SIGHTS;
        let Sight {
            said,
            compared,
            looked,
        } = &mut self.sights[self.newest];
        said.clear();
        *compared = 0;
        let directions = self.directions.of(scan);
        let odom_from_laser = odom_from_base.isometry() * base_from_laser.isometry();
        let beam_s = f64::from(scan.time_increment_s);
        let at_once = beam_s <= 0.0 || (twist.v_mps == 0.0 && twist.w_radps == 0.0);
        let stance = Stance {
            odom_from_base: odom_from_base.isometry(),
            base_from_laser: base_from_laser.isometry(),
            run_ns,
            twist,
        };
        looked.begin(scan, ranges, stance);
        let reach_m = base_from_laser.point().coords.norm() + outline.radius_m;
        let mut elapsed_s = -f64::from(scan.n_beams.saturating_sub(1)) * beam_s;
        for (beam, (range_m, direction)) in ranges.iter().zip(directions).enumerate() {
            let length_m = f64::from(*range_m);
            let in_laser = Point2::from(direction * length_m);
            let end = scan.is_hit(*range_m).then(|| {
                if at_once {
                    odom_from_laser * in_laser
                } else {
                    let in_base = stance.base_from_laser * in_laser;
                    stance.odom_from_base * twist.arc(elapsed_s).transform(in_base)
                }
            });
            looked.push(end);
            let is_within = || {
                length_m < reach_m && is_lone(ranges, beam) && {
                    let in_base = base_from_laser.transform(in_laser).coords;
                    outline.distance_m(in_base, 0.0) < 0.0
                }
            };
            said.push(if end.is_some() && !is_within() {
                Said::Hit
            } else {
                Said::Nothing
            });
            elapsed_s += beam_s;
        }
        looked.end();
    }

    /// The scans so far are too old to tell dust by.
    pub(crate) fn trust_no_more(&mut self) {
        for sight in &mut self.sights {
            sight.looked.distrust();
        }
    }

    /// Forgets everything: odometry has jumped, or an input went back in time.
    pub(crate) fn clear(&mut self) {
        for sight in &mut self.sights {
            sight.said.clear();
            sight.looked.clear();
        }
    }

    /// Picks the hits that can matter to a robot at `odom_from_base`.
    pub(crate) fn look(&mut self, odom_from_base: &Pose, swept: &Swept) {
        let base_from_odom: Isometry2<f64> = odom_from_base.isometry().inverse();
        let (translation, rotation) = (
            base_from_odom.translation.vector,
            base_from_odom.rotation.into_inner(),
        );
        let (cos, sin) = (rotation.re, rotation.im);
        let in_base = |at: Point2<f64>| {
            Vector2::new(
                cos * at.x - sin * at.y + translation.x,
                sin * at.x + cos * at.y + translation.y,
            )
        };
        self.near.clear();
        for before in 0..2 {
            let sight = (self.newest + SIGHTS - before) % SIGHTS;
            let mut said = core::mem::take(&mut self.sights[sight].said);
            let mut compared = self.sights[sight].compared;
            for (beam, said) in said.iter_mut().enumerate() {
                if matches!(said, Said::Nothing | Said::Dust) {
                    continue;
                }
                let Some(at) = self.sights[sight].looked.hit(beam).map(in_base) else {
                    continue;
                };
                if !swept.holds(at) {
                    continue;
                }
                if *said == Said::Hit {
                    *said = if self.is_dust(sight, beam, &mut compared) {
                        Said::Dust
                    } else {
                        Said::Obstacle
                    };
                }
                if *said == Said::Obstacle {
                    self.near.push(at);
                }
            }
            self.sights[sight].said = said;
            self.sights[sight].compared = compared;
        }
        self.near.close();
    }

    /// True when a hit of a scan is dust to the scans before it.
    fn is_dust(&self, sight: usize, beam: usize, compared: &mut usize) -> bool {
        let looked = |before: usize| &self.sights[(sight + SIGHTS - before) % SIGHTS].looked;
        let before = core::array::from_fn(|n| looked(n + 1));
        looked(0).is_dust(beam, &before, compared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use zeronav_msgs::description::Description;

    fn scan(time_increment_s: f32) -> Scan {
        Scan {
            n_beams: 4,
            angle_increment_rad: core::f32::consts::FRAC_PI_2,
            time_increment_s,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        }
    }

    fn outline() -> Outline {
        let description = Description {
            circumscribed_radius_m: 0.3,
            ..Description::default()
        };
        Outline::new(&description, &[])
    }

    /// Five metres around a stopped robot.
    fn all_around() -> Swept {
        let limits = Limits {
            v_mps_max: 1.0,
            v_mps_min: 0.0,
            w_radps_max: 1.0,
            a_mps2_max: 1.0,
            brake_mps2: 1.0,
            alpha_radps2_max: 1.0,
        };
        Swept::new(&limits, &outline(), [Twist::REST].into_iter(), 0.0, 5.0)
    }

    fn ahead(view: &mut View, at: Pose) -> Vec<Vector2<f64>> {
        view.look(&at, &all_around());
        view.near.iter().collect()
    }

    #[test]
    fn an_obstacle_is_gone_after_two_scans_without_it() {
        let mut view = View::default();
        let (here, rest) = (Pose::default(), (Twist::REST, 0));
        let nothing = [f32::INFINITY; 4];
        let something = [1.0, f32::NAN, f32::INFINITY, f32::INFINITY];
        view.take(&scan(0.0), &something, (&here, &outline()), &here, rest);
        assert_eq!(ahead(&mut view, here).len(), 1, "one is enough");
        view.take(&scan(0.0), &nothing, (&here, &outline()), &here, rest);
        assert_eq!(ahead(&mut view, here).len(), 1, "one does not release");
        view.take(&scan(0.0), &nothing, (&here, &outline()), &here, rest);
        assert_eq!(ahead(&mut view, here).len(), 0, "two do");
    }

    #[test]
    fn points_stand_still_while_the_robot_moves_and_the_lidar_turns() {
        let mut view = View::default();
        let at = Pose::new(2.0, 1.0, core::f64::consts::FRAC_PI_2);
        let ranges = [1.0, f32::INFINITY, f32::INFINITY, f32::INFINITY];
        let laser = Pose::new(0.2, 0.0, 0.0);
        view.take(
            &scan(0.0),
            &ranges,
            (&laser, &outline()),
            &at,
            (Twist::REST, 0),
        );
        // 1.2 m ahead of a robot that looks along +y.
        let found = ahead(&mut view, Pose::new(2.0, 1.5, 0.0));
        assert!((found[0] - Vector2::new(0.0, 0.7)).norm() < 1e-6);
        let mut view = View::default();
        let ahead_1 = Twist {
            v_mps: 1.0,
            w_radps: 0.0,
        };
        // 0.1 s per beam: beam 0 was seen 0.3 m further back.
        let origin = Pose::default();
        view.take(
            &scan(0.1),
            &ranges,
            (&origin, &outline()),
            &origin,
            (ahead_1, 0),
        );
        assert!((ahead(&mut view, origin)[0] - Vector2::new(0.7, 0.0)).norm() < 1e-6);
    }

    #[test]
    fn dust_inside_the_outline_is_left_out_and_nothing_else() {
        let (here, rest) = (Pose::default(), (Twist::REST, 0));
        let hits = |ranges: [f32; 4]| {
            let mut view = View::default();
            view.take(&scan(0.0), &ranges, (&here, &outline()), &here, rest);
            ahead(&mut view, here).len()
        };
        let far = f32::INFINITY;
        assert_eq!(hits([0.2, far, 5.0, far]), 1, "alone and inside");
        assert_eq!(hits([0.2, f32::NAN, far, far]), 0, "nothing beside it");
        assert_eq!(hits([0.31, far, far, far]), 1, "just outside");
        assert_eq!(hits([0.2, 0.25, far, far]), 2, "two that agree");
    }

    #[test]
    fn beams_are_placed_by_the_turn_while_the_lidar_turned() {
        let mut view = View::default();
        let ranges = [1.0, f32::INFINITY, f32::INFINITY, f32::INFINITY];
        let origin = Pose::default();
        // 0.1 s per beam at 1 rad/s on the spot: beam 0 looked 0.3 rad to the right.
        let turning = Twist::new(0.0, 1.0);
        view.take(
            &scan(0.1),
            &ranges,
            (&origin, &outline()),
            &origin,
            (turning, 0),
        );
        let found = ahead(&mut view, origin)[0];
        let expected = Vector2::new(0.3_f64.cos(), -(0.3_f64.sin()));
        assert!((found - expected).norm() < 1e-6, "{found:?}");
    }
}
