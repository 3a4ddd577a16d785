//! Parameters of the recovery.

use zeronav_params::parameters;

parameters! {
    /// What the robot does when it makes no progress.
    #[derive(Copy)]
    pub struct RecoveryConfig {
        /// Whether the robot recovers. Without it the robot waits where it is until the task is
        /// stuck.
        enabled: bool = true;
        /// Also for the controllers of the papers, which have no recovery of their own.
        for_papers: bool = false;
        /// Time without an admissible motion after which recovery begins.
        patience_s: f64 = 0.5, [0.0, 60.0] "s";
        /// Time to wait for another path.
        ask_s: f64 = 1.0, [0.05, 60.0] "s";
        /// Paths requested in a row before the robot moves out of the way.
        asks: u32 = 1, [1, 1_000];
        /// Time to wait for a dynamic obstacle to pass.
        wait_s: f64 = 3.0, [0.05, 600.0] "s";
        /// Distance driven back along the track.
        back_up_m: f64 = 0.4, [0.0, 4.0] "m";
        /// Speed backwards.
        back_up_mps: f64 = 0.2, [0.01, 5.0] "m/s";
        /// Angle turned on the spot to look around.
        rotate_rad: f64 = 1.6, [0.0, core::f64::consts::PI] "rad";
        /// Longest duration of a manoeuvre.
        manoeuvre_s: f64 = 6.0, [0.1, 60.0] "s";
        /// Whether a robot with a goal that does not know where it is turns around on the spot, and then drives short
        /// ways in free sight, until it knows.
        seek_pose: bool = false;
        /// Manoeuvres and waits for one goal before the task is given up.
        attempts: u32 = 20, [1, 10_000];
    }
}
