//! Local changes of the map: blocks of cells that appear near the robot, on its way, at its goal
//! or elsewhere, that close a door, or that vanish, and a wall around the goal.

use crate::support::{Map, Rng, of_cost};
use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL};
use zeronav_msgs::{Cell, CellRect, MapCell};

/// Inscribed radius and end of the inflation. [m]
pub(crate) const INSCRIBED_M: f64 = 0.2;
pub(crate) const INFLATION_M: f64 = 0.6;
pub(crate) const INFLATION_FACTOR: f64 = 4.0;

/// What happens to the map.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Block {
        at: Place,
        side: i32,
    },
    Door,
    Removal,
    /// No way is left.
    Sealed,
}

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Place {
    Near,
    Mid,
    Goal,
    Off,
}

/// Thickness of the wall around a sealed goal. [cells]
const WALL: i32 = 3;

pub(crate) const KINDS: [(&str, Kind); 11] = [
    ("near 10", block(Place::Near, 10)),
    ("near 40", block(Place::Near, 40)),
    ("mid 10", block(Place::Mid, 10)),
    ("mid 40", block(Place::Mid, 40)),
    ("goal 10", block(Place::Goal, 10)),
    ("goal 40", block(Place::Goal, 40)),
    ("off 10", block(Place::Off, 10)),
    ("off 40", block(Place::Off, 40)),
    ("door", Kind::Door),
    ("removal", Kind::Removal),
    ("sealed", Kind::Sealed),
];

const fn block(at: Place, side: i32) -> Kind {
    Kind::Block { at, side }
}

/// Where the block of an event lies; `None` where it would bury an end.
pub(crate) fn place(map: &Map, kind: Kind, way: &[Cell], rng: &mut Rng) -> Option<CellRect> {
    let (at, width, height) = match kind {
        Kind::Block { at, side } => {
            let near = usize::try_from(30 + side / 2).ok()?;
            let cell = match at {
                Place::Near => *way.get(near)?,
                Place::Mid => *way.get(way.len() / 2)?,
                Place::Goal => *way.get(way.len().checked_sub(near)?)?,
                Place::Off => {
                    let (w, h) = map.geometry.size();
                    map.free_near(Cell::new(rng.below(w), rng.below(h)))
                }
            };
            (cell, side, side)
        }
        Kind::Removal => (*way.get(way.len() / 3)?, 10, 10),
        Kind::Sealed => (*way.last()?, 61, 61),
        // The narrowest place of the way, closed from side to side.
        Kind::Door => {
            let inner = way.get(60..way.len().checked_sub(60)?)?;
            let cell = inner
                .iter()
                .max_by_key(|cell| map.view().get(**cell).map_or(0, |c| c.cost))?;
            (*cell, 61, 61)
        }
    };
    let min = Cell::new(at.x - width / 2, at.y - height / 2);
    let max = Cell::new(min.x + width, min.y + height);
    let buries = |end: &Cell| {
        (min.x - 14..max.x + 14).contains(&end.x) && (min.y - 14..max.y + 14).contains(&end.y)
    };
    let buries_goal = kind != Kind::Sealed && buries(way.last()?);
    (!buries(way.first()?) && !buries_goal).then_some(CellRect { min, max })
}

/// Fills a block of cells, or walls it in, and inflates that, with costs of 0 when `uniform`; returns the
/// changed cells and what they were.
pub(crate) fn apply(
    map: &mut Map,
    uniform: bool,
    kind: Kind,
    block: CellRect,
) -> (CellRect, Vec<MapCell>) {
    let CellRect { min, max } = block;
    let resolution_m = map.geometry.resolution_m;
    let margin = if uniform {
        0
    } else {
        (INFLATION_M / resolution_m).ceil().to_i32() + 1
    };
    let rect = block.grown(margin, &map.geometry);
    let mut before = Vec::new();
    for y in rect.min.y..rect.max.y {
        for x in rect.min.x..rect.max.x {
            let cell = Cell::new(x, y);
            let Some(index) = map.geometry.index_of(cell) else {
                continue;
            };
            let old = map.cells[index];
            before.push(old);
            let gap = |at: i32, min: i32, max: i32| {
                f64::from((min - at).max(at - max + 1).max(0)).mul_add(resolution_m, 0.0)
            };
            let inside = |at: i32, min: i32, max: i32| (at - min).min(max - 1 - at) - WALL + 1;
            let within = inside(x, min.x, max.x).min(inside(y, min.y, max.y));
            let clearance_m = if kind == Kind::Sealed && within > 0 {
                f64::from(within) * resolution_m
            } else {
                gap(x, min.x, max.x).hypot(gap(y, min.y, max.y))
            };
            let cost = if clearance_m <= 0.0 {
                COST_LETHAL
            } else if uniform || clearance_m > INFLATION_M {
                0
            } else if clearance_m <= INSCRIBED_M {
                COST_INSCRIBED
            } else {
                (252.0 * (-INFLATION_FACTOR * (clearance_m - INSCRIBED_M)).exp()).to_u8()
            };
            if cost > old.cost {
                map.cells[index] = of_cost(cost);
            }
        }
    }
    (rect, before)
}

/// Restores the cells that [`apply`] returned.
pub(crate) fn undo(map: &mut Map, rect: CellRect, before: &[MapCell]) {
    let mut cells = before.iter();
    for y in rect.min.y..rect.max.y {
        for x in rect.min.x..rect.max.x {
            if let (Some(index), Some(cell)) =
                (map.geometry.index_of(Cell::new(x, y)), cells.next())
            {
                map.cells[index] = *cell;
            }
        }
    }
}
