//! Bags of ROS 2: messages in CDR, of whichever container.

mod map;

use crate::clock::{Clock, put_in_order};
use crate::log::{Log, LogPose, LogScan, Topics, add_pose};
use map::{MAP, Maps};
use mcap::records::Record;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use zeronav_msgs::pose::Pose;
use zeronav_recorder::read::{ReadError, records};
use zeronav_ros_messages::messages::{LaserScan, Odometry, TfMessage, Time};
use zeronav_ros_messages::received::{self, decoded, plain_frame, planar_pose};

/// The types that are read.
const SCAN: &str = "sensor_msgs/msg/LaserScan";
const ODOMETRY: &str = "nav_msgs/msg/Odometry";
const TF: &str = "tf2_msgs/msg/TFMessage";

/// Most channels and most messages of a bag.
const CHANNELS_MAX: usize = 10_000;
const MESSAGES_MAX: usize = 20_000_000;

/// What is kept of a bag while it is read.
pub(crate) struct Bag<'a> {
    topics: &'a Topics,
    log: Log,
    clock: Clock,
    /// Topics by type.
    seen: BTreeMap<&'static str, BTreeSet<String>>,
    scan_frames: BTreeSet<String>,
    /// Transforms that do not move, by parent and child.
    fixed: BTreeMap<(String, String), Pose>,
    from_tf: Vec<LogPose>,
    map_from_odom: Vec<LogPose>,
    maps: Maps,
    n: usize,
}

impl<'a> Bag<'a> {
    pub(crate) fn new(topics: &'a Topics) -> Self {
        Self {
            topics,
            log: Log {
                format: "ROS 2",
                ..Log::default()
            },
            clock: Clock::default(),
            seen: BTreeMap::new(),
            scan_frames: BTreeSet::new(),
            fixed: BTreeMap::new(),
            from_tf: Vec::new(),
            map_from_odom: Vec::new(),
            maps: Maps::default(),
            n: 0,
        }
    }

    /// Takes in an MCAP file. One that is cut is read as far as it goes.
    ///
    /// # Errors
    /// Why nothing can be read.
    pub(crate) fn read_mcap(&mut self, input: impl Read) -> Result<(), String> {
        let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
        let mut channels: BTreeMap<u16, (String, &'static str)> = BTreeMap::new();
        let mut any = false;
        let read = records(input, |record| {
            match record {
                Record::Header(_) => any = true,
                Record::Schema { header, .. } if schemas.len() < CHANNELS_MAX => {
                    schemas.insert(header.id, header.name.clone());
                }
                Record::Channel(channel)
                    if channel.message_encoding == "cdr" && channels.len() < CHANNELS_MAX =>
                {
                    let kind = schemas.get(&channel.schema_id).and_then(|name| kind(name));
                    if let Some(kind) = kind {
                        channels.insert(channel.id, (channel.topic.clone(), kind));
                    }
                }
                Record::Message { header, data } => {
                    if let Some((topic, kind)) = channels.get(&header.channel_id) {
                        self.take(topic, kind, header.log_time, data);
                    }
                }
                _ => {}
            }
            Ok::<(), ReadError>(())
        });
        match read {
            Err(damage) if !any => Err(damage.to_string()),
            Err(damage) => {
                self.is_damaged(&damage.to_string());
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// A file of it cannot be read any further.
    pub(crate) fn is_damaged(&mut self, damage: &str) {
        let missing = &mut self.log.report.missing;
        missing.push(format!("what comes behind the damage: {damage}"));
    }

    /// Takes in a message.
    pub(crate) fn take(&mut self, topic: &str, kind: &'static str, log_ns: u64, data: &[u8]) {
        self.n += 1;
        if self.n > MESSAGES_MAX || !self.is_wanted(topic, kind) {
            return;
        }
        let known = match kind {
            SCAN => self.scan(log_ns, data),
            ODOMETRY => self.odometry(log_ns, data),
            TF => self.transforms(data),
            MAP => self.maps.take((topic, self.topics.map.as_deref()), data),
            _ => Some(()),
        };
        if known.is_none() {
            self.log.report.mend("messages that cannot be read");
        }
    }

    /// True for the topic of a type that was named, or the first one.
    fn is_wanted(&mut self, topic: &str, kind: &'static str) -> bool {
        let seen = self.seen.entry(kind).or_default();
        if seen.len() < CHANNELS_MAX && !seen.contains(topic) {
            seen.insert(topic.to_owned());
        }
        let named = match kind {
            SCAN => &self.topics.scan,
            ODOMETRY => &self.topics.odometry,
            _ => return true,
        };
        named.as_deref().is_none_or(|named| named == topic)
    }

    fn scan(&mut self, log_ns: u64, data: &[u8]) -> Option<()> {
        let message: LaserScan = decoded(data)?;
        let header = message.header.clone();
        let it = received::scan(message).ok()?;
        let report = &mut self.log.report;
        let first_ns = self.clock.at(stamp(header.stamp, log_ns), report);
        report.invalid(it.invalid);
        self.scan_frames.insert(header.frame_id.into_owned());
        self.log.add_scan(LogScan {
            ns: first_ns.saturating_add(it.turn_ns),
            angle_min_rad: it.scan.angle_min_rad,
            angle_increment_rad: it.scan.angle_increment_rad,
            time_increment_s: it.scan.time_increment_s,
            range_m: [it.scan.range_m_min, it.scan.range_m_max],
            ranges: it.ranges,
        });
        Some(())
    }

    fn odometry(&mut self, log_ns: u64, data: &[u8]) -> Option<()> {
        let it: Odometry = decoded(data)?;
        let at = it.pose.pose;
        let pose = planar_pose(&at.position, &at.orientation)?;
        let ns = self
            .clock
            .at(stamp(it.header.stamp, log_ns), &mut self.log.report);
        let Log {
            odometry, report, ..
        } = &mut self.log;
        add_pose(odometry, LogPose { ns, pose }, report);
        Some(())
    }

    fn transforms(&mut self, data: &[u8]) -> Option<()> {
        let message: TfMessage = decoded(data)?;
        for it in message.transforms {
            let Some(pose) = planar_pose(&it.translation, &it.rotation) else {
                self.log.report.mend("transforms that are no numbers");
                continue;
            };
            let (parent, child) = (
                plain_frame(&it.header.frame_id),
                plain_frame(&it.child_frame_id),
            );
            let place = LogPose {
                ns: stamp(it.header.stamp, 0),
                pose,
            };
            let report = &mut self.log.report;
            match (parent, child) {
                // Late ones are put in order by their stamps; their clock is that of the messages before.
                ("odom", "base_link" | "base_footprint") => {
                    add_pose(&mut self.from_tf, place, report);
                }
                ("map", "odom") => add_pose(&mut self.map_from_odom, place, report),
                _ if self.fixed.len() < CHANNELS_MAX => {
                    self.fixed
                        .insert((parent.to_owned(), child.to_owned()), pose);
                }
                _ => {}
            }
        }
        Some(())
    }

    /// What was read.
    ///
    /// # Errors
    /// What is missing without which nothing can be driven.
    pub(crate) fn into_log(self) -> Result<Log, String> {
        self.one_topic(SCAN, "--scan")?;
        self.one_topic(ODOMETRY, "--odometry")?;
        let mut log = self.log;
        if log.scans.is_empty() {
            return Err(format!("no message of {SCAN} that can be read is in it"));
        }
        if log.odometry.is_empty() && !self.from_tf.is_empty() {
            log.report
                .assumed
                .push("the odometry is the transform from odom to base_link".to_owned());
            log.odometry = self.from_tf;
        }
        if log.odometry.is_empty() {
            return Err(format!(
                "neither {ODOMETRY} nor a transform from odom to base_link is in it: without odometry nothing can be driven"
            ));
        }
        let frame = self.scan_frames.first().cloned().unwrap_or_default();
        match mount(&self.fixed, plain_frame(&frame)) {
            Some(laser) => log.laser = laser,
            None => log.report.assumed.push(format!(
                "the lidar ({frame}) is in the middle of the robot and looks ahead: no transform says where it is"
            )),
        }
        if self.scan_frames.len() > 1 {
            let missing = &mut log.report.missing;
            missing.push("scans of several lidars are taken for those of the first".to_owned());
        }
        let named = self.topics.map.as_deref();
        log.map = self.maps.chosen(named, &mut log.report)?;
        log.report
            .missing
            .push("no outline and no limits of the robot".to_owned());
        put_in_order(&mut log);
        correct(&mut log, self.map_from_odom);
        if log.map.is_some() && log.corrected.is_empty() {
            let assumed = &mut log.report.assumed;
            assumed.push(
                "the odometry begins in the frame of the map: no transform says where".to_owned(),
            );
        }
        Ok(log)
    }

    /// Accepts one topic of a type, or a named one.
    fn one_topic(&self, kind: &'static str, flag: &str) -> Result<(), String> {
        let named = match kind {
            SCAN => &self.topics.scan,
            _ => &self.topics.odometry,
        };
        let none = BTreeSet::new();
        let seen = self.seen.get(kind).unwrap_or(&none);
        let all = || {
            let names: Vec<&str> = seen.iter().map(String::as_str).collect();
            names.join(", ")
        };
        match named {
            Some(named) if !seen.contains(named) => {
                Err(format!("no {kind} on {named} is in it; there is {}", all()))
            }
            None if seen.len() > 1 => Err(format!(
                "several topics have {kind}: name one with {flag} ({})",
                all()
            )),
            _ => Ok(()),
        }
    }
}

/// Corrected poses from where a localiser had the odometry, at its moments.
fn correct(log: &mut Log, mut map_from_odom: Vec<LogPose>) {
    map_from_odom.sort_by_key(|it| it.ns);
    if map_from_odom.is_empty() {
        return;
    }
    log.report
        .assumed
        .push("corrected poses are those of the transform from map to odom".to_owned());
    let corrected = log.scans.iter().filter_map(|scan| {
        let at = map_from_odom.partition_point(|it| it.ns <= scan.ns);
        let map_from_odom = map_from_odom.get(at.checked_sub(1)?)?;
        let odometry = crate::recording::pose_at(&log.odometry, scan.ns)?;
        Some(LogPose {
            ns: scan.ns,
            pose: map_from_odom.pose.then(&odometry),
        })
    });
    log.corrected = corrected.collect();
}

/// The type that this name means, with or without `msg`.
pub(crate) fn kind(name: &str) -> Option<&'static str> {
    [SCAN, ODOMETRY, TF, MAP]
        .into_iter()
        .find(|known| *known == name || known.replace("/msg/", "/") == name)
}

/// Where a frame is on the robot, by transforms that do not move.
fn mount(fixed: &BTreeMap<(String, String), Pose>, frame: &str) -> Option<Pose> {
    const DEEPEST: usize = 16;
    let (mut at, mut pose) = (frame.to_owned(), Pose::default());
    for _ in 0..DEEPEST {
        if at == "base_link" || at == "base_footprint" {
            return Some(pose);
        }
        let ((parent, _), parent_from_at) = fixed.iter().find(|((_, child), _)| *child == at)?;
        pose = parent_from_at.then(&pose);
        at.clone_from(parent);
    }
    None
}

/// A stamp, or when the message was logged where it has none. [ns]
fn stamp(stamp: Time, log_ns: u64) -> u64 {
    match received::stamp_ns(stamp) {
        0 => log_ns,
        ns => ns,
    }
}

#[cfg(test)]
mod tests;
