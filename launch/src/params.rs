//! `zeronav params` and `zeronav schema`: what can be set, as the binaries of the services describe it.

mod in_use;

use crate::remote::cli::StackArgs;
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::arguments::service_role;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_msgs::role::Role;
use zeronav_params::Parameter;
use zeronav_supervise::algorithms::parameters_of;
use zeronav_supervise::binaries::{self, Needed};

/// The text above the tables of [`Form::Markdown`].
const HEAD: &str = "# Parameters of the services

Written by `zeronav params --markdown > services/PARAMETERS.md` from the declarations in the code. A
scenario sets them in `[services.ROLE.config]`, those of the robot in `[robot]`.
";

/// Arguments of `zeronav params`.
#[derive(Debug, Clone, Args)]
pub struct ParamsArgs {
    /// Whose, such as `local_planner`; without, of all services.
    #[arg(value_parser = service_role)]
    pub role: Option<Role>,
    /// Path of a parameter, such as `speed.v_mps`: print the value that the running stack uses.
    #[arg(conflicts_with_all = ["binary", "markdown"])]
    pub key: Option<String>,
    /// Print all values that the service of the running stack uses.
    #[arg(long, requires = "role", conflicts_with_all = ["key", "binary", "markdown"])]
    pub running: bool,
    /// Ask this binary in place of the stock one.
    #[arg(long, value_name = "FILE", requires = "role")]
    pub binary: Option<PathBuf>,
    /// Print tables, as in `services/PARAMETERS.md`.
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// `zeronav params`: the parameters of the service in a seat, or of all services, as the stock binaries
/// or another describe them; or the values that a running stack uses.
#[must_use]
pub fn params(arguments: &ParamsArgs) -> ExitCode {
    if let Some(role) = (arguments.role).filter(|_| arguments.running || arguments.key.is_some()) {
        return in_use::show(role, arguments.key.as_deref(), &arguments.stack);
    }
    let role = arguments.role;
    let roles: Vec<Role> = role.map_or_else(|| Role::SERVICES.to_vec(), |role| vec![role]);
    let described = match described(&roles, arguments.binary.as_ref()) {
        Ok(described) => described,
        Err(problem) => return usage(&problem),
    };
    match (arguments.markdown, arguments.stack.json) {
        (false, false) => described
            .iter()
            .for_each(|(role, parameters)| say(&lines(*role, parameters, roles.len() > 1))),
        (true, _) => {
            let tables = described
                .iter()
                .map(|(role, parameters)| table(*role, parameters));
            say(&format!("{HEAD}{}", tables.collect::<String>()));
        }
        (false, true) => {
            let mut services: Vec<Value> = described
                .iter()
                .map(|(role, parameters)| json!({ "role": role.label(), "parameters": parameters }))
                .collect();
            say_json(&match (role, services.pop()) {
                (Some(_), Some(only)) => only,
                (_, last) => {
                    services.extend(last);
                    json!({ "services": services })
                }
            });
        }
    }
    ExitCode::from(EXIT_PASS)
}

/// `zeronav schema`: the JSON schema of a scenario.
#[must_use]
pub fn schema() -> ExitCode {
    match described(&Role::SERVICES, None) {
        Ok(services) => say_json(&zeronav_scenario::schema(&services)),
        Err(problem) => return usage(&problem),
    }
    ExitCode::from(EXIT_PASS)
}

/// The parameters of the services in the seats `roles`, asked from the stock binaries or from
/// `binary`.
///
/// # Errors
/// One line about the first that cannot be asked.
fn described(
    roles: &[Role],
    binary: Option<&PathBuf>,
) -> Result<Vec<(Role, Vec<Parameter>)>, String> {
    if binary.is_none() {
        binaries::refresh_under_cargo(Needed::Stock)?;
    }
    let of = |role: &Role| {
        let stock = Path::new(binaries::stock(*role));
        let parameters = parameters_of(binary.map_or(stock, PathBuf::as_path))?;
        Ok((*role, parameters))
    };
    roles.iter().map(of).collect()
}

/// The values of a parameter that are accepted.
fn allowed(parameter: &Parameter, separator: &str, quote: &str) -> String {
    if parameter.choices.is_empty() {
        return parameter.range();
    }
    let quoted = |key: &String| format!("{quote}{key}{quote}");
    let keys: Vec<String> = (parameter.choices.iter())
        .map(|choice| quoted(&choice.key))
        .collect();
    keys.join(separator)
}

fn lines(role: Role, parameters: &[Parameter], with_role: bool) -> String {
    let width = parameters.iter().map(|one| one.path.len()).max();
    let width = width.unwrap_or(0);
    let head = if with_role {
        format!("{role}\n")
    } else {
        String::new()
    };
    let line = |one: &Parameter| {
        format!(
            "{:width$}  {:7}  {:>8} {:6} {:20} {}\n",
            one.path,
            one.kind,
            one.value.to_string(),
            one.unit,
            allowed(one, " | ", ""),
            one.description
        )
    };
    head + &parameters.iter().map(line).collect::<String>()
}

fn table(role: Role, parameters: &[Parameter]) -> String {
    let row = |one: &Parameter| {
        let unit = if one.unit.is_empty() {
            String::new()
        } else {
            format!(" [{}]", one.unit)
        };
        let default = match one.value.to_string() {
            none if none.is_empty() => none,
            value => format!("`{value}`"),
        };
        let rules = one.relations.iter().map(|relation| relation.rule.clone());
        let limits: Vec<String> = core::iter::once(allowed(one, ", ", "`"))
            .filter(|allowed| !allowed.is_empty())
            .chain(rules)
            .collect();
        format!(
            "| `{}` | {}{unit} | {default} | {} | {} |\n",
            one.path,
            one.kind,
            limits.join("; "),
            one.description.replace('|', "\\|")
        )
    };
    let rows: String = parameters.iter().map(row).collect();
    format!(
        "\n## {role}\n\n| key | type and unit | default | range | meaning |\n|---|---|---|---|---|\n{rows}"
    )
}
