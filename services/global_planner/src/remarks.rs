//! What a planner of the papers has to say about a path beside its counters.

/// Remarks on one search.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Remarks {
    /// A fault that is printed in the paper was switched on
    /// ([`crate::papers::options::PaperOptions::literal`]): the result is for reproduction only.
    pub literal: bool,
    /// What had to step in where the method of the paper failed.
    pub fallback: Fallback,
    /// Entries that a walk took back because nothing was left there.
    pub turned_back: u64,
    /// Cells looked at by sight lines, floods and the like, which the papers do not count.
    pub aux_cells: u64,
    /// Free cells past a corner, seen from any cell that was expanded, each counted once;
    /// the cells around obstacles for `bao_full`.
    pub virtual_total: u64,
    /// Free cells past a corner, seen from a cell of the path, each counted once: what \[BAO\]
    /// prints.
    pub virtual_on_path: u64,
    /// Diagonal steps of the path past at least one blocked cell.
    pub corner_cuts: u64,
    /// Rectangles that obstacles were replaced by (TN-REG).
    pub rectangles: u64,
    /// Rectangles that were not filled: robot, start or goal inside, or too large (TN-REG).
    pub rectangles_skipped: u64,
    /// Sharpest turn of the curve that rounds the path, 0 without one (BAO-SPL). [1/m]
    pub curvature_max_1pm: f64,
    /// True when a curve would have left the free cells, so that the path is not rounded (BAO-SPL).
    pub curve_dropped: bool,
}

/// What stepped in where the method of the paper failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Fallback {
    /// Nothing.
    #[default]
    None,
    /// Obstacles were passed on the other side (TN-HYB, first rung).
    Clockwise,
    /// Obstacles were not replaced by rectangles (TN-HYB, second rung).
    WithoutRectangles,
    /// A* from where the method gave up.
    AstarFromHere,
    /// A* from the start.
    Astar,
}
