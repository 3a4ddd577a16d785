"""A reader's copy of the map, kept equal to the writer's by updates and keyframes.

Updates are counted without gaps. After a gap, or when the writer starts again, the copy keeps what
it had, collects the updates that still come, and needs a keyframe.
"""

import math

import numpy as np

from . import contract as c

PENDING_MAX = 256
SIDE = c.TILE_CELLS
CELL = np.dtype(c.MapCell)
ROUNDING_MM = 1e-6


def cost_of(model, clearance_m):
    """Costs of known cells `clearance_m` from the nearest obstacle, by the map's cost model."""
    beyond_m = clearance_m - model.inscribed_radius_m
    spare_m = beyond_m - model.padding_m
    fall = c.COST_CIRCUMSCRIBED_MAX * np.exp(-model.scaling_per_m * np.maximum(spare_m, 0))
    inflated = clearance_m * 1000 <= model.inflation_radius_m * 1000 + ROUNDING_MM
    cost = np.where(inflated, fall.astype(np.uint8), c.COST_FREE)
    inside = (beyond_m * 1000 <= ROUNDING_MM) | (spare_m * 1000 < -ROUNDING_MM)
    cost = np.where(inside, c.COST_INSCRIBED, cost)
    return np.where(clearance_m * 1000 <= ROUNDING_MM, c.COST_LETHAL, cost).astype(np.uint8)


class MapReplica:
    """The copy. `cells[row, column]` has the fields `cost`, `flags` and `clearance_mm`."""

    def __init__(self):
        self.info = c.MapInfo()
        self.cells = np.empty((0, 0), CELL)
        self.revision = 0
        self.in_step = False
        self._last = self._next_part = 0
        self._pending, self._parts, self._before = [], [], []
        self._changed = False

    def take_changed(self):
        """True when cells were written since the last call."""
        changed, self._changed = self._changed, False
        return changed

    def cell_at(self, x_m, y_m):
        """Row and column of a point of the map frame; None outside."""
        grid = self.info.geometry
        if self.revision == 0:
            return None
        column = math.floor((x_m - grid.origin_x_m) / grid.resolution_m)
        row = math.floor((y_m - grid.origin_y_m) / grid.resolution_m)
        inside = 0 <= row < grid.height and 0 <= column < grid.width
        return (row, column) if inside else None

    def update(self, id, info, tiles):
        """Takes in one message of `map/update`."""
        if id >> 40 == self._last >> 40 and id <= self._last:
            return
        if self.in_step and id == self._last + 1 and self._same_grid(info):
            self._take_in(id, info, tiles)
            return
        if self.in_step:
            self._resync()
        if self._pending and self._pending[-1][0] >> 40 != id >> 40:
            # Another process writes the map now: after a rollback its ids are lower.
            self._pending.clear()
        if self._pending and self._pending[-1][0] >= id:
            return
        if len(self._pending) == PENDING_MAX:
            self._pending.clear()
        self._pending.append((id, info.copy(), tiles.copy()))

    def keyframe(self, info, tiles):
        """Takes in one message of `map/keyframe`."""
        same_epoch = info.revision >> 40 == self._last >> 40
        if self.in_step and same_epoch and self._same_grid(info):
            return
        same = info.revision >> 40 == self.revision >> 40
        if (same and info.revision < self.revision) or not self._covers(info, tiles):
            return
        self._before.clear()
        grid = info.geometry
        self.cells = np.empty((grid.height, grid.width), CELL)
        self.info = info.copy()
        self._write(tiles)
        self.revision = self._last = info.revision
        self.in_step = True
        self._parts.clear()
        self._next_part = 0
        pending, self._pending = self._pending, []
        for id, info, tiles in pending:
            if id >> 40 == self._last >> 40 and id <= self._last:
                continue
            if self.in_step and id == self._last + 1 and self._same_grid(info):
                self._take_in(id, info, tiles)
            else:
                self.in_step = False
                self._pending.append((id, info, tiles))

    def stamp(self, obstacles):
        """Writes tracked obstacles over the cells in place of those of the last call. Unknown
        cells stay unknown where their clearance does not block the robot's centre."""
        self._lift()
        if self.revision:
            for obstacle in obstacles:
                self._put(float(obstacle["x_m"]), float(obstacle["y_m"]), float(obstacle["radius_m"]))

    def _same_grid(self, info):
        return bytes(info.geometry) == bytes(self.info.geometry)

    def _resync(self):
        self.in_step = False
        self._pending.clear()
        self._parts.clear()
        self._next_part = 0

    def _covers(self, info, tiles):
        columns, rows = -(-info.geometry.width // SIDE), -(-info.geometry.height // SIDE)
        if len(tiles) != columns * rows:
            return False
        place = np.arange(len(tiles))
        in_order = (tiles["tile_x"] == place % columns) & (tiles["tile_y"] == place // columns)
        return bool(in_order.all())

    def _take_in(self, id, info, tiles):
        if info.part == 0:
            self._parts.clear()
            self._next_part = 0
        grid = info.geometry
        most = -(-grid.width // SIDE) * -(-grid.height // SIDE)
        n_tiles = len(tiles) + sum(len(part) for part in self._parts)
        if info.part != self._next_part or n_tiles > most:
            self._resync()
            return
        self._last = id
        if info.part + 1 != info.parts:
            self._next_part += 1
            self._parts.append(tiles.copy())
            return
        self._next_part = 0
        self._lift()
        for part in self._parts:
            self._write(part)
        self._parts.clear()
        self._write(tiles)
        self.info = info.copy()
        self.revision = id

    def _write(self, tiles):
        height, width = self.cells.shape
        for tile in tiles:
            x, y = int(tile["tile_x"]) * SIDE, int(tile["tile_y"]) * SIDE
            columns, rows = min(SIDE, width - x), min(SIDE, height - y)
            cells = tile["cells"].reshape(SIDE, SIDE)
            self.cells[y : y + rows, x : x + columns] = cells[:rows, :columns]
        self._changed |= len(tiles) > 0

    def _lift(self):
        for window, cells in reversed(self._before):
            self.cells[window] = cells
            self._changed = True
        self._before.clear()

    def _put(self, x_m, y_m, radius_m):
        grid, info = self.info.geometry, self.info
        side, reach_m = grid.resolution_m, radius_m + info.clearance_limit_mm / 1000
        x, y = (x_m - grid.origin_x_m) / side, (y_m - grid.origin_y_m) / side
        reach = reach_m / side
        rows = slice(max(0, math.floor(y - reach)), max(0, math.floor(y + reach) + 1))
        columns = slice(max(0, math.floor(x - reach)), max(0, math.floor(x + reach) + 1))
        old = self.cells[rows, columns]
        if old.size == 0:
            return
        row = np.arange(rows.start, rows.start + old.shape[0])[:, None]
        column = np.arange(columns.start, columns.start + old.shape[1])[None, :]
        distance_m = np.hypot((row + 0.5 - y) * side, (column + 0.5 - x) * side)
        clearance_m = np.maximum(distance_m - radius_m, 0)
        # A disc smaller than a cell is an obstacle, too.
        clearance_m[(row == math.floor(y)) & (column == math.floor(x))] = 0
        limit = min(info.clearance_limit_mm, 0xFFFF)
        clearance_mm = np.minimum(clearance_m * 1000 + ROUNDING_MM, limit).astype(np.uint16)
        closer = clearance_mm < old["clearance_mm"]
        if not closer.any():
            return
        cost = cost_of(info.cost_model, clearance_m)
        unknown = old["cost"] == c.COST_UNKNOWN
        known = np.maximum(cost, old["cost"])
        cost = np.where(unknown, np.where(cost < c.COST_INSCRIBED, c.COST_UNKNOWN, cost), known)
        self._before.append(((rows, columns), old.copy()))
        old["cost"] = np.where(closer, cost, old["cost"])
        old["clearance_mm"] = np.where(closer, clearance_mm, old["clearance_mm"])
        self._changed = True
