//! The papers' scenes with obstacles that appear or move, as scenarios of the stack: a new
//! arrangement for every seed. No paper gives positions, speeds or radii; PAPERS says what is
//! assumed.

mod bao_dyn;
mod blocks;
mod ju_dyn;
mod lwx_dyn;
mod zm_dyn;

pub use bao_dyn::{BaoDyn, BaoMap, LIMIT_S as BAO_LIMIT_S};
pub use ju_dyn::ju_dyn;
pub use lwx_dyn::{Coming, lwx_dyn};
pub use zm_dyn::{ZmScene, zm_dyn};

/// A scene as the text of a scenario, with the services that drive it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The scenario, TOML.
    pub text: String,
    /// Radius of its robot. [m]
    pub robot_m: f64,
}

impl Scene {
    /// The scene with this global planner of a paper, by its key: it searches the shortest way, without
    /// a price on nearness to obstacles, half a cell of the paper away from them.
    #[must_use]
    pub fn planned_by(mut self, planner: &str) -> Self {
        let padding_m = padding_m(self.robot_m);
        let row = format!(
            "\n[services.global_planner.config]\nplanner = \"{planner}\"\noptions.cost_weight = 0.0\n\
             [services.mapping.config]\npadding_m = {padding_m:.3}\n"
        );
        self.text.push_str(&row);
        self
    }
}

/// What paths keep from obstacles besides the robot's radius. [m]
///
/// A path of the papers leads over the centres of cells, half a cell away from obstacles; the cells of the
/// scenes are a metre. On the map's cells of 5 cm the shortest way leads along the very edge of where the
/// robot fits, where a controller stands for ever. Half a cell of the map is left for the middle of a
/// passage, which lies between two of its cells.
#[must_use]
pub const fn padding_m(robot_m: f64) -> f64 {
    const HALF_A_CELL_M: f64 = 0.5;
    const MIDDLE_M: f64 = 0.05;
    HALF_A_CELL_M - robot_m - MIDDLE_M
}

/// A round obstacle of `radius_m` at a place [m], with the lines that say how it comes and goes.
fn disc(name: &str, [x, y]: [f64; 2], radius_m: f64, script: &str) -> String {
    format!(
        "[[world.obstacles]]\nname = \"{name}\"\n\
         shape = {{ kind = \"disc\", centre_m = [{x:.4}, {y:.4}], radius_m = {radius_m} }}\n{script}\n"
    )
}
