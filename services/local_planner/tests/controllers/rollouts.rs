//! What a period tells of the motions that it looked at: the chosen one is what is requested, the
//! others have plausible reasons, and nothing is decided by telling.

use crate::support::cart::Cart;
use crate::support::{Block, Loop, PERIOD_S, block, disc, path};
use nalgebra::Point2;
use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::pilot::Pilot;
use zeronav_local_planner::situation::Decision;
use zeronav_local_planner::table::{CONTROLLERS, controller};
use zeronav_motion::{Twist, reachable};
use zeronav_msgs::Pose;
use zeronav_msgs::command::Validity;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::rollouts::{Rollout, RolloutOutcome};

/// Those with rollouts of their own.
const SAMPLING: [&str; 4] = ["dwa", "dwa_t", "mppi", "beam"];

fn pilot(key: &str) -> Pilot {
    let mut config = LocalPlannerConfig::default();
    config.mppi.samples = 400;
    let row = controller(key).expect("a controller");
    (row.build)(&config)
}

fn of(rollouts: &[Rollout], outcome: RolloutOutcome) -> Vec<&Rollout> {
    let all = rollouts.iter();
    all.filter(|one| one.outcome() == Some(outcome)).collect()
}

/// One period, and what it looked at; the message passes its check.
fn told(run: &mut Loop, pilot: &mut Pilot) -> (Decision, Option<Vec<Rollout>>) {
    let decision = run.step(pilot);
    let rollouts = pilot.rollouts().map(|(meta, rollouts)| {
        assert_eq!(meta.check(rollouts), Ok(()));
        assert_eq!(meta.n_looked_at, u64::from(decision.rollouts));
        rollouts.to_vec()
    });
    (decision, rollouts)
}

/// Where the walls of the hall are: y. [m]
const WALLS_M: (f64, f64) = (0.2, 7.8);

/// A hall with these obstacles and a path along it.
fn hall(more: &[Block]) -> Loop {
    let (low, high) = WALLS_M;
    let walls = [block(0.0, 0.0, 14.0, low), block(0.0, high, 14.0, 8.0)];
    let corners = path(&[(1.0, 4.0), (12.0, 4.0)]);
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let pose = Pose::new(1.0, 4.0, 0.0);
    Loop::new(robot, &[&walls, more].concat(), (14.0, 8.0), pose, corners)
}

/// Places a cart where it is now.
fn place(run: &mut Loop, cart: Cart) {
    run.obstacles = vec![Obstacle {
        track: 1,
        x_m: cart.from.0 + cart.velocity.0 * run.time_s,
        y_m: cart.from.1 + cart.velocity.1 * run.time_s,
        vx_mps: cart.velocity.0,
        vy_mps: cart.velocity.1,
        radius_m: 0.4,
        ..Obstacle::default()
    }];
}

#[test]
fn the_chosen_one_begins_with_the_request_and_telling_decides_nothing() {
    let cart = Cart::crossing(0.8, 5.0, 1.0);
    for row in CONTROLLERS {
        let key = row.key;
        let (mut run, mut pilot) = (hall(&[block(6.0, 3.9, 6.3, 4.4)]), pilot(key));
        let (mut silent_run, mut silent) = (hall(&[block(6.0, 3.9, 6.3, 4.4)]), self::pilot(key));
        pilot.record(true);
        let (mut told_of, mut driven) = (0, 0);
        for _ in 0..500 {
            place(&mut run, cart);
            place(&mut silent_run, cart);
            let (from, pose) = (run.twist, run.pose);
            let (decision, rollouts) = told(&mut run, &mut pilot);
            assert_eq!(decision, silent_run.step(&mut silent), "{key}");
            assert!(silent.rollouts().is_none(), "{key}: nobody asked");
            driven += u32::from(decision.validity == Validity::Drive);
            let Some(rollouts) = rollouts else {
                continue;
            };
            told_of += 1;
            for rollout in &rollouts {
                let [x_m, y_m] = rollout.points_m().next().expect("a point");
                let away_m = (f64::from(x_m) - pose.x_m).hypot(f64::from(y_m) - pose.y_m);
                assert!(away_m < 1e-5, "{key}: begins {away_m} m from the robot");
            }
            let chosen = of(&rollouts, RolloutOutcome::Chosen);
            if decision.validity == Validity::Drive {
                let [chosen] = chosen[..] else {
                    panic!("{key}: {} are chosen", chosen.len());
                };
                let towards = Twist::new(f64::from(chosen.v_mps), f64::from(chosen.w_radps));
                let first = reachable(&run.robot.description, from, towards, PERIOD_S);
                let error = (first.v_mps - decision.v_mps).hypot(first.w_radps - decision.w_radps);
                assert!(error < 1e-6, "{key}: {first:?} for {decision:?}");
            }
        }
        assert!(driven > 100, "{key} drove in {driven} periods");
        assert!(told_of > 30, "{key} told of {told_of} periods");
    }
}

#[test]
fn in_the_open_another_one_only_costs_less() {
    for key in SAMPLING {
        let (mut run, mut pilot) = (hall(&[]), pilot(key));
        pilot.record(true);
        for _ in 0..50 {
            told(&mut run, &mut pilot);
        }
        let (_, rollouts) = told(&mut run, &mut pilot);
        let rollouts = rollouts.expect("rollouts");
        let free = of(&rollouts, RolloutOutcome::Costlier);
        assert!(free.len() >= 10, "{key}: {}", free.len());
        assert_eq!(free.len() + 1, rollouts.len(), "{key}");
        let chosen = of(&rollouts, RolloutOutcome::Chosen)[0];
        for other in free {
            assert!(
                chosen.cost <= other.cost + 1e-4,
                "{key}: {chosen:?} for {other:?}"
            );
        }
    }
}

#[test]
fn a_wall_ahead_is_what_rollouts_lead_into() {
    const WALL_M: f64 = 3.0;
    for key in ["dwa", "dwa_t", "mppi"] {
        let (mut run, mut pilot) = (hall(&[block(WALL_M, 1.0, 3.3, 7.0)]), pilot(key));
        pilot.record(true);
        let mut into = 0;
        for _ in 0..200 {
            let (_, Some(rollouts)) = told(&mut run, &mut pilot) else {
                continue;
            };
            let hits = of(&rollouts, RolloutOutcome::Collision);
            into += hits.len();
            for rollout in hits {
                let [x_m, _] = rollout.points_m().last().expect("a point");
                // Its outline touches the margin before its centre gets there.
                let space_m = WALL_M - 0.25 - f64::from(x_m);
                assert!(
                    (-0.35..0.25).contains(&space_m),
                    "{key}: {space_m} m from it"
                );
            }
            let straight = rollouts.iter().filter(|one| one.w_radps.abs() < 0.05);
            for rollout in straight.filter(|one| one.v_mps > 0.5 && key != "mppi") {
                let [x_m, _] = rollout.points_m().last().expect("a point");
                let is_free = rollout.outcome() == Some(RolloutOutcome::Costlier);
                assert!(
                    !is_free || f64::from(x_m) < WALL_M - 0.25,
                    "{key}: {rollout:?}"
                );
            }
        }
        assert!(into > 50, "{key}: {into} lead into the wall");
    }
}

#[test]
fn a_cart_that_comes_is_met_where_it_will_be() {
    for key in ["dwa_t", "mppi", "beam"] {
        let (mut run, mut pilot) = (hall(&[]), pilot(key));
        pilot.record(true);
        let cart = Cart::crossing(0.8, 5.0, 1.0);
        let (mut met, mut told_of) = (0, 0);
        for _ in 0..350 {
            place(&mut run, cart);
            let pose = run.pose;
            if let (_, Some(rollouts)) = told(&mut run, &mut pilot) {
                told_of += 1;
                met += of(&rollouts, RolloutOutcome::MovingCollision).len();
                let hits = of(&rollouts, RolloutOutcome::Collision);
                // The search looks for ways around as far as the walls, and hits nothing before.
                let at_walls = |hit: &&Rollout| {
                    let end = hit.points_m().last().expect("a point").map(f64::from);
                    let y_m = pose.transform(Point2::from(end)).y;
                    (y_m - WALLS_M.0).min(WALLS_M.1 - y_m) < 0.25 + 0.05
                };
                let explained = key == "beam" && hits.iter().all(at_walls);
                assert!(
                    explained || hits.is_empty(),
                    "{key}: nothing static is near"
                );
            }
        }
        assert!(met > 50, "{key}: {met}");
        // What beam found is driven for five periods.
        let expected = if key == "beam" { 25..200 } else { 350..351 };
        assert!(
            expected.contains(&told_of),
            "{key}: told of {told_of} periods"
        );
    }
}

#[test]
fn a_period_without_a_choice_tells_nothing() {
    let (mut run, mut pilot) = (hall(&[]), pilot("dwa_t"));
    pilot.record(true);
    told(&mut run, &mut pilot).1.expect("rollouts");
    pilot.overruled(Twist::REST);
    assert!(pilot.rollouts().is_none());
}

#[test]
fn shut_in_the_robot_has_no_room_to_stop_from_anything_that_drives() {
    let walls = [
        block(1.3, 3.0, 1.5, 5.0),
        block(0.4, 3.0, 0.7, 5.0),
        block(0.4, 4.3, 1.5, 4.6),
        block(0.4, 3.4, 1.5, 3.7),
    ];
    for key in ["dwa", "dwa_t"] {
        let (mut run, mut pilot) = (hall(&walls), pilot(key));
        pilot.record(true);
        let mut blocked = 0;
        for _ in 0..100 {
            let (decision, rollouts) = told(&mut run, &mut pilot);
            if decision.validity != Validity::Blocked {
                continue;
            }
            let rollouts = rollouts.expect("reasons");
            let is_moving = |one: &&Rollout| one.v_mps > 0.1;
            for rollout in rollouts.iter().filter(is_moving) {
                assert_eq!(
                    rollout.outcome(),
                    Some(RolloutOutcome::NoStop),
                    "{key}: {rollout:?}"
                );
            }
            blocked += u32::from(!of(&rollouts, RolloutOutcome::NoStop).is_empty());
        }
        assert!(blocked > 10, "{key}: {blocked}");
    }
}
