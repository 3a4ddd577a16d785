//! What the searches under the guidance of the field keep about a cell.

/// In place of what is left: no way leads to the goal.
pub(super) const NO_WAY: u32 = u32::MAX;

/// A padded position: `(y + 1) * (width + 2) + x + 1`.
pub(super) type Spot = u32;

/// What a search found about a cell. All zero is a cell that no search has seen, so that the nodes of
/// a map are made without writing to them: what no search comes to takes no memory.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Node {
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
