//! Scenarios that build on other files, and variants.

use super::{Folder, GOOD, load};
use crate::{Library, Scenario, ScenarioError};
use std::path::Path;
use zeronav_msgs::Role;
use zeronav_world_files::map_file;

#[test]
fn a_scenario_builds_on_other_files_and_errors_name_the_right_one() {
    let folder = Folder::new();
    let (world, rest) = GOOD.split_once("[robot]").unwrap();
    let (robot, goals) = rest.split_once("[[goals]]").unwrap();
    let world = world.replace("title = \"Test\"\n", "");
    let world_file = folder.write("parts/hall.toml", &world);
    folder.write("launch/worlds/cart.toml", &format!("[robot]{robot}"));
    let head = "title = \"Built\"\nbase = [\"parts/hall.toml\", \"cart\"]\n";
    let own = format!("{head}[robot]\nv_mps_max = 0.5\n[[goals]]{goals}");
    let own_file = folder.write("built.toml", &own);
    let scenario = folder.load("built.toml").unwrap();
    assert!((scenario.robot.v_mps_max - 0.5).abs() < 1e-12);
    assert!((scenario.robot.w_radps_max - 2.0).abs() < 1e-12);
    assert_eq!(scenario.world.shapes.len(), 1);
    scenario.validate().unwrap();

    // A wrong value in the world's file, a wrong one here, and a wrong one of the merged table.
    folder.write(
        "parts/hall.toml",
        &world.replace("[1.0, 1.0]", "[1.0, -1.0]"),
    );
    let error = folder.load("built.toml").unwrap().validate().unwrap_err();
    let place = format!("{}:7: world.shapes[0].size_m[1]: ", world_file.display());
    assert!(error.to_string().contains(&place), "{error}");
    folder.write(
        "parts/hall.toml",
        &world.replacen("centre_m", "center_m", 1),
    );
    let error = folder.load("built.toml").unwrap_err();
    assert!(
        error
            .to_string()
            .contains(&format!("{}:4: ", world_file.display())),
        "{error}"
    );
    folder.write("parts/hall.toml", &world);
    folder.write(
        "built.toml",
        &own.replace("v_mps_max = 0.5", "v_mps_max = 0"),
    );
    let error = folder.load("built.toml").unwrap().validate().unwrap_err();
    let place = format!("{}:4: robot.v_mps_max: ", own_file.display());
    assert!(error.to_string().contains(&place), "{error}");
}

#[test]
fn what_to_build_on_must_exist_and_end() {
    for (base, why) in [
        ("\"nowhere/hall.toml\"", "no file"),
        (
            "\"cave\"",
            "known are hall, jackal, porter, turtlebot2, turtlebot3_burger, two_rooms, warehouse",
        ),
        ("[\"warehouse\", 3]", "name or a path"),
        ("\"test.toml\"", "build on itself"),
    ] {
        let error = load(&format!("title = \"x\"\nbase = {base}\n")).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("test.toml:2: base: "), "{error}");
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn paths_count_from_the_file_in_which_they_stand() {
    let folder = Folder::new();
    let scenario = load(GOOD).unwrap();
    let map = scenario.validate().unwrap().world.rasterise();
    std::fs::create_dir_all(folder.0.path().join("maps")).unwrap();
    map_file::save(&map, &folder.0.path().join("maps"), "hall").unwrap();
    folder.write("maps/world.toml", "[world]\nmap = \"hall.yaml\"\n");
    folder.write("bin/planner", "");
    let (head, rest) = GOOD.split_once("[world]").unwrap();
    let (_, rest) = rest.split_once("[[world.obstacles]]").unwrap();
    let services = "[services.mapping]\nbinary = \"bin/planner\"\n\
                    [services.local_planner]\nbinary = \"some/other\"\n";
    let text = format!("base = \"maps/world.toml\"\n{head}[[world.obstacles]]{rest}{services}");
    folder.write("test.toml", &text);
    let scenario = folder.load("test.toml").unwrap();
    let world_map = scenario.world.map.clone().unwrap();
    assert!(world_map.is_absolute() && world_map.ends_with("maps/hall.yaml"));
    assert_eq!(scenario.folder(), Some(folder.0.path()));
    let binary = |role| scenario.services.of(role).unwrap().binary.clone().unwrap();
    assert_eq!(binary(Role::Mapping), folder.0.path().join("bin/planner"));
    assert_eq!(binary(Role::LocalPlanner), Path::new("some/other"));
    let checked = scenario.validate().unwrap();
    assert_eq!(checked.world.rasterise(), map);
}

#[test]
fn unknown_names_get_a_guess() {
    let folder = Folder::new();
    let error = folder.load("blocked_ailse").unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no scenario `blocked_ailse`, did you mean `blocked_aisle`?; `zeronav list` names all"
    );
    let error = folder.load("no/such.toml").unwrap_err();
    assert!(matches!(error, ScenarioError::Read { .. }), "{error}");
}

#[test]
fn files_of_the_working_folder_come_before_built_in_ones() {
    let folder = Folder::new();
    assert_eq!(
        folder.load("sealed").unwrap().title,
        "No way into the other room"
    );
    let own = folder.write("launch/scenarios/sealed.toml", GOOD);
    folder.write("launch/scenarios/mine.toml", GOOD);
    folder.write("launch/scenarios/notes.txt", "not a scenario");
    assert_eq!(folder.load("sealed").unwrap().title, "Test");
    let listed = Library::of(folder.0.path()).list();
    let names: Vec<&str> = listed.iter().map(|one| one.name.as_str()).collect();
    assert!(
        names.len() > 2 && names.contains(&"blocked_aisle"),
        "{names:?}"
    );
    let mut once = names.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), names.len(), "{names:?}");
    let listed = |name: &str| listed.iter().find(|one| one.name == name).unwrap();
    assert_eq!(listed("sealed").file.as_deref(), Some(own.as_path()));
    assert_eq!(listed("sealed").title, "Test");
    assert!(listed("mine").file.is_some());
    assert_eq!(listed("blocked_aisle").file, None);
}

/// The good scenario with variants.
const VARIED: &str = r#"
[variants.fast]
title = "Faster"
robot.v_mps_max = 2.0
[variants.bad]
robot.v_mps_max = 0
[variants.0_5m]
goals = [{ pose = [8.5, 1.0, 0.0] }]
"#;

#[test]
fn a_variant_has_a_name_of_its_own_and_changes_what_it_says() {
    let folder = Folder::new();
    let file = folder.write("launch/scenarios/my_hall.toml", &format!("{GOOD}{VARIED}"));
    let own = folder.load("my_hall").unwrap();
    let fast = folder.load("my_hall_fast").unwrap();
    assert_eq!((own.name.as_str(), own.title.as_str()), ("my_hall", "Test"));
    assert_eq!(
        (fast.name.as_str(), fast.title.as_str()),
        ("my_hall_fast", "Faster")
    );
    assert!((own.robot.v_mps_max - 1.0).abs() < 1e-12);
    assert!((fast.robot.v_mps_max - 2.0).abs() < 1e-12);
    assert!((fast.robot.a_mps2_max - own.robot.a_mps2_max).abs() < 1e-12);
    // A list is replaced as a whole.
    let near = folder.load("my_hall_0_5m").unwrap();
    assert_eq!(near.goals.len(), 1);
    assert!((near.goals[0].pose.x_m - 8.5).abs() < 1e-12);
    // Variants are listed in place of the file that they vary.
    let listed = Library::of(folder.0.path()).list();
    let mine: Vec<&str> = (listed.iter().map(|one| one.name.as_str()))
        .filter(|name| name.starts_with("my_hall"))
        .collect();
    assert_eq!(mine, ["my_hall_0_5m", "my_hall_bad", "my_hall_fast"]);
    assert_eq!(Scenario::variants(&file), ["0_5m", "bad", "fast"]);
    assert!(folder.load("my_hall_slow").is_err());
    // What a variant says wrong is found in its line.
    let lines = GOOD.lines().count();
    let error = folder.load("my_hall_bad").unwrap().validate().unwrap_err();
    let place = format!("{}:{}: robot.v_mps_max: ", file.display(), lines + 6);
    assert!(error.to_string().contains(&place), "{error}");
}

#[test]
fn a_scenario_may_build_on_a_variant_of_another() {
    let folder = Folder::new();
    folder.write("hall.toml", &format!("{GOOD}{VARIED}"));
    folder.write("mine.toml", "base = \"hall.toml\"\nvariant = \"fast\"\n");
    assert_eq!(folder.load("./mine.toml").unwrap().title, "Faster");
    folder.write("none.toml", "base = \"hall.toml\"\nvariant = \"slow\"\n");
    let error = folder.load("./none.toml").unwrap_err().to_string();
    assert!(
        error.contains("none.toml:2: variant: there is no variant `slow`; known are"),
        "{error}"
    );
}

/// Wrong at once: a key, a preset, a map file, a pose beside the map, a fault and a range.
#[test]
fn every_error_of_a_file_is_found_at_once() {
    let folder = Folder::new();
    let several = "title = \" \"\nstrat = 1\nstart = [1.0, 2.0]\nrun.tick_hz = 0.0\n\
                   [world]\nmap = \"absent.yaml\"\n[robot]\npreset = \"porte\"\n\
                   [[goals]]\npose = [1.0e9, 1.0, 0.0]\n[[goals]]\npose = [nan, 1.0, 0.0]\n\
                   [[faults]]\nkind = \"kill\"\nservice = \"mapping\"\n";
    folder.write("several.toml", several);
    let error = folder.load("several.toml").unwrap_err().to_string();
    for (line, field) in [
        (1, "title"),
        (2, "strat"),
        (3, "start"),
        (4, "run.tick_hz"),
        (6, "world.map"),
        (8, "robot.preset"),
        (10, "goals[0].pose[0]"),
        (12, "goals[1].pose[0]"),
        (13, "faults[0].begins"),
    ] {
        let place = format!(":{line}: {field}: ");
        assert_eq!(error.matches(&place).count(), 1, "{place}\n{error}");
    }
    assert_eq!(error.lines().count(), 9, "{error}");
}

/// The text lies in a recording, which is read elsewhere.
#[test]
fn the_text_of_a_scenario_names_programs_by_whole_paths() {
    let text = format!(
        "{GOOD}[services.global_planner]\nbinary = \"./mine/planner\"\n\
         [services.global_planner.shadow]\nbinary = \"shadows/planner\"\n\
         [services.mapping]\nbinary = \"my-mapping\"\n\
         [companions.dash]\nbinary = \"dash/board\"\n\
         [[swaps]]\nat_s = 1.0\nservice = \"mapping\"\nbinary = \"other/mapping\"\n"
    );
    let written = load(&text).unwrap().to_toml(1).unwrap();
    let read = Scenario::of_text("it", &written).unwrap().scenario;
    let here = std::env::current_dir().unwrap();
    let planner = read.services.of(Role::GlobalPlanner).unwrap();
    let shadow = planner.shadow.as_ref().unwrap().binary.clone();
    let found = [
        planner.binary.clone(),
        shadow,
        Some(read.companions["dash"].binary.clone()),
        read.swaps[0].binary.clone(),
    ];
    let expected = [
        "mine/planner",
        "shadows/planner",
        "dash/board",
        "other/mapping",
    ];
    assert_eq!(found, expected.map(|name| Some(here.join(name))));
    let mapping = read.services.of(Role::Mapping).unwrap();
    assert_eq!(
        mapping.binary,
        Some("my-mapping".into()),
        "a name is looked for there"
    );
}
