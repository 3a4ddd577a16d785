//! A log as a recording in ticks: odometry at every tick, a scan at the next tick after its capture.

use crate::log::{Log, LogPose};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use zeronav_casts::Cast;
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::task::{Goal, Task, TaskKind};
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{GroundTruth, RobotDescription, RobotOdometry, RobotScan, TaskGoal};
use zeronav_msgs::truth::Truth;
use zeronav_recorder::file::DRIVEN_BY;
use zeronav_recorder::made::{Made, MadeError, Moment};

/// Name of the metadata record that says what was missing, assumed and mended.
pub const IMPORTED: &str = "zeronav.import";

/// Field of [`IMPORTED`]: the name of the YAML file beside the recording with the map that the robot knew.
pub const MAP: &str = "map";

/// Run time of a tick: no lidar of a mobile robot is faster than 20 ticks per second by much. [ns]
const TICK_NS: u64 = 50_000_000;

/// Longest log: a day. [ticks]
const TICKS_MAX: u64 = 24 * 3600 * 20;

/// The robot that a log does not describe: round, as fast as most. [m], [m/s], [rad/s] and the like
const RADIUS_M: f64 = 0.25;
const V_MPS_MAX: f64 = 1.0;
const W_RADPS_MAX: f64 = 2.0;
const A_MPS2_MAX: f64 = 1.0;
const ALPHA_RADPS2_MAX: f64 = 4.0;

/// Requests and odometry may be older than usual: ticks are longer. [s]
const AGE_S: f64 = 0.175;

/// What of the world is mapped around where the robot was. [m]
const MARGIN_M: f64 = 15.0;

/// How near a goal is reached. [m]
const TOLERANCE_M: f64 = 0.25;

/// Speeds beyond these are errors of the log. [m/s], [rad/s]
const SPEED_MAX: f64 = 20.0;

/// What a log came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Ticks, scans among them, and corrected poses.
    pub ticks: u64,
    /// See [`Self::ticks`].
    pub scans: u64,
    /// See [`Self::ticks`].
    pub corrected: u64,
    /// What it lasts. [s]
    pub lasts_s: f64,
}

/// The odometry between two messages, or at one; `None` outside.
#[must_use]
pub fn pose_at(odometry: &[LogPose], ns: u64) -> Option<Pose> {
    let after = odometry.partition_point(|it| it.ns < ns);
    let later = odometry.get(after)?;
    if later.ns == ns {
        return Some(later.pose);
    }
    let earlier = odometry.get(after.checked_sub(1)?)?;
    let share = (ns - earlier.ns).to_f64() / (later.ns - earlier.ns).to_f64();
    let (from, to) = (&earlier.pose, &later.pose);
    Some(Pose::new(
        from.x_m + share * (to.x_m - from.x_m),
        from.y_m + share * (to.y_m - from.y_m),
        wrap_angle(from.yaw_rad + share * wrap_angle(to.yaw_rad - from.yaw_rad)),
    ))
}

/// The pose that leads back.
fn inverse(pose: &Pose) -> Pose {
    Pose::from(pose.isometry().inverse())
}

/// A log whose odometry begins where the first corrected pose is, so that both have one frame.
struct Placed<'a> {
    log: &'a Log,
    /// `map_from_odom` at the beginning.
    start: Pose,
    zero_ns: u64,
    ticks: u64,
}

impl<'a> Placed<'a> {
    fn of(log: &'a Log) -> Option<Self> {
        let first = log.scans.first()?;
        let raw = pose_at(&log.odometry, first.ns)?;
        let corrected = log.corrected.iter().find(|it| it.ns == first.ns);
        let start = match (corrected, &log.map) {
            (Some(it), _) => it.pose.then(&inverse(&raw)),
            // Nobody says where the odometry lies on the map.
            (None, Some(_)) => Pose::default(),
            (None, None) => inverse(&raw),
        };
        let last_ns = log.scans.last()?.ns.min(log.odometry.last()?.ns);
        let zero_ns = first.ns.checked_sub(TICK_NS)?.max(log.odometry.first()?.ns);
        Some(Self {
            log,
            start,
            zero_ns,
            ticks: (last_ns.saturating_sub(zero_ns) / TICK_NS + 1).min(TICKS_MAX),
        })
    }

    /// `map_from_base` by odometry at this run time, as the map begins. [ns]
    fn odometry(&self, run_ns: u64) -> Pose {
        let ns = self.zero_ns + run_ns;
        let last = self.log.odometry.last().map(|it| it.pose);
        let raw = pose_at(&self.log.odometry, ns).or(last).unwrap_or_default();
        self.start.then(&raw)
    }

    /// What was driven through, with room around it: lower left and upper right corner. [m]
    fn area_m(&self) -> [[f64; 2]; 2] {
        let range_m = self
            .log
            .scans
            .first()
            .map_or(MARGIN_M, |scan| f64::from(scan.range_m[1]));
        let margin_m = range_m.min(MARGIN_M);
        let odometry = self.log.odometry.iter().map(|it| self.start.then(&it.pose));
        let all = odometry.chain(self.log.corrected.iter().map(|it| it.pose));
        let mut area_m = [[f64::MAX; 2], [f64::MIN; 2]];
        for pose in all {
            for (axis, at_m) in [pose.x_m, pose.y_m].into_iter().enumerate() {
                area_m[0][axis] = area_m[0][axis].min((at_m - margin_m).floor());
                area_m[1][axis] = area_m[1][axis].max((at_m + margin_m).ceil());
            }
        }
        area_m
    }

    /// The scenario that configures the seats to which the recording is played.
    fn scenario(&self, map: Option<&str>) -> String {
        let scan = self.log.scans.first();
        let [first, last] = self.area_m();
        let start = self.odometry(0);
        let (n_beams, range_m) = scan.map_or((2, [0.1, 10.0]), |it| (it.ranges.len(), it.range_m));
        format!(
            "title = \"imported\"\nstart = [{:?}, {:?}, {:?}]\nstatic_map = false\n\n[run]\ntick_hz = 20.0\n\
             time_limit_s = {:?}\n\n[world]\narea_m = [{first:?}, {last:?}]\n\n[robot]\nradius_m = {RADIUS_M:?}\n\
             v_mps_max = {V_MPS_MAX:?}\nw_radps_max = {W_RADPS_MAX:?}\na_mps2_max = {A_MPS2_MAX:?}\n\
             alpha_radps2_max = {ALPHA_RADPS2_MAX:?}\n\
             lidar = {{ n_beams = {n_beams}, rate_hz = 10.0, range_m_min = {:?}, range_m_max = {:?} }}\n\n\
             [services.collision_guard]\nconfig.request_age_s = {AGE_S:?}\nconfig.odometry_age_s = {AGE_S:?}\n{}",
            start.x_m,
            start.y_m,
            start.yaw_rad,
            seconds(self.ticks * TICK_NS) + 1.0,
            f64::from(range_m[0]),
            f64::from(range_m[1]),
            map.map_or_else(String::new, |map| format!(
                "\n[services.mapping]\nconfig.static_map = {}\n",
                basic_string(map)
            )),
        )
    }

    fn description(&self) -> Description {
        let scan = self.log.scans.first();
        let angles = scan.map_or([0.0, 0.1], |it| [it.angle_min_rad, it.angle_increment_rad]);
        let range_m = scan.map_or([0.1, 10.0], |it| it.range_m);
        Description {
            inscribed_radius_m: RADIUS_M,
            circumscribed_radius_m: RADIUS_M,
            v_mps_max: V_MPS_MAX,
            v_mps_min: -V_MPS_MAX,
            w_radps_max: W_RADPS_MAX,
            a_mps2_max: A_MPS2_MAX,
            brake_mps2: A_MPS2_MAX,
            alpha_radps2_max: ALPHA_RADPS2_MAX,
            base_from_laser: self.log.laser,
            angle_min_rad: f64::from(angles[0]),
            angle_increment_rad: f64::from(angles[1]),
            range_m_min: f64::from(range_m[0]),
            range_m_max: f64::from(range_m[1]),
            scan_period_ns: 2 * TICK_NS,
            n_beams: u32::try_from(scan.map_or(2, |it| it.ranges.len())).unwrap_or(2),
            ..Description::default()
        }
    }
}

/// Why a log does not become a recording.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// What is in the log.
    #[error("{0}")]
    Log(&'static str),
    /// It cannot be written.
    #[error("{0}")]
    Made(#[from] MadeError),
}

/// A basic string of TOML.
fn basic_string(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.extend(format!("\\u{:04X}", u32::from(c)).chars()),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// Writes a log as the recording `name`, whose map is the file `map` beside it.
///
/// # Errors
/// [`WriteError`].
pub fn write<W: Write + Seek>(
    log: &Log,
    (name, map): (&str, Option<&str>),
    output: W,
) -> Result<(Imported, W), WriteError> {
    let placed = Placed::of(log);
    let placed = placed.ok_or(WriteError::Log(
        "no scan lies between two odometry messages",
    ))?;
    Ok(placed.write((name, map), output)?)
}

impl Placed<'_> {
    fn write<W: Write + Seek>(
        &self,
        (name, map): (&str, Option<&str>),
        output: W,
    ) -> Result<(Imported, W), MadeError> {
        let start = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("mode", RunMode::Lockstep.label().to_owned()),
            ("seed", "0".to_owned()),
            ("tick_ns", TICK_NS.to_string()),
            ("times", "run time".to_owned()),
            ("run_zero_ns", self.zero_ns.to_string()),
            (DRIVEN_BY, "recording".to_owned()),
        ];
        let start = start.map(|(key, value)| (key.to_owned(), value));
        let scenario = self.scenario(map);
        let file = format!("{name}.toml");
        let mut made = Made::begin(output, start.into(), Some((&file, &scenario)))?;
        made.metadata(IMPORTED, self.report(map))?;
        let robot = |tick, run_ns| Moment {
            role: Role::Robot,
            tick,
            run_ns,
        };
        made.write::<RobotDescription>(robot(0, 0), self.description(), &[])?;
        self.write_goal(&mut made)?;
        let (mut scans, mut corrected) = (0, 0);
        let mut waiting = self.log.scans.iter().peekable();
        let mut driven_m = 0.0;
        let mut before = self.odometry(0);
        for tick in 1..=self.ticks {
            let run_ns = tick * TICK_NS;
            // Of two scans in one tick the second comes with the next.
            let scan = waiting.next_if(|scan| scan.ns <= self.zero_ns + run_ns);
            if let Some(scan) = scan {
                scans += 1;
                let header = Scan {
                    n_beams: u32::try_from(scan.ranges.len()).unwrap_or(0),
                    angle_min_rad: scan.angle_min_rad,
                    angle_increment_rad: scan.angle_increment_rad,
                    time_increment_s: scan.time_increment_s,
                    range_m_min: scan.range_m[0],
                    range_m_max: scan.range_m[1],
                    ..Scan::default()
                };
                let at = robot(tick, scan.ns.saturating_sub(self.zero_ns));
                made.write::<RobotScan>(at, header, &scan.ranges)?;
            }
            let pose = self.odometry(run_ns);
            driven_m += before.distance_m(&pose);
            let truth = scan.and_then(|scan| {
                let all = &self.log.corrected;
                let at = all.binary_search_by_key(&scan.ns, |it| it.ns).ok()?;
                all.get(at)
            });
            if let Some(truth) = truth {
                corrected += 1;
                // Where it is at the tick, from where it was at its scan.
                let scanned = self.odometry(truth.ns.saturating_sub(self.zero_ns));
                let meta = Truth {
                    pose: truth.pose.then(&inverse(&scanned).then(&pose)),
                    clearance_m: 1000.0,
                    driven_m,
                    ..Truth::default()
                };
                made.write::<GroundTruth>(robot(tick, run_ns), meta, &[])?;
            }
            let odometry = twist(&before, &pose, scan.is_some());
            made.write::<RobotOdometry>(robot(tick, run_ns), odometry, &[])?;
            before = pose;
        }
        let imported = Imported {
            ticks: self.ticks,
            scans,
            corrected,
            lasts_s: seconds(self.ticks * TICK_NS),
        };
        Ok((imported, made.finish(self.ticks + 1, None)?))
    }

    /// The goal is where the log ends, so that planners have something to plan.
    fn write_goal<W: Write + Seek>(&self, made: &mut Made<W>) -> Result<(), MadeError> {
        let last = self.log.corrected.last().map(|it| it.pose);
        let goal = Goal {
            pose: last.unwrap_or_else(|| self.odometry(self.ticks * TICK_NS)),
            tolerance_m: TOLERANCE_M,
            yaw_tolerance_rad: core::f64::consts::PI,
            id: 1,
        };
        let task = Task {
            kind: TaskKind::Go.code(),
            n_goals: 1,
            from_tick: 1,
            ..Task::default()
        };
        let at = Moment {
            role: Role::Launch,
            tick: 0,
            run_ns: 0,
        };
        made.write::<TaskGoal>(at, task, &[goal])?;
        Ok(())
    }

    fn report(&self, map: Option<&str>) -> BTreeMap<String, String> {
        let report = &self.log.report;
        let mended = report.mended.iter().map(|(what, n)| format!("{n} {what}"));
        let fields = [
            ("format", self.log.format.to_owned()),
            ("missing", report.missing.join("; ")),
            ("assumed", assumed(self.log).join("; ")),
            ("mended", mended.collect::<Vec<String>>().join("; ")),
        ];
        let map = map.map(|map| (MAP, map.to_owned()));
        let fields = fields.into_iter().chain(map);
        fields.map(|(key, value)| (key.to_owned(), value)).collect()
    }
}

/// What is taken to be so of a log, the ticks included.
#[must_use]
pub fn assumed(log: &Log) -> Vec<String> {
    let mut assumed = log.report.assumed.clone();
    let ms = TICK_NS / 1_000_000;
    assumed.push(format!(
        "a round robot of {RADIUS_M} m, {V_MPS_MAX} m/s and {W_RADPS_MAX} rad/s"
    ));
    assumed.push(format!(
        "odometry between its messages is straight, at ticks of {ms} ms"
    ));
    assumed.push("the goal is where the log ends".to_owned());
    assumed
}

/// Odometry at `to`, a tick after `from`.
fn twist(from: &Pose, to: &Pose, with_scan: bool) -> Odometry {
    let tick_s = seconds(TICK_NS);
    let way = inverse(from).then(to);
    let clamp = |speed: f64| speed.clamp(-SPEED_MAX, SPEED_MAX);
    Odometry {
        pose: *to,
        v_mps: clamp(way.x_m / tick_s),
        w_radps: clamp(wrap_angle(way.yaw_rad) / tick_s),
        scan_due: u32::from(with_scan),
        ..Odometry::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{LogMap, LogScan};
    use std::io::Cursor;
    use zeronav_msgs::topics::Topic;
    use zeronav_recorder::messages::native_messages;
    use zeronav_recorder::read::{attachment, summary};

    const MS: u64 = 1_000_000;

    fn log() -> Log {
        let scan = |ns| LogScan {
            ns,
            angle_min_rad: -1.0,
            angle_increment_rad: 1.0,
            time_increment_s: 0.0,
            range_m: [0.1, 9.0],
            ranges: vec![1.0, f32::INFINITY, f32::NAN],
        };
        let pose = |ns, x_m| LogPose {
            ns,
            pose: Pose::new(x_m, 0.0, 0.0),
        };
        Log {
            format: "test",
            scans: [1070, 1075, 1220].map(|ms| scan(ms * MS)).to_vec(),
            odometry: (0..=10_u32)
                .map(|n| pose((1000 + 100 * u64::from(n)) * MS, 0.1 * f64::from(n)))
                .collect(),
            corrected: vec![pose(1070 * MS, 5.0)],
            ..Log::default()
        }
    }

    #[test]
    fn a_log_becomes_ticks_with_odometry_and_scans_at_the_next_one() {
        let (imported, output) =
            write(&log(), ("it", None), Cursor::new(Vec::new())).expect("written");
        assert_eq!((imported.scans, imported.corrected), (3, 1));
        let bytes = output.into_inner();
        let (found, damage) = summary(&bytes[..]);
        assert!(damage.is_none(), "{damage:?}");
        assert_eq!(found.metadata["zeronav"]["valid"], "true");
        assert!(found.metadata[IMPORTED]["assumed"].contains("round robot"));
        let scenario = attachment(&bytes[..], "application/toml", 10_000).expect("read");
        assert!(scenario.expect("a scenario").1.starts_with(b"title"));
        let (mut of_scans, mut due, mut places) = (Vec::new(), Vec::new(), Vec::new());
        let end = native_messages(
            &bytes[..],
            |_| true,
            |name, layout, [envelope, _]| {
                let number = |path: &str| layout.number(envelope, path).expect("a number");
                if name == RobotScan::ROW.name {
                    of_scans.push((number("header.tick"), number("header.run_ns") / MS));
                } else if name == RobotOdometry::ROW.name && number("meta.scan_due") == 1 {
                    due.push(number("header.tick"));
                    places.extend(layout.word(envelope, "meta.pose.x_m"));
                }
            },
        );
        assert_eq!(end.expect("read").end_tick, Some(imported.ticks + 1));
        // Run time 0 is 50 ms before the first scan; two scans in one tick come one after the other.
        assert_eq!(of_scans, [(1, 50), (2, 55), (4, 200)]);
        assert_eq!(due, [1, 2, 4]);
        // The first odometry is where the first corrected pose is.
        let x_m: f64 = places[0].parse().expect("a number");
        assert!((x_m - 5.0).abs() < 1e-9, "{x_m}");
    }

    #[test]
    fn the_map_beside_a_recording_configures_mapping_and_odometry_lies_on_it() {
        let log = Log {
            corrected: Vec::new(),
            map: Some(LogMap {
                frame: "map".to_owned(),
                corner: Pose::default(),
                resolution_m: 0.05,
                size: (1, 1),
                cells: vec![0],
            }),
            ..log()
        };
        let written = write(
            &log,
            ("it", Some("a \"map\" e\u{301}\n.yaml")),
            Cursor::new(Vec::new()),
        );
        let bytes = written.expect("written").1.into_inner();
        let (found, _) = summary(&bytes[..]);
        assert_eq!(found.metadata[IMPORTED][MAP], "a \"map\" e\u{301}\n.yaml");
        let scenario = attachment(&bytes[..], "application/toml", 10_000).expect("read");
        let text = String::from_utf8(scenario.expect("a scenario").1).expect("text");
        assert!(
            text.contains("config.static_map = \"a \\\"map\\\" e\u{301}\\u000A.yaml\""),
            "{text}"
        );
        // Run time 0 is 20 ms behind the second message of the odometry, in its own frame.
        assert!(text.contains("start = [0.02"), "{text}");
    }

    #[test]
    fn a_log_without_odometry_around_its_scans_is_refused() {
        let mut log = log();
        log.odometry.clear();
        let error = write(&log, ("it", None), Cursor::new(Vec::new()))
            .map(|_| ())
            .expect_err("none");
        assert!(error.to_string().contains("no scan"), "{error}");
    }
}
