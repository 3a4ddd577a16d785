//! What the field and its searches keep about a cell.

/// In place of what is left: no way leads to the goal.
pub(super) const NO_WAY: u32 = u32::MAX;

/// A padded position: `(y + 1) * (width + 2) + x + 1`.
pub(super) type Spot = u32;

/// What is known about a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Lower bound of the cost to the goal.
    pub(super) left: u32,
    /// Cost of the best way from the start found so far.
    pub(super) so_far: u32,
    /// `generation << 5 | step that led here << 1 | closed`.
    pub(super) meta: u32,
}

pub(super) const CLOSED: u32 = 1;
pub(super) const STEP_SHIFT: u32 = 1;
pub(super) const STEP_MASK: u32 = 0b1_1110;
pub(super) const NO_STEP: u32 = 8;
pub(super) const GENERATION_SHIFT: u32 = 5;
pub(super) const GENERATION_MAX: u32 = (1 << (32 - GENERATION_SHIFT)) - 1;
