//! What is not carried over, and what that means.

use super::parameters::{Place, Sections};
use super::plugins::{
    CONTROLLERS_NODE, Controller, GLOBAL, LOCAL, MONITOR, PLANNERS_NODE, Plugins, is,
};
use super::report::{Report, Unknown};
use super::yaml::Value;
use std::collections::BTreeSet;

/// Most parameters without a counterpart that are named of a node.
const NAMED_MAX: usize = 3;

/// Nodes of Nav2 that have no counterpart.
#[rustfmt::skip]
const NODES: &[(&str, &str)] = &[
    ("amcl", "mapping lays scans on the map (mapping.pose_correction); it does not find a robot that is lost: `zeronav pose` tells it where it is"),
    ("bt_navigator", "no behaviour trees: the local planner carries out the task, asks for another path and recovers"),
    ("behavior_server", "recoveries are those of the local planner (local_planner.recovery): another path, waiting, backing up, turning"),
    ("recoveries_server", "recoveries are those of the local planner (local_planner.recovery): another path, waiting, backing up, turning"),
    ("smoother_server", "no smoother: global_planner.smooth_m rounds paths"),
    ("waypoint_follower", "no tasks at waypoints: `zeronav goals FILE` drives to several goals"),
    ("route_server", "no route graph: every way is planned on the grid"),
    ("docking_server", "no docking"),
    ("following_server", "no following of objects"),
    ("map_saver", "`zeronav map save` writes the map"),
    ("keepout_filter_mask_server", "keepout zones are not obeyed: draw them into the map"),
    ("keepout_costmap_filter_info_server", "keepout zones are not obeyed: draw them into the map"),
    ("filter_mask_server", "zones of a mask are not obeyed: draw keepout zones into the map"),
    ("costmap_filter_info_server", "zones of a mask are not obeyed: draw keepout zones into the map"),
    ("speed_filter_mask_server", "speed zones are not obeyed"),
    ("speed_costmap_filter_info_server", "speed zones are not obeyed"),
    ("loopback_simulator", "zeronav-robot-sim is the simulator"),
    ("vector_object_server", "keepout shapes are not obeyed: draw them into the map"),
    ("slam_toolbox", "mapping builds the map, without closing loops"),
    ("robot_state_publisher", "it goes on as it is"),
    ("lifecycle_manager", "zeronav starts and watches its own processes"),
];

/// Nodes with parameters that are carried over.
const CARRIED: &[&str] = &[
    CONTROLLERS_NODE,
    PLANNERS_NODE,
    LOCAL,
    GLOBAL,
    MONITOR,
    "velocity_smoother",
    "map_server",
];

/// Plugins of costmaps that have no counterpart.
#[rustfmt::skip]
const LAYERS: &[(&str, &str)] = &[
    ("VoxelLayer", "the planar lidar alone is seen: obstacles above and below its plane are not"),
    ("SpatioTemporalVoxelLayer", "the planar lidar alone is seen: obstacles above and below its plane are not"),
    ("NonPersistentVoxelLayer", "the planar lidar alone is seen: obstacles above and below its plane are not"),
    ("RangeSensorLayer", "range sensors are not read"),
    ("KeepoutFilter", "keepout zones are not obeyed: draw them into the map"),
    ("SpeedFilter", "speed zones are not obeyed"),
    ("BinaryFilter", "zones that switch something are not obeyed"),
    ("DenoiseLayer", "single cells are not removed"),
];

/// True when a file has a node that belongs to Nav2, or a wildcard.
pub(super) fn is_nav2(sections: &Sections) -> bool {
    let known = || {
        NODES
            .iter()
            .map(|(node, _)| *node)
            .chain(CARRIED.iter().copied())
    };
    sections.iter().any(|it| known().any(|node| it.means(node)))
}

/// Says what is not carried over. `seen` are the places of parameters that were looked at.
pub(super) fn say(
    sections: &Sections,
    plugins: &Plugins<'_>,
    seen: &BTreeSet<Place>,
    report: &mut Report,
) {
    several(sections, report);
    drive(sections, plugins, report);
    let mut said = BTreeSet::new();
    for node in [LOCAL, GLOBAL] {
        for (name, plugin) in plugins.layers(node) {
            let found = LAYERS.iter().find(|(known, _)| is(plugin, known));
            let switch = sections.get(node, &format!("{name}.enabled"));
            let is_off = switch.is_some_and(|it| it.value == Value::Switch(false));
            if let Some((known, means)) = found.filter(|_| !is_off)
                && said.insert(*known)
            {
                report.leave(format!("{node}.{name} ({known})"), *means);
            }
            sources(node, name, plugins, report);
        }
    }
    ranges(sections, plugins, report);
    zones(sections, report);
    for (index, section) in sections.iter().enumerate() {
        let node = NODES
            .iter()
            .find(|(node, _)| section.is_literal() && section.means(node));
        if let Some((_, means)) = node {
            let all = 0..section.parameters.len();
            let n = all.filter(|at| !seen.contains(&(index, *at))).count();
            let s = if n == 1 { "" } else { "s" };
            report.leave(format!("{} ({n} parameter{s})", section.name()), *means);
        }
    }
    unknown(sections, seen, report);
}

/// Further plugins of a kind.
fn several(sections: &Sections, report: &mut Report) {
    for (node, list) in [
        (CONTROLLERS_NODE, "controller_plugins"),
        (CONTROLLERS_NODE, "goal_checker_plugins"),
        (PLANNERS_NODE, "planner_plugins"),
    ] {
        let names = sections.texts(node, list);
        if let [first, rest @ ..] = &names[..]
            && !rest.is_empty()
        {
            let what = format!("{node}.{list}: {}", rest.join(", "));
            report.leave(what, format!("one at a time: {first} is carried over"));
        }
    }
    if sections.get(LOCAL, "footprint_padding").is_some()
        || sections.get(GLOBAL, "footprint_padding").is_some()
    {
        let means = "margins around the outline are those of mapping.padding_m, the controller and the guard";
        report.leave("footprint_padding", means);
    }
}

/// Drives that are no differential ones, and what is around the controller.
fn drive(sections: &Sections, plugins: &Plugins<'_>, report: &mut Report) {
    let at = |name: &str| format!("{}.{name}", plugins.controller);
    let text = |name| {
        sections
            .text(CONTROLLERS_NODE, &at(name))
            .unwrap_or_default()
            .to_lowercase()
    };
    let number = |node, name: &str| match sections.get(node, name).map(|it| &it.value) {
        Some(Value::Number(it)) => *it,
        _ => 0.0,
    };
    let model = text("motion_model");
    let amcl = sections
        .text("amcl", "robot_model_type")
        .unwrap_or_default();
    let sideways_mps = number(CONTROLLERS_NODE, &at("max_vel_y"));
    let slides = plugins.kind == Controller::Dwb && sideways_mps > 0.0;
    if model.contains("omni") || slides || amcl.to_lowercase().contains("omni") {
        report.leave(
            "an omnidirectional drive",
            "the robot is driven as a differential one: it never moves sideways",
        );
    }
    if model.contains("ackermann") {
        report.leave(
            "a drive with Ackermann steering",
            "zeronav turns robots on the spot, which this one cannot: it is not fit for it",
        );
    }
    let outer = text("plugin");
    if is(&outer, "rotationshimcontroller") {
        report.leave(
            at("plugin") + " (RotationShimController)",
            "controllers turn on the spot by themselves",
        );
    }
    let checker = sections.texts(CONTROLLERS_NODE, "progress_checker_plugins");
    if !checker.is_empty()
        || sections
            .get(CONTROLLERS_NODE, "progress_checker_plugin")
            .is_some()
    {
        report.leave(
            "controller_server: progress checker",
            "local_planner.task (progress_m, no_progress_s, stuck_s) decides when a robot is stuck",
        );
    }
    if sections
        .get(CONTROLLERS_NODE, "controller_frequency")
        .is_some()
    {
        report.leave(
            "controller_server.controller_frequency",
            "the stack runs at the rate of the odometry",
        );
    }
}

/// Sensors other than the lidar.
fn sources(node: &str, layer: &str, plugins: &Plugins<'_>, report: &mut Report) {
    let sources = plugins.sources(node, &format!("{layer}."), ("data_type", "LaserScan"));
    let mut lidars = 0;
    for (name, kind) in sources {
        if kind != "LaserScan" {
            report.leave(
                format!("{node}.{name} ({kind})"),
                "the planar lidar alone is read",
            );
            continue;
        }
        lidars += 1;
        if lidars == 2 {
            report.leave(format!("{node}.{name}"), "one lidar is read");
        }
    }
}

/// How far obstacles are marked.
fn ranges(sections: &Sections, plugins: &Plugins<'_>, report: &mut Report) {
    let range = |end: &str| {
        let name = plugins.named(GLOBAL, &format!("{{scan}}.{end}"))?;
        match sections.get(GLOBAL, &name)?.value {
            Value::Number(it) => Some((name, it)),
            _ => None,
        }
    };
    if let Some((name, marks_m)) = range("obstacle_max_range") {
        report.leave(
            format!("{GLOBAL}.{name} = {marks_m}"),
            "obstacles are marked as far as the lidar sees, up to mapping.obstacle_range_m = 12",
        );
    }
}

/// Zones of the collision monitor.
fn zones(sections: &Sections, report: &mut Report) {
    let zones = sections.texts(MONITOR, "polygons");
    if !zones.is_empty() {
        report.leave(
            format!("{MONITOR}.polygons: {}", zones.join(", ")),
            "no zones: the collision guard lets no command pass from which the outline could not stop in time",
        );
    }
}

/// True for parameters that only say which others there are.
fn is_structure(name: &str) -> bool {
    let last = name.rsplit('.').next().unwrap_or(name);
    let lists = [
        "plugin",
        "plugins",
        "filters",
        "observation_sources",
        "data_type",
        "primary_controller",
        "use_sim_time",
        "controller_frequency",
        "footprint_padding",
        "yaml_filename",
    ];
    lists.contains(&last) || last.ends_with("_plugin") || last.ends_with("_plugins")
}

/// Counts what nothing has looked at.
fn unknown(sections: &Sections, seen: &BTreeSet<Place>, report: &mut Report) {
    for (index, section) in sections.iter().enumerate() {
        if NODES
            .iter()
            .any(|(node, _)| section.is_literal() && section.means(node))
        {
            continue;
        }
        let names = section.parameters.iter().enumerate();
        let names =
            names.filter(|(at, it)| !seen.contains(&(index, *at)) && !is_structure(&it.name));
        let names: Vec<&str> = names.map(|(_, it)| it.name.as_str()).collect();
        if !names.is_empty() {
            report.unknown.push(Unknown {
                node: section.name(),
                count: names.len(),
                first: names
                    .iter()
                    .take(NAMED_MAX)
                    .map(|it| (*it).to_owned())
                    .collect(),
            });
        }
    }
}
