#!/usr/bin/env python3
"""A global planner in Python: A* on blocks of four by four cells."""

import heapq
import math

import numpy as np

from zeronav import Planner, blocks_centre, run
from zeronav.contract import COST_LETHAL

BLOCK = 4
STEPS = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]


class AStar(Planner):
    """A* on a coarse grid."""

    key = "astar_py"

    def search(self, cells, start, end, progress):
        blocks = search(cells, start, end, progress)
        return blocks and [tuple(BLOCK * at + BLOCK // 2 for at in block) for block in blocks]


def search(cells, start, end, progress):
    """Blocks from the cell `start` to the cell `end`; None when there is no way."""
    # Beyond the edge of the map lies an obstacle.
    beyond = [(0, -side % BLOCK) for side in cells.shape]
    cost = np.pad(cells["cost"], beyond, constant_values=COST_LETHAL)
    height, width = (side // BLOCK for side in cost.shape)
    parts = cost.reshape(height, BLOCK, width, BLOCK)
    blocked = blocks_centre(parts).any((1, 3))
    start, end = ((row // BLOCK, column // BLOCK) for row, column in (start, end))
    # The robot may stand closer to an obstacle than a path would lead it.
    near = (slice(max(0, start[0] - 3), start[0] + 4), slice(max(0, start[1] - 3), start[1] + 4))
    blocked[near] = (parts == COST_LETHAL).any((1, 3))[near]
    blocked[start] = False
    blocked = np.pad(blocked, 1, constant_values=True)
    weight = np.pad(1 + parts.max((1, 3)) / 64, 1).tolist()
    (row, column), (end_row, end_column) = ((y + 1, x + 1) for y, x in (start, end))
    costs, parents, free = {(row, column): 0.0}, {}, (~blocked).tolist()
    queue = [(0.0, row, column)]
    for expanded in range(blocked.size * 8):
        if not queue:
            return None
        _, row, column = heapq.heappop(queue)
        if (row, column) == (end_row, end_column):
            break
        if expanded % 500 == 0:
            progress()
        for dy, dx in STEPS:
            y, x = row + dy, column + dx
            if not (free[y][x] and free[row][x] and free[y][column]):
                continue
            cost = costs[row, column] + math.hypot(dy, dx) * weight[y][x]
            if cost < costs.get((y, x), math.inf):
                costs[y, x], parents[y, x] = cost, (row, column)
                rest = math.hypot(end_row - y, end_column - x)
                heapq.heappush(queue, (cost + rest, y, x))
    blocks = [(end_row, end_column)]
    while blocks[-1] in parents:
        blocks.append(parents[blocks[-1]])
    return [(y - 1, x - 1) for y, x in reversed(blocks)]


if __name__ == "__main__":
    run(AStar)
