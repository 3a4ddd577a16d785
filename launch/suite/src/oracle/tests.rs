use super::*;
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use zeronav_msgs::Pose;
use zeronav_world::Footprint;

const RADIUS_M: f64 = 0.215;

/// Those of a robot of 0.508 m by 0.43 m.
fn abilities() -> Abilities {
    let corners = [
        [-0.254, -0.215],
        [0.254, -0.215],
        [0.254, 0.215],
        [-0.254, 0.215],
    ];
    let footprint = Footprint::polygon(&corners).unwrap();
    Abilities {
        outline: footprint.form().clone(),
        reach_m: footprint.circumscribed_radius_m(),
        radius_m: footprint.inscribed_radius_m(),
        v_mps: [0.0, 2.0],
        w_radps_max: 4.0,
        a_mps2_max: 3.0,
        speed_up_mps2: 3.0,
        alpha_radps2_max: 8.0,
    }
}

const fn state(v_mps: f64) -> State {
    State {
        t_s: 5.0,
        at_m: [1.0, 2.0],
        yaw_rad: 0.0,
        v_mps,
        w_radps: 0.0,
    }
}

fn unavoidable(state: &State, contact_s: f64, discs_at: &dyn Fn(f64) -> Vec<Disc>) -> bool {
    let around = Surroundings {
        discs_at,
        fixed_m: &|_| f64::INFINITY,
    };
    is_unavoidable(state, contact_s, &abilities(), &around)
}

/// A wall of discs across the way, `ahead_m` before the robot's nose.
fn wall(ahead_m: f64) -> Vec<Disc> {
    let x = 1.0 + RADIUS_M + ahead_m + 0.3;
    (-20..=20)
        .map(|i| ([x, 2.0 + 0.2 * f64::from(i)], 0.3))
        .collect()
}

#[test]
fn what_cannot_be_braked_for_is_unavoidable_and_what_can_is_not() {
    // 2 m/s and 3 m/s^2: 0.67 m to stand still. One cell and half a diagonal are forgiven.
    assert!(unavoidable(&state(2.0), 5.2, &|_| wall(0.30)));
    assert!(!unavoidable(&state(2.0), 5.2, &|_| wall(0.70)));
    assert!(!unavoidable(&state(0.0), 5.2, &|_| wall(0.05)));
    // A post of that width is not passed either: turning takes longer than braking.
    let post = |_| vec![([1.0 + 0.215 + 0.2 + 0.3, 2.0], 0.3)];
    assert!(unavoidable(&state(2.0), 5.1, &post));
}

#[test]
fn who_is_walked_at_in_the_open_can_step_aside_and_who_is_surrounded_cannot() {
    let walker = |t: f64| vec![([4.0 - (t - 5.0), 2.0], 0.3)];
    assert!(!unavoidable(&state(0.0), 8.0, &walker));
    let closing = |t: f64| -> Vec<Disc> {
        let radius = (2.0 - 0.9 * (t - 5.0)).max(0.0);
        (0..32)
            .map(|i| f64::from(i) * core::f64::consts::TAU / 32.0)
            .map(|a| ([1.0 + radius * a.cos(), 2.0 + radius * a.sin()], 0.3))
            .collect()
    };
    assert!(unavoidable(&state(0.0), 7.0, &closing));
    // From far before there is time to get out, of a ring that is open.
    let open = |t: f64| closing(t)[2..].to_vec();
    assert!(!unavoidable(&state(0.0), 5.5, &open));
}

#[test]
fn who_appears_on_top_of_the_robot_cannot_be_avoided() {
    // There for 50 ms only: it is the moment of the contact that tells.
    let passing = |ahead_m: f64| {
        move |t: f64| -> Vec<Disc> {
            let there = (t < 5.05).then_some(([1.0 + ahead_m, 2.0], 0.3));
            there.into_iter().collect()
        }
    };
    assert!(unavoidable(&state(1.5), 5.012, &passing(0.4)));
    assert!(!unavoidable(&state(1.5), 5.012, &passing(0.6)));
}

#[test]
fn walls_count_too() {
    let none = |_: f64| Vec::new();
    let corridor = |at: [f64; 2]| (0.3 - (at[1] - 2.0).abs()).max(0.0);
    let dead_end = |at: [f64; 2]| corridor(at).min((1.6 - at[0]).max(0.0));
    let run = |fixed_m: &dyn Fn([f64; 2]) -> f64| {
        let around = Surroundings {
            discs_at: &none,
            fixed_m,
        };
        is_unavoidable(&state(2.0), 5.4, &abilities(), &around)
    };
    assert!(!run(&corridor));
    assert!(run(&dead_end));
}

/// The proof is one: when it says unavoidable, no drive that the robot can make gets through.
#[test]
fn no_drive_escapes_what_is_called_unavoidable() {
    let mut dice = Pcg64Mcg::seed_from_u64(6);
    let (mut proved, mut escapes) = (0, 0);
    for _ in 0..60 {
        let start = State {
            w_radps: dice.random_range(-2.0..2.0),
            ..state(dice.random_range(0.0..2.0))
        };
        let walkers: Vec<([f64; 2], [f64; 2])> = (0..25)
            .map(|_| {
                let at = [dice.random_range(-1.0..4.0), dice.random_range(0.0..4.0)];
                let v = [dice.random_range(-1.5..1.5), dice.random_range(-1.5..1.5)];
                (at, v)
            })
            .collect();
        let discs_at = |t: f64| -> Vec<Disc> {
            let along = t - start.t_s;
            walkers
                .iter()
                .map(|(at, v)| ([at[0] + v[0] * along, at[1] + v[1] * along], 0.3))
                .filter(|(at, _)| along > 0.0 || (at[0] - 1.0).hypot(at[1] - 2.0) > 0.6)
                .collect()
        };
        let contact_s = start.t_s + 0.6;
        let verdict = unavoidable(&start, contact_s, &discs_at);
        proved += usize::from(verdict);
        let escaped = (0..300).any(|_| drive(&start, contact_s + AFTER_S, &discs_at, &mut dice));
        escapes += usize::from(escaped);
        assert!(!(verdict && escaped), "{start:?}");
    }
    // Both happen, so the test can fail.
    assert!(
        proved >= 5 && escapes >= 5,
        "{proved} proved, {escapes} escapes"
    );
}

/// Goes towards a speed and a yaw rate for a moment.
fn go(now: &mut State, (v, w): (f64, f64), step_s: f64) {
    now.v_mps += (v - now.v_mps).clamp(-3.0 * step_s, 3.0 * step_s);
    now.w_radps += (w - now.w_radps).clamp(-8.0 * step_s, 8.0 * step_s);
    now.yaw_rad += now.w_radps * step_s;
    now.at_m[0] += now.v_mps * now.yaw_rad.cos() * step_s;
    now.at_m[1] += now.v_mps * now.yaw_rad.sin() * step_s;
    now.t_s += step_s;
}

/// The same of the other proof, with the robot's outline and a pedestrian who has just appeared.
#[test]
fn no_drive_escapes_who_is_touched_anyhow() {
    let abilities = abilities();
    let mut dice = Pcg64Mcg::seed_from_u64(9);
    let (mut proved, mut escaped) = (0, 0);
    for _ in 0..300 {
        let start = State {
            yaw_rad: dice.random_range(-3.0..3.0),
            w_radps: dice.random_range(-2.0..2.0),
            ..state(dice.random_range(0.0..2.0))
        };
        let (sin, cos) = (start.yaw_rad + dice.random_range(-1.0..1.0_f64)).sin_cos();
        let (far_m, speed_mps) = (dice.random_range(0.5..1.2), dice.random_range(0.0..1.5));
        let discs_at = |t: f64| -> Vec<Disc> {
            let far_m = far_m - speed_mps * (t - start.t_s);
            vec![([1.0 + far_m * cos, 2.0 + far_m * sin], 0.3)]
        };
        let lead_s = MOMENT_S * f64::from(dice.random_range(0..12_u8));
        let around = Surroundings {
            discs_at: &discs_at,
            fixed_m: &|_| f64::INFINITY,
        };
        let verdict = touches_anyhow(&start, start.t_s + lead_s, &abilities, &around);
        let mut gets_away = || {
            let mut now = start;
            let asked = [(0.0, 2.0), (-4.0, 4.0)]
                .map(|(low, high)| [low, high, dice.random_range(low..=high)]);
            let which = [0, 1].map(|n| asked[n][dice.random_range(0..3_usize)]);
            while now.t_s < start.t_s + lead_s + MOMENT_S * f64::from(MOMENTS) + 1e-9 {
                let pose = Pose::new(now.at_m[0], now.at_m[1], now.yaw_rad);
                let body = abilities.outline.placed(&pose);
                let looked_at = now.t_s > start.t_s + lead_s - 1e-9;
                let touches = |([x, y], radius_m): &Disc| {
                    body.distance_to_point_m(Point2::new(*x, *y)) < *radius_m
                };
                if looked_at && discs_at(now.t_s).iter().any(touches) {
                    return false;
                }
                for _ in 0..20 {
                    go(&mut now, (which[0], which[1]), MOMENT_S / 20.0);
                }
            }
            true
        };
        let got_away = (0..60).any(|_| gets_away());
        assert!(!(verdict && got_away), "{start:?} {lead_s}");
        proved += usize::from(verdict);
        escaped += usize::from(got_away);
    }
    assert!(proved >= 30 && escaped >= 30, "{proved} {escaped}");
}

/// A drive with commands at random, every fifth of a second; true when it touches nothing at
/// the moments that the oracle looks at.
fn drive(
    start: &State,
    until_s: f64,
    discs_at: &dyn Fn(f64) -> Vec<Disc>,
    dice: &mut Pcg64Mcg,
) -> bool {
    let mut now = *start;
    while now.t_s < until_s - 1e-9 {
        let (v, w) = (dice.random_range(0.0..=2.0), dice.random_range(-4.0..=4.0));
        let step_s = STEP_S / 100.0;
        for _ in 0..100 {
            go(&mut now, (v, w), step_s);
        }
        let touches = |(at, radius): &Disc| {
            (at[0] - now.at_m[0]).hypot(at[1] - now.at_m[1]) <= radius + RADIUS_M
        };
        if discs_at(now.t_s).iter().any(touches) {
            return false;
        }
    }
    true
}
