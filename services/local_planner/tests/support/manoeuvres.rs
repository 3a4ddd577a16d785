// What every dynamic window has to do; included once for each, with its `dwa()` in scope.

/// A warehouse robot: 0.8 m/s, 1 m/s^2.
fn amr() -> Robot {
    disc(0.25, 0.8, 1.0, 1.8, 3.0)
}

/// An aisle along x, 12 m long, `width_m` wide between y = 0.4 and 0.4 + width.
fn aisle(width_m: f64) -> [Block; 2] {
    [
        block(0.0, 0.0, 12.0, 0.4),
        block(0.0, 0.4 + width_m, 12.0, 0.8 + width_m),
    ]
}

fn in_aisle(robot: Robot, width_m: f64, corners: &[(f64, f64)]) -> Loop {
    let start = Pose::new(corners[0].0, corners[0].1, 0.0);
    Loop::new(
        robot,
        &aisle(width_m),
        (12.0, 0.8 + width_m),
        start,
        path(corners),
    )
}

/// Arrives within `limit_s` of simulated time without touching anything.
#[track_caller]
fn check_arrives(name: &str, run: &mut Loop, controller: &mut Pilot, limit_s: f64) {
    let arrived = run.run(controller, limit_s);
    println!(
        "{name}: {:.2} s, {:.2} m, nearest {:.3} m, weaving {:.2} per m, at {:?}",
        run.time_s,
        run.driven_m,
        run.least_m,
        run.weaving_per_m(),
        run.pose
    );
    assert!(run.least_m > 0.0, "{name}: touched something");
    assert!(arrived, "{name}: did not arrive in {limit_s} s");
    assert!(run.pose.distance_m(&run.goal.pose) <= run.goal.tolerance_m);
}

#[test]
fn a_straight_aisle_is_driven_straight_and_fast() {
    let mut run = in_aisle(amr(), 1.4, &[(1.0, 1.1), (11.0, 1.1)]);
    // Full speed with both ramps: 10 / 0.8 + 0.8 / 1.0.
    check_arrives("straight", &mut run, &mut dwa(), 13.3 * 1.05);
    assert!(run.weaving_per_m() < 0.01);
    assert!((run.pose.y_m - 1.1).abs() < 0.02);
}

#[test]
fn a_path_along_the_wall_is_followed_at_a_distance() {
    let mut run = in_aisle(amr(), 1.4, &[(1.0, 0.675), (11.0, 0.675)]);
    run.pose.yaw_rad = 0.3;
    let mut controller = dwa();
    for _ in 0..400 {
        run.step(&mut controller);
    }
    let space_m = run.distance_m(&run.pose);
    assert!(space_m > 0.07, "only {space_m} m from the wall");
    check_arrives("along the wall", &mut run, &mut controller, 9.0);
}

#[test]
fn corners_of_aisles_are_taken_in_one_go() {
    for w in [1.2, 1.4, 1.6] {
        let blocks = [
            block(0.0, 0.0, 8.0, 1.0),
            block(0.0, 1.0 + w, 5.0, 8.0),
            block(5.0 + w, 0.0, 8.0, 8.0),
        ];
        for (kind, y, x) in [
            ("centre", 1.0 + w / 2.0, 5.0 + w / 2.0),
            ("inner wall", 1.0 + w - 0.325, 5.325),
            ("outer wall", 1.325, 5.0 + w - 0.325),
        ] {
            for delay in [0, 2] {
                let corners = path(&[(1.0, y), (x, y), (x, 7.0)]);
                let mut run =
                    Loop::new(amr(), &blocks, (8.0, 8.0), Pose::new(1.0, y, 0.0), corners);
                run.delay = delay;
                let name = format!("corner {w} m, {kind}, delay {delay}");
                check_arrives(&name, &mut run, &mut dwa(), 16.0);
                assert!(run.weaving_per_m() < WEAVING_PER_M_MAX);
            }
        }
    }
}

#[test]
fn a_path_that_leads_back_is_met_by_a_turn_on_the_spot() {
    let mut run = in_aisle(amr(), 1.4, &[(1.0, 1.1), (11.0, 1.1)]);
    let mut controller = dwa();
    for _ in 0..150 {
        run.step(&mut controller);
    }
    assert!(run.twist.v_mps > 0.75);
    let (x, y) = (run.pose.x_m, run.pose.y_m);
    run.replan(path(&[(x, y), (1.0, 1.1)]));
    let mut farthest_m = x;
    for _ in 0..200 {
        run.step(&mut controller);
        farthest_m = farthest_m.max(run.pose.x_m);
    }
    assert!(farthest_m - x < 0.5, "overran by {}", farthest_m - x);
    check_arrives("u-turn", &mut run, &mut controller, 8.0);
}

#[test]
fn a_passage_twenty_centimetres_wider_than_the_robot_is_passed() {
    let blocks = [
        block(0.0, 0.0, 8.0, 0.4),
        block(0.0, 3.0, 8.0, 3.4),
        block(3.0, 0.4, 3.5, 1.35),
        block(3.0, 2.05, 3.5, 3.0),
    ];
    for start in [1.7, 1.9, 2.2] {
        let corners = [
            (1.0, start),
            (2.0, start),
            (2.5, 1.7),
            (4.0, 1.7),
            (7.0, 1.7),
        ];
        let pose = Pose::new(1.0, start, 0.0);
        let mut run = Loop::new(amr(), &blocks, (8.0, 3.4), pose, path(&corners));
        check_arrives(&format!("passage from {start}"), &mut run, &mut dwa(), 12.0);
    }
}

#[test]
fn a_rectangle_passes_a_door() {
    let blocks = [
        block(0.0, 0.0, 8.0, 0.4),
        block(0.0, 3.0, 8.0, 3.4),
        block(3.0, 0.4, 3.2, 1.35),
        block(3.0, 2.0, 3.2, 3.0),
    ];
    for start in [1.7, 1.9, 2.2] {
        let corners = [
            (1.0, start),
            (2.0, start),
            (2.5, 1.675),
            (4.0, 1.675),
            (7.0, 1.7),
        ];
        let pose = Pose::new(1.0, start, 0.0);
        let mut run = Loop::new(jackal(), &blocks, (8.0, 3.4), pose, path(&corners));
        check_arrives(&format!("door from {start}"), &mut run, &mut dwa(), 10.0);
    }
}

#[test]
fn a_box_dropped_ahead_stops_the_robot_and_a_new_path_frees_it() {
    for v_mps in [0.8, 1.0] {
        let hall = [block(0.0, 0.0, 12.0, 0.4), block(0.0, 4.4, 12.0, 4.8)];
        let robot = disc(0.25, v_mps, 1.0, 1.8, 3.0);
        let corners = path(&[(1.0, 1.1), (11.0, 1.1)]);
        let mut run = Loop::new(robot, &hall, (12.0, 4.8), Pose::new(1.0, 1.1, 0.0), corners);
        run.delay = 2;
        let mut controller = dwa();
        for _ in 0..150 {
            run.step(&mut controller);
        }
        assert!(run.twist.v_mps > 0.95 * v_mps, "not at full speed");
        // 1.2 m ahead of the nose, too wide to slip by; only the scan sees it.
        let x = run.pose.x_m + 0.25 + 1.2;
        run.blocks.push(block(x, 0.4, x + 0.4, 2.4));
        let mut told = false;
        for _ in 0..350 {
            told |= run.step(&mut controller).blocked_arc_m.is_some();
        }
        println!("stopped {:.3} m before the box", run.least_m);
        assert!(told, "nobody said that the path is blocked");
        assert!(run.twist.is_stopped());
        assert!(run.least_m > 0.02);
        let last = run.history.last().expect("decisions were made");
        assert_eq!(last.validity, Validity::Blocked);
        let (here, y) = (run.pose.x_m, run.pose.y_m);
        run.replan(path(&[(here, y), (here, 3.2), (x + 1.0, 3.2), (11.0, 1.1)]));
        check_arrives("round the box", &mut run, &mut controller, ROUND_THE_BOX_S);
    }
}

#[test]
fn the_goal_s_yaw_is_turned_to() {
    for yaw_rad in [-2.0, FRAC_PI_2, PI] {
        let mut run = in_aisle(amr(), 1.4, &[(1.0, 1.1), (4.0, 1.1)]);
        run.pose.yaw_rad = 3.0;
        run.goal = goal_at(&run.path, 0.15, yaw_rad, 0.1);
        check_arrives(&format!("yaw {yaw_rad}"), &mut run, &mut dwa(), 12.0);
        assert!(wrap_angle(run.pose.yaw_rad - yaw_rad).abs() < 0.1);
    }
}

#[test]
fn a_small_slow_robot_drives_the_same_way() {
    let blocks = [
        block(0.0, 0.0, 4.0, 0.5),
        block(0.0, 1.0, 2.0, 3.0),
        block(2.5, 0.0, 3.0, 3.0),
    ];
    let burger = disc(0.105, 0.22, 2.5, 2.84, 3.2);
    let corners = path(&[(0.5, 0.75), (2.25, 0.75), (2.25, 2.5)]);
    let mut run = Loop::new(
        burger,
        &blocks,
        (4.0, 3.0),
        Pose::new(0.5, 0.75, 0.0),
        corners,
    );
    // 3.5 m at 0.22 m/s.
    check_arrives("burger", &mut run, &mut dwa(), 15.9 * 1.1);
}

#[test]
fn a_path_in_steps_of_the_grid_is_driven_smoothly() {
    let mut corners = vec![(1.0, 1.0)];
    for i in 0..40_u32 {
        let at = 1.0 + 0.05 * f64::from(i);
        corners.push((at + 0.05, at));
        corners.push((at + 0.05, at + 0.05));
    }
    corners.push((8.0, 3.0));
    let wall = [block(0.0, 0.0, 10.0, 0.1)];
    let pose = Pose::new(1.0, 1.0, 0.8);
    let mut run = Loop::new(amr(), &wall, (10.0, 6.0), pose, path(&corners));
    check_arrives("steps", &mut run, &mut dwa(), 13.0);
    assert!(run.weaving_per_m() < STEPS_WEAVING_PER_M_MAX);
}
