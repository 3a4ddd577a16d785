use super::*;

const MS: u64 = 1_000_000;

fn end(topic: &str, kind: &str, node: &str, publishes: bool) -> End {
    End {
        topic: topic.to_owned(),
        kind: kind.to_owned(),
        node: node.to_owned(),
        publishes,
        reliable: publishes,
        latched: false,
    }
}

fn heard(period_ms: u64, frame: &str) -> Heard {
    let mut heard = Heard::default();
    for n in 0..30 {
        heard.note(n * period_ms * MS, (n * period_ms + 4) * MS, frame);
    }
    heard
}

/// A robot as it should be.
fn whole() -> Facts {
    let ends = vec![
        end("/cmd_vel", "geometry_msgs/Twist", "/base", false),
        end("/odom", "nav_msgs/Odometry", "/base", true),
        end("/scan", "sensor_msgs/LaserScan", "/lidar", true),
        end("/tf", "tf2_msgs/TFMessage", "/base", true),
    ];
    Facts {
        network: "domain 0".to_owned(),
        graph: Graph {
            ends,
            participants: 2,
        },
        scans: heard(100, "laser"),
        odometry: heard(20, "odom"),
        transforms: 50,
        is_laser_placed: true,
        clock_ahead_s: Some(0.0),
        is_same_clock: true,
        ..Facts::default()
    }
}

/// The one finding that is not in order.
fn only(facts: &Facts, config: &RosConfig) -> Finding {
    let findings = judge(config, facts);
    let mut bad = findings.into_iter().filter(|it| it.level != Level::Ok);
    let found = bad.next().expect("a finding");
    assert_eq!(bad.next(), None, "{found:?}");
    found
}

fn is(found: &Finding, level: Level, check: &str, words: &str) {
    let text = format!("{} {}", found.seen, found.fix.clone().unwrap_or_default());
    assert_eq!(
        (found.level, found.check.as_str()),
        (level, check),
        "{text}"
    );
    assert!(text.contains(words), "{text}");
}

#[test]
fn a_robot_as_it_should_be_is_in_order_and_described() {
    let findings = judge(&RosConfig::default(), &whole());
    assert!(
        findings.iter().all(|it| it.level == Level::Ok),
        "{findings:?}"
    );
    let scan = &findings[1].seen;
    for words in [
        "/lidar (reliable)",
        "10.0 Hz",
        "frame laser",
        "4 to 4 ms old",
    ] {
        assert!(scan.contains(words), "{scan}");
    }
}

#[test]
fn what_is_on_another_topic_is_named() {
    let config = RosConfig {
        scan_topic: "/front/scan".to_owned(),
        ..RosConfig::default()
    };
    let mut facts = whole();
    facts.scans = Heard::default();
    let findings = judge(&config, &facts);
    is(
        &findings[1],
        Level::Error,
        "scan",
        "sensor_msgs/LaserScan comes on /scan",
    );
    let config = RosConfig {
        cmd_vel_topic: "/wheels/cmd_vel".to_owned(),
        ..RosConfig::default()
    };
    is(
        &only(&whole(), &config),
        Level::Error,
        "wheels",
        "heard on /cmd_vel",
    );
    // Robots with a name space have transforms of their own.
    let mut facts = whole();
    facts.is_laser_placed = false;
    for end in &mut facts.graph.ends {
        if end.topic == "/tf" {
            "/j100/tf".clone_into(&mut end.topic);
        }
    }
    is(
        &only(&facts, &RosConfig::default()),
        Level::Error,
        "transforms",
        "transforms come on /j100/tf",
    );
}

#[test]
fn wheels_that_want_stamps_are_an_error_with_its_remedy() {
    let mut facts = whole();
    facts.graph.ends[0].kind = "geometry_msgs/TwistStamped".to_owned();
    let config = RosConfig::default();
    is(
        &only(&facts, &config),
        Level::Error,
        "wheels",
        "config.ros.cmd_vel_stamped = true",
    );
    facts.graph.ends[0] = end("/cmd_vel", "geometry_msgs/Twist", "/base", false);
    facts.graph.ends[0].latched = true;
    is(&only(&facts, &config), Level::Error, "wheels", "volatile");
}

#[test]
fn two_publishers_and_other_commanders_are_named() {
    let config = RosConfig::default();
    let mut facts = whole();
    facts
        .graph
        .ends
        .push(end("/odom", "nav_msgs/Odometry", "/ekf", true));
    is(&only(&facts, &config), Level::Error, "publishers", "/ekf");
    // Discovery may know of one alone.
    let mut facts = whole();
    facts.troubles = vec![Trouble::Publishers];
    is(
        &only(&facts, &config),
        Level::Error,
        "publishers",
        "in turn",
    );
    let mut facts = whole();
    facts
        .graph
        .ends
        .push(end("/cmd_vel", "geometry_msgs/Twist", "/teleop", true));
    is(
        &only(&facts, &config),
        Level::Warning,
        "commands",
        "/teleop",
    );
}

#[test]
fn the_seat_of_a_stack_that_is_up_is_no_other_commander() {
    let mut facts = whole();
    let kind = "geometry_msgs/Twist";
    let own = end("/cmd_vel", kind, "/zeronav_robot", true);
    facts.graph.ends.push(own);
    let findings = judge(&RosConfig::default(), &facts);
    assert!(
        findings.iter().all(|it| it.level == Level::Ok),
        "{findings:?}"
    );
}

#[test]
fn what_is_slow_late_or_silent_is_said() {
    let config = RosConfig::default();
    let mut facts = whole();
    facts.odometry = heard(200, "odom");
    is(&only(&facts, &config), Level::Warning, "odometry", "5.0 Hz");
    facts = whole();
    facts.scans = heard(700, "laser");
    is(
        &only(&facts, &config),
        Level::Error,
        "scan",
        "700 ms between two",
    );
    facts = whole();
    for n in 0..30_u64 {
        facts
            .scans
            .note(n * 100 * MS, (n * 100 + 300) * MS, "laser");
    }
    assert!(judge(&config, &facts)[1].level > Level::Ok);
    facts = whole();
    facts.odometry.end(3_000 * MS);
    is(&only(&facts, &config), Level::Error, "odometry", "0.5 s");
    facts = whole();
    (facts.is_same_clock, facts.clock_ahead_s) = (false, Some(3600.0));
    is(
        &only(&facts, &config),
        Level::Warning,
        "clock",
        "3600.000 s ahead of",
    );
    facts.troubles = vec![Trouble::Clock];
    is(
        &only(&facts, &config),
        Level::Error,
        "clock",
        "use_sim_time",
    );
}

#[test]
fn nobody_is_an_error_of_the_network_first() {
    let facts = Facts {
        network: "domain 7".to_owned(),
        ..Facts::default()
    };
    let findings = judge(&RosConfig::default(), &facts);
    is(&findings[0], Level::Error, "network", "ROS_DOMAIN_ID");
    let facts = Facts {
        rejected: vec!["odometry with a pose that is not finite"],
        broken: 3,
        ..whole()
    };
    let found = only(&facts, &RosConfig::default());
    is(&found, Level::Error, "rejected", "3 that are no messages");
    let facts = Facts {
        are_accepted: true,
        ..facts
    };
    let found = only(&facts, &RosConfig::default());
    assert_eq!(found.level, Level::Warning, "most are accepted");
}
