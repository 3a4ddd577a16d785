//! Makes the field exact again where ways became dearer, while no answer is due.
//!
//! Ramalingam, Reps, "On the Computational Complexity of Dynamic Graph Problems", Theoretical
//! Computer Science 158, 1996: first the cells that have lost every cheapest way, in order of what
//! was left from them; then what is left now, from the cells around them inwards. Takes time for
//! the cells whose bound changes, not for the map.
//!
//! At any moment every bound is a lower bound, and they are consistent: new ones are written
//! together.

use super::GoalField;
use super::node::{NO_WAY, Spot};
use super::prices::{BLOCKED, is_blocked};
use super::raise_state::{item, parts};

impl GoalField {
    /// Work of about `expansions` expansions; true when more is left.
    pub(super) fn raise(&mut self, expansions: u64) -> bool {
        let mut left = expansions;
        let cost_decreased = core::mem::take(&mut self.raise.cost_decreased);
        if cost_decreased && self.raise.offered.is_some() {
            self.suspect_all_lost();
        }
        while left > 0 {
            left -= 1;
            // What rises while bounds are found for the lost cells waits: those found are then too
            // low, but bounds all the same.
            let next = if self.raise.offered.is_none() {
                self.raise.to_check.pop()
            } else {
                None
            };
            if let Some(spot) = next {
                self.suspect(spot);
                for offset in self.offsets {
                    self.suspect(spot.wrapping_add(offset));
                }
            } else if let Some(suspect) = self.raise.suspects.pop() {
                let (_, spot) = parts(suspect);
                self.raise.suspected.remove(spot);
                if !self.is_supported(spot) {
                    self.lose(spot);
                }
            } else if let Some(spot) = self.next_to_offer() {
                self.offer_least(spot);
            } else if let Some(best) = self.raise.front.pop() {
                let (left, spot) = parts(best);
                if self.raise.is_lost.has(spot) {
                    self.settle(spot, left);
                }
            } else {
                self.commit();
                if self.raise.is_idle() {
                    return false;
                }
            }
        }
        true
    }

    fn suspect(&mut self, spot: Spot) {
        let Some(left) = self.left.get(spot) else {
            return;
        };
        if left != NO_WAY
            && spot != self.goal
            && !self.raise.is_lost.has(spot)
            && self.raise.suspected.add(spot)
        {
            self.raise.suspects.push(item(left, spot));
        }
    }

    /// Something became cheaper while bounds were found for the lost cells: all are judged again.
    fn suspect_all_lost(&mut self) {
        self.raise.front.clear();
        self.raise.found.clear();
        self.raise.offered = None;
        let mut lost = core::mem::take(&mut self.raise.lost);
        for spot in lost.drain(..) {
            self.raise.is_lost.remove(spot);
            self.suspect(spot);
        }
        self.raise.lost = lost;
    }

    /// True when a step leads from `spot` to a cell from which so much is left that the bound of
    /// `spot` is what its way costs.
    fn is_supported(&self, spot: Spot) -> bool {
        let (own, around) = self.prices.around(spot);
        let left = self.left.at(spot);
        own != BLOCKED
            && (0_u32..).zip(self.offsets).any(|(step, offset)| {
                let to = spot.wrapping_add(offset);
                !is_blocked(around, step)
                    && self.corner_permits(around, step)
                    && !self.raise.is_lost.has(to)
                    && self.over(step, to) <= left
            })
    }

    /// What is left from the cell before a step to `to`, by the bound of `to`.
    #[inline]
    pub(super) fn over(&self, step: u32, to: Spot) -> u32 {
        let price = usize::from(self.prices.at(to));
        self.left
            .at(to)
            .saturating_add(self.steps[step as usize & 1][price])
    }

    fn lose(&mut self, spot: Spot) {
        self.raise.is_lost.add(spot);
        self.raise.lost.push(spot);
        // All that may have rested on it: also where a step is not legal any more.
        let left = self.left.at(spot);
        for offset in self.offsets {
            let from = spot.wrapping_add(offset);
            if self.left.get(from).is_some_and(|other| other > left) {
                self.suspect(from);
            }
        }
    }

    fn next_to_offer(&mut self) -> Option<Spot> {
        let offered = self.raise.offered.get_or_insert(0);
        let spot = self.raise.lost.get(*offered).copied()?;
        *offered += 1;
        Some(spot)
    }

    /// Opens `spot` with the least that its neighbours allow.
    fn offer_least(&mut self, spot: Spot) {
        let (own, around) = self.prices.around(spot);
        if own == BLOCKED {
            return;
        }
        let mut least = NO_WAY;
        for (step, offset) in (0_u32..).zip(self.offsets) {
            let to = spot.wrapping_add(offset);
            if !is_blocked(around, step)
                && self.corner_permits(around, step)
                && !self.raise.is_lost.has(to)
            {
                least = least.min(self.over(step, to));
            }
        }
        if least != NO_WAY {
            self.raise.front.push(item(least, spot));
        }
    }

    fn settle(&mut self, spot: Spot, left: u32) {
        self.raise.is_lost.remove(spot);
        self.raise.found.push((spot, left));
        let (own, around) = self.prices.around(spot);
        let costs = self.steps.each_ref().map(|steps| steps[usize::from(own)]);
        for (step, offset) in (0_u32..).zip(self.offsets) {
            let from = spot.wrapping_add(offset);
            if !is_blocked(around, step)
                && self.corner_permits(around, step)
                && self.raise.is_lost.has(from)
            {
                let left = left.saturating_add(costs[step as usize & 1]);
                self.raise.front.push(item(left, from));
            }
        }
    }

    /// Writes the bounds that were found, and that no way leads from the other lost cells. All at
    /// once: in between a neighbour's could be lower by more than the step costs, and a search would
    /// close cells again and again.
    fn commit(&mut self) {
        for (spot, left) in self.raise.found.drain(..) {
            self.left.set(spot, left.max(self.left.at(spot)));
        }
        for spot in self.raise.lost.drain(..) {
            if self.raise.is_lost.has(spot) {
                self.raise.is_lost.remove(spot);
                self.left.set(spot, NO_WAY);
            }
        }
        self.raise.offered = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Changed, State};
    use super::*;
    use crate::moves::STRAIGHT;
    use crate::planner::{CornerRule, Unknown};
    use crate::test_map::{Draw, FREE, SIDE, view};
    use zeronav_msgs::map::COST_LETHAL;
    use zeronav_msgs::{Cell, CellRect, MapCell};

    fn edit(cells: &mut [MapCell], draw: &mut Draw) -> CellRect {
        let (x, y) = (draw.below(u64::from(SIDE)), draw.below(u64::from(SIDE)));
        let (w, h) = (1 + draw.below(6), 1 + draw.below(6));
        let kind = draw.below(3);
        let (last_x, last_y) = (u64::from(SIDE).min(x + w), u64::from(SIDE).min(y + h));
        for y in y..last_y {
            for x in x..last_x {
                let cost = match kind {
                    0 => COST_LETHAL,
                    1 => 0,
                    _ => u8::try_from(draw.below(200)).unwrap(),
                };
                let at = usize::try_from(y * u64::from(SIDE) + x).unwrap();
                cells[at].cost = cost;
                cells[at].clearance_mm = if cost == COST_LETHAL { 0 } else { 1000 };
            }
        }
        let cell = |x: u64, y: u64| Cell::new(i32::try_from(x).unwrap(), i32::try_from(y).unwrap());
        CellRect {
            min: cell(x, y),
            max: cell(last_x, last_y),
        }
    }

    /// After any edits and searches, in slices of any size: what is left is what a search from the
    /// goal finds on the map as it is.
    #[test]
    fn work_ahead_makes_the_field_exact_again() {
        let rules = [
            CornerRule::Allow,
            CornerRule::ForbidAny,
            CornerRule::ForbidBoth,
        ];
        let (mut n_exact, mut n_beyond, mut n_searches) = (0, 0, 0);
        for seed in 0..60_u64 {
            let mut draw = Draw(seed);
            let rule = rules[usize::try_from(seed % 3).unwrap()];
            let mut cells = vec![FREE; (SIDE * SIDE) as usize];
            let goal = Cell::new(20, 20);
            let mut field = GoalField::new(3.0);
            // Half of the fields end before the map does.
            if seed % 2 == 0 {
                field.margin = 10 * STRAIGHT;
            }
            field.follow(&view(&cells), Unknown::Free, rule);
            let mut robot = Cell::new(0, 0);
            for _ in 0..40 {
                let rect = edit(&mut cells, &mut draw);
                let _: Changed = field.change(&view(&cells), &[rect], |_| {});
                field.follow(&view(&cells), Unknown::Free, rule);
                for _ in 0..draw.below(3) {
                    field.improve(Some(robot), goal, 1 + draw.below(300), |_, _| true);
                }
                if draw.below(3) > 0 {
                    continue;
                }
                robot = Cell::new(draw.coordinate(), draw.coordinate());
                let at = field.spot(robot);
                if field.is_whole_for(goal) && field.prices.at(at) != BLOCKED {
                    let stats = &mut crate::planner::PlanStats::default();
                    let go = &mut |_| crate::planner::Control::Go;
                    let guide = super::super::Guide::Field;
                    let found = field.search((robot, goal), guide, u64::MAX, go, stats);
                    let cost = field.cost_of(goal);
                    let mut other = GoalField::new(3.0);
                    other.follow(&view(&cells), Unknown::Free, rule);
                    let guide = super::super::Guide::Octile;
                    let by_octile = other.search((robot, goal), guide, u64::MAX, go, stats);
                    assert_eq!(found, by_octile, "seed {seed}");
                    if found == crate::search::Found::Path {
                        assert_eq!(cost, other.cost_of(goal), "seed {seed}");
                        n_searches += 1;
                    }
                }
                while field.improve(Some(robot), goal, 1 + draw.below(500), |_, _| true) {}
                let mut fresh = GoalField::new(3.0);
                fresh.follow(&view(&cells), Unknown::Free, rule);
                while fresh.improve(None, goal, 10_000, |_, _| true) {}
                assert_eq!((field.state, fresh.state), (State::Whole, State::Whole));
                assert!(field.is_exact(), "seed {seed}");
                assert_eq!(fresh.reach, NO_WAY);
                if ![at, field.goal]
                    .map(|end| field.prices.at(end))
                    .contains(&BLOCKED)
                {
                    let beyond = field.left.at(at).saturating_add(field.margin / 4);
                    assert!(field.reach >= beyond, "seed {seed}");
                }
                for spot in 0..Spot::try_from(field.nodes.len()).unwrap() {
                    if field.prices.at(spot) == BLOCKED {
                        continue;
                    }
                    let [kept, anew] = [&field, &fresh].map(|of| of.left.at(spot).min(field.reach));
                    assert_eq!(kept, anew, "seed {seed}, spot {spot}, {rule:?}");
                    n_exact += 1;
                    n_beyond += u32::from(field.reach != NO_WAY && kept == field.reach);
                }
            }
        }
        assert!(n_exact > 100_000, "{n_exact}");
        assert!(n_beyond > 10_000, "{n_beyond}");
        assert!(n_searches > 200, "{n_searches}");
    }
}
