//! What changes cut off, against a walk along every way.

use super::*;
use crate::planner::{CornerRule, Unknown};
use crate::test_map::{Draw, FREE, GEOMETRY, view};
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::{CellRect, MapCell};

/// Makes cells of a rectangle dearer, or lethal.
fn raise(cells: &mut [MapCell], draw: &mut Draw) -> CellRect {
    let min = Cell::new(draw.coordinate(), draw.coordinate());
    let size = 1 + i32::try_from(draw.below(6)).unwrap();
    let cost = [COST_LETHAL, 100][usize::try_from(draw.below(2)).unwrap()];
    raise_to(cells, min, size, cost)
}

fn raise_to(cells: &mut [MapCell], min: Cell, size: i32, cost: u8) -> CellRect {
    let max = Cell::new(min.x + size, min.y + size);
    let rect = CellRect { min, max }.grown(0, &GEOMETRY);
    for y in rect.min.y..rect.max.y {
        for x in rect.min.x..rect.max.x {
            let cell = &mut cells[GEOMETRY.index_of(Cell::new(x, y)).unwrap()];
            cell.cost = cell.cost.max(cost);
        }
    }
    rect
}

/// True when the step may be taken still.
fn is_open(field: &GoalField, from: Spot, step: u32) -> bool {
    let (_, around) = field.prices.around(from);
    !is_blocked(around, step) && field.corner_permits(around, step)
}

fn holds(intervals: &[positions::Interval], position: u32) -> bool {
    (intervals.iter()).any(|(first, end)| (*first..*end).contains(&position))
}

/// Holds the cuts against both ways of each cell; gives how many are cut.
fn check(field: &GoalField, detours: &mut Detours, cutting: Cutting) -> usize {
    let Detours {
        cuts,
        ready,
        cost_increased,
        ..
    } = detours;
    cuts.set(ready, field, cost_increased, cutting);
    let is_free = |spot: Spot| {
        let (then, now) = (ready.known(spot).unwrap().price, field.prices.at(spot));
        now != BLOCKED && (cutting == Cutting::Blocked || now <= then)
    };
    let spots = 0..Spot::try_from(field.nodes.len()).unwrap();
    let mut n_cut = 0;
    for (spot, known) in spots.filter_map(|spot| Some((spot, ready.known(spot)?))) {
        let (mut at, mut is_whole) = (spot, is_free(spot));
        while let Some(parent) = ready.known(at).unwrap().parent(field, at) {
            let step = ready.known(at).unwrap().step.unwrap();
            is_whole &= is_free(parent) && is_open(field, parent, step);
            at = parent;
        }
        assert_eq!(at, ready.root());
        assert_eq!(holds(cuts.forward(), known.position), !is_whole);
        n_cut += usize::from(!is_whole);
        let Some((to_goal, _)) = ready.below_to_goal(known.position) else {
            continue;
        };
        (at, is_whole) = (spot, is_free(spot));
        while let Some(step) = ready.known(at).unwrap().step_to_goal {
            let next = at.wrapping_add(field.offsets[step as usize]);
            is_whole &= is_free(next) && is_open(field, at, step);
            at = next;
        }
        assert_eq!(at, field.goal);
        assert_eq!(cuts.to_goal().holds(to_goal), !is_whole);
        n_cut += usize::from(!is_whole);
    }
    n_cut
}

#[test]
fn what_changes_cut_off_is_every_way_that_leads_over_them() {
    let rules = [
        CornerRule::Allow,
        CornerRule::ForbidAny,
        CornerRule::ForbidBoth,
    ];
    let mut n_cut = [0; 2];
    for seed in 0..60 {
        let mut draw = Draw(seed);
        let rule = rules[usize::try_from(seed % 3).unwrap()];
        let mut cells = vec![FREE; GEOMETRY.len()];
        for _ in 0..25 {
            raise(&mut cells, &mut draw);
        }
        let [goal, start] = [(); 2].map(|()| Cell::new(draw.coordinate(), draw.coordinate()));
        let mut detours = Detours::default();
        let mut field = GoalField::new(3.0);
        field.follow(&view(&cells), Unknown::Free, rule);
        let _: Changed = field.change(&view(&cells), &[], |_| {});
        while field.improve(Some(start), goal, 1000, |_, _| true) {}
        while detours.prepare(&mut field, start, 1000) {}
        if !detours.ready.is_for(&field) {
            continue;
        }
        for n in 0..5 {
            let rect = if n < 4 {
                raise(&mut cells, &mut draw)
            } else {
                // An end is buried.
                let end = [start, goal][usize::try_from(draw.below(2)).unwrap()];
                raise_to(&mut cells, Cell::new(end.x - 2, end.y - 2), 5, COST_LETHAL)
            };
            let changed = field.change(&view(&cells), &[rect], |spot| detours.note(spot));
            detours.note_update(changed);
            for (n, cutting) in [Cutting::Blocked, Cutting::Dearer].into_iter().enumerate() {
                n_cut[n] += check(&field, &mut detours, cutting);
            }
        }
    }
    assert!(n_cut.iter().all(|n| *n > 5000), "{n_cut:?}");
}
