//! Parameters of the time-indexed dynamic window.

use zeronav_params::parameters;

parameters! {
    /// Parameters of the time-indexed dynamic window besides those of
    /// [`crate::dwa::options::DwaConfig`].
    #[derive(Copy)]
    pub struct DwaTConfig {
        /// Length of a rollout; a robot that needs longer to stop gets longer ones.
        horizon_s: f64 = 2.4, [0.2, 10.0] "s";
        /// Poses of a rollout.
        steps: u32 = 30, [5, 64];
        /// Speeds in the window.
        speeds: u32 = 20, [2, 64];
        /// Yaw rates in the window; multiples of 8 are the cheapest.
        yaw_rates: u32 = 40, [3, 64];
        /// Speed that costs nothing however near obstacles are.
        speed_base_mps: f64 = 0.7, [0.01, 100.0] "m/s";
        /// Speed that costs nothing in addition, per metre of free space around the footprint.
        speed_gain_hz: f64 = 6.0, [0.0, 1.0e3] "1/s";
        /// Cost weight of each metre per second beyond that.
        weight_speed: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight of an immediate predicted collision; later ones count less.
        weight_moving: f64 = 6.0, [0.0, 1.0e3];
    }
}
