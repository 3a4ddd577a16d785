//! The planner that the configuration names: the ones there are, and what is wrong with a key.

use zeronav_global_planner::{
    BuildError, GlobalPlannerConfig, PLANNERS, PlannerRow, UnknownPlanner,
};
use zeronav_params::Parameter;
use zeronav_shell::StartError;
use zeronav_shell::nearest::unknown;

/// Key and description of every planner.
pub(crate) fn planners() -> Vec<(&'static str, String)> {
    let line = |row: &PlannerRow| {
        let may_fail = if row.complete {
            ""
        } else {
            "; may miss a way that there is"
        };
        (row.key, format!("{}{may_fail} ({})", row.title, row.source))
    };
    PLANNERS.iter().map(line).collect()
}

/// The parameters, with the planners as choices of `planner`.
pub(crate) fn parameters() -> Vec<Parameter> {
    let listed = |one: Parameter| match one.path.as_str() {
        "planner" => one.with_choices(planners().into_iter()),
        _ => one,
    };
    let parameters = zeronav_params::describe::<GlobalPlannerConfig>();
    parameters.into_iter().map(listed).collect()
}

/// The field of the configuration that is wrong.
pub(crate) fn unusable(error: BuildError) -> StartError {
    match error {
        BuildError::Planner(UnknownPlanner { key }) => {
            let known = PLANNERS.iter().map(|row| row.key);
            StartError::config("planner", unknown("planner", &key, known))
        }
        BuildError::Parameter(error) => error.into(),
    }
}
