//! Mapping as a process: answers every scan with the tiles that changed.

mod map_files;
mod map_output;
mod predecessor;
mod readings;
mod run_log;

use map_output::MapOutput;
use predecessor::Predecessor;
use readings::Readings;
use run_log::RunLog;
use std::process::ExitCode;
use zeronav_mapping::{Mapping, MappingConfig};
use zeronav_msgs::foresight::FORESIGHT_PERCEIVE;
use zeronav_msgs::header::Parents;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::EVENT_NEED_KEYFRAME;
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Due, Service, Shell, StartError};
use zeronav_world::StaticMap;

/// Time between two looks for the odometry around a scan. [ns]
const LOOK_NS: u64 = 1_000_000;

/// How long after the answer to a scan nothing else is asked of it: the cores are left to planners and guard, which act on
/// the same scan. [ns]
const QUIET_NS: u64 = 4_000_000;

struct MappingService {
    config: MappingConfig,
    static_map: Option<StaticMap>,
    /// The map of the process in the seat, for one that comes to take its place.
    predecessor: Option<Predecessor>,
    /// The map has begun, or goes on with that of a predecessor.
    began: bool,
    /// Tick of the predecessor's map: what was said of the robot's pose until then is in it. 0 = none.
    learnt_tick: u64,
    /// Made when the robot is known.
    mapping: Option<Mapping>,
    /// When the last answer was out. [ns]
    answered_ns: u64,
    readings: Readings,
    map: MapOutput,
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
        map_files::warn(loaded.as_ref());
        let peer = shell.peer();
        Ok(Self {
            static_map: loaded.map(|loaded| loaded.map),
            predecessor: None,
            began: false,
            learnt_tick: 0,
            mapping: None,
            answered_ns: 0,
            readings: Readings::open(peer, config.regularisation.enabled)?,
            map: MapOutput::open(peer, config.window.most_tiles(&geometry))?,
            log: RunLog::default(),
            config,
        })
    }

    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<(), StartError> {
        self.map.refresh();
        if shell.roster().clock.foresight & FORESIGHT_PERCEIVE != 0 {
            self.readings.be_told(shell.peer())?;
        }
        self.readings.poll(shell);
        self.make_map()?;
        if !self.begins(shell)? {
            return Ok(());
        }
        let tick_ns = shell.roster().clock.tick_ns;
        let poses = self.readings.poses_of_scan(tick_ns);
        for due in shell.due(&self.readings.trigger(poses.is_some())) {
            match poses.filter(|_| due.kind == SpanKind::Answer) {
                Some(poses) => self.answer(shell, due, poses),
                None => self.send_first(shell, due),
            }
        }
        if poses.is_none() && self.readings.awaits_odometry(shell) {
            shell.wake_by(shell.woken_ns() + LOOK_NS);
        }
        if self.readings.report(shell) {
            self.send_stale(shell);
        }
        self.check_when_quiet(shell);
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
        if self.mapping.is_none()
            && let Some(robot) = self.readings.description.get()
        {
            let static_map = self.static_map.take();
            let mapping = map_files::begin(&self.config, static_map.as_ref(), &robot)?;
            self.mapping = Some(mapping);
        }
        Ok(())
    }

    /// True once there is a map. A newcomer first takes over what the process in the seat has learnt.
    fn begins(&mut self, shell: &mut Shell) -> Result<bool, StartError> {
        let Some(mapping) = self.mapping.as_mut().filter(|_| !self.began) else {
            return Ok(self.began);
        };
        // The first map is already that of the zones.
        if !shell.roster().has_clock() || self.readings.zones.is_missing(shell.roster()) {
            return Ok(false);
        }
        if self.predecessor.is_none() {
            self.predecessor = Predecessor::open(shell)?;
        }
        if let Some(predecessor) = &mut self.predecessor {
            let Some(tick) = predecessor.hand_over(shell, mapping)? else {
                return Ok(false);
            };
            self.learnt_tick = tick;
            self.predecessor = None;
        }
        if self.readings.zones.advance(0) {
            mapping.set_zones(self.readings.zones.set());
        }
        self.began = true;
        Ok(true)
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

    fn answer(&mut self, shell: &mut Shell, due: Due, poses: (Pose, Pose)) {
        let mut draft = self.readings.begin(shell, due);
        let estimate = self.readings.take_estimate(due.tick);
        let new_zones = self.readings.zones.advance(due.tick);
        let observation = self.readings.observation(poses);
        let (Some(observation), Some(mapping)) = (observation, &mut self.mapping) else {
            return;
        };
        if let Some(estimate) = estimate.filter(|it| it.from_tick > self.learnt_tick) {
            let pose = estimate.map_from_base;
            let (x_m, y_m, yaw_rad) = (pose.x_m, pose.y_m, pose.yaw_rad);
            tracing::info!(tick = due.tick, x_m, y_m, yaw_rad, "pose estimate applied");
            let certainty = estimate.certainty().unwrap_or_default();
            mapping.relocate(estimate.map_from_odom(), certainty, &observation);
        }
        if new_zones {
            mapping.set_zones(self.readings.zones.set());
        }
        *mapping.timer() = shell.stage_timer(draft.started_ns);
        mapping.take_in(&observation);
        mapping.let_out(&observation.odom_from_base);
        draft.stages_ns = mapping.timer().stages_ns();
        let work = u64::from(observation.scan.n_beams);
        let n_obstacles = self.map.send_obstacles(shell, &draft, mapping);
        self.map.current = true;
        let sent = if mapping.take_moved() {
            self.map.send_moved(shell, &draft, mapping)
        } else {
            self.map.send(shell, &draft, mapping)
        };
        shell.finish(&draft, sent, work);
        self.answered_ns = now_ns();
        let (map_from_odom, _) = mapping.map_from_odom();
        self.log.log_sought(due.tick, mapping.sought());
        self.log
            .log(due.tick, draft.run_ns, &map_from_odom, n_obstacles);
    }

    /// Asks of the last scan what nobody waits for. When does not matter to the next answer.
    fn check_when_quiet(&mut self, shell: &mut Shell) {
        let Some(mapping) = self.mapping.as_mut().filter(|it| it.is_unchecked()) else {
            return;
        };
        let quiet_until_ns = self.answered_ns + QUIET_NS;
        if shell.woken_ns() < quiet_until_ns {
            shell.wake_by(quiet_until_ns);
        } else {
            mapping.check();
        }
    }

    /// When scans have stopped coming, one empty revision marks the map as not current.
    fn send_stale(&mut self, shell: &mut Shell) {
        if let Some(mapping) = self.mapping.as_mut().filter(|_| self.map.current) {
            self.map.current = false;
            tracing::warn!("scans have stopped coming, the map is not current");
            let newest = self.readings.scan.received().unwrap_or_default();
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
