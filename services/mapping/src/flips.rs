//! What a scan changed about the cells.

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
