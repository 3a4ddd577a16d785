//! Worlds of data sets: what is read, what is refused, and how a scenario says it. Single rows are
//! written here; whole files are the shipped ones, and those of others where the environment names
//! them.

use super::data;
use core::f64::consts::FRAC_PI_2;
use core::fmt::Write as _;
use nalgebra::Point2;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zeronav_world::{Footprint, World, WorldSpec};
use zeronav_world_files::dynabarn::DynabarnWorld;
use zeronav_world_files::pedestrians::{Playback, Scene};
use zeronav_world_files::{DataError, WorldError};
use zeronav_world_files::{barn, barn::BarnWorld, dynabarn};

fn written(text: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("data.csv");
    std::fs::write(&file, text).unwrap();
    (folder, file)
}

fn spec_of(words: &str, file: &Path) -> WorldSpec {
    toml::from_str(&words.replace("FILE", file.to_str().unwrap())).unwrap()
}

const BARN: &str = "x_m,y_m,r_m\n-4.425,0.075,0.075\n-2.25,6.0,0.075\n";

const DYNABARN: &str = "# two cylinders\nobstacle,plugin,period_s,t_s,x_m,y_m\n\
    0,a,10.0,0.0,-5.0,-10.0\n0,a,10.0,4.0,-5.0,-2.0\n0,a,10.0,10.0,1.0,-2.0\n\
    1,b,8.0,0.0,10.0,3.0\n1,b,8.0,8.0,-10.0,3.0\n";

const PEOPLE: &str = "t_s,id,x_m,y_m\n0.0,1,0.0,0.0\n0.4,1,0.4,0.0\n0.4,7,5.0,5.0\n\
    0.8,1,0.8,0.0\n0.8,7,5.0,4.0\n1.2,7,5.0,3.0\n1.2,9,9.0,9.0\n";

#[test]
fn a_barn_world_is_its_cylinders_in_the_corridor() {
    let (_folder, file) = written(BARN);
    let world = BarnWorld::load(&file).unwrap();
    assert_eq!(
        world.cylinders,
        [[-4.425, 0.075, 0.075], [-2.25, 6.0, 0.075]]
    );
    let (world, _) = zeronav_world_files::load(&spec_of("barn = \"FILE\"", &file)).unwrap();
    assert_eq!(world.shapes().len(), 2);
    let distance_m = world.point_distance_m(barn::START.point());
    assert!((distance_m - 2.925).abs() < 1e-12, "{distance_m}");
    assert!(world.contains(barn::GOAL.point()));
    assert!((barn::START.yaw_rad - FRAC_PI_2).abs() < 1e-12);
    // More can be laid on it, and its area replaced.
    let more = "barn = \"FILE\"\narea_m = [[-4.5, 0.0], [0.0, 12.0]]\nresolution_m = 0.1\n\
        shapes = [{ kind = \"disc\", centre_m = [-1.0, 8.0], radius_m = 0.2 }]";
    let (world, _) = zeronav_world_files::load(&spec_of(more, &file)).unwrap();
    assert_eq!((world.shapes().len(), world.geometry().height), (3, 120));
}

#[test]
fn cylinders_of_dynabarn_go_round_from_any_phase() {
    let (_folder, file) = written(DYNABARN);
    let world = DynabarnWorld::load(&file).unwrap();
    assert_eq!(world.rounds.len(), 2);
    let (world, _) = zeronav_world_files::load(&spec_of(
        "dynabarn = { file = \"FILE\", phase_s = 12.0 }",
        &file,
    ))
    .unwrap();
    assert_eq!((world.shapes().len(), world.obstacles().len()), (3, 2));
    // 12 s are 2 s into the first round and 4 s into the second.
    let at = |index: usize| world.obstacles()[index].shape.pose().point();
    assert!((at(0) - Point2::new(-5.0, -6.0)).norm() < 1e-9, "{}", at(0));
    assert!((at(1) - Point2::new(0.0, 3.0)).norm() < 1e-9, "{}", at(1));
    assert!(world.obstacles()[1].is_there_from_the_start());
    for pose in [dynabarn::START, dynabarn::GOAL] {
        assert!(world.contains(pose.point()));
        assert!(!world.touches(&Footprint::disc(0.3).unwrap(), &pose));
    }
}

#[test]
fn people_come_and_go_as_they_were_recorded() {
    let (_folder, file) = written(PEOPLE);
    let scene = Scene::load(&file).unwrap();
    // Person 9 was only glimpsed.
    assert_eq!(scene.walkers.keys().copied().collect::<Vec<_>>(), [1, 7]);
    assert_eq!(scene.span_s(), (0.0, 1.2));
    let (lower, upper) = scene.bounds();
    assert_eq!(
        (lower, upper),
        (Point2::new(0.0, 0.0), Point2::new(5.0, 5.0))
    );
    let playback = Playback {
        from_s: 0.2,
        duration_s: Some(0.6),
        radius_m: 0.25,
    };
    let people = scene.obstacles(&playback);
    assert_eq!(people.len(), 2);
    // Person 1 is there already, half way to the second sample, and leaves at 0.8 s.
    assert!(people[0].appears.is_none());
    assert!((people[0].lasts_s.unwrap() - 0.6).abs() < 1e-12);
    // Person 7 comes 0.2 s later and is cut off by the end.
    let comes_s = people[1].appears.as_ref().unwrap().at_s.unwrap();
    assert!((comes_s - 0.2).abs() < 1e-12);
    assert!((people[1].lasts_s.unwrap() - 0.4).abs() < 1e-12);
    let words = "pedestrians = { file = \"FILE\", from_s = 0.2, radius_m = 0.25 }";
    let (world, _) = zeronav_world_files::load(&spec_of(words, &file)).unwrap();
    let at = world.obstacles()[0].shape.pose().point();
    assert!((at - Point2::new(0.2, 0.0)).norm() < 1e-9, "{at}");
    assert_eq!(world.geometry().width, 180);
    // On another world they bring no area.
    let text = format!("{words}\narea_m = [[-1.0, -1.0], [1.0, 1.0]]");
    let (world, _) = zeronav_world_files::load(&spec_of(&text, &file)).unwrap();
    assert_eq!(world.geometry().width, 40);
}

#[test]
fn a_world_comes_from_one_place() {
    let (_folder, file) = written(BARN);
    let words = "barn = \"FILE\"\ndynabarn = { file = \"FILE\" }";
    let error = zeronav_world_files::load(&spec_of(words, &file)).unwrap_err();
    assert!(error.to_string().starts_with("dynabarn: "), "{error}");
    let unread = spec_of("barn = \"FILE\"\narea_m = [[0, 0], [1, 1]]", &file);
    assert_eq!(World::new(&unread, None).unwrap_err().field, "barn");
}

#[test]
fn files_that_are_wrong_are_refused_by_line() {
    #[track_caller]
    fn refused(words: &str, text: &str, place: &str, why: &str) {
        let (_folder, file) = written(text);
        let error = zeronav_world_files::load(&spec_of(words, &file)).unwrap_err();
        assert!(matches!(error, WorldError::Data { .. }), "{error}");
        let text = error.to_string();
        let place = format!("{}{place}: ", file.display());
        assert!(text.contains(&place) && text.contains(why), "{text}");
    }
    let (barn, dynabarn, people) = (
        "barn = \"FILE\"",
        "dynabarn = { file = \"FILE\" }",
        "pedestrians = { file = \"FILE\" }",
    );
    refused(barn, "x,y,r\n", ":1", "header");
    refused(barn, "x_m,y_m,r_m\n1,2,nan\n", ":2", "nan");
    refused(barn, "x_m,y_m,r_m\n1,2,0.1\n1,2\n", ":3", "2 columns");
    refused(barn, "x_m,y_m,r_m\n1,1e300,0.1\n", ":2", "1e300");
    let head = "obstacle,plugin,period_s,t_s,x_m,y_m\n";
    let back = format!("{head}0,a,9,0,0,0\n0,a,9,5,1,1\n0,a,9,5,2,2\n");
    refused(dynabarn, &back, ":1", "obstacle 0");
    refused(dynabarn, &format!("{head}0,a,9,0,0,0\n"), ":1", "2 to");
    refused(dynabarn, &format!("{head}0,a,-9,0,0,0\n"), ":2", "-9");
    refused(people, "t_s,id,x_m,y_m\n0,1.5,0,0\n", ":2", "whole number");
    refused(people, "t_s,id,x_m,y_m\n0,1,0,0\n", ":1", "nobody");
    refused(
        people,
        "t_s,id,x_m,y_m\n1,1,0,0\n0,1,0,0\n",
        ":1",
        "person 1",
    );
    let (_folder, file) = written("x_m");
    std::fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    let error = BarnWorld::load(&file).unwrap_err();
    assert!(matches!(error, DataError::Read { .. }), "{error}");
    assert!(BarnWorld::load(Path::new("absent.csv")).is_err());
}

#[test]
fn crowds_that_are_too_large_say_what_to_do() {
    let mut text = String::from("t_s,id,x_m,y_m\n");
    for second in [0, 1] {
        for id in 0..300 {
            let _ = writeln!(text, "{second},{id},{id},0");
        }
    }
    let (_folder, file) = written(&text);
    let words = "pedestrians = { file = \"FILE\" }";
    let error = zeronav_world_files::load(&spec_of(words, &file))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("300 people") && error.contains("duration_s"),
        "{error}"
    );
}

/// Every world has room for a Jackal at start and goal.
fn check_barn(folder: &Path) {
    let robot = Footprint::polygon(&[[-0.26, -0.22], [0.26, -0.22], [0.26, 0.22], [-0.26, 0.22]]);
    let robot = robot.unwrap();
    for file in data::files(folder, "csv") {
        let (world, _) = zeronav_world_files::load(&spec_of("barn = \"FILE\"", &file)).unwrap();
        assert!(world.shapes().len() > 150, "{}", file.display());
        for pose in [barn::START, barn::GOAL] {
            assert!(!world.touches(&robot, &pose), "{}", file.display());
        }
    }
}

/// Every world is read at every phase.
fn check_dynabarn(folder: &Path) {
    for file in data::files(folder, "csv") {
        let world = DynabarnWorld::load(&file).unwrap();
        assert!(world.rounds.len() > 2, "{}", file.display());
        for phase_s in [0.0, 17.3, 1.0e4] {
            let (world, n) = (World::new(&world.spec(phase_s), None), world.rounds.len());
            assert_eq!(world.unwrap().obstacles().len(), n, "{}", file.display());
        }
    }
}

/// Every crowd is played from its beginning and from its middle.
fn check_pedestrians(folder: &Path) {
    for file in data::files(folder, "csv") {
        let scene = Scene::load(&file).unwrap();
        let (first_s, last_s) = scene.span_s();
        assert!(last_s - first_s > 100.0, "{}", file.display());
        for from_s in [first_s, 0.5 * (first_s + last_s)] {
            let playback = Playback {
                from_s,
                duration_s: Some(60.0),
                radius_m: 0.3,
            };
            let world = World::new(&scene.spec(&playback), None);
            assert!(world.unwrap().obstacles().len() > 5, "{}", file.display());
        }
    }
}

#[test]
fn every_shipped_world_of_barn_has_room_at_start_and_goal() {
    check_barn(&data::shipped_data("barn/worlds"));
}

#[test]
fn every_shipped_world_of_dynabarn_is_read_at_every_phase() {
    check_dynabarn(&data::shipped_data("dynabarn"));
}

#[test]
fn every_shipped_crowd_is_played() {
    check_pedestrians(&data::shipped_data("pedestrians"));
}

#[test]
#[ignore = "needs barn at $ZERONAV_DATA"]
fn every_world_of_barn_has_room_on_external_data() {
    check_barn(&data::external_data("barn/worlds"));
}

#[test]
#[ignore = "needs dynabarn at $ZERONAV_DATA"]
fn every_world_of_dynabarn_is_read_on_external_data() {
    check_dynabarn(&data::external_data("dynabarn"));
}

#[test]
#[ignore = "needs pedestrians at $ZERONAV_DATA"]
fn every_crowd_is_played_on_external_data() {
    check_pedestrians(&data::external_data("pedestrians"));
}
