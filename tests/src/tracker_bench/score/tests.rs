//! The score of made-up tracks.

use super::*;
use crate::tracker_bench::tally::Inside;

const PERIOD_NS: u64 = 100_000_000;

/// A walker at `x`, `y` that goes on along x with `speed_mps`.
fn walker(number: u64, x: f64, y: f64, speed_mps: f64) -> Truth {
    let velocity = Vector2::new(speed_mps, 0.0);
    let at = Point2::new(x, y);
    Truth {
        number,
        seen: true,
        at,
        velocity,
        ahead: AHEAD_S.map(|ahead_s| Some(at + velocity * ahead_s)),
    }
}

/// A track that lies `off_m` beside such a walker along y, known to 0.1 m and 0.1 m/s.
fn track(number: u64, truth: &Truth, off_m: f64) -> Obstacle {
    Obstacle {
        track: number,
        x_m: truth.at.x,
        y_m: truth.at.y + off_m,
        vx_mps: truth.velocity.x,
        vy_mps: truth.velocity.y,
        covariance: [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.01, 0.0, 0.01],
        ..Obstacle::default()
    }
}

/// The tally of `n` scans; `of` gives truths and tracks of a scan that is taken at a time. [s]
fn tally(n: u64, of: impl Fn(f64) -> (Vec<Truth>, Vec<Obstacle>)) -> Tally {
    let mut score = Score::default();
    for scan in 0..n {
        let run_ns = scan * PERIOD_NS;
        let (truths, tracks) = of(seconds(run_ns));
        score.add(run_ns, &truths, &tracks);
    }
    score.finish()
}

/// Number of failures: never found, lost, swapped, false, doubled.
fn failings(tally: &Tally) -> [usize; 5] {
    [
        Failing::NeverFound,
        Failing::Lost,
        Failing::Swapped,
        Failing::False,
        Failing::Doubled,
    ]
    .map(|failing| tally.count(failing))
}

#[test]
fn the_delay_counts_from_the_first_scan_that_shows_enough() {
    let found = tally(30, |t| {
        let mut truth = walker(3, t, 0.0, 1.0);
        truth.seen = t > 0.45;
        let tracks = if t > 0.85 {
            vec![track(7, &truth, 0.1)]
        } else {
            vec![]
        };
        (vec![truth], tracks)
    });
    assert_eq!((found.sights, found.long_sights), (1, 1));
    assert_eq!(found.delays_s.len(), 1);
    assert!((found.delays_s[0] - 0.4).abs() < 1e-9, "{found:?}");
    assert_eq!(failings(&found), [0; 5]);
    // In sight from 0.5 s to 2.9 s.
    assert!((found.in_sight_s - 2.4).abs() < 1e-9, "{found:?}");
    assert_eq!(found.early[0].untracked, 1);
    assert_eq!(found.early[1].errors_mps.len(), 1);
}

#[test]
fn what_is_short_in_sight_or_stands_need_not_be_found() {
    let unseen = |seen_s: f64, speed_mps: f64| {
        tally(30, |t| {
            let mut truth = walker(3, speed_mps * t, 0.0, speed_mps);
            truth.seen = t < seen_s;
            (vec![truth], vec![])
        })
    };
    assert_eq!(failings(&unseen(3.0, 1.0)), [1, 0, 0, 0, 0]);
    assert_eq!(failings(&unseen(0.95, 1.0)), [0; 5]);
    assert_eq!(unseen(3.0, 0.15).sights, 0, "it has never started");
}

#[test]
fn a_gap_of_three_scans_is_a_new_sight_and_a_shorter_one_is_none() {
    let with_gap = |until_s: f64| {
        tally(30, |t| {
            let mut truth = walker(3, t, 0.0, 1.0);
            truth.seen = t < 0.95 || t > until_s;
            let tracks = vec![track(7, &truth, 0.0)];
            (vec![truth], tracks)
        })
    };
    // Seen at 0.9 s, then at 1.2 s, or at 1.3 s.
    assert_eq!(with_gap(1.15).sights, 1);
    let hidden = with_gap(1.25);
    assert_eq!((hidden.sights, hidden.delays_s.len()), (2, 2));
    assert_eq!(failings(&hidden), [0; 5], "nobody loses what is hidden");
}

#[test]
fn velocities_are_compared_as_vectors_at_their_times() {
    let off = tally(30, |t| {
        let truth = walker(3, t, 0.0, 1.0);
        let mut own = track(7, &truth, 0.0);
        // Three degrees a tenth of a second, and too slow from half a second on.
        let angle = 30.0_f64.to_radians() * t;
        let speed_mps = if t > 0.45 { 0.8 } else { 1.0 };
        own.vx_mps = speed_mps * angle.cos();
        own.vy_mps = -speed_mps * angle.sin();
        (vec![truth], vec![own])
    });
    for (early, (angle_deg, speed_mps)) in
        off.early
            .iter()
            .zip([(6.0, 1.0), (15.0, 0.8), (30.0, 0.8_f64)])
    {
        let cos = f64::to_radians(angle_deg).cos();
        let error_mps = (1.0 + speed_mps * speed_mps - 2.0 * speed_mps * cos).sqrt();
        assert_eq!(early.errors_mps.len(), 1);
        assert!((early.errors_mps[0] - error_mps).abs() < 1e-9, "{early:?}");
        assert!(
            (early.headings_deg[0] - angle_deg).abs() < 1e-9,
            "{early:?}"
        );
        assert!(
            (early.too_fast_mps[0] - speed_mps + 1.0).abs() < 1e-9,
            "{early:?}"
        );
    }
}

#[test]
fn a_track_that_ends_is_lost_once_and_a_scan_without_it_is_not() {
    let without = |gone: fn(f64) -> bool| {
        tally(30, |t| {
            let truth = walker(3, t, 0.0, 1.0);
            let tracks = if gone(t) {
                vec![]
            } else {
                vec![track(7, &truth, 0.0)]
            };
            (vec![truth], tracks)
        })
    };
    assert_eq!(failings(&without(|t| t > 0.95 && t < 1.05)), [0; 5]);
    assert_eq!(
        failings(&without(|t| t > 0.95 && t < 1.95)),
        [0, 1, 0, 0, 0]
    );
    assert_eq!(failings(&without(|t| t > 0.95)), [0, 1, 0, 0, 0]);
    // Another number for the same is a loss, too.
    let again = tally(30, |t| {
        let truth = walker(3, t, 0.0, 1.0);
        let number = if t < 1.45 { 7 } else { 8 };
        let own = track(number, &truth, 0.0);
        (vec![truth], vec![own])
    });
    assert_eq!(failings(&again), [0, 1, 0, 0, 0]);
    // And so is one that strays, which from half a second on is another obstacle's, or nobody's.
    let strays = tally(30, |t| {
        let truth = walker(3, t, 0.0, 1.0);
        let own = track(7, &truth, if t < 0.95 { 0.1 } else { 0.7 });
        (vec![truth], vec![own])
    });
    assert_eq!(failings(&strays), [0, 1, 0, 0, 1]);
}

#[test]
fn tracks_that_exchange_their_obstacles_are_swapped() {
    let pass = |exchange: bool| {
        tally(40, |t| {
            let (a, b) = (walker(1, t, 0.0, 1.0), walker(2, 4.0 - t, 0.3, -1.0));
            let (mut first, mut second) = (track(7, &a, 0.0), track(8, &b, 0.0));
            if exchange && t > 2.05 {
                (first.track, second.track) = (8, 7);
            }
            (vec![a, b], vec![first, second])
        })
    };
    assert_eq!(failings(&pass(false)), [0; 5]);
    assert_eq!(failings(&pass(true)), [0, 0, 2, 0, 0]);
}

#[test]
fn a_track_where_nothing_moves_is_false_and_a_second_one_is_double() {
    let ghosts = tally(30, |t| {
        let (truth, post) = (walker(3, t, 0.0, 1.0), walker(4, 0.0, 5.0, 0.0));
        let tracks = vec![
            track(7, &truth, 0.0),
            track(8, &truth, 0.9),
            track(9, &walker(0, -3.0, 0.0, 0.5), 0.0),
            track(10, &post, 0.0),
        ];
        (vec![truth, post], tracks)
    });
    assert_eq!(failings(&ghosts), [0, 0, 0, 2, 1]);
    assert!((ghosts.run_s - 2.9).abs() < 1e-9);
    // Who stops may be called moving for a while, and a track may outlive what has gone.
    let stops = |until_s: f64| {
        tally(40, |t| {
            let speed_mps = if t < 1.05 { 1.0 } else { 0.0 };
            let truth = walker(3, t.min(1.0), 0.0, speed_mps);
            let tracks = if t < until_s {
                vec![track(7, &truth, 0.0)]
            } else {
                vec![]
            };
            (vec![truth], tracks)
        })
    };
    assert_eq!(failings(&stops(2.5)), [0; 5]);
    assert_eq!(failings(&stops(4.0)), [0, 0, 0, 1, 0]);
    let vanishes = |until_s: f64| {
        tally(30, |t| {
            let truth = walker(3, t, 0.0, 1.0);
            let tracks = if t < until_s {
                vec![track(7, &truth, 0.0)]
            } else {
                vec![]
            };
            (if t < 1.05 { vec![truth] } else { vec![] }, tracks)
        })
    };
    assert_eq!(failings(&vanishes(1.45)), [0; 5]);
    assert_eq!(failings(&vanishes(1.75)), [0, 0, 0, 1, 0]);
}

#[test]
fn predictions_are_judged_where_the_obstacle_still_is() {
    let slow = tally(20, |t| {
        let mut truth = walker(3, t, 0.0, 1.0);
        truth.ahead[2] = None;
        // It turns off: what goes straight on is 0.3 m wrong after a second.
        truth.ahead[1] = truth.ahead[1].map(|there| there + Vector2::new(0.0, 0.3));
        let mut own = track(7, &truth, 0.0);
        own.vx_mps = 0.6;
        (vec![truth], vec![own])
    });
    let [half, one, two] = &slow.ahead;
    assert_eq!((half.errors_m.len(), two.errors_m.len()), (20, 0));
    assert!(
        half.errors_m
            .iter()
            .all(|error_m| (error_m - 0.2).abs() < 1e-9)
    );
    assert!(half.straight_m.iter().all(|error_m| error_m.abs() < 1e-9));
    assert!(
        one.errors_m
            .iter()
            .all(|error_m| (error_m - 0.5).abs() < 1e-9)
    );
    assert!(
        one.straight_m
            .iter()
            .all(|error_m| (error_m - 0.3).abs() < 1e-9)
    );
}

#[test]
fn ellipses_count_the_truth_now_and_a_second_ahead() {
    // Off by 1.5 standard deviations now, and by 0.15 / sqrt(0.01 + 0.01) = 1.06 after a second.
    let beside = tally(20, |t| {
        let truth = walker(3, t, 0.0, 1.0);
        let own = track(7, &truth, 0.15);
        (vec![truth], vec![own])
    });
    let (n, one, two) = (20, 0, 20);
    assert_eq!(beside.now, Inside { n, one, two });
    assert_eq!(beside.then, Inside { n, one, two });
    // 0.05 is within both, 0.25 without both now.
    let near = |off_m: f64| {
        tally(20, |t| {
            let truth = walker(3, t, 0.0, 1.0);
            let own = track(7, &truth, off_m);
            (vec![truth], vec![own])
        })
    };
    assert_eq!((near(0.05).now.one, near(0.05).now.two), (20, 20));
    assert_eq!((near(0.25).now.two, near(0.25).then.two), (0, 20));
}

#[test]
fn fast_lidars_do_not_weigh_more() {
    let mut score = Score::default();
    for scan in 0..40_u64 {
        let truth = walker(
            3,
            0.025 * f64::from(u32::try_from(scan).unwrap_or(0)),
            0.0,
            1.0,
        );
        score.add(scan * PERIOD_NS / 4, &[truth], &[track(7, &truth, 0.0)]);
    }
    let tally = score.finish();
    assert_eq!(tally.now.n, 10);
    assert!((tally.in_sight_s - 0.975).abs() < 1e-9);
}
