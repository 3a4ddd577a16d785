//! What a search stands on: which cells are free, which are connected, and where it begins.

use crate::bits::BitMap;
use crate::ends::{Ends, WayOut, find_ends};
use crate::map_options::MapOptions;
use crate::planner::{CornerRule, PlanError, PlanQuery};
use crate::reach::Reach;
use zeronav_msgs::{Cell, CellRect, MapView};

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Ground {
    pub(crate) bits: BitMap,
    pub(crate) reach: Reach,
    way_out: WayOut,
}

impl Ground {
    /// Nothing is known yet.
    pub(crate) fn new(options: MapOptions) -> Self {
        Self {
            bits: BitMap::default(),
            reach: Reach::default(),
            way_out: WayOut::new(options),
        }
    }

    /// Follows the map; both ends of the path.
    ///
    /// # Errors
    /// As [`find_ends`].
    pub(crate) fn ends(&mut self, query: &PlanQuery<'_>) -> Result<Ends, PlanError> {
        let ends = find_ends(query, &mut self.way_out)?;
        self.bits.follow(&query.map, query.unknown);
        Ok(ends)
    }

    /// Where the search begins, [`Reach::exit`].
    pub(crate) fn start(&mut self, rule: CornerRule, ends: &Ends) -> Cell {
        let Self {
            bits,
            reach,
            way_out,
        } = self;
        reach.exit(bits, rule, ends, way_out)
    }

    /// False when it is proved that there is no way, [`Reach::may`].
    #[inline]
    pub(crate) fn may(&mut self, rule: CornerRule, ways: (Cell, Cell), expanded: u64) -> bool {
        self.reach.may(&self.bits, rule, ways, expanded)
    }

    /// The answer where there is no way.
    pub(crate) fn no_way(&mut self, rule: CornerRule, ends: &Ends) -> PlanError {
        self.reach.no_way(&self.bits, rule, ends)
    }

    /// Begins a path, [`WayOut::lead`].
    pub(crate) fn lead(&self, path: &mut Vec<Cell>) {
        self.way_out.lead(path);
    }

    /// Takes in the cells of `changed`. From now on every change has to be told.
    pub(crate) fn change(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.bits.change(map, changed, |_, _, _| {});
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.bits.bytes() + self.reach.bytes()
    }
}
