//! How a region is found and its trees are numbered, in slices.

use super::super::node::{GENERATION_SHIFT, NO_STEP, NO_WAY, STEP_MASK, STEP_SHIFT, Spot};
use super::super::prices::{BLOCKED, is_blocked};
use super::super::run::{FIELD, Run};
use super::super::{GoalField, Lists};
use super::forest::{Forest, Known, NEVER, NOWHERE, POSITIONS_MAX, Place};
use crate::bucket_queue::BucketQueue;
use crate::planner::{Control, PlanStats};
use crate::search::Found;
use zeronav_casts::Cast;

/// Cells of a region, at most.
const REGION_MAX: u64 = POSITIONS_MAX as u64;

/// In place of a spot: the search ends nowhere.
const NO_GOAL: Spot = Spot::MAX;

/// In place of the step that led to a cell: it has a number in place of its costs.
const NUMBERED: u32 = 9;

/// Expansions that a step of the other phases is worth.
const STEPS_PER_EXPANSION: u64 = 4;

/// How far the work has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// More is left.
    More,
    /// The region is ready.
    Ready,
    /// Bounds changed so much meanwhile that its search is of no use.
    Abandoned,
}

/// What is done next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Phase {
    #[default]
    Done,
    /// The search from the robot's cell.
    Search,
    /// Each cell, in the order in which it was closed, gets its number and its parent's.
    Number,
    /// And the number of the next one on the way to the goal.
    Link,
    /// How many lie below each in the first tree, from the last to the first.
    Weigh,
    /// Its position in that tree.
    Place,
    /// How many lie below each in the other tree, those without any first.
    WeighToGoal,
    /// Its position in that tree, in the opposite order.
    PlaceToGoal,
    /// All this by position.
    Put,
    /// Blocks of positions.
    SumUp,
}

/// A cell of the region.
#[derive(Debug, Clone, Copy)]
struct Member {
    so_far: u32,
    total: u32,
    /// Numbers of the parents, [`NOWHERE`] for roots.
    parent: u32,
    goal_parent: u32,
    /// How many lie below it, itself included.
    size: u32,
    goal_size: u32,
    /// Its position, and that of the next one below it.
    position: u32,
    next: u32,
    goal_position: u32,
    goal_next: u32,
    /// Children in the other tree that have not been weighed.
    waits_for: u8,
    step: u8,
    step_to_goal: u8,
}

/// See the module's description.
#[derive(Debug, Default)]
pub(super) struct Growth {
    phase: Phase,
    generation: u32,
    life: u64,
    goal: Spot,
    lists: Lists,
    /// Next number of the phase.
    at: usize,
    spots: Vec<Spot>,
    members: Vec<Member>,
    /// Numbers in the order in which they were weighed.
    weighed: Vec<u32>,
    forest: Forest,
}

/// The search that finds a region, in cells from which it is known what is left.
fn region_search<'a>(field: &'a mut GoalField, lists: &'a mut Lists) -> Run<'a, BucketQueue> {
    let mut run = field.run(&mut lists.open, &mut lists.closed, NO_GOAL);
    run.left.beyond = NO_WAY;
    run
}

impl Growth {
    /// False when nothing was begun, or a search of the field has come between.
    pub(super) fn is_under_way(&mut self, field: &GoalField) -> bool {
        let searching = matches!(self.phase, Phase::Search | Phase::Number | Phase::Link);
        let others = self.life != field.life || self.goal != field.goal;
        if others || searching && self.generation != field.generation {
            self.phase = Phase::Done;
        }
        self.phase != Phase::Done
    }

    /// The last one that was finished.
    pub(super) const fn forest(&mut self) -> &mut Forest {
        &mut self.forest
    }

    /// Begins with the search from `start`; false when no way leads from there.
    pub(super) fn begin(&mut self, field: &mut GoalField, start: Spot) -> bool {
        field.next_generation();
        (self.generation, self.life, self.goal) = (field.generation, field.life, field.goal);
        let span = field.span;
        let begun = region_search(field, &mut self.lists).begin::<FIELD>(start, span);
        self.phase = if begun { Phase::Search } else { Phase::Done };
        begun
    }

    /// Work of about `expansions` expansions.
    pub(super) fn go_on(&mut self, field: &mut GoalField, expansions: u64) -> Progress {
        if self.phase == Phase::Search {
            if !self.search(field, expansions) {
                self.spots.clear();
                self.members.clear();
                self.at = 0;
                self.phase = Phase::Number;
            }
            return Progress::More;
        }
        for _ in 0..expansions * STEPS_PER_EXPANSION {
            if !self.step(field) {
                self.at = 0;
                self.phase = match self.phase {
                    Phase::Done | Phase::SumUp => Phase::Done,
                    Phase::Search | Phase::Number => Phase::Link,
                    Phase::Link => Phase::Weigh,
                    Phase::Weigh => Phase::Place,
                    Phase::Place => {
                        self.begin_other_tree();
                        Phase::WeighToGoal
                    }
                    Phase::WeighToGoal => Phase::PlaceToGoal,
                    Phase::PlaceToGoal => {
                        self.forest.begin(field, self.goal, self.members.len());
                        Phase::Put
                    }
                    Phase::Put => Phase::SumUp,
                };
                return if self.phase == Phase::Done {
                    Progress::Ready
                } else {
                    Progress::More
                };
            }
            if self.phase == Phase::Done {
                return Progress::Abandoned;
            }
        }
        Progress::More
    }

    /// True when more is left.
    fn search(&mut self, field: &mut GoalField, expansions: u64) -> bool {
        let n_closed = self.lists.closed.len() as u64;
        let mut run = region_search(field, &mut self.lists);
        run.last = expansions.min(REGION_MAX.saturating_sub(n_closed));
        let mut stats = PlanStats::default();
        let found = run.go_on::<FIELD>(&mut |_| Control::Go, &mut stats);
        found == Found::Stopped && (self.lists.closed.len() as u64) < REGION_MAX
    }

    /// One step of the phase; false when there is none.
    fn step(&mut self, field: &mut GoalField) -> bool {
        let at = self.at;
        self.at += 1;
        match self.phase {
            Phase::Done | Phase::Search => false,
            Phase::Number => self.number(field, at),
            Phase::Link => self.link(field, at),
            Phase::Weigh => self.weigh(at),
            Phase::Place => self.place(at),
            Phase::WeighToGoal => self.weigh_to_goal(at),
            Phase::PlaceToGoal => self.place_to_goal(at),
            Phase::Put => self.put(field, at),
            Phase::SumUp => self.forest.sum_up_next(),
        }
    }

    fn number(&mut self, field: &mut GoalField, at: usize) -> bool {
        let Some(spot) = self.lists.closed.get(at).copied() else {
            return false;
        };
        let node = &mut field.nodes[spot as usize];
        let step = (node.meta & STEP_MASK) >> STEP_SHIFT;
        if step == NUMBERED {
            // It was closed twice: bounds changed meanwhile.
            return true;
        }
        // The search is over: its costs are not needed any more, numbers are.
        let generation = node.meta >> GENERATION_SHIFT;
        let so_far = node.so_far;
        let total = so_far.saturating_add(field.left.at(spot));
        node.so_far = self.members.len().to_u32();
        node.meta = node.meta & !STEP_MASK | NUMBERED << STEP_SHIFT;
        let parent = if step == NO_STEP {
            NOWHERE
        } else {
            let parent = spot.wrapping_sub(field.offsets[step as usize & 7]);
            let parent = field.nodes[parent as usize];
            if parent.meta >> GENERATION_SHIFT != generation
                || (parent.meta & STEP_MASK) >> STEP_SHIFT != NUMBERED
            {
                // Something became cheaper meanwhile, and the cell was opened again from one that
                // was closed after it.
                self.phase = Phase::Done;
                return true;
            }
            parent.so_far
        };
        self.members.push(Member {
            so_far,
            total,
            parent,
            goal_parent: NOWHERE,
            size: 1,
            goal_size: 1,
            position: 0,
            next: 1,
            goal_position: NEVER,
            goal_next: NEVER,
            waits_for: 0,
            step: step as u8,
            step_to_goal: NO_STEP.to_u8(),
        });
        self.spots.push(spot);
        true
    }

    fn link(&mut self, field: &GoalField, at: usize) -> bool {
        let Some(spot) = self.spots.get(at).copied() else {
            return false;
        };
        let (own, around) = field.prices.around(spot);
        let left = field.left.at(spot);
        if own == BLOCKED || spot == field.goal {
            return true;
        }
        for (step, offset) in (0_u32..).zip(field.offsets) {
            let to = spot.wrapping_add(offset);
            if is_blocked(around, step)
                || !field.corner_permits(around, step)
                || field.over(step, to) != left
            {
                continue;
            }
            // A cheapest way from a cell of the region costs no more anywhere, so it lies in the
            // region, but for cells as dear as its last ones, and where bounds changed meanwhile.
            let node = field.nodes[to as usize];
            if node.meta >> GENERATION_SHIFT == self.generation
                && (node.meta & STEP_MASK) >> STEP_SHIFT == NUMBERED
            {
                let member = &mut self.members[at];
                (member.step_to_goal, member.goal_parent) = (step.to_u8(), node.so_far);
                self.members[node.so_far as usize].waits_for += 1;
                break;
            }
        }
        true
    }

    fn weigh(&mut self, at: usize) -> bool {
        let Some(number) = self.members.len().checked_sub(at + 1) else {
            return false;
        };
        let Member { parent, size, .. } = self.members[number];
        if let Some(parent) = self.members.get_mut(parent as usize) {
            parent.size += size;
        }
        true
    }

    fn place(&mut self, at: usize) -> bool {
        let Some(member) = self.members.get(at).copied() else {
            return false;
        };
        if let Some(parent) = self.members.get_mut(member.parent as usize) {
            let position = parent.next;
            parent.next += member.size;
            let member = &mut self.members[at];
            (member.position, member.next) = (position, position + 1);
        }
        true
    }

    fn begin_other_tree(&mut self) {
        self.weighed.clear();
        let leaves = self.members.iter().zip(0_u32..);
        self.weighed.extend(
            leaves
                .filter(|(member, _)| member.waits_for == 0)
                .map(|(_, number)| number),
        );
    }

    fn weigh_to_goal(&mut self, at: usize) -> bool {
        let Some(number) = self.weighed.get(at).copied() else {
            return false;
        };
        let Member {
            goal_parent,
            goal_size,
            ..
        } = self.members[number as usize];
        if let Some(parent) = self.members.get_mut(goal_parent as usize) {
            parent.goal_size += goal_size;
            parent.waits_for -= 1;
            if parent.waits_for == 0 {
                self.weighed.push(goal_parent);
            }
        }
        true
    }

    fn place_to_goal(&mut self, at: usize) -> bool {
        let Some(number) = self.weighed.len().checked_sub(at + 1) else {
            return false;
        };
        let number = self.weighed[number] as usize;
        let member = self.members[number];
        let position = if let Some(parent) = self.members.get_mut(member.goal_parent as usize) {
            // A parent that is on no way has no position to give.
            if parent.goal_next == NEVER {
                return true;
            }
            let position = parent.goal_next;
            parent.goal_next += member.goal_size;
            position
        } else if self.spots[number] == self.goal {
            0
        } else {
            return true;
        };
        let member = &mut self.members[number];
        (member.goal_position, member.goal_next) = (position, position + 1);
        true
    }

    fn put(&mut self, field: &GoalField, at: usize) -> bool {
        let (Some(member), Some(spot)) = (self.members.get(at), self.spots.get(at)) else {
            return false;
        };
        let taken = |step: u8| Some(u32::from(step)).filter(|step| *step != NO_STEP);
        let known = Known {
            position: member.position,
            step: taken(member.step),
            step_to_goal: taken(member.step_to_goal),
            // It was free when it was closed, whatever came since.
            price: field.prices.at(*spot).min(BLOCKED - 1),
        };
        let place = Place {
            spot: *spot,
            so_far: member.so_far,
            end: member.position + member.size,
            goal_end: member.goal_position.saturating_add(member.goal_size),
        };
        let costs = (member.total, member.goal_position);
        self.forest.put(known, costs, place);
        true
    }

    pub(super) fn bytes(&self) -> usize {
        self.forest.bytes()
            + self.members.capacity() * size_of::<Member>()
            + self.weighed.capacity() * size_of::<u32>()
            + self.lists.open.bytes()
            + (self.lists.closed.capacity() + self.spots.capacity()) * size_of::<Spot>()
    }
}
