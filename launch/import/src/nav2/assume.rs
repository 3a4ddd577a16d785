//! What a scenario needs and no parameter gives.

use super::draft::Draft;
use super::outline;
use super::parameters::Sections;
use super::plugins::{
    CONTROLLERS, DEFAULT_CONTROLLER, DEFAULT_PLANNER, Kin, PLANNERS, Plugins, is,
};
use super::plugins::{CONTROLLERS_NODE, PLANNERS_NODE};
use super::report::{Assumed, Carried, Report};
use super::urdf::{Outline, Urdf};
use super::yaml::Value;
use toml::Value as Toml;

/// Largest side of a world without a map. [m]
const AREA_M: f64 = 40.0;

/// Most cells along a side of it: 128 tiles of 32 cells.
const SIDE_CELLS_MAX: f64 = 4096.0;

/// Mapping's clearance limit and inflation radius without a word of the scenario. [m]
const CLEARANCE_LIMIT_M: f64 = 1.0;
const INFLATION_M: f64 = 0.6;

/// Most cells and metres of the clearance limit.
const LIMIT_CELLS_MAX: f64 = 90.0;
const LIMIT_M_MAX: f64 = 65.0;

const RADIUS: &str = "robot.radius_m";
const FOOTPRINT: &str = "robot.footprint_m";
const POSE: &str = "robot.lidar.pose";
const RESOLUTION: &str = "world.resolution_m";

/// A draft and what is said of it.
pub(super) type Making<'a> = (&'a mut Draft, &'a mut Report);

/// Gives a field a value that no parameter gives.
pub(super) fn assume(
    (draft, report): Making<'_>,
    to: &'static str,
    value: impl Into<Toml>,
    why: &str,
) {
    let value = value.into();
    report.assumed.push(Assumed {
        to,
        value: value.to_string(),
        why: why.to_owned(),
    });
    draft.set(to, value, format!("assumed: {why}"));
}

/// Limits that are still missing.
pub(super) fn limits((draft, report): Making<'_>) {
    let limits = [
        (
            "robot.v_mps_max",
            0.5,
            "no controller in the file says how fast: the usual speed of Nav2",
        ),
        (
            "robot.v_mps_min",
            0.0,
            "nothing in the file lets the robot drive backwards",
        ),
        (
            "robot.w_radps_max",
            1.0,
            "no controller in the file says how fast it turns",
        ),
        (
            "robot.a_mps2_max",
            1.0,
            "no acceleration is in the file: most indoor bases do it",
        ),
        (
            "robot.alpha_radps2_max",
            2.0,
            "no angular acceleration is in the file: most indoor bases do it",
        ),
    ];
    for (to, value, why) in limits {
        if draft.get(to).is_none() {
            assume((&mut *draft, &mut *report), to, value, why);
        }
    }
    if draft.number("robot.v_mps_min") == Some(0.0) {
        let means = "it cannot back out of a dead end in a recovery; set it below 0 if nothing is behind the robot that the lidar does not see";
        report.leave("robot.v_mps_min = 0", means);
    }
}

/// The outline, from the URDF when the file has none.
///
/// # Errors
/// When there is none.
pub(super) fn outline((draft, report): Making<'_>, urdf: Option<&Urdf>) -> Result<(), String> {
    if draft.get(RADIUS).is_some() || draft.get(FOOTPRINT).is_some() {
        return Ok(());
    }
    let missing = "no footprint and no robot_radius of local_costmap or global_costmap is in it";
    let Some(urdf) = urdf else {
        return Err(format!("{missing}: add one, or give the URDF with --urdf"));
    };
    let (found, link) = urdf
        .outline(base_frame(draft))
        .map_err(|why| format!("{missing}, and none in the URDF: {why}"))?;
    let from = format!("URDF, collision geometry of {link}");
    let (to, value): (_, Toml) = match found {
        Outline::Disc(radius_m) => (RADIUS, radius_m.into()),
        Outline::Polygon(corners) => {
            let corners = corners.iter().map(|it| it.to_vec());
            (FOOTPRINT, corners.collect::<Vec<_>>().into())
        }
    };
    carried_from_urdf((draft, report), to, value, from);
    let means = "wheels and whatever else sticks out of that link are not in the outline: check it";
    report.leave("other links of the URDF", means);
    Ok(())
}

fn carried_from_urdf((draft, report): Making<'_>, to: &'static str, value: Toml, from: String) {
    report.carried.push(Carried {
        from: from.clone(),
        line: None,
        value: value.to_string(),
        to,
        ours: Some(value.to_string()),
    });
    draft.set(to, value, from);
}

/// The frame of the robot.
fn base_frame(draft: &Draft) -> &str {
    draft
        .text("services.robot.config.ros.base_frame")
        .unwrap_or("base_link")
}

/// The lidar: its place from the URDF, everything else is what it tells in its scans.
pub(super) fn lidar((draft, report): Making<'_>, urdf: Option<&Urdf>) {
    let base = base_frame(draft).to_owned();
    let asked = urdf.filter(|it| it.has(&base));
    let mount = match (urdf, asked) {
        (None, _) => Err("no URDF was given".to_owned()),
        (Some(_), None) => Err(format!("the URDF has no link {base}")),
        (_, Some(urdf)) => urdf.mount(&base),
    };
    match mount {
        Ok(mount) => {
            let from = format!("URDF, fixed joints from {base} to {}", mount.link);
            carried_from_urdf(
                (&mut *draft, &mut *report),
                POSE,
                mount.pose.to_vec().into(),
                from,
            );
            if mount.is_inverted {
                let means = "it is mounted upside down, which robot.lidar.pose cannot say: services.robot.config.ros.laser_from_tf must stay true";
                report.leave(mount.link, means);
            }
        }
        Err(why) => {
            let why = format!("{why}; zeronav-ros2 takes it from /tf");
            assume((&mut *draft, &mut *report), POSE, vec![0.0; 3], &why);
        }
    }
    let told = "the lidar says it itself in each scan; a simulated one needs it here";
    let rate = "measure it with `ros2 topic hz` on the scan topic: it decides when a scan is late";
    let lidar: [(_, Toml, _); 4] = [
        ("robot.lidar.n_beams", 360.into(), told),
        ("robot.lidar.rate_hz", 10.0.into(), rate),
        ("robot.lidar.range_m_min", 0.1.into(), told),
        ("robot.lidar.range_m_max", 12.0.into(), told),
    ];
    for (to, value, why) in lidar {
        assume((&mut *draft, &mut *report), to, value, why);
    }
}

/// Planner and controller.
pub(super) fn algorithms(making: Making<'_>, sections: &Sections, plugins: &Plugins<'_>) {
    let (draft, report) = making;
    let plugin = plugins.controller_plugin;
    if sections.names(CONTROLLERS_NODE) {
        let from = format!("{CONTROLLERS_NODE}.{}.plugin", plugins.controller);
        let to = "services.local_planner.config.controller";
        let known = CONTROLLERS.iter().find(|it| is(plugin, it.plugin));
        kin(
            (&mut *draft, &mut *report),
            (from, plugin),
            (to, DEFAULT_CONTROLLER),
            known,
        );
    }
    if sections.names(PLANNERS_NODE) {
        let plugin = plugins.planner_plugin;
        let from = format!("{PLANNERS_NODE}.{}.plugin", plugins.planner);
        let to = "services.global_planner.config.planner";
        let known = PLANNERS.iter().find(|it| is(plugin, it.plugin));
        kin(
            (draft, report),
            (from, plugin),
            (to, DEFAULT_PLANNER),
            known,
        );
    }
}

fn kin<K>(
    (draft, report): Making<'_>,
    (from, plugin): (String, &str),
    (to, default): (&'static str, &'static str),
    known: Option<&Kin<K>>,
) {
    let means = known.map_or("none of this name is known", |it| it.means);
    let Some(key) = known.and_then(|it| it.key) else {
        report.leave(format!("{from} = {plugin}"), means);
        let why = format!("the default in place of {plugin}");
        assume((draft, report), to, default, &why);
        return;
    };
    draft.set(to, key, format!("{from} = {plugin}: {means}"));
    report.carried.push(Carried {
        from,
        line: None,
        value: plugin.to_owned(),
        to,
        ours: Some(format!("{key} ({means})")),
    });
}

/// The side of ROS.
pub(super) fn ros((draft, report): Making<'_>, sections: &Sections) {
    draft.set(
        "services.robot.binary",
        "zeronav-ros2",
        "without this line and the table below: simulated",
    );
    let words: [(_, Toml, _); 6] = [
        (
            "services.robot.config.ros.scan_topic",
            "/scan".into(),
            "the usual name",
        ),
        (
            "services.robot.config.ros.odom_topic",
            "/odom".into(),
            "the usual name",
        ),
        (
            "services.robot.config.ros.cmd_vel_topic",
            "/cmd_vel".into(),
            "the usual name",
        ),
        (
            "services.robot.config.ros.odom_frame",
            "odom".into(),
            "the usual name",
        ),
        (
            "services.robot.config.ros.base_frame",
            "base_link".into(),
            "the usual name",
        ),
        (
            "services.robot.config.ros.use_sim_time",
            false.into(),
            "the file does not say so: a real robot",
        ),
    ];
    for (to, value, why) in words {
        if draft.get(to).is_none() {
            assume((&mut *draft, &mut *report), to, value, why);
        }
    }
    let stamped = "services.robot.config.ros.cmd_vel_stamped";
    if draft.get(stamped).is_none() {
        // Only files from Kilted on have these.
        let newer = |name: &str| {
            let last = name.rsplit('.').next().unwrap_or(name);
            [
                "service_introspection_mode",
                "introspection_mode",
                "error_code_name_prefixes",
            ]
            .contains(&last)
        };
        let is_newer = sections
            .iter()
            .flat_map(|it| &it.parameters)
            .any(|it| newer(&it.name));
        let why = if is_newer {
            "enable_stamped_cmd_vel is not in the file, which looks like one of Kilted or later, where it is true"
        } else {
            "enable_stamped_cmd_vel is not in the file: false up to Jazzy, true from Kilted on"
        };
        assume((draft, report), stamped, is_newer, why);
    }
}

/// Area, and start when `amcl` has one.
pub(super) fn world((draft, report): Making<'_>, sections: &Sections, has_map: bool) {
    let number = |axis: &str| match sections.get("amcl", &format!("initial_pose.{axis}"))?.value {
        Value::Number(it) if it.is_finite() && it.abs() < 1.0e6 => Some(it),
        _ => None,
    };
    let is_set =
        sections.get("amcl", "set_initial_pose").map(|it| &it.value) == Some(&Value::Switch(true));
    let pose = is_set.then(|| ["x", "y", "yaw"].map(|axis| number(axis).unwrap_or(0.0)));
    let pose = pose.map(|[x, y, yaw]| [x, y, yaw % core::f64::consts::TAU]);
    if let Some(pose) = pose.filter(|_| has_map) {
        let from = "amcl.initial_pose";
        draft.set("start", pose.to_vec(), from);
        let value = Toml::from(pose.to_vec()).to_string();
        report.carried.push(Carried {
            from: from.to_owned(),
            line: None,
            value: value.clone(),
            to: "start",
            ours: Some(value),
        });
    } else {
        let why = "`zeronav pose` tells the stack where the robot is";
        assume((&mut *draft, &mut *report), "start", vec![0.0; 3], why);
    }
    if has_map {
        draft.unset(RESOLUTION);
        return;
    }
    if draft.get(RESOLUTION).is_none() {
        assume(
            (&mut *draft, &mut *report),
            RESOLUTION,
            0.05,
            "no costmap says so",
        );
    }
    let resolution_m = draft.number(RESOLUTION).unwrap_or(0.05);
    let half_m = 0.5 * AREA_M.min(resolution_m * SIDE_CELLS_MAX);
    let area = vec![vec![-half_m, -half_m], vec![half_m, half_m]];
    let why = "no map was given: nothing is known but what the lidar sees from here on";
    assume((&mut *draft, &mut *report), "world.area_m", area, why);
    assume((draft, report), "static_map", false, "no map was given");
}

/// Lets mapping tell clearances as far as the inflation and the outline need it, and its cells allow.
pub(super) fn clearance((draft, report): Making<'_>, resolution_m: f64) {
    let inflation = "services.mapping.config.inflation_radius_m";
    let to = "services.mapping.config.clearance_limit_m";
    let inscribed_m = draft.number(RADIUS).unwrap_or_else(|| inscribed_m(draft));
    let inflation_m = draft.number(inflation).unwrap_or(INFLATION_M);
    let most_m = LIMIT_M_MAX.min(LIMIT_CELLS_MAX * resolution_m);
    let wanted_m = CLEARANCE_LIMIT_M.max(inflation_m).max(inscribed_m + 0.1);
    let limit_m = wanted_m.max(resolution_m).min(most_m);
    if inflation_m > limit_m {
        let why = format!("{inflation_m} is more than {LIMIT_CELLS_MAX} cells of {resolution_m} m");
        assume((&mut *draft, &mut *report), inflation, limit_m, &why);
    }
    if (limit_m - CLEARANCE_LIMIT_M).abs() > 1.0e-9 {
        let why = "as far as the inflation and the outline reach, in at most 90 cells";
        assume((draft, report), to, limit_m, why);
    }
}

fn inscribed_m(draft: &Draft) -> f64 {
    let corners = draft.get(FOOTPRINT).and_then(Toml::as_array);
    let corner = |it: &Toml| {
        let it = it.as_array()?;
        Some([it.first()?.as_float()?, it.get(1)?.as_float()?])
    };
    let corners: Vec<[f64; 2]> = corners.into_iter().flatten().filter_map(corner).collect();
    if corners.len() < 3 {
        return 0.0;
    }
    outline::inscribed_m(&corners)
}
