//! The papers' scenes with obstacles that appear or move, as scenarios of the stack: a new
//! arrangement for every seed. No paper gives positions, speeds or radii; PAPERS says what is
//! assumed.

mod bao_dyn;
mod blocks;
mod ju_dyn;
mod lwx_dyn;
mod zm_dyn;

pub use bao_dyn::{BaoDyn, BaoMap, PADDING_M as BAO_PADDING_M};
pub use blocks::LIMIT_S;
pub use ju_dyn::ju_dyn;
pub use lwx_dyn::{Coming, lwx_dyn};
pub use zm_dyn::{ZmScene, zm_dyn};

/// A scene as the text of a scenario, with the services that drive it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The scenario, TOML.
    pub text: String,
}

impl Scene {
    /// The scene with this global planner of a paper, by its key: it searches the shortest way, without
    /// a price on nearness to obstacles.
    #[must_use]
    pub fn planned_by(mut self, planner: &str) -> Self {
        let row = format!(
            "\n[services.global_planner.config]\nplanner = \"{planner}\"\noptions.cost_weight = 0.0\n"
        );
        self.text.push_str(&row);
        self
    }

    /// The same with paths that keep [`BAO_PADDING_M`] off obstacles besides the robot's radius.
    #[must_use]
    pub fn half_a_cell_off(mut self) -> Self {
        let row = format!("\n[services.mapping.config]\npadding_m = {BAO_PADDING_M:?}\n");
        self.text.push_str(&row);
        self
    }
}

/// A round obstacle of `radius_m` at a place [m], with the lines that say how it comes and goes.
fn disc(name: &str, [x, y]: [f64; 2], radius_m: f64, script: &str) -> String {
    format!(
        "[[world.obstacles]]\nname = \"{name}\"\n\
         shape = {{ kind = \"disc\", centre_m = [{x:.4}, {y:.4}], radius_m = {radius_m} }}\n{script}\n"
    )
}
