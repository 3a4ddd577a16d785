//! Which cells of the space of states a layer has a node in already.

/// Slots, a power of two; far more than nodes in a layer.
const SLOTS: usize = 4096;

/// Most nodes of a layer: a quarter of the slots, so that a free one is near.
pub(crate) const WIDTH_MAX: u32 = 1024;

/// A cell: columns of x, y, yaw and speed.
pub(super) type Cell = [i16; 4];

/// An open-addressing set that is emptied by counting up.
#[derive(Debug, Clone)]
pub(super) struct Visited {
    slots: Vec<(u32, Cell)>,
    layer: u32,
}

impl Visited {
    pub(super) fn new() -> Self {
        Self {
            slots: vec![(0, Cell::default()); SLOTS],
            layer: 0,
        }
    }

    /// Forgets all cells.
    pub(super) fn clear(&mut self) {
        self.layer = self.layer.wrapping_add(1);
        if self.layer == 0 {
            self.slots.fill((0, Cell::default()));
            self.layer = 1;
        }
    }

    /// Takes in a cell; false when it was there. At most [`WIDTH_MAX`] after a [`Self::clear`].
    pub(super) fn insert(&mut self, cell: Cell) -> bool {
        let hash = cell.iter().fold(0_u32, |hash, column| {
            (hash ^ u32::from(column.cast_unsigned())).wrapping_mul(0x9E37_79B1)
        });
        let mut slot = (hash >> 16) as usize % SLOTS;
        loop {
            let (layer, there) = self.slots[slot];
            if layer != self.layer {
                self.slots[slot] = (self.layer, cell);
                return true;
            }
            if there == cell {
                return false;
            }
            slot = (slot + 1) % SLOTS;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn it_is_a_set_that_can_be_emptied(
            layers in proptest::collection::vec(
                proptest::collection::vec(proptest::array::uniform4(-3_i16..3), 0..200), 1..5),
        ) {
            let mut visited = Visited::new();
            for cells in layers {
                visited.clear();
                let mut expected = BTreeSet::new();
                for cell in cells {
                    prop_assert_eq!(visited.insert(cell), expected.insert(cell));
                }
            }
        }
    }
}
