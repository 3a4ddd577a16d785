use super::super::plan::SuitePlan;
use super::*;

#[test]
fn every_world_is_a_scenario_and_the_same_one_again() {
    let worlds = worlds(&SuitePlan::of("field"));
    assert_eq!(worlds.len(), 432);
    let folder = tempfile::tempdir().unwrap();
    for world in worlds {
        let (sheet, extra_s) = drawn(&world).unwrap();
        assert_eq!(drawn(&world).unwrap(), (sheet.clone(), extra_s));
        let file = folder.path().join("it.toml");
        std::fs::write(&file, sheet.to_string()).unwrap();
        let scenario = Scenario::load(file.to_str().unwrap()).unwrap();
        let checked = scenario
            .validate()
            .unwrap_or_else(|error| panic!("{}: {error}", world.name));
        assert!(
            !checked.world.touches(&checked.footprint, &scenario.start),
            "{}: it starts in a wall",
            world.name
        );
        for goal in &scenario.goals {
            assert!(
                !checked.world.touches(&checked.footprint, &goal.pose),
                "{}: its goal is in a wall",
                world.name
            );
        }
    }
}
