//! How far the robot knows where it is, by the covariance of its pose.

use crate::codes;
use crate::map::MapInfo;

/// Standard deviation of a coordinate from which on the robot does not know where it is. [m]
pub const POSE_SIGMA_M_MAX: f64 = 0.75;

/// Standard deviation of the yaw from which on the robot does not know where it is. [rad]
pub const POSE_SIGMA_RAD_MAX: f64 = 0.35;

/// Standard deviations of a pose that the robot was told and that nothing has confirmed. [m, rad]
pub const POSE_SIGMA_TOLD: (f64, f64) = (0.6, 0.3);

/// The same of a pose that is not confirmed, at least. [m, rad]
const UNCONFIRMED: (f64, f64) = (0.55, 0.25);

codes! {
    /// How far the robot knows where it is.
    #[derive(Default)]
    pub enum PoseCertainty: u16 {
        /// It does not: it stands, and nothing can be said of a goal.
        #[default]
        Unknown = 0 => "unknown",
        /// It was told, and what it sees neither contradicts nor confirms that: it may drive, but neither claims an
        /// arrival nor gives up a goal before it has waited for that.
        Unconfirmed = 1 => "unconfirmed",
        /// It does.
        Confirmed = 2 => "confirmed",
    }
}

impl PoseCertainty {
    /// True when the robot may drive by its pose.
    #[must_use]
    pub const fn is_known(self) -> bool {
        !matches!(self, Self::Unknown)
    }

    /// True when goals may end by its pose.
    #[must_use]
    pub const fn is_confirmed(self) -> bool {
        matches!(self, Self::Confirmed)
    }
}

impl MapInfo {
    /// How far the robot knows where it is on this map: by the deviations of its pose.
    #[must_use]
    pub fn certainty(&self) -> PoseCertainty {
        let [xx, _, _, yy, _, yaw] = self.covariance;
        let is_below =
            |(place_m, yaw_rad): (f64, f64)| xx.max(yy) < place_m.powi(2) && yaw < yaw_rad.powi(2);
        if is_below(UNCONFIRMED) {
            PoseCertainty::Confirmed
        } else if is_below((POSE_SIGMA_M_MAX, POSE_SIGMA_RAD_MAX)) {
            PoseCertainty::Unconfirmed
        } else {
            PoseCertainty::Unknown
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_tell_how_far_the_robot_knows_where_it_is() {
        let of = |place_m: f64, yaw_rad: f64| {
            let (place, yaw) = (place_m.powi(2), yaw_rad.powi(2));
            let covariance = [place, 0.0, 0.0, place, 0.0, yaw];
            MapInfo {
                covariance,
                ..MapInfo::default()
            }
            .certainty()
        };
        assert_eq!(of(0.0, 0.0), PoseCertainty::Confirmed);
        // As uncertain as a map of the robot's own making may let it become.
        assert_eq!(of(0.5, 0.2), PoseCertainty::Confirmed);
        let (told_m, told_rad) = POSE_SIGMA_TOLD;
        assert_eq!(of(told_m, told_rad), PoseCertainty::Unconfirmed);
        assert_eq!(of(told_m, 0.0), PoseCertainty::Unconfirmed);
        assert_eq!(of(0.0, told_rad), PoseCertainty::Unconfirmed);
        assert_eq!(of(POSE_SIGMA_M_MAX, 0.0), PoseCertainty::Unknown);
        assert_eq!(of(0.0, POSE_SIGMA_RAD_MAX), PoseCertainty::Unknown);
        assert!(PoseCertainty::Unknown < PoseCertainty::Unconfirmed);
        let known = PoseCertainty::ALL
            .iter()
            .map(|it| (it.is_known(), it.is_confirmed()));
        assert!(known.eq([(false, false), (true, false), (true, true)]));
    }
}
