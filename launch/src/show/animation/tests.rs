use super::super::recording::RecordedPath;
use super::*;

/// Two metres to the east with a replan and an obstacle half-way.
fn run() -> Recording {
    let robot = (0..=80).map(|at| {
        let time_s = 0.1 * f64::from(at);
        [time_s, 1.0 + 0.25 * time_s, 1.0, 0.0]
    });
    let path = |time_s: f64, cause: &str| RecordedPath {
        time_s,
        cause: cause.to_owned(),
        length_m: 2.0,
        points_m: vec![[1.0, 1.0], [2.0, 1.0], [3.0, 1.0]],
    };
    Recording {
        scenario: "a < b".to_owned(),
        outcome: "reached".to_owned(),
        time_s: 8.0,
        driven_m: 2.0,
        contacts: 0,
        area_m: [[0.0, 0.0], [4.0, 2.0]],
        walls_m: vec![[0.0, 0.0, 4.0, 0.1]],
        footprint_m: vec![[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]],
        goals: vec![[3.0, 1.0, 0.0]],
        robot: robot.collect(),
        obstacles: vec![RecordedObstacle {
            name: "load".to_owned(),
            outline_m: vec![[0.1, 0.1], [-0.1, 0.1], [0.0, -0.1]],
            poses: vec![[4.0, 2.5, 1.0, 0.0]],
        }],
        paths: vec![path(0.0, "goal"), path(4.0, "obstacle")],
        ..Recording::default()
    }
}

/// Values and times of the animation of `attribute` in the element that contains `mark`.
fn animated(svg: &str, mark: &str, attribute: &str) -> (Vec<String>, Vec<f64>) {
    let line = svg.lines().find(|line| line.contains(mark)).expect(mark);
    let from = line
        .find(&format!("attributeName=\"{attribute}\""))
        .expect(attribute);
    let list = |name: &str| {
        let start = line[from..].find(&format!(" {name}=\"")).expect(name) + name.len() + 3;
        let rest = &line[from + start..];
        rest[..rest.find('"').unwrap()]
            .split(';')
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let times = list("keyTimes")
        .iter()
        .map(|time| time.parse().unwrap())
        .collect();
    (list("values"), times)
}

#[test]
fn paths_obstacles_and_texts_appear_at_their_times() {
    let svg = run().to_animation();
    // 8 s of run time are played as they were, and the end is held for 2 s.
    assert!(svg.contains("dur=\"10.00s\""), "{svg}");
    let pairs = |values: &[&str], times: &[f64]| -> (Vec<String>, Vec<f64>) {
        (
            values.iter().map(|&value| value.to_owned()).collect(),
            times.to_vec(),
        )
    };
    let replaced = animated(
        &svg,
        "<polyline class=\"path\" fill=\"none\" stroke-width=\"3\" opacity=\"0\"",
        "opacity",
    );
    assert_eq!(replaced, pairs(&["0", "1", "0"], &[0.0, 0.0, 0.4]));
    let current = animated(
        &svg,
        "<polyline class=\"path\" fill=\"none\" stroke-width=\"3\" opacity=\"1\"",
        "opacity",
    );
    assert_eq!(current, pairs(&["0", "1"], &[0.0, 0.4]));
    let obstacle = animated(&svg, "<title>load</title>", "opacity");
    assert_eq!(obstacle, pairs(&["0", "1"], &[0.0, 0.4]));
    let caption = animated(&svg, "load appears: new path of 2.0 m", "opacity");
    assert_eq!(caption, pairs(&["0", "1", "0"], &[0.0, 0.4, 0.8]));
    assert!(svg.contains("a &lt; b") && !svg.contains("a < b"), "{svg}");
    assert!(
        svg.contains("reached after 8.0 s and 2.0 m, 0 contacts"),
        "{svg}"
    );
}

#[test]
fn of_two_paths_at_once_the_newer_is_told() {
    let mut run = run();
    let mut newer = run.paths[1].clone();
    (newer.time_s, newer.length_m) = (4.3, 1.5);
    run.paths.push(newer);
    let svg = run.to_animation();
    assert!(svg.contains(">load appears: new path of 1.5 m<"), "{svg}");
    assert!(!svg.contains("new path of 2.0 m"), "{svg}");
}

#[test]
fn the_robot_moves_with_its_poses_and_the_end_is_the_still_picture() {
    let svg = run().to_animation();
    let scale = (WIDTH_PX - 2.0 * BORDER_PX) / 4.0;
    let line = svg
        .lines()
        .find(|line| line.contains("class=\"robot\""))
        .expect("the robot");
    assert!(
        line.contains(&format!("translate({:.1} {:.1})", 3.0 * scale, scale)),
        "{line}"
    );
    let from = line.find("values=\"").expect("places") + "values=\"".len();
    let places: Vec<&str> = line[from..from + line[from..].find('"').unwrap()]
        .split(';')
        .collect();
    let first = format!("{} {}", short(scale, 1), short(scale, 1));
    assert_eq!((places.len(), places[0]), (100, first.as_str()));
    assert_eq!(
        places[99],
        format!("{} {}", short(3.0 * scale, 1), short(scale, 1))
    );
}

#[test]
fn yaws_do_not_turn_the_long_way() {
    let poses = [3.0, -3.0, 3.0].map(|yaw_rad| [0.0, 0.0, 0.0, yaw_rad]);
    let yaws: Vec<f64> = unwrapped(&poses).iter().map(|pose| pose[3]).collect();
    assert!(
        yaws.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.3),
        "{yaws:?}"
    );
}

#[test]
fn a_long_run_with_many_paths_stays_small() {
    let mut long = run();
    long.time_s = 3600.0;
    long.robot = (0..36_000)
        .map(|at| {
            let time_s = 0.1 * f64::from(at);
            [
                time_s,
                2.0 + (0.1 * time_s).sin(),
                1.0 + 0.5 * (0.07 * time_s).cos(),
                time_s,
            ]
        })
        .collect();
    let path = long.paths[0].clone();
    long.paths = (0..3600)
        .map(|at| RecordedPath {
            time_s: f64::from(at),
            points_m: long
                .robot
                .iter()
                .take(200)
                .map(|at| [at[1], at[2]])
                .collect(),
            ..path.clone()
        })
        .collect();
    let svg = long.to_animation();
    assert!(svg.len() < 300_000, "{} bytes", svg.len());
    assert_eq!(
        svg.matches("class=\"path\"").count(),
        PATHS_MAX + 2,
        "with the legend"
    );
}
