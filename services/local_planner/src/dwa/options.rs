//! Parameters of the dynamic window. The other controllers of this project take them over.

use core::f64::consts::PI;
use zeronav_params::parameters;

parameters! {
    /// Parameters of the dynamic window.
    #[derive(Copy)]
    pub struct DwaConfig {
        /// Length of a rollout; a robot that needs longer to stop gets longer ones.
        horizon_s: f64 = 1.5, [0.2, 10.0] "s";
        /// Time between two poses of a rollout.
        step_s: f64 = 0.1, [0.02, 0.5] "s";
        /// Time of acceleration that the sampled window spans. One control period would leave no
        /// choice; the published twist is the part of the way there that one period allows.
        window_s: f64 = 0.3, [0.01, 5.0] "s";
        /// Speeds in the window.
        speeds: u32 = 20, [2, 64];
        /// Yaw rates in the window.
        yaw_rates: u32 = 41, [3, 64];
        /// Free space that is kept around the footprint. Less leads through narrower gaps, but a
        /// band beside the line of the path must be left to drive in.
        safety_margin_m: f64 = 0.02, [0.005, 1.0] "m";
        /// Distance from the footprint within which obstacles cost.
        soft_clearance_m: f64 = 0.20, [0.01, 2.0] "m";
        /// Free space that is kept at the end of a stop along the arc.
        stop_margin_m: f64 = 0.05, [0.0, 2.0] "m";
        /// Time before braking begins in the worst case: transport, the guard, the drives.
        reaction_s: f64 = 0.1, [0.0, 1.0] "s";
        /// Shortest look-ahead distance along the path.
        lookahead_m_min: f64 = 0.35, [0.05, 5.0] "m";
        /// Driving time that the look-ahead distance spans.
        lookahead_s: f64 = 0.6, [0.0, 5.0] "s";
        /// Heading error above which the robot turns on the spot; half of it when it is stopped.
        turn_above_rad: f64 = 0.9, [0.4, PI] "rad";
        /// Weights of the evaluation.
        weights: DwaWeights;
    }
}

parameters! {
    /// Weights of the evaluation, in metres of progress.
    #[derive(Copy)]
    pub struct DwaWeights {
        /// Weight of a metre of progress along the path.
        progress: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight per metre beside the path, averaged over the rollout.
        cross_track: f64 = 3.0, [0.0, 1.0e3];
        /// Cost weight of the heading error to the path at the end (1 - cos).
        heading: f64 = 0.4, [0.0, 1.0e3];
        /// Cost weight of an obstacle at the safety margin, at full speed.
        clearance: f64 = 1.0, [0.0, 1.0e3];
        /// Weight of full speed.
        speed: f64 = 0.1, [0.0, 1.0e3];
        /// Cost weight of a change of the chosen yaw rate by its largest value.
        turn_change: f64 = 0.1, [0.0, 1.0e3];
    }
}
