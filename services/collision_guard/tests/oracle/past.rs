//! What the oracle remembers of a scan.

use crate::slow::Hit;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;

/// A scan for the oracle's memory.
#[derive(Default)]
pub(crate) struct Past {
    pub(crate) run_ns: u64,
    /// The robot moved while the lidar turned.
    pub(crate) turned: bool,
    /// Of every beam where it began and ended in `odom`, its direction there [rad] and its range. [m]
    pub(crate) beams: Vec<(Hit, Hit, f64, f64)>,
}

impl Past {
    /// How many of so many beams to either side of one ended near it, where beams lie so far apart.
    pub(crate) fn beside(&self, beam: usize, side: usize, apart_m: f64) -> usize {
        let n = self.beams.len();
        let at = self.beams[beam].1;
        (1..=side)
            .flat_map(|offset| [(beam + offset) % n, (beam + n - offset) % n])
            .filter(|other| apart(self.beams[*other].1, at) <= 0.03 + 3.0 * apart_m)
            .count()
    }

    /// The hits that not both beams beside them share.
    pub(crate) fn thin(&self, description: &Description) -> Vec<Hit> {
        let beams = self.beams.iter().enumerate();
        beams
            .filter(|(_, beam)| beam.3.is_finite())
            .filter(|(n, beam)| self.beside(*n, 1, description.angle_increment_rad * beam.3) < 2)
            .map(|(_, beam)| beam.1)
            .collect()
    }
}

/// Distance of two points; not a number where one of them is none. [m]
pub(crate) fn apart(a: Hit, b: Hit) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

pub(crate) fn placed(pose: &Pose, at: Hit) -> Hit {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    [
        pose.x_m + cos * at[0] - sin * at[1],
        pose.y_m + sin * at[0] + cos * at[1],
    ]
}
