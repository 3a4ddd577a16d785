//! A way round what cuts the path, found at once.
//!
//! A search from the robot under the guidance of the field expands every cell from which a way as
//! cheap as the way round leads on: near the robot, too, long before the cut. With the field weighted
//! it runs down the previous way to the cut, looks for a way past it there, and turns to what lies
//! farther back only when that is dear. The way costs at most so many times the least as the weight
//! says (Pohl, "Heuristic Search Viewed as Path Finding in a Graph", Artificial Intelligence 1,
//! 1970).

use super::detours::Detour;
use super::run::FIELD_WEIGHTED;
use super::{GoalField, Guide};
use crate::planner::{Control, Expansions, PlanStats};
use crate::search::Found;
use zeronav_msgs::Cell;

/// Weight times four.
const QUARTERS: u32 = 8;

/// Expansions of the search for the cheapest way, some 0.4 ms.
const EXACT_MAX: u64 = 6144;

/// Expansions of the weighted search, some 0.6 ms.
const WEIGHTED_MAX: u64 = 8192;

impl GoalField {
    /// Searches a way round from `start` to `goal`, both free; to be traced when there is one. Adds to
    /// the counters of `stats`.
    pub(crate) fn search_around(
        &mut self,
        ends: (Cell, Cell),
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Option<Detour> {
        if !self.is_whole_for(ends.1) {
            return None;
        }
        // Where the cut is near, the cheapest way takes no longer.
        match self.search(ends, Guide::Field, EXACT_MAX, budget, stats) {
            Found::Path => {
                let cost = self.cost_of(ends.1);
                Some(Detour { cost, least: cost })
            }
            Found::Stopped => self.search_weighted(ends, budget, stats),
            Found::Nothing => None,
        }
    }

    fn search_weighted(
        &mut self,
        (start, goal): (Cell, Cell),
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Option<Detour> {
        self.next_generation();
        let ends = (self.spot(start), self.spot(goal));
        let mut open = core::mem::take(&mut self.open_around);
        let mut closed = core::mem::take(&mut self.lists.closed);
        let mut run = self.run(&mut open, &mut closed, ends.1);
        run.quarters = QUARTERS;
        run.last = stats.expanded.saturating_add(WEIGHTED_MAX);
        let found = run.search::<FIELD_WEIGHTED>(ends.0, u32::MAX, budget, stats);
        stats.generated += run.generated;
        stats.peak_open = stats.peak_open.max(open.peak());
        // Costs so far need not be the least: they teach the field nothing.
        closed.clear();
        (self.open_around, self.lists.closed) = (open, closed);
        if found != Found::Path {
            return None;
        }
        let cost = self.cost_of(goal);
        let least = if self.eased_box.is_empty() {
            let left = self.left.at(ends.0).min(self.reach);
            left.max(cost / QUARTERS * 4).min(cost)
        } else {
            0
        };
        Some(Detour { cost, least })
    }
}

#[cfg(test)]
mod tests {
    use super::super::prices::BLOCKED;
    use super::*;
    use crate::moves::{STEPS, STRAIGHT};
    use crate::planner::{CornerRule, Unknown};
    use crate::test_map::{Draw, FREE, GEOMETRY, view};
    use zeronav_msgs::CellRect;
    use zeronav_msgs::map::COST_LETHAL;

    /// What the way found costs by the prices of the map, each of its steps being legal.
    fn cost_along(field: &GoalField, cells: &[Cell]) -> u32 {
        let steps = cells.windows(2).map(|pair| {
            let by = (pair[1].x - pair[0].x, pair[1].y - pair[0].y);
            let step = STEPS.iter().position(|step| *step == by).unwrap();
            let (_, around) = field.prices.around(field.spot(pair[0]));
            assert!(field.corner_permits(around, u32::try_from(step).unwrap()));
            let price = field.prices.at(field.spot(pair[1]));
            assert_ne!(price, BLOCKED);
            field.steps[step & 1][usize::from(price)]
        });
        steps.sum()
    }

    #[test]
    fn a_weighted_search_finds_a_legal_way_of_bounded_cost() {
        let go = &mut |_| Control::Go;
        let (mut n_found, mut n_dearer) = (0, 0);
        for seed in 0..300 {
            let mut draw = Draw(seed);
            let mut cells = vec![FREE; GEOMETRY.len()];
            let [goal, start] = [(); 2].map(|()| Cell::new(draw.coordinate(), draw.coordinate()));
            let mut field = GoalField::new(3.0);
            field.margin = 10 * STRAIGHT;
            field.follow(&view(&cells), Unknown::Free, CornerRule::ForbidAny);
            field.change(&view(&cells), &[], |_| {});
            while field.improve(Some(start), goal, 1000, |_, _| true) {}
            for _ in 0..8 {
                let min = Cell::new(draw.coordinate(), draw.coordinate());
                let size = 1 + i32::try_from(draw.below(12)).unwrap();
                let max = Cell::new(min.x + size, min.y + 2 + size / 4);
                let rect = CellRect { min, max }.grown(0, &GEOMETRY);
                for y in rect.min.y..rect.max.y {
                    for x in rect.min.x..rect.max.x {
                        cells[GEOMETRY.index_of(Cell::new(x, y)).unwrap()].cost =
                            [COST_LETHAL, 120][usize::try_from(seed % 2).unwrap()];
                    }
                }
                field.change(&view(&cells), &[rect], |_| {});
            }
            let free = |cell: Cell| field.prices.at(field.spot(cell)) != BLOCKED;
            if start == goal || !free(start) || !free(goal) {
                continue;
            }
            let stats = &mut PlanStats::default();
            let around = field.search_weighted((start, goal), go, stats);
            let mut way = Vec::new();
            if around.is_some() {
                field.trace(goal, &mut way);
            }
            let found = field.search((start, goal), Guide::Octile, u64::MAX, go, stats);
            assert_eq!(around.is_some(), found == Found::Path, "seed {seed}");
            let Some(Detour { cost, least }) = around else {
                continue;
            };
            let best = field.cost_of(goal);
            assert_eq!((way.first(), way.last()), (Some(&start), Some(&goal)));
            assert_eq!(cost_along(&field, &way), cost, "seed {seed}");
            assert!(
                least <= best && best <= cost,
                "seed {seed}: {least}, {best}, {cost}"
            );
            assert!(cost <= best * QUARTERS / 4, "seed {seed}: {cost} of {best}");
            n_found += 1;
            n_dearer += u32::from(cost > best);
        }
        assert!(n_found > 200 && n_dearer > 10, "{n_found}, {n_dearer}");
    }
}
