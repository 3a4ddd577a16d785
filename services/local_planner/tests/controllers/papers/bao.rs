//! The dynamic window of BAO.

use super::*;

#[test]
fn bao_dwa_windows_are_those_of_the_paper() {
    let robot = zeronav_msgs::description::Description {
        v_mps_max: 0.5,
        w_radps_max: 1.2,
        a_mps2_max: 0.5,
        brake_mps2: 0.5,
        alpha_radps2_max: 2.0,
        ..Default::default()
    };
    let (v, w) = window(&robot, Twist::new(0.2, 1.1), 0.1);
    assert!((v.low - 0.15).abs() < 1e-12 && (v.high - 0.25).abs() < 1e-12);
    assert!((w.low - 0.9).abs() < 1e-12 && (w.high - 1.2).abs() < 1e-12);
    // sqrt(2 * 0.16 * 0.5) = 0.4.
    assert!(is_admissible(&robot, Twist::new(0.399, 0.0), 0.16));
    assert!(!is_admissible(&robot, Twist::new(0.401, 0.0), 0.16));
    // w^2 <= 2 (dist |w| / v) alpha: 1.0 <= 2 * 0.16 / 0.3 * 2.
    assert!(is_admissible(&robot, Twist::new(0.3, 1.0), 0.16));
    assert!(!is_admissible(&robot, Twist::new(0.3, 1.2), 0.08));
}

/// A window of 6 x 7 twists with random terms, some of them not admissible.
fn random_window(seed: u64) -> Vec<Sample> {
    let mut random = Pcg32::seed_from_u64(seed);
    let mut samples = Vec::new();
    for i in 0..6_u8 {
        for j in 0..7_u8 {
            let sample = Sample {
                twist: Twist::new(0.1 * f64::from(i), 0.4 * (f64::from(j) - 3.0)),
                place: [i, j],
                head: random.random_range(0.0..3.1),
                dist: random.random_range(0.0..2.0),
                path: random.random_range(0.0..2.0),
            };
            if random.random_bool(0.8) {
                samples.push(sample);
            }
        }
    }
    samples
}

/// Eq. 17 term by term, with a factor that it says is without effect.
fn score(samples: &[Sample], config: &BaoDwaConfig, of: &Sample, sigma: f64) -> f64 {
    let sum = |term: &dyn Fn(&Sample) -> f64| samples.iter().map(term).sum::<f64>();
    let head = config.head * of.head / sum(&|s| s.head);
    let dist = config.dist * of.dist / sum(&|s| s.dist);
    let vel = config.vel * of.twist.v_mps / sum(&|s| s.twist.v_mps);
    let path = config.path * of.path / sum(&|s| s.path);
    sigma * (head + dist + vel + path)
}

#[test]
fn bao_dwa_chooses_the_largest_score_whatever_the_factor() {
    let config = BaoDwaConfig::default();
    for seed in 0..50 {
        let samples = random_window(seed);
        let chosen = choose(&samples, &config, &mut Vec::new()).expect("a window");
        for sigma in [0.1, 1.0, 7.0] {
            let best = samples
                .iter()
                .max_by(|a, b| {
                    let by = |s| score(&samples, &config, s, sigma);
                    by(a).total_cmp(&by(b))
                })
                .expect("a window");
            assert_eq!(chosen, best.twist, "seed {seed}, sigma {sigma}");
        }
    }
    assert_eq!(choose(&[], &config, &mut Vec::new()), None);
}

#[test]
fn bao_dwa_smoothing_takes_the_middle_of_good_twists_and_min_max_scales_otherwise() {
    // A single twist with a high score among bad ones, and a plateau of good ones.
    let mut samples = Vec::new();
    for i in 0..5_u8 {
        for j in 0..9_u8 {
            let head = match (i, j) {
                (2, 1) => 3.0,
                (1..=3, 5..=7) => 2.5,
                _ => 0.5,
            };
            samples.push(Sample {
                twist: Twist::new(0.1 * f64::from(i), 0.2 * (f64::from(j) - 4.0)),
                place: [i, j],
                head,
                dist: 1.0,
                path: 1.0,
            });
        }
    }
    let plain = BaoDwaConfig {
        vel: 0.0,
        ..BaoDwaConfig::default()
    };
    let smooth = BaoDwaConfig {
        smooth: Smooth::Box,
        ..plain
    };
    let place = |config: &BaoDwaConfig| {
        let chosen = choose(&samples, config, &mut Vec::new());
        let found = samples.iter().find(|sample| Some(sample.twist) == chosen);
        found.expect("one of them").place
    };
    assert_eq!(place(&plain), [2, 1]);
    assert_eq!(place(&smooth), [2, 6]);
    // Scaled from least to largest, a term that hardly differs weighs as much as any other.
    let two = |head: f64, dist: f64, w: f64| Sample {
        twist: Twist::new(0.3, w),
        place: [0, 0],
        head,
        dist,
        path: 0.0,
    };
    let pair = [two(3.0, 1.90, 0.1), two(1.0, 1.91, -0.2)];
    let by = |normalise| {
        let config = BaoDwaConfig {
            normalise,
            ..BaoDwaConfig::default()
        };
        choose(&pair, &config, &mut Vec::new())
    };
    assert_eq!(by(Normalise::Sum), Some(pair[0].twist));
    assert_eq!(by(Normalise::MinMax), Some(pair[1].twist));
}

#[test]
fn bao_dwa_tells_which_term_decided_against_the_fastest_twist() {
    let sample = |v_mps, head, dist| Sample {
        twist: Twist::new(v_mps, 0.0),
        place: [0, 0],
        head,
        dist,
        path: 1.0,
    };
    let decisive =
        |samples: &[Sample]| decisive(samples, &BaoDwaConfig::default(), &mut Vec::new());
    let near = [sample(0.5, 3.0, 0.1), sample(0.3, 3.0, 1.9)];
    assert_eq!(decisive(&near), RequestCause::ClearanceCritic);
    let beside = [sample(0.5, 0.2, 1.0), sample(0.3, 3.0, 1.0)];
    assert_eq!(decisive(&beside), RequestCause::PathCritic);
    let fastest = [sample(0.5, 3.0, 1.0), sample(0.3, 3.0, 1.0)];
    assert_eq!(decisive(&fastest), RequestCause::StoppingDistance);
    assert_eq!(decisive(&[]), RequestCause::Critics);
}

#[test]
fn bao_dwa_arcs_are_exact_where_euler_drifts() {
    let twist = Twist::new(0.5, 1.2);
    let exact = twist.arc(1.0);
    let euler = |n: u32| {
        let dt = 1.0 / f64::from(n);
        let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0_f64);
        for _ in 0..n {
            (x, y) = (x + 0.5 * dt * yaw.cos(), y + 0.5 * dt * yaw.sin());
            yaw += 1.2 * dt;
        }
        (x - exact.x_m).hypot(y - exact.y_m)
    };
    // Eq. 13 as printed comes nearer with shorter steps, ten times as near with ten times as many.
    let (coarse, fine, finest) = (euler(10), euler(100), euler(1000));
    assert!((0.01..0.05).contains(&coarse), "{coarse}");
    assert!((8.0..12.0).contains(&(coarse / fine)), "{coarse} {fine}");
    assert!((8.0..12.0).contains(&(fine / finest)), "{fine} {finest}");
}

/// Drives `bao_dwa` through a scene; every published twist leaves room to brake to the outline of
/// what stands there.
fn bao_drive(config: BaoDwaConfig, mut run: Loop, limit_s: f64) -> (bool, Loop) {
    let mut whole = LocalPlannerConfig::default();
    whole.papers.bao_dwa = config;
    let row = controller("bao_dwa").expect("in the table");
    let mut controller = (row.build)(&whole);
    let brake_mps2 = run.robot.description.brake_mps2;
    while run.time_s < limit_s {
        let decision = run.step(&mut controller);
        let stop_m = decision.v_mps * decision.v_mps / (2.0 * brake_mps2);
        for share in 0..=10 {
            let ahead = Twist::new(decision.v_mps, decision.w_radps);
            let along_s = stop_m / decision.v_mps.max(1e-6) * f64::from(share) / 10.0;
            let on_arc = ahead.arc(along_s);
            let pose = Pose::from(run.pose.isometry() * on_arc.isometry());
            assert!(
                run.distance_m(&pose) > 0.0,
                "{decision:?} at {:?}",
                run.pose
            );
        }
        if decision.validity == Validity::AtGoal && run.twist.is_stopped() {
            return (true, run);
        }
    }
    (false, run)
}

fn corridor() -> Loop {
    let walls = [block(0.0, 0.0, 10.0, 0.4), block(0.0, 3.4, 10.0, 3.8)];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.0, 1.9), (8.0, 1.9)]);
    Loop::new(
        robot,
        &walls,
        (10.0, 3.8),
        Pose::new(1.0, 1.9, 0.4),
        corners,
    )
}

#[test]
fn bao_dwa_drives_a_corridor_with_every_option() {
    let default = BaoDwaConfig::default();
    for config in [
        default,
        BaoDwaConfig {
            path: 0.0,
            ..default
        },
        BaoDwaConfig {
            smooth: Smooth::Box,
            ..default
        },
        BaoDwaConfig {
            normalise: Normalise::MinMax,
            ..default
        },
        BaoDwaConfig {
            switch: Switch::OnDetect,
            ..default
        },
    ] {
        let (arrived, run) = bao_drive(config, corridor(), 60.0);
        println!(
            "{config:?}: {:.1} s, nearest {:.2}",
            run.time_s, run.least_m
        );
        assert!(arrived && run.least_m > 0.0, "{config:?}: {}", run.time_s);
    }
}

#[test]
fn bao_dwa_turns_round_for_a_goal_behind_it_and_stops_before_a_wall() {
    let mut behind = corridor();
    behind.pose = Pose::new(5.0, 1.9, 0.0);
    behind.replan(path(&[(5.0, 1.9), (1.5, 1.9)]));
    let (arrived, run) = bao_drive(BaoDwaConfig::default(), behind, 60.0);
    assert!(arrived && run.least_m > 0.0, "at {:?}", run.pose);
    let mut walled = corridor();
    walled.blocks.push(block(5.0, 0.4, 5.3, 3.4));
    let (arrived, run) = bao_drive(BaoDwaConfig::default(), walled, 30.0);
    assert!(!arrived && run.least_m > 0.0);
    assert!((3.5..4.75).contains(&run.pose.x_m), "{:?}", run.pose);
}
