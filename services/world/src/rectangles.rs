//! Occupied cells as few large rectangles.

use crate::static_map::{Occupancy, StaticMap};
use parry2d::bounding_volume::Aabb;
use parry2d::math::Vec2;
use zeronav_casts::Cast;

/// Rectangles that together cover exactly the occupied cells of `map`, none of them twice: equal
/// runs of neighbouring rows are one rectangle. Row by row, O(cells).
pub(crate) fn of_occupied(map: &StaticMap) -> Vec<Aabb> {
    let geometry = &map.geometry;
    let width = geometry.width as usize;
    let corner = |x: usize, y: usize| {
        let (x, y) = (x.to_f64(), y.to_f64());
        Vec2::new(
            geometry.origin_x_m + x * geometry.resolution_m,
            geometry.origin_y_m + y * geometry.resolution_m,
        )
    };
    let mut done = Vec::new();
    // Runs `from..to` that reach up to the current row, with the row in which they began; sorted.
    let mut open: Vec<(usize, usize, usize)> = Vec::new();
    let mut finish = |(from, to, since): (usize, usize, usize), end: usize| {
        done.push(Aabb::new(corner(from, since), corner(to, end)));
    };
    for (y, row) in map.cells.chunks(width).enumerate() {
        let mut above = Vec::new();
        let mut older = open.iter().peekable();
        for (from, to) in runs(row) {
            let mut since = y;
            while let Some(below) = older.next_if(|below| below.0 <= from) {
                if (below.0, below.1) == (from, to) {
                    since = below.2;
                } else {
                    finish(*below, y);
                }
            }
            above.push((from, to, since));
        }
        for below in older {
            finish(*below, y);
        }
        open = above;
    }
    for below in open {
        finish(below, geometry.height as usize);
    }
    done
}

/// Half-open runs of occupied cells, from left to right.
fn runs(row: &[Occupancy]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mut x = 0;
    core::iter::from_fn(move || {
        let occupied = |cell: &Occupancy| *cell == Occupancy::Occupied;
        let from = x + row[x..].iter().position(occupied)?;
        let length = row[from..].iter().position(|cell| !occupied(cell));
        x = length.map_or(row.len(), |length| from + length);
        Some((from, x))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::{Cell, GridGeometry};

    /// A map of 1 m cells drawn with its upper row first.
    fn map(rows: &[&str]) -> StaticMap {
        let width = u32::try_from(rows[0].len()).unwrap();
        let height = u32::try_from(rows.len()).unwrap();
        StaticMap {
            geometry: GridGeometry {
                origin_x_m: 0.0,
                origin_y_m: 0.0,
                resolution_m: 1.0,
                width,
                height,
            },
            cells: rows
                .iter()
                .rev()
                .flat_map(|row| row.bytes())
                .map(|byte| match byte {
                    b'#' => Occupancy::Occupied,
                    b'?' => Occupancy::Unknown,
                    _ => Occupancy::Free,
                })
                .collect(),
        }
    }

    fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Aabb {
        Aabb::new(Vec2::new(x0, y0), Vec2::new(x1, y1))
    }

    #[test]
    fn blocks_become_one_rectangle_and_steps_two() {
        let map = map(&[
            "##..#", //
            "##.?#", //
            "###.#", //
        ]);
        let found = of_occupied(&map);
        assert_eq!(found.len(), 3);
        assert!(found.contains(&rectangle(0.0, 0.0, 3.0, 1.0)));
        assert!(found.contains(&rectangle(0.0, 1.0, 2.0, 3.0)));
        assert!(found.contains(&rectangle(4.0, 0.0, 5.0, 3.0)));
    }

    #[test]
    fn every_occupied_cell_is_covered_once() {
        let mut state: u32 = 7;
        let mut cells = Vec::new();
        for _ in 0..60 * 40 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            cells.push(if state >> 31 == 0 {
                Occupancy::Occupied
            } else {
                Occupancy::Free
            });
        }
        let mut map = map(&[".".repeat(60).as_str(); 40]);
        map.cells = cells;
        let found = of_occupied(&map);
        for y in 0..40 {
            for x in 0..60 {
                let centre = map.geometry.centre_of(Cell::new(x, y));
                let covers = found
                    .iter()
                    .filter(|rectangle| {
                        rectangle.contains_local_point(Vec2::new(centre.x, centre.y))
                    })
                    .count();
                let occupied = map.get(Cell::new(x, y)) == Some(Occupancy::Occupied);
                assert_eq!(covers, usize::from(occupied), "cell {x} {y}");
            }
        }
    }

    #[test]
    fn an_empty_map_has_none() {
        assert!(of_occupied(&map(&["...", "?.."])).is_empty());
    }
}
