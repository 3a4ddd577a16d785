//! What each seat is told: its configuration file, and whether its binary can work with it.

use crate::scenario::Scenario;
use crate::supervise::question::{self, Silence, headline};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::DeTable;
use zeronav_files::read;
use zeronav_msgs::role::Role;
use zeronav_robot_description::RobotSpec;
use zeronav_shell::places::Places;
use zeronav_world::{World, WorldSpec};
use zeronav_world_files::map_file;

/// What the simulated robot reads.
#[derive(Debug, Serialize)]
struct RobotConfig<'a> {
    world: &'a WorldSpec,
    robot: &'a RobotSpec,
    start: [f64; 3],
}

/// Writes the configuration of every seat into `folder`.
///
/// # Errors
/// One line naming the file.
pub(crate) fn write(
    scenario: &Scenario,
    world: &World,
    folder: &Path,
) -> Result<BTreeMap<Role, PathBuf>, String> {
    let robot = toml::Table::try_from(RobotConfig {
        world: &scenario.world,
        robot: &scenario.robot,
        start: [
            scenario.start.x_m,
            scenario.start.y_m,
            scenario.start.yaw_rad,
        ],
    })
    .map_err(|error| format!("the robot's configuration has no TOML form: {error}"))?;
    let mut mapping = toml::Table::new();
    if scenario.static_map {
        let map = map_file::save(&world.rasterise(), folder, "static_map")
            .map_err(|error| error.to_string())?;
        mapping.insert("static_map".into(), map.display().to_string().into());
    } else {
        let geometry = world.geometry();
        let (x, y) = (geometry.origin_x_m, geometry.origin_y_m);
        let far_x = x + f64::from(geometry.width) * geometry.resolution_m;
        let far_y = y + f64::from(geometry.height) * geometry.resolution_m;
        let area = vec![vec![x, y], vec![far_x, far_y]];
        mapping.insert("area_m".into(), area.into());
        mapping.insert("resolution_m".into(), geometry.resolution_m.into());
    }
    let mut files = BTreeMap::new();
    for role in Role::SERVICES {
        let mut table = match role {
            Role::Robot => robot.clone(),
            Role::Mapping => mapping.clone(),
            _ => toml::Table::new(),
        };
        if let Some(service) = scenario.services.of(role) {
            table.extend(service.config.clone());
        }
        let file = folder.join(format!("{role}.toml"));
        std::fs::write(&file, table.to_string())
            .map_err(|error| format!("writing {}: {error}", file.display()))?;
        files.insert(role, file);
    }
    Ok(files)
}

/// Asks each of the `binaries` whether it can work with its configuration, which it gets as a run
/// would write it. All at a time.
///
/// # Errors
/// One line about the first that cannot: a value of its configuration by file, line and field of the
/// scenario, or else the binary.
pub(crate) fn check(
    scenario: &Scenario,
    world: &World,
    binaries: &BTreeMap<Role, PathBuf>,
) -> Result<(), String> {
    let folder = tempfile::Builder::new()
        .prefix("zeronav-check-")
        .tempdir()
        .map_err(|error| format!("making a folder for the check: {error}"))?;
    let files = write(scenario, world, folder.path())?;
    let asked = |binary: &Path, file: &Path| {
        let arguments = [
            "--print-config".as_ref(),
            "--config".as_ref(),
            file.as_os_str(),
        ];
        question::ask(binary, &arguments)
    };
    std::thread::scope(|scope| {
        let questions: Vec<_> = binaries
            .iter()
            .filter_map(|(role, binary)| Some((*role, binary, files.get(role)?)))
            .map(|(role, binary, file)| (role, file, scope.spawn(move || asked(binary, file))))
            .collect();
        for (role, file, question) in questions {
            let answer = question.join().unwrap_or(Err(Silence::Late));
            answer.map_err(|silence| refusal(scenario, role, file, &silence))?;
        }
        Ok(())
    })
}

/// What a binary says against its configuration, about the scenario instead of the `file` that it
/// was given.
fn refusal(scenario: &Scenario, role: Role, file: &Path, silence: &Silence) -> String {
    let said = match silence {
        Silence::Refused { said, .. } => said.as_str(),
        _ => "",
    };
    let (field, why) = match place_of(said, file) {
        Some((field, why)) => (in_scenario(scenario, role, &field), why),
        None => (
            format!("services.{role}.binary"),
            format!("asked with --print-config: {silence}"),
        ),
    };
    scenario.error_at(&field, &why).to_string()
}

/// Field and reason of a complaint `... FILE:LINE: FIELD: REASON`; where the field is left out, that
/// of the line.
fn place_of(said: &str, file: &Path) -> Option<(String, String)> {
    let (_, rest) = said.split_once(&format!("{}:", file.display()))?;
    let (line, rest) = headline(rest)
        .split_once(": ")
        .map(|(line, rest)| (line.trim().to_owned(), rest.trim().to_owned()))?;
    let is_field = |word: &str| {
        let of_field = |one: char| one.is_alphanumeric() || "_-.[]".contains(one);
        !word.is_empty() && word.chars().all(of_field)
    };
    if let Some((field, why)) = rest.split_once(": ").filter(|(field, _)| is_field(field)) {
        return Some((field.to_owned(), why.to_owned()));
    }
    let line: usize = line.parse().ok()?;
    let text = read::text(file, read::TEXT_BYTES_MAX).ok()?;
    let table = DeTable::parse(&text).ok()?;
    let start = text
        .split_inclusive('\n')
        .take(line.checked_sub(1)?)
        .map(str::len)
        .sum();
    let end = start + text.get(start..)?.find('\n').unwrap_or(text.len() - start);
    let places = Places::of(table.get_ref());
    let field = places.field_within(&(start..end))?;
    Some((field.to_owned(), rest))
}

/// The field of a seat's configuration as a field of the scenario.
fn in_scenario(scenario: &Scenario, role: Role, field: &str) -> String {
    let table = field.split(['.', '[']).next().unwrap_or_default();
    let config = scenario.services.of(role).map(|service| &service.config);
    let written = config.is_some_and(|config| config.contains_key(table));
    // World, robot and start are the scenario's own.
    if role == Role::Robot && !written && ["world", "robot", "start"].contains(&table) {
        return field.to_owned();
    }
    format!("services.{role}.config.{field}")
}
