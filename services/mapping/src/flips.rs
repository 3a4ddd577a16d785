//! What a scan changed about the cells.

/// What a scan did to the map. Counts of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Integrated {
    /// Became obstacles.
    pub marked: usize,
    /// Are obstacles no longer.
    pub cleared: usize,
    /// Were seen for the first time.
    pub revealed: usize,
}

/// Row-major indices of the cells that changed. Memory is reused.
#[derive(Debug, Default)]
pub(crate) struct Flips {
    /// Cells that became obstacles.
    pub marked: Vec<usize>,
    /// Cells that stopped being obstacles.
    pub cleared: Vec<usize>,
    /// Cells seen for the first time.
    pub revealed: Vec<usize>,
}

impl Flips {
    /// How many there are.
    pub(crate) fn count(&self) -> Integrated {
        Integrated {
            marked: self.marked.len(),
            cleared: self.cleared.len(),
            revealed: self.revealed.len(),
        }
    }

    /// Empties the lists.
    pub(crate) fn clear(&mut self) {
        let Self {
            marked,
            cleared,
            revealed,
        } = self;
        for list in [marked, cleared, revealed] {
            list.clear();
        }
    }
}
