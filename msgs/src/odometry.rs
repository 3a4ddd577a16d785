//! `robot/odometry`: where the wheels say the robot is; the control tick of the stack.

use crate::message;
use crate::message::{Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::pose::Pose;

message! {
    /// Pose and twist by odometry.
    pub struct Odometry = "zeronav.Odometry.v1" {
        /// `odom_from_base`.
        pub pose: Pose,
        /// [m/s] forward speed in `base`.
        pub v_mps: f64,
        /// [rad/s] yaw rate in `base`, counter-clockwise.
        pub w_radps: f64,
        /// [m^2, m^2, rad^2] variances of x, y and yaw, >= 0.
        pub variance: [f64; 3],
        /// [flag] 1 when a scan belongs to this tick, 0 when not.
        pub scan_due: u32,
        /// Written as 0.
        pub spare: u32,
    }
}

impl Odometry {
    /// True when a scan belongs to this tick.
    #[must_use]
    pub const fn scan_due(&self) -> bool {
        self.scan_due == 1
    }

    /// Accepts finite odometry.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.pose.check("pose")?;
        number(self.v_mps, -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(self.w_radps, -SPEED_MAX, SPEED_MAX, "w_radps")?;
        for variance in self.variance {
            number(variance, 0.0, 1.0e12, "variance")?;
        }
        ensure(self.scan_due <= 1, Refusal::Code("scan_due"))
    }
}
