//! `zeronav import PARAMETERS.yaml`: a robot of Nav2 as a scenario.

use crate::output_file::{self, Problem};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json};
use zeronav_import::nav2::{self, Converted, Report};
use zeronav_msgs::Pose;
use zeronav_scenario::Scenario;
use zeronav_shell::printable::printable;
use zeronav_world::{Footprint, World, WorldSpec};

/// Room around a robot that is put on a map: less would keep a large one from turning. [m]
const START_CLEARANCE_M: f64 = 0.3;

/// What is asked for.
pub(super) struct Order<'a> {
    /// The parameters.
    pub(super) file: &'a Path,
    /// The URDF.
    pub(super) urdf: Option<&'a Path>,
    /// The map.
    pub(super) map: Option<&'a Path>,
    /// The scenario; `None` = `NAME_imported.toml` in this folder.
    pub(super) out: Option<&'a Path>,
    /// True when a file of this name may be replaced.
    pub(super) force: bool,
    /// True when one JSON object is printed.
    pub(super) json: bool,
}

/// `zeronav import` of a parameter file.
pub(super) fn import(order: &Order<'_>) -> ExitCode {
    let file = order.file;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let usual = || PathBuf::from(format!("{name}_imported.toml"));
    let out = order.out.map_or_else(usual, Path::to_path_buf);
    match write(order, &out) {
        Ok(converted) => {
            if order.json {
                say_json(&to_json(&converted, &out));
            } else {
                say(&to_text(&converted.report, &out));
            }
            ExitCode::from(EXIT_PASS)
        }
        Err(problem) => problem.say(),
    }
}

fn write(order: &Order<'_>, out: &Path) -> Result<Converted, Problem> {
    if out.extension().is_none_or(|it| it != "toml") {
        let why = format!("{}: a scenario's file ends with .toml", out.display());
        return Err(Problem::Input(why));
    }
    let converted = nav2::scenario_of(order.file, order.urdf, order.map);
    let mut converted = converted.map_err(|error| Problem::Input(error.to_string()))?;
    let input = |why: String| Problem::Input(format!("{}: {why}", order.file.display()));
    if let Some(map) = converted.map.clone() {
        place(&mut converted, &map)?;
    } else {
        let resolution_m = converted.draft.number("world.resolution_m");
        converted.fit(resolution_m.unwrap_or(0.05));
    }
    check(&converted).map_err(input)?;
    if let Some(map) = &converted.map {
        let named = seen_from(out, map);
        converted.draft.set("world.map", named, "");
    }
    let text = converted.draft.to_toml();
    output_file::made(out, order.force, |mut output| {
        let written = output.write_all(text.as_bytes());
        written.map_err(|error| Problem::writing(out, &error))
    })?;
    Ok(converted)
}

/// Asks the scenario what is wrong with it, before anything is written.
fn check(converted: &Converted) -> Result<(), String> {
    let text = converted.draft.to_toml();
    let scenario = Scenario::of_text("imported", &text).and_then(|it| it.whole()?.validate());
    scenario.map(drop).map_err(|error| {
        let error = error.to_string();
        let first = error.lines().next().unwrap_or_default();
        format!("a robot with these parameters cannot be driven: {first}")
    })
}

/// Puts the robot on its map, where that is free.
fn place(converted: &mut Converted, map: &Path) -> Result<(), Problem> {
    let wrong = |why: &dyn core::fmt::Display| Problem::Input(why.to_string());
    let absolute = std::path::absolute(map).map_err(|error| wrong(&error))?;
    let spec = WorldSpec::of_map(&absolute);
    let (world, _) = zeronav_world_files::load(&spec).map_err(|error| wrong(&error))?;
    converted.fit(world.geometry().resolution_m);
    let named = absolute.to_string_lossy().into_owned();
    converted.draft.set("world.map", named, "");
    let Some(footprint) = footprint(converted) else {
        return Ok(());
    };
    let wanted = start(converted);
    if world.contains(wanted.point()) && !world.touches(&footprint, &wanted) {
        return Ok(());
    }
    let Some(free) = free_near(&world, &footprint, &wanted) else {
        let why = "the robot fits nowhere near its start or the middle of the map";
        return Err(Problem::Input(format!("{}: {why}", map.display())));
    };
    let why = format!(
        "[{}, {}, {}] is not free on the map: `zeronav pose` tells the stack where the robot is",
        wanted.x_m, wanted.y_m, wanted.yaw_rad
    );
    converted.start_at([free.x_m, free.y_m, free.yaw_rad].map(rounded), &why);
    Ok(())
}

/// To a millimetre, which is well within the room around the robot.
fn rounded(value: f64) -> f64 {
    (value * 1.0e3).round() / 1.0e3
}

/// The free pose that is nearest to `wanted`, or to the middle of the map.
fn free_near(world: &World, footprint: &Footprint, wanted: &Pose) -> Option<Pose> {
    let geometry = world.geometry();
    let half = |cells: u32| 0.5 * f64::from(cells) * geometry.resolution_m;
    let middle = Pose::new(
        geometry.origin_x_m + half(geometry.width),
        geometry.origin_y_m + half(geometry.height),
        wanted.yaw_rad,
    );
    [wanted, &middle].into_iter().find_map(|near| {
        let any_rad = core::f64::consts::PI;
        world.nearest_free_pose(footprint, near, any_rad, START_CLEARANCE_M, |_| true)
    })
}

/// The outline; `None` of one that the check says is wrong.
fn footprint(converted: &Converted) -> Option<Footprint> {
    if let Some(radius_m) = converted.draft.number("robot.radius_m") {
        return Footprint::disc(radius_m).ok();
    }
    let corners = converted.draft.get("robot.footprint_m")?.clone();
    let corners: Vec<[f64; 2]> = corners.try_into().ok()?;
    Footprint::polygon(&corners).ok()
}

fn start(converted: &Converted) -> Pose {
    let start = converted.draft.get("start").cloned();
    let start = start.and_then(|it| it.try_into::<[f64; 3]>().ok());
    let [x_m, y_m, yaw_rad] = start.unwrap_or_default();
    Pose::new(x_m, y_m, yaw_rad)
}

/// `map` as the file `out` names it: below its folder, or as a whole.
fn seen_from(out: &Path, map: &Path) -> String {
    let whole = |path: &Path| path.canonicalize().ok();
    let folder = match out.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let map = whole(map).unwrap_or_else(|| map.to_path_buf());
    let below = whole(folder).and_then(|folder| Some(map.strip_prefix(folder).ok()?.to_path_buf()));
    below.unwrap_or(map).to_string_lossy().into_owned()
}

fn to_text(report: &Report, out: &Path) -> String {
    let [carried, assumed, left] = [
        report.carried.len(),
        report.assumed.len(),
        report.left.len(),
    ];
    let unknown: usize = report.unknown.iter().map(|it| it.count).sum();
    let mut lines = report.lines();
    let out = out.display();
    lines.push(format!(
        "{out}: {carried} parameters carried over, {assumed} values assumed, {left} things not carried over, {unknown} \
         parameters without a counterpart"
    ));
    lines.push(format!(
        "`zeronav check {out}` looks for what is wrong, `zeronav up {out}` brings it up"
    ));
    let lines: Vec<_> = lines.iter().map(|line| printable(line)).collect();
    lines.join("\n") + "\n"
}

fn to_json(converted: &Converted, out: &Path) -> serde_json::Value {
    let report = &converted.report;
    let carried = report.carried.iter().map(|it| {
        json!({ "from": it.from, "line": it.line, "value": it.value, "to": it.to, "ours": it.ours })
    });
    let assumed = report.assumed.iter();
    let assumed = assumed.map(|it| json!({ "to": it.to, "value": it.value, "why": it.why }));
    let left = report.left.iter();
    let left = left.map(|it| json!({ "what": it.what, "means": it.means }));
    let unknown = report.unknown.iter();
    let unknown =
        unknown.map(|it| json!({ "node": it.node, "count": it.count, "first": it.first }));
    json!({
        "scenario": out,
        "map": converted.map,
        "carried": carried.collect::<Vec<_>>(),
        "assumed": assumed.collect::<Vec<_>>(),
        "not_carried": left.collect::<Vec<_>>(),
        "without_counterpart": unknown.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    const PARAMETERS: &str = r#"
controller_server:
  ros__parameters:
    controller_plugins: ["FollowPath"]
    FollowPath: {plugin: "nav2_mppi_controller::MPPIController", vx_max: 0.4}
local_costmap:
  local_costmap:
    ros__parameters: {robot_radius: 0.2, resolution: 0.05}
"#;

    fn with(place: &TempDir, parameters: &str, map: Option<&str>) -> Result<Converted, Problem> {
        let file = place.path().join("params.yaml");
        std::fs::write(&file, parameters).expect("written");
        let map = map.map(|it| place.path().join(it));
        let order = Order {
            file: &file,
            urdf: None,
            map: map.as_deref(),
            out: None,
            force: false,
            json: false,
        };
        write(&order, &place.path().join("robot.toml"))
    }

    fn driven(place: &TempDir) -> Scenario {
        let file = place.path().join("robot.toml");
        let scenario = Scenario::load(&file.to_string_lossy()).expect("a scenario");
        scenario.validate().expect("that can be driven");
        scenario
    }

    #[test]
    fn what_is_written_can_be_driven_and_is_not_replaced() {
        let place = tempfile::tempdir().expect("a folder");
        with(&place, PARAMETERS, None).expect("written");
        let scenario = driven(&place);
        assert_eq!(scenario.robot.radius_m, Some(0.2));
        assert!((scenario.robot.v_mps_max - 0.4).abs() < 1e-12 && !scenario.static_map);
        let again = with(&place, PARAMETERS, None).expect_err("it exists");
        assert!(matches!(again, Problem::Input(why) if why.contains("--force")));
    }

    #[test]
    fn on_a_map_the_robot_starts_where_it_is_free() {
        let place = tempfile::tempdir().expect("a folder");
        // 4 x 4 m around the origin, with a block of 1 m in the middle.
        let is_block = |n: usize| (15..25).contains(&(n % 40)) && (15..25).contains(&(n / 40));
        let mut image = b"P5\n40 40\n255\n".to_vec();
        image.extend((0..1600).map(|n| if is_block(n) { 0 } else { 254 }));
        std::fs::write(place.path().join("map.pgm"), image).expect("written");
        let yaml = "image: map.pgm\nresolution: 0.1\norigin: [-2.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
        std::fs::write(place.path().join("map.yaml"), yaml).expect("written");
        with(&place, PARAMETERS, Some("map.yaml")).expect("written");
        let start = driven(&place).start;
        assert!(start.x_m.abs().max(start.y_m.abs()) > 0.9, "{start:?}");
        let text = std::fs::read_to_string(place.path().join("robot.toml")).expect("text");
        assert!(text.contains("map = \"map.yaml\"\n"), "{text}");
    }

    #[test]
    fn of_what_is_wrong_nothing_is_written() {
        let wrong = [
            (PARAMETERS.replace("0.4", "-0.4"), None),
            (PARAMETERS.to_owned(), Some("nowhere.yaml")),
            (PARAMETERS.replace("0.2,", "200.0,"), None),
        ];
        for (parameters, map) in wrong {
            let place = tempfile::tempdir().expect("a folder");
            let problem = with(&place, &parameters, map).expect_err("it is wrong");
            assert!(
                matches!(&problem, Problem::Input(why) if !why.contains('\n')),
                "{problem:?}"
            );
            assert!(!place.path().join("robot.toml").exists());
        }
    }
}
