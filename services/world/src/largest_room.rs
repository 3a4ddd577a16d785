//! The largest connected room of a map in which a disc can stand.

use crate::static_map::{Occupancy, StaticMap};
use zeronav_casts::Cast;
use zeronav_msgs::Cell;

impl StaticMap {
    /// The cells of the largest connected room in which the centre of a disc of `radius_m` [m] can stand: free, and no
    /// occupied cell within a square of that half side. In the order in which they are found; empty when there is none.
    #[must_use]
    pub fn largest_room(&self, radius_m: f64) -> Vec<Cell> {
        let mut open = self.standing_room(radius_m);
        let (width, height) = self.geometry.size();
        let mut largest = Vec::new();
        for first in (0..height).flat_map(|y| (0..width).map(move |x| Cell::new(x, y))) {
            let mut take = |cell: Cell| {
                let index = self.geometry.index_of(cell)?;
                core::mem::take(&mut open[index]).then_some(cell)
            };
            let mut room: Vec<Cell> = take(first).into_iter().collect();
            let mut next = 0;
            while let Some(cell) = room.get(next).copied() {
                next += 1;
                for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    room.extend(take(Cell::new(cell.x + dx, cell.y + dy)));
                }
            }
            if room.len() > largest.len() {
                largest = room;
            }
        }
        largest
    }

    /// For every cell, whether the centre of the disc can stand in it.
    fn standing_room(&self, radius_m: f64) -> Vec<bool> {
        let (width, height) = self.geometry.size();
        let reach = (radius_m / self.geometry.resolution_m).ceil().to_i32();
        let mut open: Vec<bool> = (self.cells.iter())
            .map(|it| *it == Occupancy::Free)
            .collect();
        for y in 0..height {
            for x in 0..width {
                if self.get(Cell::new(x, y)) != Some(Occupancy::Occupied) {
                    continue;
                }
                let rows = y.saturating_sub(reach).max(0)..=y.saturating_add(reach).min(height - 1);
                for row in rows {
                    let columns =
                        x.saturating_sub(reach).max(0)..=x.saturating_add(reach).min(width - 1);
                    for column in columns {
                        if let Some(index) = self.geometry.index_of(Cell::new(column, row)) {
                            open[index] = false;
                        }
                    }
                }
            }
        }
        open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::GridGeometry;

    #[test]
    fn the_larger_of_two_rooms_is_found_without_what_is_near_a_wall() {
        let geometry = GridGeometry {
            resolution_m: 0.1,
            width: 20,
            height: 10,
            ..GridGeometry::default()
        };
        let mut map = StaticMap::free(geometry);
        for y in 0..10 {
            let index = geometry.index_of(Cell::new(6, y)).unwrap();
            map.cells[index] = Occupancy::Occupied;
        }
        // A wall in column 6: beyond one cell of margin the columns 8 to 19 are one room, 0 to 4 the other.
        let room = map.largest_room(0.1);
        assert_eq!(room.len(), 12 * 10);
        assert!(room.iter().all(|cell| cell.x >= 8));
        assert_eq!(map.largest_room(5.0), []);
        map.cells.fill(Occupancy::Unknown);
        assert_eq!(map.largest_room(0.0), []);
    }
}
