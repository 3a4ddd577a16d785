//! `zeronav doctor --ros2`: whether a robot of ROS 2 can be driven, and what to do where it cannot.
//!
//! It joins the network as the seat does, listens, and publishes nothing. `graph` reads who is there, `heard` what
//! comes, and `findings` judges both.

pub mod findings;
pub mod graph;
pub mod heard;

use crate::config::RosConfig;
use crate::frames::Frames;
use crate::inbox::{Inbox, host_offset_ns};
use crate::inputs::{Arrived, Event, Expected, Inputs, Measured, Trouble};
use crate::network::Network;
use crate::stamps::Stamps;
use clap::Parser;
use findings::{Facts, Finding, Level, judge};
use graph::Watch;
use heard::Heard;
use std::io::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use zeronav_casts::Cast;
use zeronav_msgs::pose::Pose;
use zeronav_ros_messages::received::{stamp_ns, turn_ns};
use zeronav_shell::clock::now_ns;
use zeronav_shell::printable;

/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Name of the node.
const NODE: &str = "zeronav_doctor";

/// Exit code when the robot cannot be driven.
const EXIT_FAIL: u8 = 1;

/// Exit code of wrong arguments.
const EXIT_USAGE: u8 = 2;

/// Looks at a robot of ROS 2: who publishes what, how, how often and how late, and whether it can be driven.
#[derive(Debug, Parser)]
#[command(name = "zeronav-ros2-doctor", version)]
struct Arguments {
    /// The table `config.ros` of the robot's seat, as TOML.
    #[arg(long, value_name = "TOML", default_value = "")]
    ros: String,
    /// How long to listen. [s]
    #[arg(long, value_name = "S", default_value_t = 6, value_parser = clap::value_parser!(u64).range(1..=600))]
    seconds: u64,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The program.
#[must_use]
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    match look(&arguments) {
        Ok(findings) => {
            let worst = findings.iter().map(|it| it.level).max();
            let can_drive = worst < Some(Level::Error);
            let text = if arguments.json {
                let whole = serde_json::json!({ "can_drive": can_drive, "checks": findings });
                format!("{whole:#}\n")
            } else {
                findings.iter().map(text).collect()
            };
            // Who reads may have gone.
            let _ = std::io::stdout().write_all(text.as_bytes());
            ExitCode::from(if can_drive { 0 } else { EXIT_FAIL })
        }
        Err(why) => {
            let _ = writeln!(
                std::io::stderr(),
                "zeronav-ros2-doctor: {}",
                printable(&why)
            );
            ExitCode::from(EXIT_USAGE)
        }
    }
}

/// A finding as one line, and its fix below.
fn text(finding: &Finding) -> String {
    let level = match finding.level {
        Level::Ok => "ok",
        Level::Warning => "warning",
        Level::Error => "error",
    };
    let seen = printable(&finding.seen);
    let fix = finding.fix.as_ref();
    let fix = fix.map(|fix| format!("{:8}   {}\n", "", printable(fix)));
    let fix = fix.unwrap_or_default();
    format!("{level:8} {}: {seen}\n{fix}", finding.check)
}

fn look(arguments: &Arguments) -> Result<Vec<Finding>, String> {
    let config: RosConfig =
        toml::from_str(&arguments.ros).map_err(|error| format!("--ros: {error}"))?;
    zeronav_params::check(&config).map_err(|error| format!("--ros: {error}"))?;
    let names = config.check_names();
    names.map_err(|(field, why)| format!("--ros: {field}: {why}"))?;
    let network = Network::new(&config.network)?;
    let (context, mut node) = network.node(NODE)?;
    let mut watch = Watch::begin(&context)?;
    let inbox = Inbox::open(&mut node, &config, || ())?;
    let mut listener = Listener::new(&config);
    let (began, limit) = (Instant::now(), Duration::from_secs(arguments.seconds));
    while began.elapsed() < limit {
        watch.look();
        while let Some(arrived) = inbox.next()? {
            listener.take(arrived);
        }
        std::thread::sleep(PAUSE);
    }
    watch.look();
    listener.end();
    let network = format!(
        "domain {}, {}",
        network.domain_id,
        match network.range {
            crate::network::Range::Subnet => "the whole subnet",
            crate::network::Range::Localhost => "this host alone",
        }
    );
    let facts = Facts {
        network,
        graph: watch.graph(),
        broken: inbox.broken(),
        ..listener.facts(&config)
    };
    Ok(judge(&config, &facts))
}

/// Hears as the seat does.
struct Listener {
    inputs: Inputs,
    frames: Frames,
    host_offset_ns: i64,
    scans: Heard,
    odometry: Heard,
    transforms: u64,
    troubles: Vec<Trouble>,
    /// Scans, odometry.
    are_accepted: [bool; 2],
}

impl Listener {
    fn new(config: &RosConfig) -> Self {
        let host_offset_ns = host_offset_ns();
        let expected = Expected {
            odom_frame: config.odom_frame.clone(),
            base_frame: config.base_frame.clone(),
            // Whether transforms say it is found out beside.
            fixed_laser: Some(Pose::default()),
            start: Pose::default(),
        };
        let stamps = Stamps::new(config.use_sim_time, host_offset_ns);
        Self {
            inputs: Inputs::new(expected, stamps, None),
            frames: Frames::default(),
            host_offset_ns,
            scans: Heard::default(),
            odometry: Heard::default(),
            transforms: 0,
            troubles: Vec::new(),
            are_accepted: [false; 2],
        }
    }

    fn take(&mut self, arrived: Arrived) {
        let came_ns = arrived.came_ns;
        let of_system_ns = came_ns.saturating_add_signed(-self.host_offset_ns);
        match &arrived.event {
            Event::Scan(it) => {
                // Its last beam is as old as the seat takes it to be.
                let last_ns = stamp_ns(it.header.stamp).saturating_add(turn_ns(it));
                let frame = &it.header.frame_id;
                self.scans.note(last_ns, of_system_ns, frame);
            }
            Event::Odometry(it) => {
                let (header, stamp_ns) = (&it.header, stamp_ns(it.header.stamp));
                self.odometry.note(stamp_ns, of_system_ns, &header.frame_id);
            }
            Event::Transforms(it) => {
                self.transforms += 1;
                self.frames.take(it);
            }
        }
        self.inputs.take(arrived);
        while let Some(measured) = self.inputs.next_measured() {
            let kind = usize::from(matches!(measured, Measured::Odometry { .. }));
            self.are_accepted[kind] = true;
        }
        for trouble in [Trouble::Clock, Trouble::Publishers] {
            if self.inputs.holds(trouble, came_ns).is_some() && !self.troubles.contains(&trouble) {
                self.troubles.push(trouble);
            }
        }
    }

    /// Nothing more is heard.
    fn end(&mut self) {
        let now_ns = now_ns().saturating_add_signed(-self.host_offset_ns);
        self.scans.end(now_ns);
        self.odometry.end(now_ns);
    }

    fn facts(&self, config: &RosConfig) -> Facts {
        let stamps = self.inputs.stamps();
        let placed = self.frames.base_from(&config.base_frame, &self.scans.frame);
        Facts {
            scans: self.scans.clone(),
            odometry: self.odometry.clone(),
            transforms: self.transforms,
            is_laser_placed: placed.is_some(),
            troubles: self.troubles.clone(),
            rejected: self.inputs.reasons().to_vec(),
            are_accepted: self.are_accepted == [true; 2],
            clock_ahead_s: stamps.ahead_ns().map(|it| it.to_f64() * 1.0e-9),
            is_same_clock: stamps.is_same_clock(),
            ..Facts::default()
        }
    }
}
