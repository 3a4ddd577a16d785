//! `beam`: a search in time among dynamic obstacles.
//!
//! One arc, held for seconds, does not lead through a crowd: the way is to slow down now, pass
//! behind one and before the next. So sequences of manoeuvres are searched, each [`BeamConfig::manoeuvre_s`]
//! of a speed and a yaw rate that are asked for, within the robot's accelerations, and compared with
//! the predictions of their own moment. It is a beam search (Lowerre, "The Harpy Speech Recognition
//! System", 1976): of every layer of manoeuvres the [`BeamConfig::width`] best nodes are kept, by the
//! time spent and risked plus the time that the way to go still takes, at most one in each cell of
//! position, yaw and speed. The first manoeuvre of the best sequence is driven for
//! [`BeamConfig::replan_s`]; then it is searched again.
//!
//! - **Dynamic obstacles are where they will be, and nowhere else.** The map holds what is static, so
//!   the way behind a pedestrian is free.
//! - **The way to go** is the cost-to-go of `dwa_t` on the map: the search follows no path, so it
//!   does not turn back and forth with every path that comes.
//! - **A stopped robot may be walked into**, at a cost; one that drives may not, as far as
//!   predictions are to be relied on (1.5 s).
//! - **Standing still is no refuge** from who does not give way: a robot that would be hit while it
//!   brakes drives on as was found, if that leads to no static obstacle.
//! - Without dynamic obstacles nearby, at the goal, and for the exact check of what is published it
//!   is `dwa_t`.

mod node;
pub mod options;
mod space;
mod visited;

use crate::beam::options::BeamConfig;
use crate::dwa::options::DwaConfig;
use crate::dwa_t::options::DwaTConfig;
use crate::dwa_t::{TimedWindow, in_time};
use crate::lanes::data::narrow;
use crate::pilot::Pilot;
use crate::pilot::perception::{Prediction, Tracks};
use crate::pilot::scene::{Choose, ControlOutput, Mode, Scene};
use crate::record::{DrawnRollout, Record};
use node::{Blocked, Node};
use space::{LOOKS, Space};
use visited::Visited;
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::obstacles::OBSTACLES_MAX;
use zeronav_msgs::rollouts::RolloutOutcome;

/// Speeds that are asked for, as shares of the fastest.
const SPEEDS: [f32; 6] = [0.0, 0.15, 0.35, 0.6, 0.8, 1.0];

/// Yaw rates that are asked for, as shares of the fastest.
const YAW_RATES: [f32; 7] = [0.0, 0.125, -0.125, 0.3, -0.3, 0.625, -0.625];

/// The same for manoeuvres from this one on: what comes later is only outlined, and searched again
/// before it is driven.
const FINE: usize = 2;
const COARSE_SPEEDS: [f32; 4] = [0.0, 0.35, 0.7, 1.0];
const COARSE_YAW_RATES: [f32; 5] = [0.0, 0.2, -0.2, 0.625, -0.625];

/// [m/s^2] sideways beyond which a speed and a yaw rate are not asked for together.
const SIDEWAYS_MPS2: f32 = 2.6;

/// [m] around the robot that the search knows.
const SIGHT_M: f64 = 6.0;

/// [m] within which a walking obstacle makes the robot search.
const WALKS_M: f64 = 6.0;

/// [m] before the goal where it ends.
const FINAL_M: f64 = 0.3;

/// The controller `beam` at rest. The numbers must be within the ranges of their structs.
#[must_use]
pub fn beam(dwa: DwaConfig, timed: DwaTConfig, config: BeamConfig) -> Pilot {
    Pilot::new(
        in_time(dwa, timed),
        Tracks::Predicted(Box::new(Prediction::default().with_sight(SIGHT_M))),
        Box::new(Beam {
            search: Search::new(config),
            alone: TimedWindow::new(timed),
        }),
    )
}

/// The search among dynamic obstacles, the time-indexed window where there are none.
#[derive(Debug)]
struct Beam {
    search: Search,
    alone: TimedWindow,
}

impl Choose for Beam {
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {
        if !Search::is_needed(scene) {
            self.search.forget();
            return self.alone.choose(scene);
        }
        let mut record = scene.memory.record.take();
        let found = self.search.lead(scene, record.as_deref_mut());
        if let Some(record) = record.as_mut().filter(|_| found.is_none()) {
            // What the window looks at decides.
            record.begin(scene.situation.map_from_base);
        }
        scene.memory.record = record;
        let output = match found {
            Some(twist) => {
                scene.memory.mode = Mode::Follow;
                scene.memory.astray_s = 0.0;
                scene.memory.searched = true;
                scene.memory.limit = scene.searched();
                scene.steer(twist)
            }
            None => self.alone.choose(scene),
        };
        scene.memory.rollouts = scene.memory.rollouts.max(self.search.looked_at);
        output
    }

    fn forget(&mut self) {
        self.search.forget();
    }
}

/// The search and what it found last.
#[derive(Debug, Clone)]
struct Search {
    config: BeamConfig,
    /// The twist to go towards, and for how long it has been that. [s]
    found: Option<(Twist, f64)>,
    looked_at: u32,
    /// All layers, one after the other.
    nodes: Vec<Node>,
    /// The current layer before it is thinned out, and its order.
    fresh: Vec<Node>,
    order: Vec<u32>,
    /// Discs near a node.
    near: Vec<usize>,
    visited: Visited,
}

impl Search {
    fn new(config: BeamConfig) -> Self {
        let width = config.width as usize;
        let most = width * SPEEDS.len() * YAW_RATES.len();
        Self {
            config,
            found: None,
            looked_at: 0,
            nodes: Vec::with_capacity(1 + width * config.layers as usize),
            fresh: Vec::with_capacity(most),
            order: Vec::with_capacity(most),
            near: Vec::with_capacity(OBSTACLES_MAX),
            visited: Visited::new(),
        }
    }

    fn forget(&mut self) {
        self.found = None;
        self.looked_at = 0;
    }

    /// True when an obstacle walks nearby and the goal is not near.
    fn is_needed(scene: &Scene<'_>) -> bool {
        scene.seen.dynamic.is_within(WALKS_M) && scene.place.remaining_m >= FINAL_M
    }

    /// The twist of the manoeuvre that was found last or, when that is old, is found now.
    fn lead(&mut self, scene: &mut Scene<'_>, mut record: Option<&mut Record>) -> Option<Twist> {
        let situation = scene.situation;
        if let Some((twist, age_s)) = &mut self.found {
            *age_s += situation.period_s;
            if *age_s < self.config.replan_s - 0.5 * situation.period_s {
                if let Some(record) = &mut record {
                    record.hold();
                }
                return Some(*twist);
            }
        }
        let looks = self.config.layers as usize * LOOKS;
        let (look_s, delay_s) = (self.config.look_s(), self.config.delay_s);
        scene.seen.dynamic.tabulate(looks, look_s, delay_s);
        scene.find_cost_to_go(false);
        let goal = situation.goal.pose.point() - situation.map_from_base.point();
        let seen = &*scene.seen;
        let space = Space {
            config: self.config,
            robot: situation.robot,
            surroundings: &seen.surroundings,
            dynamic: &seen.dynamic,
            cost_to_go: seen.cost_to_go().filter(|_| situation.map.is_some()),
            here: situation.map_from_base,
            goal: (narrow(goal.x), narrow(goal.y)),
            tolerance: narrow(situation.goal.tolerance_m),
            fastest: narrow(scene.top_speed_mps()),
            soft: narrow(scene.config.soft_clearance_m),
        };
        let twist = self.search(&space, scene.from, record);
        self.found = twist.map(|twist| (twist, 0.0));
        twist
    }

    /// The first manoeuvre of the best sequence; `None` when no manoeuvre is free.
    fn search(
        &mut self,
        space: &Space<'_>,
        from: Twist,
        mut record: Option<&mut Record>,
    ) -> Option<Twist> {
        self.looked_at = 0;
        self.nodes.clear();
        self.nodes.push(space.root(from.v_mps, from.w_radps));
        let mut layer = 0..1;
        let mut depth = 0;
        while depth < self.config.layers as usize {
            self.expand(space, layer.clone(), depth, record.as_deref_mut());
            if self.fresh.is_empty() {
                break;
            }
            layer = self.keep_the_best(depth + 1, space.fastest);
            depth += 1;
        }
        if depth == 0 {
            return None;
        }
        // The best of the last layer is its first node.
        if let Some(record) = record {
            self.tell(record, layer.clone(), depth);
        }
        let (v, w) = self.nodes[self.ancestor(layer.start, depth - 1)].asked;
        Some(Twist::new(f64::from(v), f64::from(w)))
    }

    /// The node so many manoeuvres before another one.
    fn ancestor(&self, node: usize, before: usize) -> usize {
        (0..before).fold(node, |node, _| self.nodes[node].parent)
    }

    /// Tells the record of the sequences that end in a layer of this depth.
    fn tell(&self, record: &mut Record, layer: core::ops::Range<usize>, depth: usize) {
        let first = layer.start;
        for end in layer {
            let seen = DrawnRollout {
                twist: self.nodes[self.ancestor(end, depth - 1)].asked,
                cost: self.nodes[end].total,
                outcome: RolloutOutcome::Costlier,
                steps: depth,
            };
            let place = |step: usize| {
                let state = self.nodes[self.ancestor(end, depth - 1 - step)].state;
                (state.x, state.y)
            };
            record.offer(&seen, place);
            if end == first {
                record.lead(&seen, place);
            }
        }
    }

    /// Tells the record of a manoeuvre from `parent`, a node of this depth, that something is in the
    /// way of.
    fn tell_blocked(
        &self,
        record: &mut Record,
        (parent, depth): (usize, usize),
        asked: (f32, f32),
        blocked: &Blocked,
    ) {
        let twist = match depth {
            0 => asked,
            depth => self.nodes[self.ancestor(parent, depth - 1)].asked,
        };
        let seen = DrawnRollout {
            twist,
            cost: self.nodes[parent].total,
            outcome: blocked.by,
            steps: depth + 1,
        };
        record.offer(&seen, |step| {
            if step == depth {
                return blocked.at;
            }
            let state = self.nodes[self.ancestor(parent, depth - 1 - step)].state;
            (state.x, state.y)
        });
    }

    /// Drives every manoeuvre from every node of a layer.
    fn expand(
        &mut self,
        space: &Space<'_>,
        layer: core::ops::Range<usize>,
        number: usize,
        mut record: Option<&mut Record>,
    ) {
        let jump = narrow(space.robot.a_mps2_max.max(space.robot.brake_mps2))
            * narrow(self.config.manoeuvre_s);
        let w_max = narrow(space.robot.w_radps_max);
        let (speeds, yaw_rates): (&[f32], &[f32]) = if number < FINE {
            (&SPEEDS, &YAW_RATES)
        } else {
            (&COARSE_SPEEDS, &COARSE_YAW_RATES)
        };
        self.fresh.clear();
        for parent in layer {
            let node = self.nodes[parent];
            space.gather(&node, number, &mut self.near);
            for v in speeds.iter().map(|share| share * space.fastest) {
                // Which is out of reach is another manoeuvre's end.
                if (v - node.state.v).abs() > 1.1 * jump {
                    continue;
                }
                for w in yaw_rates.iter().map(|share| share * w_max) {
                    if (v * w).abs() > SIDEWAYS_MPS2 {
                        continue;
                    }
                    self.looked_at += 1;
                    match space.drive(&node, (v, w), number, &self.near) {
                        Ok(next) => self.fresh.push(Node { parent, ..next }),
                        Err(blocked) => {
                            if let Some(record) = &mut record {
                                self.tell_blocked(record, (parent, number), (v, w), &blocked);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Makes the best nodes of the current layer, one in a cell, the next layer.
    fn keep_the_best(&mut self, depth: usize, fastest_mps: f32) -> core::ops::Range<usize> {
        let depth = depth.to_f32();
        let fresh = &self.fresh;
        self.order.clear();
        self.order.extend((0_u32..).take(fresh.len()));
        self.order.sort_unstable_by(|a, b| {
            let total = |index: &u32| fresh[*index as usize].total;
            total(a).total_cmp(&total(b)).then(a.cmp(b))
        });
        self.visited.clear();
        let start = self.nodes.len();
        for index in &self.order {
            let node = self.fresh[*index as usize];
            if self.visited.insert(node.cell(depth, fastest_mps)) {
                self.nodes.push(node);
                if self.nodes.len() - start == self.config.width as usize {
                    break;
                }
            }
        }
        start..self.nodes.len()
    }
}
