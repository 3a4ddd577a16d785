//! No planner allocates once it has seen map and question.

mod support;

use support::Map;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, EXACT, PlanQuery, PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::{Cell, CellRect};

#[test]
fn a_question_asked_again_allocates_nothing() {
    let mut map = Map::office(600, 400, 11);
    let ends = (
        map.free_near(Cell::new(20, 20)),
        map.free_near(Cell::new(580, 380)),
    );
    let rect = CellRect {
        min: Cell::new(300, 200),
        max: Cell::new(310, 210),
    };
    for key in EXACT {
        let mut planner = (row_of(key).unwrap().build)(&PlannerOptions::default());
        let (width, height) = map.geometry.size();
        let whole = CellRect {
            min: Cell::new(0, 0),
            max: Cell::new(width, height),
        };
        planner.map_changed(&map.view(), &[whole]);
        let mut path = CellPath::default();
        let mut counted = [0; 16];
        for count in &mut counted {
            // A block comes and goes.
            let mut other = core::mem::take(&mut map.cells);
            for y in rect.min.y..rect.max.y {
                for x in rect.min.x..rect.max.x {
                    let cell = &mut other[map.geometry.index_of(Cell::new(x, y)).unwrap()];
                    cell.cost = if cell.cost == 254 { 0 } else { 254 };
                }
            }
            map.cells = other;
            let allocated = allocation_counter::measure(|| {
                planner.map_changed(&map.view(), &[rect]);
                let query = PlanQuery {
                    map: map.view(),
                    start: map.pose(ends.0),
                    goal: map.pose(ends.1),
                    tolerance_m: 0.1,
                    unknown: Unknown::Free,
                    corner_rule: CornerRule::ForbidAny,
                };
                planner
                    .plan(&query, &mut |_| Control::Go, &mut path)
                    .unwrap_or_else(|error| panic!("{key}: {error}"));
                while planner.prepare(&map.pose(ends.0), 10_000) {}
            });
            *count = allocated.count_total;
        }
        assert_eq!(counted[11..], [0; 5], "{key}: {counted:?}");
    }
}
