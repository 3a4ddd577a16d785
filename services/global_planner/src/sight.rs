//! Whether the straight line between two cell centres is free.

use crate::bits::Lines;
use crate::planner::CornerRule;

/// A position: column and row.
type At = (u32, u32);

/// What a look along a line met.
pub(crate) struct Look {
    /// First blocked cell that the line passes or touches at a corner that may not be passed.
    pub hit: Option<At>,
    /// Cells that the line passes up to there.
    pub cells: u64,
}

/// Looks along the line from one centre to another on a map: the same cells as
/// [`crate::line::supercover`], but only up to the first that is blocked.
#[inline]
pub(crate) fn look(rule: CornerRule, from: At, to: At, blocked: impl Fn(At) -> bool) -> Look {
    let (nx, ny) = (
        i64::from(to.0.abs_diff(from.0)),
        i64::from(to.1.abs_diff(from.1)),
    );
    let step = |from: u32, to: u32| -> u32 { if to > from { 1 } else { u32::MAX } };
    let (sx, sy) = (step(from.0, to.0), step(from.1, to.1));
    let (mut x, mut y) = from;
    let (mut ix, mut iy) = (0_i64, 0_i64);
    let mut cells = 1;
    loop {
        if blocked((x, y)) {
            let hit = Some((x, y));
            return Look { hit, cells };
        }
        if ix == nx && iy == ny {
            return Look { hit: None, cells };
        }
        cells += 1;
        // The next vertical border is crossed at (2 ix + 1) / 2 nx, the next horizontal one at
        // (2 iy + 1) / 2 ny.
        let order = ((2 * ix + 1) * ny).cmp(&((2 * iy + 1) * nx));
        let beside = (x.wrapping_add(sx), y.wrapping_add(sy));
        if order.is_eq() {
            let sides = [(beside.0, y), (x, beside.1)];
            let [one, other] = sides.map(&blocked);
            if !rule.permits(one, other) {
                let hit = Some(if one { sides[0] } else { sides[1] });
                return Look { hit, cells };
            }
        }
        if order.is_le() {
            x = beside.0;
            ix += 1;
        }
        if order.is_ge() {
            y = beside.1;
            iy += 1;
        }
    }
}

/// True when no cell that the line passes is blocked on a bit map, and every corner that it touches
/// may be passed. Padded positions.
pub(crate) fn sees(lines: &Lines, rule: CornerRule, from: At, to: At) -> bool {
    let blocked = |(x, y): At| lines.is_blocked(y as usize, x as usize);
    look(rule, from, to, blocked).hit.is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::supercover;
    use crate::padded::cell_of;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sees_along_the_cells_of_the_line(
            seed: u64,
            from in (1_u32..30, 1_u32..20),
            to in (1_u32..30, 1_u32..20),
            rule in 0_usize..3,
        ) {
            let rule = [CornerRule::Allow, CornerRule::ForbidAny, CornerRule::ForbidBoth][rule];
            let mut lines = Lines::default();
            lines.reset(30, 20);
            let mut state = seed;
            for y in 1..=20 {
                for x in 1..=30 {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    lines.set(y, x, (state >> 33).is_multiple_of(16));
                }
            }
            let mut free = true;
            let blocked = |cell: zeronav_msgs::Cell| {
                let (x, y) = crate::padded::padded(cell);
                lines.is_blocked(y as usize, x as usize)
            };
            supercover(cell_of(from), cell_of(to), |crossing| {
                free &= !blocked(crossing.cell);
                if let Some([one, other]) = crossing.touched {
                    free &= rule.permits(blocked(one), blocked(other));
                }
            });
            prop_assert_eq!(sees(&lines, rule, from, to), free);
        }
    }
}
