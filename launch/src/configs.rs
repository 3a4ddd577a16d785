//! What each seat is told: its configuration file, and whether its binary can work with it.

use serde::Serialize;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::DeTable;
use zeronav_files::read;
use zeronav_msgs::role::Role;
use zeronav_robot_description::RobotSpec;
use zeronav_scenario::Scenario;
use zeronav_shell::places::Places;
use zeronav_supervise::question::{self, Silence, headline};
use zeronav_supervise::temporary::TemporaryFolder;
use zeronav_world::{World, WorldSpec};
use zeronav_world_files::map_file;

/// Most values of a configuration that are refused one after the other.
const REFUSALS_MAX: usize = 16;

/// What the simulated robot reads.
#[derive(Debug, Serialize)]
struct RobotConfig<'a> {
    world: &'a WorldSpec,
    robot: &'a RobotSpec,
    start: [f64; 3],
}

/// Writes the configuration of every seat into `folder`; that of a `remote` seat is empty, as the other host has its own.
///
/// # Errors
/// One line naming the file.
pub(crate) fn write(
    scenario: &Scenario,
    world: &World,
    remote: &[Role],
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
        if remote.contains(&role) {
            table.clear();
        } else if let Some(service) = scenario.services.of(role) {
            table.extend(service.config.clone());
        }
        let file = folder.join(format!("{role}.toml"));
        std::fs::write(&file, table.to_string())
            .map_err(|error| format!("writing {}: {error}", file.display()))?;
        files.insert(role, file);
    }
    Ok(files)
}

/// Writes the configuration of every companion into `folder`.
///
/// # Errors
/// One line naming the file.
pub(crate) fn write_companions(
    scenario: &Scenario,
    folder: &Path,
) -> Result<BTreeMap<String, PathBuf>, String> {
    let mut files = BTreeMap::new();
    for (name, companion) in &scenario.companions {
        let file = folder.join(format!("{name}.toml"));
        std::fs::write(&file, companion.config.to_string())
            .map_err(|error| format!("writing {}: {error}", file.display()))?;
        files.insert(name.clone(), file);
    }
    Ok(files)
}

/// A program that is asked whether it can work with its configuration.
struct Asked<'a> {
    binary: &'a Path,
    /// The configuration, as a run would write it.
    file: &'a Path,
    /// Where the program stands in the scenario, such as `services.mapping`.
    place: String,
    /// Its seat; `None` of a companion.
    role: Option<Role>,
}

/// A folder for the configurations of a check.
fn folder_of_check() -> Result<TemporaryFolder, String> {
    TemporaryFolder::new("zeronav-check-")
        .map_err(|error| format!("making a folder for the check: {error}"))
}

/// Asks each of the companions whether it can work with its configuration, as [`check`] does. One whose name
/// cannot be is not asked: it may name a file elsewhere.
///
/// # Errors
/// As [`check`].
pub(crate) fn check_companions(
    scenario: &Scenario,
    binaries: &BTreeMap<String, PathBuf>,
) -> Result<Vec<String>, String> {
    if binaries.is_empty() || !scenario.can_name_companions() {
        return Ok(Vec::new());
    }
    let folder = folder_of_check()?;
    let files = write_companions(scenario, folder.path())?;
    let asked = binaries.iter().filter_map(|(name, binary)| {
        Some(Asked {
            binary,
            file: files.get(name)?,
            place: format!("companions.{name}"),
            role: None,
        })
    });
    Ok(ask_all(scenario, asked))
}

/// Asks each of the `binaries` whether it can work with its configuration, which it gets as a run
/// would write it. All at a time.
///
/// A line for each that cannot, and for each value that it does not accept: by file, line and field
/// of the scenario, or else by the binary.
///
/// # Errors
/// When there is no place for the configurations.
pub(crate) fn check<'a>(
    scenario: &Scenario,
    world: &World,
    binaries: impl Iterator<Item = (&'a Role, &'a PathBuf)>,
) -> Result<Vec<String>, String> {
    let folder = folder_of_check()?;
    let files = write(scenario, world, &[], folder.path())?;
    let asked = binaries.filter_map(|(role, binary)| {
        Some(Asked {
            binary,
            file: files.get(role)?,
            place: format!("services.{role}"),
            role: Some(*role),
        })
    });
    Ok(ask_all(scenario, asked))
}

/// What they say, all asked at a time.
fn ask_all<'a>(scenario: &Scenario, asked: impl Iterator<Item = Asked<'a>>) -> Vec<String> {
    std::thread::scope(|scope| {
        let questions: Vec<_> = asked
            .map(|asked| {
                let asked = Arc::new(asked);
                let of_thread = Arc::clone(&asked);
                let ask = move || refusals(scenario, &of_thread);
                let thread = std::thread::Builder::new().spawn_scoped(scope, ask);
                // Without room for a thread they are asked one after another.
                thread.map_err(|_| asked)
            })
            .collect();
        let answers = questions.into_iter().map(|question| match question {
            Ok(thread) => thread.join().unwrap_or_default(),
            Err(asked) => refusals(scenario, &asked),
        });
        answers.flatten().collect()
    })
}

/// What a binary says against its configuration, about the scenario instead of the `file` that it
/// was given. It says one thing at a time: what it has refused is taken out before it is asked again.
fn refusals(scenario: &Scenario, asked: &Asked<'_>) -> Vec<String> {
    let Asked { binary, file, .. } = *asked;
    let rates = format!("{},{}", scenario.run.tick_hz, scenario.robot.lidar.rate_hz);
    let mut arguments: Vec<&OsStr> = vec![
        "--print-config".as_ref(),
        "--config".as_ref(),
        file.as_os_str(),
    ];
    // Of a service of another author only the contract is known.
    let named = asked.role.and_then(|role| scenario.services.of(role));
    let is_stock = named.is_some_and(|service| service.binary.is_none());
    if is_stock
        && [scenario.run.tick_hz, scenario.robot.lidar.rate_hz]
            .iter()
            .all(|it| *it > 0.0)
    {
        arguments.extend(["--rates".as_ref(), OsStr::new(&rates)]);
    }
    let (mut refusals, mut taken) = (Vec::new(), Vec::new());
    while refusals.len() < REFUSALS_MAX {
        let Err(silence) = question::ask(binary, &arguments) else {
            break;
        };
        let said = match &silence {
            Silence::Refused { said, .. } => said.as_str(),
            _ => "",
        };
        let Some((field, why)) = place_of(said, file) else {
            // Without what was taken out it may say things that are not true of the scenario.
            if refusals.is_empty() {
                let why = format!("asked with --print-config: {silence}");
                let field = format!("{}.binary", asked.place);
                refusals.push(scenario.error_at(&field, &why).to_string());
            }
            break;
        };
        // What lacks a value that was taken out says nothing of the scenario.
        if (taken.iter()).any(|name: &String| why.contains(name) || field.ends_with(name)) {
            break;
        }
        let place = in_scenario(scenario, asked, &field);
        refusals.push(scenario.error_at(&place, &why).to_string());
        if !take_out(file, &field) {
            break;
        }
        let name = field.rsplit('.').next().unwrap_or(&field);
        taken.push(name.to_owned());
    }
    refusals
}

/// Takes the value at `field`, or the table's key that holds it, out of a configuration.
fn take_out(file: &Path, field: &str) -> bool {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let Ok(mut root) = text.parse::<toml::Table>() else {
        return false;
    };
    let path = field.split('[').next().unwrap_or(field);
    let mut keys: Vec<&str> = path.split('.').collect();
    let last = keys.pop().unwrap_or_default();
    let mut table = &mut root;
    for key in keys {
        match table.get_mut(key).and_then(toml::Value::as_table_mut) {
            Some(inner) => table = inner,
            None => return false,
        }
    }
    table.remove(last).is_some() && std::fs::write(file, root.to_string()).is_ok()
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

/// The field of a configuration as a field of the scenario.
fn in_scenario(scenario: &Scenario, asked: &Asked<'_>, field: &str) -> String {
    let table = field.split(['.', '[']).next().unwrap_or_default();
    let robot = (asked.role == Some(Role::Robot)).then_some(&scenario.services.robot.config);
    // World, robot and start are the scenario's own.
    if robot.is_some_and(|config| !config.contains_key(table))
        && ["world", "robot", "start"].contains(&table)
    {
        return field.to_owned();
    }
    format!("{}.config.{field}", asked.place)
}
