use super::*;

/// What the map says of a scan that lies on it.
const FITS: Explained = Explained {
    on: 60.0,
    new: 0.0,
    through: 0.0,
};

/// A scan of 60 beams, all of which ended, 0.1 s after the last one, from a place along x.
fn judged(explained: Explained, n_ends: f64, x_m: f64) -> Judged {
    Judged {
        explained,
        n_ends,
        n_hits: n_ends,
        map_from_base: Pose::new(x_m, 0.0, 0.0),
        is_inside: false,
        elapsed_s: 0.1,
    }
}

/// After how many scans from one place with so many beams explained, new and through walls the robot is lost.
fn lost_after(mut watch: LostWatch, [on, new, through]: [f64; 3]) -> Option<usize> {
    let seen = judged(Explained { on, new, through }, on + new + through, 0.0);
    (1..100).find(|_| watch.is_lost(&seen, 0.6))
}

#[test]
fn who_sees_through_walls_and_explains_little_is_lost() {
    for watch in [LostWatch::of(true), LostWatch::confirmed()] {
        let after = lost_after(watch, [10.0, 40.0, 40.0]).expect("lost");
        assert!((20..=21).contains(&after), "{after}");
    }
}

#[test]
fn moved_furniture_crowds_and_bare_halls_are_not_lost() {
    for watch in [LostWatch::of(true), LostWatch::confirmed()] {
        let after = |seen| lost_after(watch, seen);
        assert_eq!(after([60.0, 20.0, 20.0]), None, "furniture was moved");
        assert_eq!(after([10.0, 80.0, 2.0]), None, "people stand around");
        assert_eq!(after([0.0, 60.0, 0.0]), None, "all that is seen is new");
        assert_eq!(after([1.0, 2.0, 6.0]), None, "too few beams");
    }
    let known = LostWatch::confirmed();
    assert_eq!(lost_after(known, [2.0, 2.0, 15.0]), None, "too few beams");
}

/// What a robot sees of a sparse map is enough to doubt what it was told, not what it has known.
#[test]
fn fewer_beams_speak_against_a_place_that_is_not_confirmed() {
    let after = lost_after(LostWatch::of(true), [2.0, 2.0, 15.0]).expect("lost");
    assert!((20..=21).contains(&after), "{after}");
}

/// Nothing was told that could be wrong: it takes as much to doubt odometry as for a robot that knows where it is.
#[test]
fn who_was_told_nothing_is_doubted_no_sooner_than_who_knows() {
    let watch = || LostWatch::of(false);
    assert!(watch().is_confirmed());
    assert_eq!(lost_after(watch(), [2.0, 2.0, 15.0]), None, "too few beams");
    let after = lost_after(watch(), [10.0, 40.0, 40.0]).expect("lost");
    assert!((20..=21).contains(&after), "{after}");
    // Nor do those of several places add up, or does a wrong cell of the map count.
    let few = Explained {
        on: 1.0,
        new: 3.0,
        through: 4.0,
    };
    let mut of_few = watch();
    let mut places = (0..100).map(|n| judged(few, 8.0, 0.1 * f64::from(n)));
    assert!(places.all(|seen| !of_few.is_lost(&seen, 0.6)));
    let inside = Judged {
        is_inside: true,
        ..judged(few, 8.0, 0.0)
    };
    let mut inside_of = watch();
    assert!((1..100).all(|_| !inside_of.is_lost(&inside, 0.6)));
    // Where nothing is known it is.
    let off = judged(Explained::default(), 60.0, 0.0);
    let mut off_map = watch();
    assert!((1..100).any(|_| off_map.is_lost(&off, 0.6)));
}

#[test]
fn a_place_is_confirmed_by_one_scan_that_sees_enough() {
    let confirms = |[on, new, through]: [f64; 3]| {
        let mut watch = LostWatch::of(true);
        let seen = judged(Explained { on, new, through }, on + new + through, 0.0);
        assert!(!watch.is_confirmed() && !watch.is_lost(&seen, 0.6));
        watch.is_confirmed()
    };
    assert!(confirms([20.0, 5.0, 0.0]));
    assert!(!confirms([14.0, 11.0, 0.0]), "too little is explained");
    assert!(!confirms([20.0, 4.0, 0.0]), "too few beams");
    assert!(!confirms([10.0, 5.0, 10.0]), "walls are missing");
    assert!(LostWatch::confirmed().is_confirmed());
    // Beside the map most beams end where nothing is known.
    let mut watch = LostWatch::of(true);
    let [on, new, through] = [24.0, 8.0, 0.0];
    let seen = judged(Explained { on, new, through }, 50.0, 0.0);
    assert!(!watch.is_lost(&seen, 0.6) && !watch.is_confirmed());
    // What the map does not explain is taken for something that moves after a while.
    let seen = Judged {
        n_ends: 32.0,
        ..seen
    };
    assert!(!watch.is_lost(&seen, 0.6) && !watch.is_confirmed());
}

/// Few beams say the same from one place however often; from several places they add up.
#[test]
fn what_is_seen_of_a_bare_hall_adds_up_while_the_robot_drives() {
    let few = |on: f64, new: f64, through: f64| Explained { on, new, through };
    let after = |seen: Explained, step_m: f64| {
        let mut watch = LostWatch::of(true);
        let n = (0..100).find(|n| {
            let lost = watch.is_lost(&judged(seen, 8.0, step_m * f64::from(*n)), 0.6);
            assert!(!(lost && watch.is_confirmed()));
            lost || watch.is_confirmed()
        });
        n.map(|_| watch.is_confirmed())
    };
    assert_eq!(after(few(7.0, 1.0, 0.0), 0.0), None);
    assert_eq!(after(few(7.0, 1.0, 0.0), 0.1), Some(true));
    assert_eq!(after(few(1.0, 3.0, 4.0), 0.0), None);
    assert_eq!(after(few(1.0, 3.0, 4.0), 0.1), Some(false));
    assert_eq!(after(few(3.0, 5.0, 0.0), 0.1), None, "all of it is new");
}

/// The first scan of a pose that is a little off is laid on the map: what it said before does not count against that.
#[test]
fn a_scan_that_fits_outweighs_those_before() {
    let mut watch = LostWatch::of(true);
    let off = Explained {
        on: 5.0,
        new: 30.0,
        through: 20.0,
    };
    assert!(!watch.is_lost(&judged(off, 55.0, 0.0), 0.6) && !watch.is_confirmed());
    assert!(!watch.is_lost(&judged(FITS, 60.0, 0.0), 0.6) && watch.is_confirmed());
}

#[test]
fn a_place_in_a_wall_at_which_the_scan_does_not_fit_is_not_believed_for_long() {
    let inside = |on: f64, new: f64| Judged {
        is_inside: true,
        ..judged(
            Explained {
                on,
                new,
                through: 0.0,
            },
            on + new,
            0.0,
        )
    };
    let mut watch = LostWatch::of(true);
    let lost = (1..100).find(|_| watch.is_lost(&inside(30.0, 30.0), 0.6));
    assert_eq!((lost, watch.is_confirmed()), (Some(5), false));
    // Who has known where it is drives over a cell of the map that is wrong.
    let mut watch = LostWatch::confirmed();
    assert!((1..100).all(|_| !watch.is_lost(&inside(30.0, 30.0), 0.6)));
    // So does who was told the truth.
    let mut watch = LostWatch::of(true);
    assert!((1..100).all(|_| !watch.is_lost(&inside(60.0, 0.0), 0.6)));
    assert!(watch.is_confirmed());
}

/// Laid on the other sides of its walls a scan looks fine at first.
#[test]
fn now_and_then_it_looks_closely() {
    let mut watch = LostWatch::confirmed();
    let through = Explained {
        through: 60.0,
        ..Explained::default()
    };
    let seen = judged(through, 60.0, 0.0);
    let lost = (1..100).find(|_| !watch.is_fine() && watch.is_lost(&seen, 0.6));
    assert!(lost.is_some_and(|n| (20..=30).contains(&n)), "{lost:?}");
    assert!(!LostWatch::of(true).is_fine(), "it is not confirmed");
}

#[test]
fn a_place_off_the_map_is_not_believed_unless_it_was_on_it_before() {
    let nothing = judged(Explained::default(), 60.0, 0.0);
    let after = |watch: &mut LostWatch| (1..100).find(|_| watch.is_lost(&nothing, 0.6));
    let mut watch = LostWatch::of(true);
    assert!(!watch.is_lost(&judged(FITS, 60.0, 0.0), 0.6));
    assert_eq!(after(&mut watch), None);
    assert!(after(&mut LostWatch::of(true)).is_some());
}

#[test]
fn a_blind_lidar_does_not_make_a_robot_lost() {
    let mut watch = LostWatch::of(true);
    let nothing = Explained {
        through: 30.0,
        ..Explained::default()
    };
    assert!((1..100).all(|_| !watch.is_lost(&judged(nothing, 3.0, 0.0), 0.6)));
}

#[test]
fn a_moment_is_forgotten() {
    let bad = Explained {
        through: 90.0,
        ..Explained::default()
    };
    let mut watch = LostWatch::confirmed();
    for _ in 0..100 {
        for _ in 0..12 {
            assert!(!watch.is_lost(&judged(bad, 90.0, 0.0), 0.6));
        }
        for _ in 0..7 {
            assert!(!watch.is_lost(&judged(FITS, 60.0, 0.0), 0.6));
        }
    }
}

/// A pose that was uncertain meanwhile is worth what it was.
#[test]
fn who_lies_on_the_map_again_knows_as_much_as_before() {
    assert!(LostWatch::confirmed().again().is_confirmed());
    assert!(!LostWatch::of(true).again().is_confirmed());
}
