use super::super::plan::SuitePlan;
use super::*;
use zeronav_scenario::ForesightSpec;

fn plan() -> SuitePlan {
    SuitePlan {
        suite: "field".to_owned(),
        resume: None,
        controller: None,
        settings: zeronav_scenario::settings::Settings::default(),
        bound: false,
        seeds: 1,
        worlds: None,
        noise: noise::Noise::Default,
        foresight: ForesightSpec::default(),
        data: None,
        hours: None,
        shard: None,
        jobs: None,
        progress: false,
        out: PathBuf::new(),
    }
}

#[test]
fn every_world_is_a_scenario_and_the_same_one_again() {
    let worlds = worlds(&plan());
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
