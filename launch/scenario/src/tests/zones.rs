//! Zones of a scenario: what is read, and the line that names what is wrong.

use super::{Folder, GOOD, load, refused};
use zeronav_msgs::zones::ZoneKind;

/// The good scenario, with a zone behind it: line 30 is its table.
fn with(zone: &str) -> String {
    format!("{GOOD}[[zones]]\n{zone}\n")
}

#[track_caller]
fn wrong(zone: &str, field: &str, why: &str) {
    let error = load(&with(zone)).and_then(|scenario| scenario.validate());
    let error = error.expect_err(zone).to_string();
    assert!(error.contains(field) && error.contains(why), "{error}");
}

#[test]
fn a_zone_has_a_name_a_kind_and_a_polygon() {
    let polygon = "polygon = [[2.0, 3.0], [4.0, 3.0], [3.0, 4.5]]";
    let good = with(&format!(
        "name = \"ramp\"\nkind = \"speed_limit\"\nlimit_mps = 0.3\n{polygon}"
    ));
    let scenario = load(&good).unwrap();
    scenario.validate().unwrap();
    let part = scenario.zones[0].parts().unwrap()[0];
    assert_eq!(
        (part.name(), part.kind(), part.value),
        ("ramp", Some(ZoneKind::SpeedLimit), 0.3)
    );
    assert_eq!(part.corners(), [[2.0, 3.0], [4.0, 3.0], [3.0, 4.5]]);
    // As it is written again.
    let table = toml::Table::try_from(&scenario).unwrap();
    assert_eq!(table["zones"].as_array().unwrap().len(), 1);

    wrong(
        &format!("name = \"\"\nkind = \"keepout\"\n{polygon}"),
        "zones[0].name",
        "1 to 32 bytes",
    );
    wrong(
        &format!("name = \"a\"\n{polygon}"),
        "zones[0].kind",
        "keepout, speed_limit, cost or lane",
    );
    let limit = format!("name = \"a\"\nkind = \"speed_limit\"\n{polygon}");
    wrong(&limit, "zones[0].kind", "limit_mps or percent");
    wrong(
        &format!("{limit}\nlimit_mps = 0.0"),
        "zones[0].limit_mps",
        "0.01",
    );
    wrong(
        &format!("{limit}\npercent = 150.0"),
        "zones[0].percent",
        "100",
    );
    let keepout = "name = \"a\"\nkind = \"keepout\"";
    wrong(
        &format!("{keepout}\n{polygon}\ncost = 3.0"),
        "zones[0].cost",
        "of no use",
    );
    wrong(
        &format!("{keepout}\npolygon = [[0.0, 0.0], [1.0, 1.0]]"),
        "zones[0].polygon",
        "3 to 16 corners",
    );
    let bow = "polygon = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]";
    wrong(&format!("{keepout}\n{bow}"), "zones[0].polygon", "cross");
    let flat = "polygon = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]";
    wrong(&format!("{keepout}\n{flat}"), "zones[0].polygon", "no area");
    let twice = format!("{keepout}\n{polygon}\n[[zones]]\n{keepout}\n{polygon}");
    wrong(&twice, "zones[1].name", "two zones `a`");
}

#[test]
fn a_goal_in_a_keepout_zone_is_rejected_with_the_nearest_pose_outside() {
    let closed = "[[zones]]\nname = \"dock\"\nkind = \"keepout\"\n\
                  polygon = [[8.0, 0.0], [10.0, 0.0], [10.0, 2.0], [8.0, 2.0]]\n";
    let goal = "pose = [9.0, 1.0, 0]\n";
    let why = "(9, 1) lies in the keepout zone `dock`; the nearest free pose is [";
    refused(goal, &format!("{goal}{closed}"), 25, "goals[0].pose", why);
    // The robot may begin in one, and a goal that is said to be unreachable may lie there.
    let started = GOOD.replace("start = [1.0, 2.0, 0.5]", "start = [9.0, 1.0, 0.0]");
    let started = started.replace(goal, "pose = [2.0, 2.0, 0]\n");
    load(&format!("{started}{closed}"))
        .unwrap()
        .validate()
        .unwrap();
    let unreachable = format!("{GOOD}{closed}[expect]\noutcome = \"unreachable\"\n");
    load(&unreachable).unwrap().validate().unwrap();
}

#[test]
fn a_mask_is_found_beside_the_scenario_and_named_when_it_is_wrong() {
    let folder = Folder::new();
    folder.write(
        "test.toml",
        &with("name = \"floor\"\nmask = \"masks/floor.yaml\""),
    );
    let error = folder
        .load("test.toml")
        .and_then(|scenario| scenario.validate());
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains(":28: zones[0].mask: ") && error.contains("masks/floor.yaml"),
        "{error}"
    );
    let yaml = "image: floor.pgm\nresolution: 0.5\norigin: [2.0, 3.0, 0.0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\ntype: 0\n";
    folder.write("masks/floor.yaml", yaml);
    folder.write("masks/floor.pgm", "P2\n2 2\n255\n0 254\n0 0\n");
    let scenario = folder.load("test.toml").unwrap();
    scenario.validate().unwrap();
    let parts = scenario.zones[0].parts().unwrap();
    assert_eq!(parts.len(), 2);
    assert!(
        parts
            .iter()
            .all(|part| part.kind() == Some(ZoneKind::Keepout) && part.name() == "floor")
    );
    folder.write(
        "test.toml",
        &with("name = \"floor\"\nkind = \"keepout\"\nmask = \"masks/floor.yaml\""),
    );
    let error = folder
        .load("test.toml")
        .and_then(|scenario| scenario.validate());
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("zones[0].kind: is said by the file")
    );
}
