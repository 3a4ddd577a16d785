//! Mapping as a process: answers every scan with the tiles that changed.

mod map_files;
mod map_output;
mod run_log;

use map_output::MapOutput;
use run_log::RunLog;
use std::process::ExitCode;
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_SCAN};
use zeronav_msgs::obstacles::{OBSTACLES_MAX, Obstacle, Obstacles};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::time::nanoseconds;
use zeronav_msgs::topics::{EVENT_NEED_KEYFRAME, MapObstacles, RobotDescription, RobotScan};
use zeronav_params::Parameter;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    CurrentGoal, Due, Latest, OdometryReader, Service, Shell, StartError, Trigger, Writer,
};
use zeronav_world::StaticMap;

/// Time without a scan after which the map is not current. [ns]
const STALE_NS: u64 = 500_000_000;

struct MappingService {
    config: MappingConfig,
    static_map: Option<StaticMap>,
    /// Made when the robot is known.
    mapping: Option<Mapping>,
    odometry: OdometryReader,
    description: Latest<RobotDescription>,
    scan: Latest<RobotScan>,
    /// Read for regularisation only.
    goal: Option<CurrentGoal>,
    map: MapOutput,
    tracked: Writer<MapObstacles>,
    obstacles: Vec<Obstacle>,
    log: RunLog,
}

impl Service for MappingService {
    const ROLE: Role = Role::Mapping;
    type Config = MappingConfig;

    fn parameters() -> Vec<Parameter> {
        zeronav_params::describe::<MappingConfig>()
    }

    fn check(config: &MappingConfig) -> Result<(), StartError> {
        map_files::check(config)
    }

    fn open(shell: &mut Shell, config: MappingConfig) -> Result<Self, StartError> {
        let (loaded, geometry) = map_files::load(&config)?;
        for warning in loaded.iter().flat_map(|loaded| &loaded.warnings) {
            tracing::warn!("{warning}");
        }
        let peer = shell.peer();
        let regularises = config.regularisation.enabled;
        Ok(Self {
            static_map: loaded.map(|loaded| loaded.map),
            mapping: None,
            odometry: OdometryReader::open(peer)?,
            description: peer.latest()?,
            scan: peer.latest()?,
            goal: regularises.then(|| CurrentGoal::open(peer)).transpose()?,
            map: MapOutput::open(peer, config.window.most_tiles(&geometry))?,
            tracked: peer.writer(OBSTACLES_MAX)?,
            obstacles: Vec::with_capacity(OBSTACLES_MAX),
            log: RunLog::default(),
            config,
        })
    }

    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<(), StartError> {
        self.map.refresh();
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        self.scan.poll(roster);
        if let Some(goal) = &mut self.goal {
            goal.poll(roster);
        }
        shell.count(&[&self.odometry, &self.scan, &self.description]);
        self.make_map()?;
        if self.mapping.is_none() {
            return Ok(());
        }
        let poses = self.poses_of_scan();
        let trigger = Trigger {
            tick: self.scan.tick(),
            complete: poses.is_some(),
            ..Trigger::default()
        };
        for due in shell.due(&trigger) {
            match poses.filter(|_| due.kind == SpanKind::Answer) {
                Some(poses) => self.answer(shell, due, poses),
                None => self.send_first(shell, due),
            }
        }
        self.check_scans(shell);
        shell.reason(REASON_ODOMETRY, self.scan.tick() > shell.answered_tick());
        if rung.has(EVENT_NEED_KEYFRAME) {
            self.map.want_keyframe();
        }
        if let Some(mapping) = &self.mapping {
            self.map.send_keyframe_if_due(shell, mapping);
        }
        Ok(())
    }
}

impl MappingService {
    /// Makes the map once the robot is known.
    fn make_map(&mut self) -> Result<(), StartError> {
        if self.mapping.is_some() {
            return Ok(());
        }
        let Some(robot) = self.description.get() else {
            return Ok(());
        };
        let static_map = self.static_map.take();
        let mapping = Mapping::new(&self.config, static_map.as_ref(), robot.meta, robot.items)
            .map_err(map_files::unusable)?;
        let geometry = mapping.mapper().geometry();
        let (width, height) = (geometry.width, geometry.height);
        tracing::info!(width, height, geometry.resolution_m, "the map begins");
        self.mapping = Some(mapping);
        Ok(())
    }

    /// `odom_from_base` at the capture of the newest scan's first and last beam; `None` until the
    /// odometry around the capture has been received.
    fn poses_of_scan(&self) -> Option<(Pose, Pose)> {
        let scan = self.scan.get()?;
        let history = self.odometry.history();
        let last_ns = scan.header.run_ns;
        let last = history.pose_at(last_ns)?;
        let steps = f64::from(scan.meta.n_beams.saturating_sub(1));
        let turn_ns = nanoseconds(steps * f64::from(scan.meta.time_increment_s));
        if turn_ns == 0 {
            return Some((last, last));
        }
        // The first turn began before the first odometry.
        let first = history.pose_at(last_ns.saturating_sub(turn_ns));
        Some((first.unwrap_or(last), last))
    }

    /// The first revision is the static map: an empty update, and a keyframe that holds it.
    fn send_first(&mut self, shell: &mut Shell, due: Due) {
        let Some(mapping) = &mut self.mapping else {
            return;
        };
        let draft = shell.begin(due, 0, 0, Parents::default());
        let sent = self.map.send(shell, &draft, mapping);
        self.map.want_keyframe();
        self.map.send_keyframe_if_due(shell, mapping);
        shell.finish(&draft, sent, 0);
    }

    fn answer(&mut self, shell: &mut Shell, due: Due, (first, last): (Pose, Pose)) {
        let (Some(scan), Some(mapping)) = (self.scan.get(), &mut self.mapping) else {
            return;
        };
        let (run_ns, capture_ns) = (scan.header.run_ns, scan.header.capture_ns);
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: scan.header.id,
            ..Parents::default()
        };
        let draft = shell.begin(due, run_ns, capture_ns, parents);
        if let Some(goal) = &mut self.goal {
            goal.advance(shell.roster(), due.tick);
        }
        let goal = self.goal.as_ref().and_then(CurrentGoal::goal);
        let newest = self.odometry.newest();
        mapping.take_in(&Observation {
            scan: scan.meta,
            ranges: scan.items,
            run_ns,
            odom_from_base_first: first,
            odom_from_base: last,
            odometry_variance: newest.map_or([0.0; 3], |newest| newest.odometry.variance),
            goal: goal.map(|goal| goal.pose.point()),
        });
        let work = u64::from(scan.meta.n_beams);
        self.obstacles.clear();
        self.obstacles.extend(mapping.obstacles());
        let tracked = Obstacles {
            n_obstacles: self.obstacles.len() as u64,
        };
        shell.send(&draft, &mut self.tracked, tracked, &self.obstacles);
        self.map.current = true;
        let sent = if mapping.take_moved() {
            self.map.send_moved(shell, &draft, mapping)
        } else {
            self.map.send(shell, &draft, mapping)
        };
        shell.finish(&draft, sent, work);
        let (map_from_odom, _) = mapping.map_from_odom();
        let n_obstacles = self.obstacles.len();
        self.log.log(due.tick, run_ns, &map_from_odom, n_obstacles);
    }

    /// When scans have stopped coming, one empty revision marks the map as not current.
    fn check_scans(&mut self, shell: &mut Shell) {
        let newest = self.scan.received().unwrap_or_default();
        let silent = shell.woken_ns().saturating_sub(newest.came_ns) > STALE_NS
            && !shell.roster().lockstep();
        shell.reason(REASON_SCAN, silent);
        if let Some(mapping) = self.mapping.as_mut().filter(|_| silent && self.map.current) {
            self.map.current = false;
            tracing::warn!("scans have stopped coming, the map is not current");
            let due = Due {
                tick: newest.tick,
                kind: SpanKind::Extra,
            };
            let draft = shell.begin(due, newest.run_ns, newest.capture_ns, Parents::default());
            let sent = self.map.send(shell, &draft, mapping);
            shell.finish(&draft, sent, 0);
        }
    }
}

impl Drop for MappingService {
    /// The process was asked to stop.
    fn drop(&mut self) {
        if let (Some(folder), Some(mapping)) = (&self.config.save_to, &self.mapping) {
            map_files::save(mapping.mapper(), folder);
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MappingService>()
}
