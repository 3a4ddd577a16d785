//! The controller that the configuration names: the ones there are, and what is wrong with a key.

use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::period::BuildError;
use zeronav_local_planner::table::{CONTROLLERS, ControllerRow, UnknownController};
use zeronav_params::Parameter;
use zeronav_shell::StartError;
use zeronav_shell::nearest::unknown;

/// Key and description of every controller.
pub(crate) fn controllers() -> Vec<(&'static str, String)> {
    let line = |row: &ControllerRow| (row.key, format!("{} ({})", row.title, row.source));
    CONTROLLERS.iter().map(line).collect()
}

/// The parameters, with the controllers as choices of `controller`.
pub(crate) fn parameters() -> Vec<Parameter> {
    let listed = |one: Parameter| match one.path.as_str() {
        "controller" => one.with_choices(controllers().into_iter()),
        _ => one,
    };
    let parameters = zeronav_params::describe::<LocalPlannerConfig>();
    parameters.into_iter().map(listed).collect()
}

/// The field of the configuration that is wrong.
pub(crate) fn unusable(error: BuildError) -> StartError {
    match error {
        BuildError::Controller(UnknownController { key }) => {
            let known = CONTROLLERS.iter().map(|row| row.key);
            StartError::config("controller", unknown("controller", &key, known))
        }
        BuildError::Config(error) => error.into(),
    }
}
