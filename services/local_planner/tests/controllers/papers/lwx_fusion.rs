//! The combination of LWX, driven: the fit of a walk that was planned over the whole map.

use super::*;

/// A hall with a block in its middle, farther away than a scan's bodies count, and the path around it.
fn around_a_block(key: &str) -> (Loop, Vec<Point2<f64>>, bool) {
    let blocks = [
        block(0.0, 0.0, 16.0, 0.4),
        block(0.0, 9.6, 16.0, 10.0),
        block(0.0, 0.4, 0.4, 9.6),
        block(15.6, 0.4, 16.0, 9.6),
        block(6.5, 4.2, 9.0, 6.0),
    ];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.5, 5.0), (6.0, 3.2), (9.5, 3.2), (14.0, 5.0)]);
    let pose = Pose::new(1.5, 5.0, -0.4);
    let mut run = Loop::new(robot, &blocks, (16.0, 10.0), pose, corners);
    let row = controller(key).expect("in the table");
    let mut controller = (row.build)(&LocalPlannerConfig::default());
    let mut track = Vec::new();
    let mut arrived = false;
    while run.time_s < 90.0 && !arrived {
        arrived = run.run(&mut controller, PERIOD_S);
        track.push(run.pose.point());
    }
    (run, track, arrived)
}

fn goes_unfitted(run: &Loop) -> bool {
    run.history
        .iter()
        .any(|decision| decision.cause == RequestCause::NoFit)
}

#[test]
fn lwx_fusion_drives_the_fit_of_a_walk_that_no_scan_reaches_the_end_of() {
    let (fusion, curve, arrived) = around_a_block("lwx_fusion");
    assert!(arrived && fusion.least_m > 0.0, "{:?}", fusion.pose);
    let dropped = fusion
        .history
        .iter()
        .position(|it| it.cause == RequestCause::NoFit);
    assert_eq!(dropped, None, "its fit was dropped in that period");
    let (oapf, walked, arrived) = around_a_block("lwx_oapf");
    assert!(arrived && oapf.least_m > 0.0, "{:?}", oapf.pose);
    // The farthest that the fusion comes from the way of its part.
    let beside = |point: &Point2<f64>| {
        let far = walked.iter().map(|other| (other - point).norm());
        far.fold(f64::INFINITY, f64::min)
    };
    let apart = curve
        .iter()
        .map(|point| (beside(point), point))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a track");
    println!("{:.2} m apart at {:.2}", apart.0, apart.1);
    assert!(apart.0 > 0.1, "{} m: the drives are the same", apart.0);
}

#[test]
fn lwx_fusion_says_that_it_has_no_fit() {
    // A wall across the path: the walk does not arrive, and there is nothing to fit.
    let blocks = [block(0.0, 0.0, 10.0, 0.4), block(6.0, 0.4, 6.3, 3.8)];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.0, 1.9), (8.0, 1.9)]);
    let pose = Pose::new(1.0, 1.9, 0.0);
    let mut run = Loop::new(robot, &blocks, (10.0, 3.8), pose, corners);
    let row = controller("lwx_fusion").expect("in the table");
    let mut controller = (row.build)(&LocalPlannerConfig::default());
    assert!(!run.run(&mut controller, 4.0));
    assert!(goes_unfitted(&run));
    let said = run
        .history
        .iter()
        .find(|it| it.cause == RequestCause::NoFit);
    // It limits nothing itself.
    assert!(
        (said.map_or(0.0, |it| it.limit_mps) - 0.8).abs() < 1e-9,
        "{said:?}"
    );
}
