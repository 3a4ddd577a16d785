mod fixtures;

use super::*;
use crate::nav2::plugins::Controller;
use crate::nav2::table::{FIELDS, Form, ROWS};
use fixtures::{DWB, MPPI, RPP, URDF};
use proptest::prelude::*;
use std::collections::BTreeSet;

fn convert(text: &str, urdf: Option<&str>) -> Result<Converted, String> {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("params.yaml");
    std::fs::write(&file, text).expect("written");
    let robot = urdf.map(|text| {
        let file = place.path().join("robot.urdf");
        std::fs::write(&file, text).expect("written");
        file
    });
    let converted = scenario_of(&file, robot.as_deref(), None);
    converted.map_err(|error| {
        error
            .to_string()
            .replace(&*place.path().to_string_lossy(), "")
    })
}

fn table_of(converted: &Converted) -> toml::Table {
    let text = converted.draft.to_toml();
    text.parse()
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn left<'a>(converted: &'a Converted, what: &str) -> &'a Left {
    let mut left = converted.report.left.iter();
    let found = left.find(|it| it.what.contains(what));
    found.unwrap_or_else(|| panic!("{what} is not in {:#?}", converted.report.left))
}

fn assumed<'a>(converted: &'a Converted, to: &str) -> &'a Assumed {
    let mut assumed = converted.report.assumed.iter();
    let found = assumed.find(|it| it.to == to);
    found.unwrap_or_else(|| panic!("{to} is not in {:#?}", converted.report.assumed))
}

#[test]
fn a_file_with_a_dynamic_window_becomes_these_values() {
    let converted = convert(DWB, None).expect("a scenario");
    let table = table_of(&converted);
    let robot = &table["robot"];
    let expected = [
        ("v_mps_max", 0.24),
        ("v_mps_min", -0.1),
        ("w_radps_max", 1.0),
        ("a_mps2_max", 1.5),
        ("brake_mps2", 2.0),
        ("alpha_radps2_max", 3.0),
    ];
    for (key, value) in expected {
        assert_eq!(robot[key].as_float(), Some(value), "{key}");
    }
    let corners: Vec<[f64; 2]> = robot["footprint_m"].clone().try_into().expect("corners");
    assert_eq!(
        corners,
        [[0.3, 0.2], [-0.1, 0.2], [-0.1, -0.2], [0.3, -0.2]]
    );
    assert!(
        assumed(&converted, "robot.footprint_m")
            .why
            .contains("clockwise")
    );
    assert!(robot.get("radius_m").is_none());
    assert!(left(&converted, "robot_radius").means.contains("footprint"));
    let services = &table["services"];
    let mapping = &services["mapping"]["config"];
    assert_eq!(mapping["inflation_radius_m"].as_float(), Some(0.55));
    assert_eq!(mapping["cost_scaling_factor"].as_float(), Some(3.0));
    assert_eq!(table["world"]["resolution_m"].as_float(), Some(0.1));
    assert_eq!(table["static_map"].as_bool(), Some(false));
    let local = &services["local_planner"]["config"];
    assert_eq!(local["controller"].as_str(), Some("dwa"));
    assert_eq!(local["dwa"]["horizon_s"].as_float(), Some(1.7));
    assert_eq!(local["dwa"]["speeds"].as_integer(), Some(20));
    assert!(local["dwa"].get("yaw_rates").is_none(), "80 are too many");
    assert!(
        left(&converted, "vtheta_samples = 80")
            .means
            .contains("3 to 64")
    );
    let global = &services["global_planner"]["config"];
    assert_eq!(global["planner"].as_str(), Some("mpgaa"));
    assert_eq!(global["unknown"].as_str(), Some("lethal"));
    assert_eq!(services["robot"]["binary"].as_str(), Some("zeronav-ros2"));
    let ros = &services["robot"]["config"]["ros"];
    assert_eq!(ros["scan_topic"].as_str(), Some("/front/scan"));
    assert_eq!(ros["base_frame"].as_str(), Some("base_link"));
    assert_eq!(ros["use_sim_time"].as_bool(), Some(true));
    assert_eq!(ros["cmd_vel_stamped"].as_bool(), Some(false));
    assert!(
        left(&converted, "amcl.base_frame_id")
            .means
            .contains("base_link")
    );
    assert!(left(&converted, "PointCloud2").means.contains("lidar"));
    assert!(
        left(&converted, "VoxelLayer")
            .means
            .contains("above and below")
    );
    assert!(left(&converted, "nowhere.yaml").means.contains("--map"));
    let unknown = converted
        .report
        .unknown
        .iter()
        .find(|it| it.node == "my_node");
    let unknown = unknown.expect("a node that nobody knows");
    assert_eq!((unknown.count, unknown.first.len()), (4, 3));
    let text = converted.draft.to_toml();
    assert!(text.contains("# tolerance_m = 0.2 "), "{text}");
    assert!(
        text.contains("v_mps_min = -0.1  # controller_server.FollowPath.min_vel_x\n"),
        "{text}"
    );
}

#[test]
fn a_file_with_mppi_takes_the_defaults_of_nav2_and_says_so() {
    let converted = convert(MPPI, None).expect("a scenario");
    let table = table_of(&converted);
    let robot = &table["robot"];
    assert_eq!(robot["radius_m"].as_float(), Some(0.22));
    assert_eq!(robot["v_mps_max"].as_float(), Some(0.6));
    assert_eq!(robot["v_mps_min"].as_float(), Some(-0.35));
    assert_eq!(robot["brake_mps2"].as_float(), Some(3.0));
    assert!(
        assumed(&converted, "robot.v_mps_min")
            .why
            .contains("default of Nav2")
    );
    let local = &table["services"]["local_planner"]["config"];
    assert_eq!(local["controller"].as_str(), Some("mppi"));
    assert_eq!(local["mppi"]["samples"].as_integer(), Some(1000));
    assert!(local["mppi"].get("steps").is_none());
    assert!(
        left(&converted, "time_steps = 80")
            .means
            .contains("14 to 64")
    );
    assert!(
        left(&converted, "omnidirectional")
            .means
            .contains("sideways")
    );
    assert!(
        left(&converted, "KeepoutFilter")
            .means
            .contains("not obeyed")
    );
    assert!(
        left(&converted, "SmacPlannerHybrid")
            .means
            .contains("turn on the spot")
    );
    assert!(
        left(&converted, "planner_plugins: Other")
            .means
            .contains("GridBased")
    );
    let ros = &table["services"]["robot"]["config"]["ros"];
    assert_eq!(ros["cmd_vel_stamped"].as_bool(), Some(true));
    assert_eq!(ros["scan_topic"].as_str(), Some("/scan"));
    assert_eq!(ros["odom_topic"].as_str(), Some("/odom"));
}

#[test]
fn wildcards_and_namespaces_reach_every_node_and_a_launch_file_is_not_read() {
    let converted = convert(RPP, None).expect("a scenario");
    let table = table_of(&converted);
    let robot = &table["robot"];
    assert_eq!(robot["v_mps_max"].as_float(), Some(0.7));
    assert_eq!(robot["v_mps_min"].as_float(), Some(-0.7));
    let ros = &table["services"]["robot"]["config"]["ros"];
    assert_eq!(ros["use_sim_time"].as_bool(), Some(true));
    assert_eq!(ros["cmd_vel_stamped"].as_bool(), Some(true));
    assert_eq!(ros["scan_topic"].as_str(), Some("/robot1/scan"));
    let controller = &table["services"]["local_planner"]["config"]["controller"];
    assert_eq!(controller.as_str(), Some("beam"));
    assert!(
        left(&converted, "RegulatedPurePursuit")
            .means
            .contains("pure pursuit")
    );
    assert!(
        left(&converted, "RotationShim")
            .means
            .contains("turn on the spot")
    );
    assert!(
        left(&converted, "$(var turn)")
            .means
            .contains("launch file")
    );
    assert!(
        converted.report.unknown.is_empty(),
        "{:?}",
        converted.report.unknown
    );
}

#[test]
fn a_urdf_gives_mount_and_outline() {
    let bare = "controller_server: {ros__parameters: {}}\n";
    let why = convert(bare, None).expect_err("no outline");
    assert!(
        why.contains("robot_radius") && why.contains("--urdf"),
        "{why}"
    );
    let converted = convert(bare, Some(URDF)).expect("a scenario");
    let table = table_of(&converted);
    assert_eq!(table["robot"]["radius_m"].as_float(), Some(0.25));
    let pose: [f64; 3] = table["robot"]["lidar"]["pose"]
        .clone()
        .try_into()
        .expect("a pose");
    assert_eq!(format!("{pose:?}"), "[0.1, 0.0, 0.0]");
    // That of the file counts.
    let table = table_of(&convert(MPPI, Some(URDF)).expect("a scenario"));
    assert_eq!(table["robot"]["radius_m"].as_float(), Some(0.22));
}

// long: a row for each kind of bad input
#[test]
fn what_cannot_be_is_one_line_with_file_line_and_parameter() {
    let with = |from: &str, to: &str| {
        assert!(DWB.contains(from), "{from}");
        DWB.replace(from, to)
    };
    let radius = "robot_radius";
    for (text, words) in [
        (
            with("max_vel_x: 0.26", "max_vel_x: .nan"),
            ["line 23", "FollowPath.max_vel_x", "finite"],
        ),
        (
            with("max_vel_x: 0.26", "max_vel_x: -0.26"),
            ["line 23", "max_vel_x", "negative"],
        ),
        (
            with("max_vel_x: 0.26", "max_vel_x: fast"),
            ["line 23", "max_vel_x", "a number"],
        ),
        (
            with("max_vel_x: 0.26", "max_vel_x: 0.0"),
            ["line 23", "max_vel_x", "0.001 to 1000"],
        ),
        (
            with("[0.24, 0.0, 1.5]", "[0.24]"),
            ["velocity_smoother.max_velocity[2]", "x, y, theta", "line"],
        ),
        (
            with("[0.24, 0.0, 1.5]", "0.24"),
            ["max_velocity[0]", "a list", "line"],
        ),
        (
            with("[0.3, 0.2]]", "[0.3, .inf]]"),
            ["footprint", "-100 to 100", "line"],
        ),
        (
            with("[0.3, 0.2]]", "[9, 9, 9]]"),
            ["footprint", "corners", "line"],
        ),
        (
            with("/front/scan", "/front//scan"),
            ["scan.topic", "cannot be the name", "line"],
        ),
        (
            with("True", "maybe"),
            ["use_sim_time", "true or false", "line 11"],
        ),
        (
            with(
                "  ros__parameters:\n    base",
                "  ros__parameters:\n   - base",
            ),
            ["params.yaml", "line", "not YAML"],
        ),
        (
            "controller_server:\n  max_vel_x: 1\n".to_owned(),
            ["params.yaml", "line", "ros__parameters"],
        ),
        (
            "talker:\n  ros__parameters: {a: 1}\n".to_owned(),
            ["params.yaml", "no node of Nav2", "controller_server"],
        ),
        (String::new(), ["params.yaml", "no table", "line"]),
        (
            MPPI.replace(radius, "radius"),
            ["params.yaml", radius, "--urdf"],
        ),
        ("a: ".repeat(3), ["params.yaml", "line 1", "not YAML"]),
    ] {
        let why = convert(&text, None).expect_err(words[1]);
        assert!(!why.contains('\n'), "{why}");
        for word in words {
            assert!(why.contains(word), "{word:?}: {why}");
        }
    }
    let why = convert(MPPI, Some("robot: 1")).expect_err("no XML");
    assert!(why.contains("robot.urdf: line 1: is not XML"), "{why}");
    let missing = scenario_of(Path::new("/nowhere/params.yaml"), None, None);
    assert!(
        missing
            .expect_err("no file")
            .to_string()
            .contains("/nowhere/params.yaml")
    );
    let huge = "a: 1\n".repeat(300_000);
    assert!(
        convert(&huge, None)
            .expect_err("huge")
            .contains("more than")
    );
}

#[test]
fn clearances_reach_as_far_as_inflation_and_outline_in_ninety_cells() {
    let limit = |text: &str, resolution_m| {
        let mut converted = convert(text, None).expect("a scenario");
        converted.fit(resolution_m);
        let mapping = |key: &str| {
            converted
                .draft
                .number(&format!("services.mapping.config.{key}"))
        };
        (mapping("clearance_limit_m"), mapping("inflation_radius_m"))
    };
    assert_eq!(limit(DWB, 0.05), (None, Some(0.55)));
    let wide = DWB.replace("inflation_radius: 0.55", "inflation_radius: 2.5");
    assert_eq!(limit(&wide, 0.05), (Some(2.5), Some(2.5)));
    assert_eq!(limit(&wide, 0.02), (Some(1.8), Some(1.8)));
    let large = MPPI.replace("robot_radius: 0.22", "robot_radius: 1.5");
    assert_eq!(limit(&large, 0.05), (Some(1.6), None));
}

#[test]
fn every_row_leads_to_a_field_and_every_field_of_a_robot_has_its_declared_range() {
    for row in ROWS {
        let field = FIELDS.iter().find(|it| it.path == row.to);
        let field = field.unwrap_or_else(|| panic!("{} is no field", row.to));
        if let (Some(usual), Some([least, most])) = (row.otherwise, field.range) {
            let usual = if row.form == Form::Size {
                usual.abs()
            } else {
                usual
            };
            assert!((least..=most).contains(&usual), "{row:?}");
        }
        let braces = row.parameter.contains("{controller}");
        assert!(
            row.of.is_none_or(|it| it != Controller::Other && braces),
            "{row:?}"
        );
    }
    let declared = zeronav_robot_description::RobotSpec::parameters("robot");
    for field in FIELDS.iter().filter(|it| it.path.starts_with("robot.")) {
        let of = declared.iter().find(|it| it.path == field.path);
        let of = of.unwrap_or_else(|| panic!("a robot has no {}", field.path));
        let range = field.range.map(|[least, most]| (Some(least), Some(most)));
        assert!(
            range.is_none_or(|it| it == (of.min, of.max)),
            "{}",
            field.path
        );
    }
    let paths: BTreeSet<&str> = FIELDS.iter().map(|it| it.path).collect();
    assert_eq!(paths.len(), FIELDS.len());
}

#[test]
fn names_of_files_tell_parameters_from_logs() {
    for (name, is) in [
        ("a.yaml", true),
        ("a.YML", true),
        ("a.mcap", false),
        ("yaml", false),
    ] {
        assert_eq!(is_parameter_file(Path::new(name)), is, "{name}");
    }
}

/// Texts that look like parameter files, now and then.
fn yamlish() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        Just("controller_server:\n".to_owned()),
        Just("  ros__parameters:\n".to_owned()),
        Just("local_costmap:\n  local_costmap:\n    ros__parameters:\n".to_owned()),
        Just("      robot_radius: 0.3\n".to_owned()),
        Just("      footprint: \"[[".to_owned()),
        Just("    FollowPath: {plugin: \"dwb_core::DWBLocalPlanner\", max_vel_x: ".to_owned()),
        Just("/**: {ros__parameters: ".to_owned()),
        Just("*a".to_owned()),
        Just("&a ".to_owned()),
        Just("<<: ".to_owned()),
        Just(".nan".to_owned()),
        Just("-1e400".to_owned()),
        Just("]]}\n".to_owned()),
        Just("? ".to_owned()),
        Just("!!binary ".to_owned()),
        "[-a-z0-9:\\[\\]{},&*!|>'\"%@ \n\t#]{0,12}",
        any::<String>(),
    ];
    prop::collection::vec(word, 0..24).prop_map(|words| words.concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn no_text_makes_it_panic_and_what_it_makes_is_toml(text in yamlish(), urdf in prop::option::of("(<robot>|<link name=\"a\">|</robot>|<joint|xyz=\"1 2\"|[ -~]){0,8}")) {
        match convert(&text, urdf.as_deref()) {
            Ok(converted) => drop(table_of(&converted)),
            Err(why) => prop_assert!(!why.is_empty()),
        }
    }

    #[test]
    fn a_value_of_any_kind_in_a_known_place_never_panics(at in 0..20_usize, value in prop_oneof![
        Just("[]"), Just("{}"), Just("~"), Just("1e308"), Just("-1e308"), Just("\"\""), Just("[[[]]]"),
        Just("{a: {b: 1}}"), Just("true"), Just("\u{202e}\u{0085}"), Just("0x7fffffffffffffff"), Just("[1, 2, 3, 4, 5, 6]"),
    ]) {
        let rows: Vec<&str> = DWB.lines().filter(|it| it.contains(": ")).collect();
        let line = rows[at * rows.len() / 20];
        let key = line.split(": ").next().expect("a key");
        let text = DWB.replace(line, &format!("{key}: {value}"));
        if let Ok(mut converted) = convert(&text, None) {
            converted.fit(0.05);
            drop(table_of(&converted));
        }
    }
}
