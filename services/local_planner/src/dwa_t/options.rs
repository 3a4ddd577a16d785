//! Parameters of the time-indexed dynamic window.

use zeronav_params::parameters;

parameters! {
    /// Parameters of the time-indexed dynamic window besides those of
    /// [`crate::dwa::options::DwaConfig`].
    #[derive(Copy)]
    pub struct DwaTConfig {
        /// Length of a rollout; a robot that needs longer to stop gets longer ones.
        horizon_s: f64 = 2.4, [0.2, 10.0] "s";
        /// First part of a rollout that is compared with the path and with static obstacles where
        /// there is no room around the robot; 1.5 s in the open. Later only dynamic obstacles count.
        scored_s: f64 = 0.8, [0.1, 10.0] "s";
        /// Poses of a rollout.
        steps: u32 = 30, [5, 64];
        /// Speeds in the window.
        speeds: u32 = 20, [2, 64];
        /// Yaw rates in the window; multiples of 8 are the cheapest.
        yaw_rates: u32 = 40, [3, 64];
        /// Standard deviations of a predicted position that are added to the obstacle's radius.
        growth_sigmas: f64 = 1.0, [0.0, 5.0];
        /// Slowest growth of a predicted radius; it is never less than a fifth of the obstacle's
        /// speed.
        growth_mps_min: f64 = 0.08, [0.0, 2.0] "m/s";
        /// Largest growth of a predicted radius.
        growth_m_max: f64 = 0.5, [0.0, 5.0] "m";
        /// Speed that costs nothing however near obstacles are.
        speed_base_mps: f64 = 0.7, [0.01, 100.0] "m/s";
        /// Speed that costs nothing in addition, per metre of free space around the footprint.
        speed_gain_hz: f64 = 6.0, [0.0, 1.0e3] "1/s";
        /// Cost weight of each metre per second beyond that.
        weight_speed: f64 = 1.0, [0.0, 1.0e3];
        /// Cost weight of an immediate predicted collision; later ones count less.
        weight_moving: f64 = 6.0, [0.0, 1.0e3];
    }
    relations |own| {
        scored_s: own.scored_s <= own.horizon_s, "must be at most horizon_s";
    }
}
