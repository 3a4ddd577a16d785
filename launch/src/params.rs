//! `zeronav params` and `zeronav schema`: what can be set, as the binaries of the services describe it.

use crate::exit::EXIT_PASS;
use crate::scenario;
use crate::show::terminal::{say, say_json, usage};
use crate::supervise::algorithms::parameters_of;
use crate::supervise::binaries::{self, Needed};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_msgs::role::Role;
use zeronav_params::Parameter;

/// The text above the tables of [`Form::Markdown`].
const HEAD: &str = "# Parameters of the services

Written by `zeronav params --markdown > services/PARAMETERS.md` from the declarations in the code. A
scenario sets them in `[services.ROLE.config]`, those of the robot in `[robot]`.
";

/// How the parameters are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A line each, for a terminal.
    Lines,
    /// One JSON object.
    Json,
    /// A table for each service.
    Markdown,
}

/// The parameters of the service in the seat `role`, or of all services, as the stock binaries or
/// `binary` describe them.
#[must_use]
pub fn params(role: Option<Role>, binary: Option<&PathBuf>, form: Form) -> ExitCode {
    let roles: Vec<Role> = role.map_or_else(|| Role::SERVICES.to_vec(), |role| vec![role]);
    let described = match described(&roles, binary) {
        Ok(described) => described,
        Err(problem) => return usage(&problem),
    };
    match form {
        Form::Lines => described
            .iter()
            .for_each(|(role, parameters)| say(&lines(*role, parameters, roles.len() > 1))),
        Form::Markdown => {
            let tables = described
                .iter()
                .map(|(role, parameters)| table(*role, parameters));
            say(&format!("{HEAD}{}", tables.collect::<String>()));
        }
        Form::Json => {
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
        Ok(services) => say_json(&scenario::schema(&services)),
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
