//! From what was seen and heard to findings, each with what to do about it. Pure.

use super::graph::{End, Graph};
use super::heard::Heard;
use crate::config::RosConfig;
use crate::inputs::Trouble;
use crate::seat::NODE;
use serde::Serialize;

/// A lidar or odometry that is silent for longer stops the robot. [s]
const SILENT_S: f64 = 0.5;

/// Odometry that is slower than this is too slow to drive by. [Hz]
const ODOMETRY_HZ_MIN: f64 = 10.0;

/// Age of a measurement with which a stack does not react in time. [s]
const AGE_MAX_S: f64 = 0.2;

/// Most other topics that are named.
const NAMED_MAX: usize = 5;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// As it should be.
    Ok,
    /// It drives, and may drive badly.
    Warning,
    /// It does not drive.
    Error,
}

/// What was looked at, what was seen, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub level: Level,
    /// What was looked at.
    pub check: String,
    /// What was seen.
    pub seen: String,
    /// What to do about it.
    pub fix: Option<String>,
}

/// What was seen and heard.
#[derive(Debug, Clone, Default)]
pub struct Facts {
    /// Where: domain and range, in words.
    pub network: String,
    /// Who publishes and hears what.
    pub graph: Graph,
    /// Scans.
    pub scans: Heard,
    /// Odometry.
    pub odometry: Heard,
    /// Messages with transforms.
    pub transforms: u64,
    /// Transforms lead from the frame of the scans to that of the robot.
    pub is_laser_placed: bool,
    /// What the seat would stand for: its clock, or two publishers in turn.
    pub troubles: Vec<Trouble>,
    /// Why messages were rejected.
    pub rejected: Vec<&'static str>,
    /// Scans and odometry were accepted all the same.
    pub are_accepted: bool,
    /// Messages that are no messages of their type.
    pub broken: u64,
    /// By how much the robot's clock is ahead. [s]
    pub clock_ahead_s: Option<f64>,
    /// The clocks agree.
    pub is_same_clock: bool,
}

fn finding(level: Level, check: &str, seen: String, fix: impl Into<Option<String>>) -> Finding {
    Finding {
        level,
        check: check.to_owned(),
        seen,
        fix: fix.into(),
    }
}

/// The ends in words: node and quality of service of each.
fn ends<'a>(of: impl Iterator<Item = &'a End>) -> String {
    let words = of.map(|end| {
        let node = if end.node.is_empty() {
            "a node without a name"
        } else {
            &end.node
        };
        let reliability = if end.reliable {
            "reliable"
        } else {
            "best effort"
        };
        let latched = if end.latched { ", transient local" } else { "" };
        format!("{node} ({reliability}{latched})")
    });
    words.collect::<Vec<_>>().join(", ")
}

/// Everything, in the order in which it is mended.
#[must_use]
pub fn judge(config: &RosConfig, facts: &Facts) -> Vec<Finding> {
    let mut findings = vec![network(facts)];
    let scan = ["scan", &config.scan_topic, "sensor_msgs/LaserScan"];
    let odometry = ["odometry", &config.odom_topic, "nav_msgs/Odometry"];
    findings.push(measured(scan, &facts.scans, facts, 0.0));
    findings.push(measured(odometry, &facts.odometry, facts, ODOMETRY_HZ_MIN));
    findings.push(transforms(config, facts));
    findings.push(clock(config, facts));
    findings.push(publishers(config, facts));
    findings.push(wheels(config, facts));
    findings.push(commanders(config, facts));
    findings.extend(rejected(facts));
    findings
}

fn network(facts: &Facts) -> Finding {
    let (n, ends) = (facts.graph.participants, facts.graph.ends.len());
    let seen = format!(
        "{}: {n} other participants with {ends} ends of topics",
        facts.network
    );
    if n > 0 {
        return finding(Level::Ok, "network", seen, None);
    }
    let fix = "set ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE as on the robot, let UDP and multicast pass (a \
               guest network often does not); discovery servers, static peers and rmw_zenoh are not supported";
    finding(Level::Error, "network", seen, fix.to_owned())
}

/// Other topics of this type.
fn instead(kind: &str, facts: &Facts, of: &str) -> Option<String> {
    let mut topics = facts.graph.topics_of(kind);
    topics.truncate(NAMED_MAX);
    (!topics.is_empty()).then(|| {
        format!(
            "{kind} comes on {}: config.ros.{of} names the topic",
            topics.join(", ")
        )
    })
}

fn measured(
    [check, topic, kind]: [&str; 3],
    heard: &Heard,
    facts: &Facts,
    rate_hz_min: f64,
) -> Finding {
    let field = if check == "scan" {
        "scan_topic"
    } else {
        "odom_topic"
    };
    let publishers: Vec<&End> = facts.graph.of(topic, true).collect();
    if let Some(other) = publishers.iter().find(|end| end.kind != kind) {
        let seen = format!("{topic} is {} by {}", other.kind, other.node);
        let fix = format!("{kind} is needed");
        return finding(Level::Error, check, seen, fix);
    }
    if heard.n == 0 {
        let (seen, fix) = if publishers.is_empty() {
            let seen = format!("nobody publishes {topic}");
            let other = instead(kind, facts, field);
            let fix = other.unwrap_or_else(|| "start the driver".to_owned());
            (seen, fix)
        } else {
            let who = ends(publishers.into_iter());
            let seen = format!("nothing came on {topic} of {who}");
            let fix = "look at the driver on the robot (`ros2 topic hz`): if it publishes, UDP is lost on the way";
            (seen, fix.to_owned())
        };
        return finding(Level::Error, check, seen, fix);
    }
    let who = ends(publishers.into_iter());
    let rate_hz = heard.rate_hz().unwrap_or(0.0);
    let longest_s = heard.longest_s();
    let mut seen = format!(
        "{topic} by {who}: {rate_hz:.1} Hz, at most {:.0} ms between two, frame {}",
        1.0e3 * longest_s,
        heard.frame
    );
    let age_s = heard.age_s().filter(|_| facts.is_same_clock);
    if let Some([least, most]) = age_s {
        let words = format!(", {:.0} to {:.0} ms old", 1.0e3 * least, 1.0e3 * most);
        seen.push_str(&words);
    }
    if longest_s > SILENT_S {
        let fix =
            "the robot stands when nothing comes for 0.5 s: look at the driver, and at the network";
        return finding(Level::Error, check, seen, fix.to_owned());
    }
    if rate_hz < rate_hz_min {
        let fix =
            format!("the robot is driven once per message: publish at {rate_hz_min:.0} Hz or more");
        return finding(Level::Warning, check, seen, fix);
    }
    if age_s.is_some_and(|[_, most]| most > AGE_MAX_S) {
        let fix = "late measurements are late reactions: look at the network, and at the driver's buffers";
        return finding(Level::Warning, check, seen, fix.to_owned());
    }
    finding(Level::Ok, check, seen, None)
}

fn transforms(config: &RosConfig, facts: &Facts) -> Finding {
    let check = "transforms";
    let (frame, base) = (&facts.scans.frame, &config.base_frame);
    if !config.laser_from_tf {
        let seen = "the lidar lies where robot.lidar.pose says".to_owned();
        return finding(Level::Ok, check, seen, None);
    }
    if facts.scans.n == 0 {
        let seen = format!(
            "{} messages on {} and {}; without scans their frame is not known",
            facts.transforms, config.tf_topic, config.tf_static_topic
        );
        return finding(Level::Warning, check, seen, None);
    }
    if facts.is_laser_placed {
        let seen = format!("they lead from {frame} to {base}");
        return finding(Level::Ok, check, seen, None);
    }
    let seen = format!(
        "none lead from {frame} to {base} ({} messages on {} and {})",
        facts.transforms, config.tf_topic, config.tf_static_topic
    );
    let others: Vec<&str> = facts.graph.topics_of("tf2_msgs/TFMessage");
    let others = others.into_iter().filter(|topic| {
        let topic = *topic;
        topic != config.tf_topic && topic != config.tf_static_topic
    });
    let others: Vec<&str> = others.take(NAMED_MAX).collect();
    let fix = if others.is_empty() {
        "start robot_state_publisher, or say config.ros.laser_from_tf = false and robot.lidar.pose"
            .to_owned()
    } else {
        format!(
            "transforms come on {}: config.ros.tf_topic and tf_static_topic name them",
            others.join(", ")
        )
    };
    finding(Level::Error, check, seen, fix)
}

fn clock(config: &RosConfig, facts: &Facts) -> Finding {
    let check = "clock";
    if facts.troubles.contains(&Trouble::Clock) {
        let seen = "it was set, or stood still, while the doctor listened".to_owned();
        let fix = "look at the time synchronisation of the robot; of a simulation, config.ros.use_sim_time = true";
        return finding(Level::Error, check, seen, fix.to_owned());
    }
    let Some(ahead_s) = facts.clock_ahead_s else {
        let seen = if config.use_sim_time {
            "that of a simulation"
        } else {
            "nothing with a stamp came"
        };
        return finding(Level::Ok, check, seen.to_owned(), None);
    };
    if facts.is_same_clock {
        let seen = "the robot's agrees with this system's: delays of the network are known";
        return finding(Level::Ok, check, seen.to_owned(), None);
    }
    let side = if ahead_s > 0.0 { "ahead of" } else { "behind" };
    let seen = format!("the robot's is {:.3} s {side} this system's", ahead_s.abs());
    let fix = "it drives; with synchronised clocks (chrony) delays of the network would count as age, too";
    finding(Level::Warning, check, seen, fix.to_owned())
}

fn publishers(config: &RosConfig, facts: &Facts) -> Finding {
    let check = "publishers";
    for topic in [&config.scan_topic, &config.odom_topic] {
        if facts.graph.of(topic, true).count() > 1 {
            let who = ends(facts.graph.of(topic, true));
            let seen = format!("several publish {topic}: {who}");
            let fix = "end all but one, or name the topic of one";
            return finding(Level::Error, check, seen, fix.to_owned());
        }
    }
    if facts.troubles.contains(&Trouble::Publishers) {
        let seen = "scans or odometry came of two nodes in turn".to_owned();
        let fix = "end one of them: the robot stands while both publish";
        return finding(Level::Error, check, seen, fix.to_owned());
    }
    let seen = "one publishes scans, one odometry, at most".to_owned();
    finding(Level::Ok, check, seen, None)
}

fn wheels(config: &RosConfig, facts: &Facts) -> Finding {
    let (check, topic) = ("wheels", config.cmd_vel_topic.as_str());
    let kind = if config.cmd_vel_stamped {
        "geometry_msgs/TwistStamped"
    } else {
        "geometry_msgs/Twist"
    };
    let hearing: Vec<&End> = facts.graph.of(topic, false).collect();
    if hearing.is_empty() {
        let others = facts.graph.ends.iter().filter(|end| {
            !end.publishes && end.kind.starts_with("geometry_msgs/Twist") && end.topic != topic
        });
        let mut others: Vec<&str> = others.map(|end| end.topic.as_str()).collect();
        others.dedup();
        others.truncate(NAMED_MAX);
        let seen = format!("nobody hears {topic}");
        let fix = if others.is_empty() {
            "start the base".to_owned()
        } else {
            let others = others.join(", ");
            format!("velocities are heard on {others}: config.ros.cmd_vel_topic names the topic")
        };
        return finding(Level::Error, check, seen, fix);
    }
    let who = ends(hearing.iter().copied());
    if let Some(other) = hearing.iter().find(|end| end.kind != kind) {
        let seen = format!("{topic} is heard as {} by {}", other.kind, other.node);
        let stamped = !config.cmd_vel_stamped;
        let fix = format!("config.ros.cmd_vel_stamped = {stamped}");
        return finding(Level::Error, check, seen, fix);
    }
    if let Some(other) = hearing.iter().find(|end| end.latched) {
        let seen = format!(
            "{} asks for transient local commands on {topic}",
            other.node
        );
        let fix = "subscribe with volatile durability: an old command is no command";
        return finding(Level::Error, check, seen, fix.to_owned());
    }
    let seen = format!("{topic} as {kind} is heard by {who}");
    finding(Level::Ok, check, seen, None)
}

fn commanders(config: &RosConfig, facts: &Facts) -> Finding {
    let (check, topic) = ("commands", config.cmd_vel_topic.as_str());
    // The seat of a stack that is up is nobody else.
    let is_own = |end: &&End| end.node.strip_prefix('/') == Some(NODE);
    let others = ends(facts.graph.of(topic, true).filter(|end| !is_own(end)));
    if others.is_empty() {
        let seen = format!("nobody else publishes {topic}");
        return finding(Level::Ok, check, seen, None);
    }
    let seen = format!("{topic} is published by {others}, too");
    let fix = "the base obeys whoever spoke last: end it, or let a twist_mux choose";
    finding(Level::Warning, check, seen, fix.to_owned())
}

fn rejected(facts: &Facts) -> Option<Finding> {
    let mut why: Vec<String> = facts.rejected.iter().map(|it| (*it).to_owned()).collect();
    if facts.broken > 0 {
        why.push(format!(
            "{} that are no messages of their type",
            facts.broken
        ));
    }
    let level = if facts.are_accepted {
        Level::Warning
    } else {
        Level::Error
    };
    let fix = "look at the driver; frames of odometry are config.ros.odom_frame and base_frame";
    let seen = why.join("; ");
    (!why.is_empty()).then(|| finding(level, "rejected", seen, fix.to_owned()))
}

#[cfg(test)]
mod tests;
