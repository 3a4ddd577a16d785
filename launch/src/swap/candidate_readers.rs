//! Reads what both processes of a seat answer.

use super::scores::{Answer, Scores};
use zeronav_casts::Cast;
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{COST_LETHAL, FLAG_STATIC, MapView};
use zeronav_msgs::path::{PathStatus, Waypoint};
use zeronav_msgs::replica::MapReplica;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::Seat;
use zeronav_msgs::topics::{ControlRequest, MapKeyframe, MapUpdate, PlanPath, RobotCommand, Topic};
use zeronav_shell::{Latest, Roster, StartError, Stream, View};
use zeronav_supervise::stack::Stack;

/// Paths in a row through cells that the lidar saw occupied: the newcomer may not have had that scan
/// yet.
const BLOCKED_PATHS_MAX: u32 = 3;

/// Hears the incumbent (0) and the newcomer (1).
#[derive(Debug)]
pub(super) struct CandidateReaders {
    rosters: [Roster; 2],
    topics: Topics,
    /// Paths of the newcomer in a row that lead through an obstacle.
    blocked_paths: u32,
}

#[derive(Debug)]
enum Topics {
    Paths([Stream<PlanPath>; 2]),
    Requests([Stream<ControlRequest>; 2]),
    Commands([Stream<RobotCommand>; 2]),
    Maps(Box<[MapReaders; 2]>),
}

/// One process's map.
#[derive(Debug)]
struct MapReaders {
    updates: Stream<MapUpdate>,
    keyframe: Latest<MapKeyframe>,
    replica: MapReplica,
    /// Scan of the newest revision.
    scan: u64,
}

/// A roster in which the process with this epoch is the one that is obeyed, at every tick.
pub(super) fn roster_of(role: Role, epoch: u32) -> Roster {
    Roster {
        seats: vec![Seat {
            role: role.code(),
            epoch,
            ..Seat::default()
        }],
        ..Roster::default()
    }
}

impl CandidateReaders {
    /// Opens the topics of the role's answers.
    ///
    /// # Errors
    /// When there is no place left for a reader.
    pub(super) fn open(stack: &Stack, role: Role, newcomer: u32) -> Result<Self, StartError> {
        let peer = stack.peer()?;
        let topics = match role {
            Role::Mapping => {
                let candidate_readers = || {
                    Ok::<_, StartError>(MapReaders {
                        updates: peer.stream()?,
                        keyframe: peer.latest()?,
                        replica: MapReplica::new(),
                        scan: 0,
                    })
                };
                Topics::Maps(Box::new([candidate_readers()?, candidate_readers()?]))
            }
            Role::GlobalPlanner => Topics::Paths([peer.stream()?, peer.stream()?]),
            Role::LocalPlanner => Topics::Requests([peer.stream()?, peer.stream()?]),
            Role::CollisionGuard => Topics::Commands([peer.stream()?, peer.stream()?]),
            Role::Robot | Role::Launch | Role::Tap => {
                return Err(StartError::Usage(format!("{role} is not swapped")));
            }
        };
        let incumbent = stack.epoch(role);
        Ok(Self {
            rosters: [roster_of(role, incumbent), roster_of(role, newcomer)],
            topics,
            blocked_paths: 0,
        })
    }

    /// The incumbent has this epoch now: it may have been restarted.
    pub(super) fn incumbent_is(&mut self, epoch: u32) {
        if let Some(seat) = self.rosters[0].seats.first_mut() {
            seat.epoch = epoch;
        }
    }

    /// Takes in what has come, and compares answers to ticks from `from_tick` on. True when a map
    /// is missing, so that mapping should be asked for a keyframe.
    pub(super) fn listen(
        &mut self,
        from_tick: u64,
        map: Option<&MapView<'_>>,
        scores: &mut Scores,
    ) -> bool {
        let rosters = &self.rosters;
        match &mut self.topics {
            Topics::Paths(streams) => {
                for (which, (stream, roster)) in streams.iter_mut().zip(rosters).enumerate() {
                    let blocked_paths = &mut self.blocked_paths;
                    stream.drain(roster, |view| {
                        let is_found = view.meta.status() == Some(PathStatus::Found);
                        if which == 1 {
                            *blocked_paths = match map.map(|map| blockage(map, view.items)) {
                                Some(Blockage::Static) if is_found => BLOCKED_PATHS_MAX,
                                Some(Blockage::Sensed) if is_found => *blocked_paths + 1,
                                _ => 0,
                            };
                        }
                        if view.header.tick >= from_tick.max(1) {
                            let length_m = is_found.then_some(view.meta.length_m);
                            scores.answer(which, view.header.tick, Answer::Path(length_m));
                        }
                    });
                }
            }
            Topics::Requests(streams) => {
                ingest(streams, rosters, from_tick, scores, |view| {
                    Answer::of_request(view.meta)
                });
            }
            Topics::Commands(streams) => {
                ingest(streams, rosters, from_tick, scores, |view| {
                    Answer::of_command(view.meta)
                });
            }
            Topics::Maps(candidate_readers) => {
                return ingest_maps(candidate_readers, rosters, from_tick, scores);
            }
        }
        false
    }

    /// Messages of the newcomer that were rejected. A message whose header cannot be read has no
    /// author; it counts, as the incumbent was trusted before.
    pub(super) fn rejected(&self) -> u64 {
        let newcomer = self.rosters[1].seats.first().map_or(0, |seat| seat.epoch);
        match &self.topics {
            Topics::Paths([_, stream]) => rejected(stream, newcomer),
            Topics::Requests([_, stream]) => rejected(stream, newcomer),
            Topics::Commands([_, stream]) => rejected(stream, newcomer),
            Topics::Maps(candidate_readers) => rejected(&candidate_readers[1].updates, newcomer),
        }
    }

    /// True when the newcomer's paths lead through obstacles.
    pub(super) fn is_blocked(&self) -> bool {
        self.blocked_paths >= BLOCKED_PATHS_MAX
    }
}

/// Rejected messages of the process with this epoch, and those that name no author.
fn rejected<T: Topic>(stream: &Stream<T>, epoch: u32) -> u64 {
    stream.refused_of(epoch) + stream.refused_of_nobody()
}

fn ingest<T: Topic>(
    streams: &mut [Stream<T>; 2],
    rosters: &[Roster; 2],
    from_tick: u64,
    scores: &mut Scores,
    answer: impl Fn(View<'_, T>) -> Answer,
) {
    for (which, (stream, roster)) in streams.iter_mut().zip(rosters).enumerate() {
        stream.drain(roster, |view| {
            if view.header.tick >= from_tick.max(1) {
                scores.answer(which, view.header.tick, answer(view));
            }
        });
    }
}

fn ingest_maps(
    candidate_readers: &mut [MapReaders; 2],
    rosters: &[Roster; 2],
    from_tick: u64,
    scores: &mut Scores,
) -> bool {
    let mut is_missing = false;
    // The newer of two revisions waits until the other process has made its own.
    let order = if candidate_readers[0].scan > candidate_readers[1].scan {
        [1, 0]
    } else {
        [0, 1]
    };
    for which in order {
        let scan_of_other = candidate_readers[1 - which].scan;
        loop {
            let (own, roster) = (&mut candidate_readers[which], &rosters[which]);
            if own.keyframe.poll(roster)
                && let Some(view) = own.keyframe.get()
            {
                own.replica.keyframe(view.meta, view.items);
                own.keyframe.release();
            }
            if own.scan > scan_of_other && scan_of_other != 0 {
                break;
            }
            let (replica, scan) = (&mut own.replica, &mut own.scan);
            let taken = own.updates.take(roster, |view| {
                replica.update(view.header.id(), view.meta, view.items);
                // A revision counts with its last part.
                let is_whole = view.meta.is_last_part() && view.header.parents.scan != 0;
                if is_whole {
                    *scan = view.header.parents.scan;
                }
                (view.header.tick, is_whole)
            });
            let Some((tick, is_whole)) = taken else {
                break;
            };
            own.replica.take_changed();
            if is_whole && tick >= from_tick.max(1) && own.scan == scan_of_other {
                let [incumbent, newcomer] = &*candidate_readers;
                if let (Some(one), Some(other)) = (whole(incumbent), whole(newcomer)) {
                    scores.maps(&one, &other);
                }
            }
        }
        is_missing |= candidate_readers[which].replica.needs_keyframe();
    }
    is_missing
}

fn whole(candidate_readers: &MapReaders) -> Option<MapView<'_>> {
    let is_whole = !candidate_readers.replica.needs_keyframe()
        && candidate_readers.replica.revision() != Id::NONE;
    candidate_readers.replica.view().filter(|_| is_whole)
}

/// What a path leads through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Blockage {
    None,
    Sensed,
    Static,
}

/// Most cells that are looked up for one path.
const LOOKUPS_MAX: u32 = 200_000;

/// What the centre of the robot would drive through on a path. One that is longer than any path on
/// this map leads out of it, which nothing is known about.
fn blockage(map: &MapView<'_>, waypoints: &[Waypoint]) -> Blockage {
    let mut found = Blockage::None;
    let mut left = LOOKUPS_MAX;
    for pair in waypoints.windows(2) {
        let [from, to] = pair else { continue };
        let (dx_m, dy_m) = (to.x_m - from.x_m, to.y_m - from.y_m);
        let steps = (dx_m.hypot(dy_m) / (0.5 * map.geometry.resolution_m)).ceil();
        if steps >= f64::from(left) {
            return Blockage::Static;
        }
        let steps = steps.max(1.0).to_u32();
        left -= steps.min(left);
        for step in 0..=steps {
            let share = f64::from(step) / f64::from(steps);
            let point = nalgebra::Point2::new(from.x_m + share * dx_m, from.y_m + share * dy_m);
            let cell = map.get(map.geometry.unbounded_cell_at(point));
            match cell {
                Some(cell) if cell.cost == COST_LETHAL && cell.flags & FLAG_STATIC != 0 => {
                    return Blockage::Static;
                }
                Some(cell) if cell.cost == COST_LETHAL => found = Blockage::Sensed,
                _ => {}
            }
        }
    }
    found
}
