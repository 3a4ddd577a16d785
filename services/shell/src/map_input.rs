//! The map as a service takes it in: updates in order, and a keyframe when one was missed.

use crate::due::{Due, Trigger};
use crate::error::StartError;
use crate::input::Input;
use crate::odometry::OdometryReader;
use crate::peer::Peer;
use crate::reader::{Latest, Stream};
use crate::received::Received;
use crate::roster::Roster;
use crate::shell::Shell;
use crate::writer::Draft;
use zeronav_msgs::grid::CellRect;
use zeronav_msgs::header::{Id, Parents};
use zeronav_msgs::map::{MapInfo, MapView};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::replica::MapReplica;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{EVENT_NEED_KEYFRAME, MapKeyframe, MapObstacles, MapUpdate};

/// Least time between two requests for a keyframe. [ns]
const ASK_PAUSE_NS: u64 = 20_000_000;

/// How much older than the map tracked obstacles may be to be stamped on it, in run time: a mapping
/// that was restarted has none to take back. [ns]
const OBSTACLES_AGE_NS_MAX: u64 = 500_000_000;

/// Reads `map/update` and `map/keyframe` into a copy of the map.
#[derive(Debug)]
pub struct MapInput {
    updates: Stream<MapUpdate>,
    keyframe: Latest<MapKeyframe>,
    /// Stamped on the copy; `None` for a service that predicts them.
    obstacles: Option<Latest<MapObstacles>>,
    /// Faster ones are not stamped. [m/s]
    stamped_below_mps: f64,
    /// Scratch: those that are.
    stamped: Vec<Obstacle>,
    replica: MapReplica,
    changed: Vec<CellRect>,
    newest: Option<Received>,
    /// Tick of the newest keyframe.
    keyframe_tick: u64,
    asked_ns: Option<u64>,
}

impl MapInput {
    /// Opens both topics. The map holds static obstacles only.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            // Updates before the keyframe, so that none is missed between the two.
            updates: peer.stream()?,
            keyframe: peer.latest()?,
            obstacles: None,
            stamped_below_mps: f64::INFINITY,
            stamped: Vec::new(),
            replica: MapReplica::new(),
            changed: Vec::new(),
            newest: None,
            keyframe_tick: 0,
            asked_ns: None,
        })
    }

    /// Opens `map/obstacles`, too, for a service that takes dynamic obstacles for static ones: they
    /// are stamped on the copy (see [`MapReplica::stamp`]).
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn with_obstacles(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            obstacles: Some(peer.latest()?),
            ..Self::open(peer)?
        })
    }

    /// The same with only those stamped that are slower than this; faster ones are gone before the robot
    /// is there. [m/s]
    #[must_use]
    pub fn slower_than(self, v_mps: f64) -> Self {
        Self {
            stamped_below_mps: v_mps,
            ..self
        }
    }

    /// Takes in what has come and asks for a keyframe if only that helps; true when the last part of
    /// a revision came in.
    pub fn poll(&mut self, shell: &Shell) -> bool {
        let (roster, now_ns) = (shell.roster(), shell.woken_ns());
        let completed = self.take_in(roster);
        let asked = |asked_ns| now_ns.saturating_sub(asked_ns) < ASK_PAUSE_NS;
        if self.is_lost() && roster.has_clock() && !self.asked_ns.is_some_and(asked) {
            self.asked_ns = Some(now_ns);
            shell.ring_event(Role::Mapping, EVENT_NEED_KEYFRAME);
        }
        completed
    }

    /// [`Self::poll`] for members without a shell: asks for nothing.
    pub fn take_in(&mut self, roster: &Roster) -> bool {
        // Whether a map that its author left before this process began came in on the way depends
        // on the speed of the machine.
        let author = self.revision().epoch();
        if author != 0 && roster.lockstep() && roster.began_after(Role::Mapping, author) {
            self.replica = MapReplica::new();
            (self.newest, self.keyframe_tick) = (None, 0);
        }
        let mut completed = false;
        self.updates.drain(roster, |view| {
            self.replica.update(view.header.id(), view.meta, view.items);
            // The parts before are of a revision that is not complete yet.
            if view.meta.is_last_part() {
                self.newest = Some(Received::of(view.header, roster.woken_ns));
                completed = true;
            }
        });
        // Also when none is needed, and given back at once: there are few places for keyframes,
        // and an unread one would take one from the next.
        if self.keyframe.poll(roster)
            && let Some(view) = self.keyframe.get()
        {
            self.replica.keyframe(view.meta, view.items);
            self.keyframe_tick = view.header.tick;
        }
        self.keyframe.release();
        self.changed = self.replica.take_changed();
        self.stamp_obstacles(roster);
        completed
    }

    /// Stamps the obstacles after every poll that changed the map, and when they changed. Polled
    /// after the map: mapping sends the obstacles of a scan before its update.
    fn stamp_obstacles(&mut self, roster: &Roster) {
        let Some(obstacles) = &mut self.obstacles else {
            return;
        };
        if !obstacles.poll(roster) && self.changed.is_empty() {
            return;
        }
        let map_ns = self.newest.map_or(0, |map| map.run_ns);
        let view = obstacles.get();
        let young =
            view.filter(|view| map_ns.saturating_sub(view.header.run_ns) <= OBSTACLES_AGE_NS_MAX);
        let below_mps = self.stamped_below_mps;
        let items = young.map_or(&[] as &[Obstacle], |view| view.items);
        let slow = items
            .iter()
            .filter(|it| it.vx_mps.hypot(it.vy_mps) < below_mps);
        self.stamped.clear();
        self.stamped.extend(slow);
        self.replica.stamp(&self.stamped);
        self.changed.append(&mut self.replica.take_changed());
    }

    /// The trigger of a service that answers every map: in lockstep each tick with a scan, after
    /// the map of that tick; in real time the newest map, and again when there is `news`.
    #[must_use]
    pub fn trigger(&self, roster: &Roster, odometry: &OdometryReader, news: bool) -> Trigger {
        let lockstep = roster.lockstep();
        let tick = match (odometry.newest(), self.newest) {
            (Some(odometry), _) if lockstep && odometry.odometry.scan_due() => odometry.tick,
            (_, Some(map)) if !lockstep => map.tick,
            _ => 0,
        };
        Trigger {
            tick,
            complete: !lockstep || !roster.answers(Role::Mapping, tick) || self.has(tick),
            deadline_ns: None,
            news,
        }
    }

    /// Begins an answer to the newest map.
    #[must_use]
    pub fn begin(&self, shell: &Shell, due: Due, parents: Parents) -> Draft {
        let map = self.newest.unwrap_or_default();
        let run_ns = if due.tick == map.tick {
            map.run_ns
        } else {
            shell.run_ns(due.tick)
        };
        shell.begin(due, run_ns, map.capture_ns, parents)
    }

    /// The map, once there is one.
    #[must_use]
    pub fn view(&self) -> Option<MapView<'_>> {
        self.replica.view()
    }

    /// Fixed fields of the newest revision.
    #[must_use]
    pub fn info(&self) -> &MapInfo {
        self.replica.info()
    }

    /// Revision of the cells; [`Id::NONE`] before the first.
    #[must_use]
    pub fn revision(&self) -> Id {
        self.replica.revision()
    }

    /// `map_from_base`, from `odom_from_base`.
    #[must_use]
    pub fn map_from_base(&self, odom_from_base: &Pose) -> Pose {
        self.info().map_from_odom.then(odom_from_base)
    }

    /// Rectangles around the cells that became others in the last poll; all of the map after a
    /// keyframe.
    #[must_use]
    pub fn changed(&self) -> &[CellRect] {
        &self.changed
    }

    /// When the newest update whose last part came in was captured and received.
    #[must_use]
    pub fn received(&self) -> Option<Received> {
        self.newest
    }

    /// Tick of the newest revision that came in, as an update or as a keyframe; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        let updated = self.newest.map_or(0, |newest| newest.tick);
        updated.max(self.keyframe_tick)
    }

    /// True when there is a map without a gap and mapping still receives scans.
    #[must_use]
    pub fn is_current(&self) -> bool {
        !self.is_lost() && self.info().current == 1
    }

    /// True when the copy can only go on with a keyframe.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.replica.needs_keyframe()
    }

    /// True when the map of `tick` is here, whole and without a gap before it.
    #[must_use]
    pub fn has(&self, tick: u64) -> bool {
        self.newest.is_some_and(|newest| newest.tick >= tick) && !self.is_lost()
    }
}

impl Input for MapInput {
    fn refused(&self) -> u64 {
        let obstacles = self.obstacles.as_ref().map_or(0, Input::refused);
        self.updates.refused() + self.keyframe.refused() + obstacles
    }
}
