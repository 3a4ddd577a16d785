//! What every search needs of the map: which cells are free, which are connected, and where the
//! path begins and ends.

use crate::bits::BitMap;
use crate::ends::{Ends, WayOut, find_ends};
use crate::map_options::MapOptions;
use crate::planner::{CellPath, CornerRule, PlanError, PlanQuery, Unknown};
use crate::reach::Reach;
use crate::search::Found;
use zeronav_msgs::{Cell, CellRect, MapView};

/// A copy of the map in the form that a search reads.
pub(crate) trait FreeCells: Default {
    /// Becomes that of `map`, see [`BitMap::follow`].
    fn follow(&mut self, map: &MapView<'_>, unknown: Unknown);

    /// Reads the cells of `changed` again, see [`BitMap::change`].
    fn change(&mut self, map: &MapView<'_>, changed: &[CellRect]);

    /// Which cells are free.
    fn bits(&self) -> &BitMap;

    /// Bytes held.
    fn bytes(&self) -> usize;
}

impl FreeCells for BitMap {
    fn follow(&mut self, map: &MapView<'_>, unknown: Unknown) {
        Self::follow(self, map, unknown);
    }

    fn change(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        Self::change(self, map, changed, |_, _, _| {});
    }

    fn bits(&self) -> &BitMap {
        self
    }

    fn bytes(&self) -> usize {
        Self::bytes(self)
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Ground<M = BitMap> {
    pub(crate) map: M,
    reach: Reach,
    way_out: WayOut,
}

impl<M: FreeCells> Ground<M> {
    /// Without memory of any map.
    pub(crate) fn new(options: MapOptions) -> Self {
        Self {
            map: M::default(),
            reach: Reach::default(),
            way_out: WayOut::new(options),
        }
    }

    /// Opens a plan: clears `path`, finds both ends, reads the map.
    ///
    /// # Errors
    /// As [`find_ends`].
    pub(crate) fn open(
        &mut self,
        query: &PlanQuery<'_>,
        path: &mut CellPath,
    ) -> Result<Ends, PlanError> {
        path.clear();
        self.map.follow(&query.map, query.unknown);
        let (bits, reach) = (self.map.bits(), &mut self.reach);
        find_ends(query, &mut self.way_out, &mut |one, other| {
            reach.known(bits, query.corner_rule, one, other)
        })
    }

    /// Searches between the ends: begins the path with the way out of the inflation, and leaves
    /// the search to `search` unless it is known already that there is no path. `search` appends
    /// the path from its first cell to its second.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`], [`PlanError::Unreachable`]; `path.cells` is then empty.
    pub(crate) fn answer(
        &mut self,
        query: &PlanQuery<'_>,
        ends: &Ends,
        path: &mut CellPath,
        search: impl FnOnce(&mut Self, (Cell, Cell), &mut CellPath) -> Found,
    ) -> Result<(), PlanError> {
        let (bits, rule) = (self.map.bits(), query.corner_rule);
        let start = self.reach.exit(bits, rule, ends, &mut self.way_out);
        self.way_out.lead(&mut path.cells);
        let between = (start, ends.goal);
        let found = if self.may(rule, between, 0) {
            search(self, between, path)
        } else {
            Found::Nothing
        };
        if found != Found::Path {
            path.cells.clear();
        }
        match found {
            Found::Path => Ok(()),
            Found::Stopped => Err(PlanError::OutOfBudget),
            Found::Nothing => Err(self.reach.no_way(self.map.bits(), rule, ends)),
        }
    }

    /// False when it is proved that there is no path, [`Reach::may`].
    #[inline]
    pub(crate) fn may(&mut self, rule: CornerRule, between: (Cell, Cell), expanded: u64) -> bool {
        self.reach.may(self.map.bits(), rule, between, expanded)
    }

    /// True when the two cells are connected.
    pub(crate) fn known(&mut self, rule: CornerRule, a: Cell, b: Cell) -> bool {
        self.reach.known(self.map.bits(), rule, a, b)
    }

    /// Work for when no answer is due: gets the proof of [`Self::may`] ready, in slices; true when
    /// more is left.
    pub(crate) fn prepare(&mut self) -> bool {
        self.reach.prepare(self.map.bits())
    }

    /// The map, and [`Self::may`] as a function of the expansions.
    pub(crate) fn parts(
        &mut self,
        rule: CornerRule,
        between: (Cell, Cell),
    ) -> (&M, impl FnMut(u64) -> bool) {
        let Self { map, reach, .. } = self;
        let map = &*map;
        let bits = map.bits();
        (map, move |expanded| {
            reach.may(bits, rule, between, expanded)
        })
    }

    /// Reads the cells of `changed` again. From now on every change has to be told.
    pub(crate) fn change(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.map.change(map, changed);
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.map.bytes() + self.reach.bytes()
    }
}
