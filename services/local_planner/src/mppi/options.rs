//! Parameters of model predictive path integral control.

use zeronav_params::parameters;

parameters! {
    /// Parameters of model predictive path integral control.
    #[derive(Copy)]
    pub struct MppiConfig {
        /// Samples of a cycle, rounded up to a multiple of 40.
        samples: u32 = 2000, [40, 20_000];
        /// Steps of a sample.
        steps: u32 = 56, [14, 64];
        /// Duration of a step.
        step_s: f64 = 0.05, [0.02, 0.1] "s";
        /// Standard deviation of a sample's speeds.
        speed_std_mps: f64 = 0.2, [0.001, 10.0] "m/s";
        /// Standard deviation of a sample's yaw rates.
        yaw_rate_std_radps: f64 = 0.5, [0.001, 10.0] "rad/s";
        /// Progress by which a sample must be worse to have 1/e of another's weight.
        temperature_m: f64 = 0.05, [0.001, 10.0] "m";
        /// Seed of the noise.
        seed: u64 = 1, [0, u64::MAX];
        /// Weights of the critics.
        critics: CriticWeights;
    }
}

parameters! {
    /// Weights of the critics, in metres of progress; a critic of weight 0 is not evaluated.
    #[derive(Copy)]
    pub struct CriticWeights {
        /// Cost weight of an immediate collision with a static obstacle; later ones count less.
        obstacles: f64 = 8.0, [0.0, 1.0e3];
        /// Cost weight of an obstacle at the safety margin, at full speed.
        clearance: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight of each metre per second beyond what the clearance allows.
        calm: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight of an immediate predicted collision; later ones count less.
        moving: f64 = 6.0, [0.0, 1.0e3];
        /// Cost weight per metre of path that is left at the end.
        path_follow: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight per metre beside the path, averaged over the sample.
        path_align: f64 = 3.0, [0.0, 1.0e3];
        /// Cost weight of the heading error to the path, averaged over the sample (1 - cos).
        path_angle: f64 = 0.4, [0.0, 1.0e3];
        /// Cost weight per metre from the goal at the end, on the last metre.
        goal: f64 = 0.5, [0.0, 1.0e3];
        /// Cost weight of the yaw error at the goal (1 - cos), on the last half metre.
        goal_angle: f64 = 0.3, [0.0, 1.0e3];
        /// Cost weight per metre driven backwards.
        prefer_forward: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight of a change of the yaw rate by its largest value.
        smooth: f64 = 0.2, [0.0, 1.0e3];
    }
}
