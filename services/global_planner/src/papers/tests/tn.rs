//! TN-REG, TN-SW, TN-APF, TN-3N, TN-HYB.

use super::generate::{blocky, corners, iid};
use super::{assert_close, assert_legal, count, plain, plan, plan_with};
use crate::papers::on_map::OnMap;
use crate::papers::tn_3n::{Memory, Rotate};
use crate::papers::tn_hyb::{Mode, TnHyb, tn_hyb};
use crate::support::Map;
use crate::{CornerRule, Fallback, PlanError, PlannerOptions};
use zeronav_msgs::map::FLAG_REGULARISED;
use zeronav_msgs::{Cell, CellRect};
use zeronav_observe::statistics::median;

const RULE: CornerRule = CornerRule::ForbidAny;

/// The method alone.
fn without_ladder() -> PlannerOptions {
    let mut options = plain();
    options.papers.walk.ladder = false;
    options
}

/// The hybrid as the table builds it.
fn hybrid_planner(options: &PlannerOptions) -> OnMap<TnHyb> {
    let papers = &options.papers;
    OnMap::new(tn_hyb(papers.walk, papers.literal), options.map())
}

/// Plans from S to G with the hybrid; the planner shows what it did.
fn hybrid(text: &str, options: &PlannerOptions) -> (OnMap<TnHyb>, Result<f64, PlanError>) {
    let (map, at) = Map::drawn(text);
    let mut planner = hybrid_planner(options);
    let result = plan_with(&mut planner, &map, RULE, (at('S'), at('G')));
    (planner, result.map(|found| found.cost))
}

fn rect(min: (i32, i32), max: (i32, i32)) -> CellRect {
    CellRect {
        min: Cell::new(min.0, min.1),
        max: Cell::new(max.0, max.1),
    }
}

#[test]
fn tn_reg_a_u_on_the_line_becomes_its_rectangle() {
    let (planner, result) = hybrid(
        "............
         ....###.....
         S.....#....G
         ....###.....
         ............",
        &without_ladder(),
    );
    assert!(result.is_ok());
    let regions = planner.solver.regions();
    assert_eq!(regions.rectangles(), [rect((4, 1), (7, 4))]);
    // The pocket, and nothing else.
    let filled: Vec<_> = (0_usize..)
        .zip(regions.walls())
        .filter_map(|(index, wall)| wall.then_some((index % 12, index / 12)))
        .collect();
    assert_eq!(filled, [(4, 2), (5, 2)]);
}

#[test]
fn tn_reg_a_u_off_the_line_stays() {
    let (planner, result) = hybrid(
        "....###.....
         ......#.....
         ....###.....
         ............
         S..........G",
        &without_ladder(),
    );
    assert_close(result.unwrap(), 11.0, 1e-12, "straight");
    assert!(planner.solver.regions().rectangles().is_empty());
    assert!(!planner.solver.regions().walls().contains(&true));
}

#[test]
fn tn_reg_a_u_around_the_start_is_skipped() {
    let text = "............
                ....###.....
                ....S.#....G
                ....###.....
                ............";
    let (map, at) = Map::drawn(text);
    let mut planner = hybrid_planner(&without_ladder());
    for _ in 0..2 {
        let found = plan_with(&mut planner, &map, RULE, (at('S'), at('G'))).unwrap();
        assert_eq!(found.stats().remarks.rectangles, 0);
        assert!(found.stats().remarks.rectangles_skipped > 0);
        assert!(!planner.solver.regions().walls().contains(&true));
    }
}

#[test]
fn tn_reg_diagonal_cells_are_one_obstacle_and_large_ones_are_left() {
    // The paper's example: from (1, 1) to (6, 6) the line meets (4, 4).
    let text = "........
                ......G.
                ...##...
                ...##...
                ..#.....
                ........
                .S......
                ........";
    let (planner, result) = hybrid(text, &without_ladder());
    assert!(result.is_ok());
    let rectangles = planner.solver.regions().rectangles();
    assert_eq!(rectangles, [rect((2, 3), (5, 6))]);
    let mut small = without_ladder();
    small.papers.walk.rectangle_share_max = 0.1;
    let (planner, result) = hybrid(text, &small);
    assert!(result.is_ok());
    assert!(planner.solver.regions().rectangles().is_empty());
}

#[test]
fn tn_sw_a_block_is_walked_around_between_two_straight_lines() {
    let (planner, result) = hybrid(
        "................
         ................
         .......##.......
         S......##......G
         .......##.......
         ................
         ................",
        &without_ladder(),
    );
    assert!(result.is_ok());
    let mut modes = planner.solver.modes().to_vec();
    modes.dedup();
    let (straight, walk) = (Mode::Attraction, Mode::ThreeNeighbours);
    assert_eq!(modes, [straight, walk, straight]);
}

#[test]
fn tn_apf_a_visible_goal_is_reached_in_a_straight_line() {
    let map = Map::free(20, 20);
    let ends = (Cell::new(1, 2), Cell::new(18, 11));
    let found = plan("tn_apf", &plain(), &map, RULE, ends).unwrap();
    assert_close(found.cost, 17_f64.hypot(9.0), 1e-9, "straight");
    let hybrid = plan("tn_hyb", &plain(), &map, RULE, ends).unwrap();
    assert_close(hybrid.cost, found.cost, 1e-9, "the hybrid sees it too");
    // Steps along the force m1 (target - position), m1 = 5, stay on that line.
    let (mut x, mut y, mut length) = (1.0_f64, 2.0_f64, 0.0);
    loop {
        let force = (5.0 * (18.0 - x), 5.0 * (11.0 - y));
        let norm = force.0.hypot(force.1);
        let step = 0.5_f64.min(norm / 5.0);
        if step < 1e-12 {
            break;
        }
        (x, y) = (x + step * force.0 / norm, y + step * force.1 / norm);
        length += step;
        assert_close(
            (x - 1.0) * 9.0 - (y - 2.0) * 17.0,
            0.0,
            1e-9,
            "off the line",
        );
    }
    assert_close(length, found.cost, 1e-9, "length");
}

#[test]
fn tn_apf_gives_up_at_an_obstacle_and_proves_an_enclosure() {
    let (map, at) = Map::drawn("...\nS#G\n...");
    let result = plan("tn_apf", &plain(), &map, RULE, (at('S'), at('G')));
    assert_eq!(result.map(|found| found.cost), Err(PlanError::DeadEnd));
    let (map, at) = Map::drawn(".#.\nS#G\n.#.");
    let result = plan("tn_apf", &plain(), &map, RULE, (at('S'), at('G')));
    let blocked_by_corner = false;
    assert_eq!(
        result.map(|found| found.cost),
        Err(PlanError::Unreachable { blocked_by_corner })
    );
}

#[test]
fn tn_3n_looks_at_9_cells_where_a_star_looks_at_24() {
    // Figs. 4 and 5 of the paper: from (3, 2) three cells straight up.
    let map = Map::free(7, 7);
    let ends = (Cell::new(3, 2), Cell::new(3, 5));
    let walk = plan("tn_3n", &plain(), &map, RULE, ends).unwrap();
    let astar = plan("tn_a8", &plain(), &map, RULE, ends).unwrap();
    assert_eq!(walk.stats().evaluated, 9);
    assert_eq!(astar.stats().evaluated, 24);
    let straight: Vec<_> = (2..=5).map(|y| Cell::new(3, y)).collect();
    assert_eq!(walk.path.cells, straight);
}

#[test]
fn tn_3n_turns_counter_clockwise_or_as_told() {
    // Going right, the wall is passed above when turning to the left.
    let (map, at) = Map::drawn(
        ".........
         ....#....
         ....#....
         S...#...G
         ....#....
         ....#....
         .........",
    );
    let ends = (at('S'), at('G'));
    let highest = |rotate| {
        let mut options = plain();
        options.papers.walk.rotate = rotate;
        let found = plan("tn_3n", &options, &map, RULE, ends).unwrap();
        found.path.cells.iter().any(|cell| *cell == Cell::new(4, 6))
    };
    assert!(highest(Rotate::Ccw));
    assert!(!highest(Rotate::Cw));
}

#[test]
fn tn_3n_finds_the_gap_in_a_wall_on_its_right() {
    let (map, at) = Map::drawn(
        ".....G...
         .........
         #######..
         .........
         .....S...",
    );
    for keep_heading in [false, true] {
        let mut options = plain();
        options.papers.walk.keep_heading = keep_heading;
        let found = plan("tn_3n", &options, &map, RULE, (at('S'), at('G'))).unwrap();
        let through = |cell: &Cell| cell.y == 2 && cell.x >= 7;
        assert!(found.path.cells.iter().any(through), "keeps {keep_heading}");
    }
}

/// A pocket that is open on the side of the start.
const U_TRAP: &str = "............
                      ...######...
                      ........#...
                      S.......#..G
                      ........#...
                      ...######...
                      ............";

/// The three readings of "grids that have been searched": a walk without a memory turns to and fro in the
/// pocket, one that enters no cell twice (the text) finds the way out, and so does one that goes back.
#[test]
fn tn_3n_leaves_a_pocket_with_a_memory_only() {
    let (map, at) = Map::drawn(U_TRAP);
    let ends = (at('S'), at('G'));
    let cost = |memory, literal| {
        let mut options = plain();
        options.papers.literal = literal;
        options.papers.walk.memory = memory;
        plan("tn_3n", &options, &map, RULE, ends).map(|found| found.cost)
    };
    assert_eq!(cost(Memory::None, false), Err(PlanError::DeadEnd));
    let visited = cost(Memory::Visited, false).unwrap();
    assert!(visited >= 13.0, "{visited}");
    assert!(cost(Memory::Backtracking, false).unwrap() >= 13.0);
    assert_eq!(cost(Memory::Backtracking, true), Ok(visited), "literally");
}

/// A switch from one mode to the other happens where a line meets an obstacle and where the walk leaves its
/// area: not again and again along the same side of it.
#[test]
fn tn_sw_switches_at_most_twice_at_an_area() {
    let (mut switches, mut areas) = (0, 0);
    for seed in 0..200 {
        let map = blocky(30, 30, 10, seed);
        let (from, to) = corners(&map);
        let mut planner = hybrid_planner(&without_ladder());
        let Ok(found) = plan_with(&mut planner, &map, RULE, (from, to)) else {
            continue;
        };
        let own = planner.solver.modes();
        let changes = own.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let skipped = usize::try_from(found.stats().remarks.rectangles_skipped).unwrap();
        let met = planner.solver.regions().rectangles().len() + skipped;
        // In to and out of every area that was met, and on.
        assert!(changes <= 2 * met.max(1), "seed {seed}: {changes} at {met}");
        switches += changes;
        areas += met;
    }
    eprintln!("{switches} switches at {areas} areas");
    assert!(areas > 200, "{areas} areas: the maps tell nothing");
}

/// Maps of 200 that the hybrid solves without its ladder, and the mean of the lengths of a reading as
/// shares of the shortest.
fn solved_by(memory: Memory) -> (u32, f64) {
    let mut options = without_ladder();
    options.papers.walk.memory = memory;
    let (mut solved, mut length) = (0, 0.0);
    for seed in 0..200 {
        let map = blocky(20, 20, 25, seed);
        let Ok(astar) = plan("tn_a8", &plain(), &map, RULE, corners(&map)) else {
            continue;
        };
        if let Ok(found) = plan("tn_hyb", &options, &map, RULE, corners(&map)) {
            assert_legal(&found, &map, RULE, &format!("{memory:?} {seed}"));
            solved += 1;
            length += found.cost / astar.cost;
        }
    }
    (solved, length / f64::from(solved))
}

/// Without a memory the walk turns in circles, with one it dies in pockets, and going back it solves
/// nearly everything, on longer and longer ways.
#[test]
fn tn_3n_readings_solve_more_the_more_they_remember() {
    let [none, visited, back] =
        [Memory::None, Memory::Visited, Memory::Backtracking].map(solved_by);
    eprintln!("memoryless {none:?}, visited {visited:?}, backtracking {back:?}");
    assert!(none.0 + 20 < visited.0 && visited.0 + 10 < back.0);
    assert!(none.1 < visited.1 && visited.1 < back.1);
    // Literal mode is the text: visited, and nothing about going back.
    let mut literal = without_ladder();
    literal.papers.literal = true;
    assert_eq!(Memory::read(&literal.papers.walk, true), Memory::Visited);
    literal.papers.walk.memory = Memory::None;
    assert_eq!(Memory::read(&literal.papers.walk, true), Memory::None);
}

#[test]
fn tn_3n_a_closed_box_is_unreachable() {
    let (map, at) = Map::drawn(
        "........
         ....####
         S...#.G#
         ....####
         ........",
    );
    let blocked_by_corner = false;
    for key in ["tn_3n", "tn_hyb"] {
        let result = plan(key, &plain(), &map, RULE, (at('S'), at('G')));
        assert_eq!(
            result.map(|found| found.cost),
            Err(PlanError::Unreachable { blocked_by_corner })
        );
    }
}

#[test]
fn tn_hyb_the_walls_of_a_room_are_no_rectangle() {
    // One obstacle, whose rectangle is the whole map with both ends in it.
    let (map, at) = Map::drawn(
        "#########
         #...#...#
         #S..#..G#
         #...#...#
         #...#...#
         #.......#
         #########",
    );
    let mut options = without_ladder();
    options.papers.walk.rectangle_share_max = 1.0;
    let found = plan("tn_hyb", &options, &map, RULE, (at('S'), at('G'))).unwrap();
    assert_eq!(found.stats().remarks.rectangles, 0);
    assert_eq!(found.stats().remarks.rectangles_skipped, 1);
}

#[test]
fn tn_hyb_without_a_memory_walks_in_circles_until_a_star_steps_in() {
    let mut options = plain();
    options.papers.walk.memory = Memory::None;
    let (mut rescued, mut from_start) = (0, 0);
    for seed in 0..60 {
        let map = iid(20, 20, 30, seed);
        let Ok(found) = plan("tn_hyb", &options, &map, RULE, corners(&map)) else {
            continue;
        };
        assert_legal(&found, &map, RULE, &format!("seed {seed}"));
        rescued += u32::from(found.stats().remarks.fallback == Fallback::AstarFromHere);
        from_start += u32::from(found.stats().remarks.fallback == Fallback::Astar);
    }
    // A walk that has no memory can end where it began, too.
    eprintln!("{rescued} from where the walk was, {from_start} from the start");
    assert!(rescued > 0);
}

#[test]
fn tn_hyb_climbs_its_ladder() {
    // The obstacle's rectangle reaches from edge to edge of the map.
    let (map, at) = Map::drawn(
        "...#......
         ...#......
         S..#...#.G
         ...##..#..
         ....####..
         ..........",
    );
    let ends = (at('S'), at('G'));
    let mut options = plain();
    options.papers.walk.rectangle_share_max = 1.0;
    let found = plan("tn_hyb", &options, &map, RULE, ends).unwrap();
    assert_eq!(found.stats().remarks.fallback, Fallback::None);
    let (map, at) = Map::drawn(
        "...#......
         ...#......
         S..#...#.G
         ...##..#..
         ....####..
         .....#....
         ..#..#....
         ..##......",
    );
    let ends = (at('S'), at('G'));
    let found = plan("tn_hyb", &options, &map, RULE, ends).unwrap();
    assert_eq!(found.stats().remarks.fallback, Fallback::WithoutRectangles);
    options.papers.walk.ladder = false;
    let result = plan("tn_hyb", &options, &map, RULE, ends).map(|found| found.cost);
    assert_eq!(result, Err(PlanError::DeadEnd));
}

#[test]
fn tn_hyb_finds_a_way_wherever_a_star_does_on_600_maps() {
    let mut ratios = Vec::new();
    let (mut others, mut backtracked) = (0, 0);
    for percent in [15, 25, 35] {
        for seed in 0..200 {
            let map = if seed % 2 == 0 {
                blocky(20, 20, percent, seed)
            } else {
                iid(20, 20, percent, seed)
            };
            let what = format!("{percent} %, seed {seed}");
            let one = plan("tn_hyb", &plain(), &map, RULE, corners(&map));
            let other = plan("tn_a8", &plain(), &map, RULE, corners(&map));
            let (found, astar) = match (one, other) {
                (Ok(found), Ok(astar)) => (found, astar),
                (Err(one), Err(other)) => {
                    assert_eq!(one, other, "{what}");
                    continue;
                }
                _ => panic!("{what}: they disagree about whether there is a way"),
            };
            assert_legal(&found, &map, RULE, &what);
            let remarks = found.stats().remarks;
            if remarks.fallback == Fallback::None {
                let (walk, search) = (found.stats().evaluated, astar.stats().evaluated);
                ratios.push(count(walk) / count(search));
                backtracked += u32::from(remarks.turned_back > 0);
            } else {
                others += 1;
            }
        }
    }
    let n = u32::try_from(ratios.len()).unwrap();
    let dear = ratios.iter().filter(|ratio| **ratio >= 0.3).count();
    let ratio = median(ratios).unwrap();
    eprintln!(
        "{n} without the ladder ({backtracked} went back), {others} with, {dear} dear, {ratio}"
    );
    assert!(n > 250 && others > 30 && backtracked > 20);
    // Specified is less than 0.3 on every success; going back through a pocket costs more on 7 %.
    let share = count(dear as u64) / f64::from(n);
    assert!((0.03..0.11).contains(&share), "{dear} of {n} ratios");
    assert!(ratio > 0.01 && ratio < 0.1, "median ratio {ratio}");
}

#[test]
fn tn_3n_walks_around_what_mapping_regularised() {
    let (mut map, at) = Map::drawn(U_TRAP);
    let ends = (at('S'), at('G'));
    let inside = |cell: &Cell| (4..8).contains(&cell.x) && (2..5).contains(&cell.y);
    let walk = |map: &Map, key| plan(key, &plain(), map, RULE, ends).unwrap();
    let into = walk(&map, "tn_3n");
    assert!(into.path.cells.iter().any(inside), "the pocket");
    for y in 2..5 {
        for x in 3..8 {
            let mut cell = map.view().get(Cell::new(x, y)).unwrap();
            cell.flags |= FLAG_REGULARISED;
            map.put(Cell::new(x, y), cell);
        }
    }
    let around = walk(&map, "tn_3n");
    assert!(!around.path.cells.iter().any(inside));
    assert_eq!(around.stats().remarks.turned_back, 0);
    assert_eq!(around.stats().remarks.fallback, Fallback::None);
    // A planner whose row does not say so goes through.
    let (map, at) = flagged_line();
    let ends = (at('S'), at('G'));
    let astar = plan("tn_a8", &plain(), &map, RULE, ends).unwrap();
    assert_close(astar.cost, 4.0, 1e-12, "straight");
    // Where rectangles leave no way, the walk does without.
    let found = plan("tn_3n", &plain(), &map, RULE, ends).unwrap();
    assert_close(found.cost, 4.0, 1e-12, "straight");
    assert_eq!(found.stats().remarks.fallback, Fallback::WithoutRectangles);
}

/// A free corridor with a regularised cell in it.
fn flagged_line() -> (Map, impl Fn(char) -> Cell) {
    let (mut map, at) = Map::drawn("S...G");
    let mut cell = map.view().get(Cell::new(2, 0)).unwrap();
    cell.flags |= FLAG_REGULARISED;
    map.put(Cell::new(2, 0), cell);
    (map, at)
}
