//! What an update of the map means for the field.

use super::node::Spot;
use super::{Changed, GoalField, State};
use zeronav_casts::Cast;
use zeronav_msgs::{CellRect, MapView};

impl GoalField {
    /// Takes in the cells of `changed` and calls `cost_increased` with each that became dearer or blocked;
    /// says what changed. From now on every change has to be told.
    pub(crate) fn change(
        &mut self,
        map: &MapView<'_>,
        changed: &[CellRect],
        mut cost_increased: impl FnMut(Spot),
    ) -> Changed {
        self.told = true;
        if !self.built || *map.geometry != self.geometry {
            self.built = false;
            self.follow(map, self.unknown, self.rule);
            return Changed {
                any: true,
                cost_decreased: true,
            };
        }
        let mut changes = Changed::default();
        let row = map.geometry.width as usize;
        for rect in changed {
            let rect = rect.grown(0, map.geometry);
            if rect.min.x >= rect.max.x {
                continue;
            }
            let columns = rect.min.x.cast_unsigned() as usize..rect.max.x.cast_unsigned() as usize;
            for y in rect.min.y.max(0)..rect.max.y {
                let y = y.cast_unsigned() as usize;
                let first = (y + 1) * self.width as usize + columns.start + 1;
                let cells = &map.cells[y * row..][columns.clone()];
                let prices = self.prices.row_mut(first, cells.len());
                for (n, (cell, price)) in cells.iter().zip(prices).enumerate() {
                    let new = self.unknown.cost(*cell);
                    let old = core::mem::replace(price, new);
                    let (spot, x, y) = (
                        (first + n).to_u32(),
                        (columns.start + n).to_u32() + 1,
                        y.to_u32() + 1,
                    );
                    if new != old && matches!(self.state, State::Growing | State::Whole) {
                        self.raise.note(spot);
                    }
                    if new < old && !matches!(self.state, State::Missing | State::Clearing) {
                        self.raise.cost_decreased = true;
                        self.cost_decreased.push(spot);
                        self.eased_box.add(x, y);
                    }
                    if new > old {
                        cost_increased(spot);
                    }
                    changes.any |= new != old;
                    changes.cost_decreased |= new < old;
                }
            }
        }
        // More than a repair could ever be worth: it is not kept for one.
        if self.cost_decreased.len().max(self.raise.to_check.len()) > self.nodes.len() {
            self.state = State::Missing;
            self.forget_eased();
        }
        changes
    }
}
