//! The cells that a straight line between two cell centres passes, exactly.
//!
//! Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987, in integers, which
//! is possible because both ends are centres; a line through the corner of four cells is told
//! apart from one that misses it.

use zeronav_casts::Cast;
use zeronav_msgs::Cell;

/// A cell of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// The cell.
    pub cell: Cell,
    /// Where the line enters it, as a fraction of the line, 0 to 1.
    pub enters: f64,
    /// Where the line leaves it; > `enters`, except on a line of one point.
    pub leaves: f64,
    /// The line left the cell before exactly through a corner: these two cells are touched there
    /// and nowhere else.
    pub touched: Option<[Cell; 2]>,
}

/// Calls `visit` with every cell whose inside the line from the centre of `from` to that of `to`
/// passes, in order, both ends included.
pub fn supercover(from: Cell, to: Cell, mut visit: impl FnMut(Crossing)) {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let (nx, ny) = (i64::from(dx.abs()), i64::from(dy.abs()));
    let (mut ix, mut iy) = (0_i64, 0_i64);
    let mut now = Crossing {
        cell: from,
        enters: 0.0,
        leaves: 1.0,
        touched: None,
    };
    while ix < nx || iy < ny {
        // The next vertical border is crossed at (2 ix + 1) / 2 nx, the next horizontal one at
        // (2 iy + 1) / 2 ny.
        let order = ((2 * ix + 1) * ny).cmp(&((2 * iy + 1) * nx));
        let Cell { x, y } = now.cell;
        let (beside_x, beside_y) = (Cell::new(x + dx.signum(), y), Cell::new(x, y + dy.signum()));
        now.leaves = if order.is_le() {
            fraction(ix, nx)
        } else {
            fraction(iy, ny)
        };
        visit(now);
        let (cell, touched) = match order {
            core::cmp::Ordering::Less => (beside_x, None),
            core::cmp::Ordering::Greater => (beside_y, None),
            core::cmp::Ordering::Equal => (
                Cell::new(beside_x.x, beside_y.y),
                Some([beside_x, beside_y]),
            ),
        };
        ix += i64::from(order.is_le());
        iy += i64::from(order.is_ge());
        now = Crossing {
            cell,
            enters: now.leaves,
            leaves: 1.0,
            touched,
        };
    }
    visit(now);
}

fn fraction(border: i64, n: i64) -> f64 {
    (2 * border + 1).to_f64() / (2 * n).to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the cells, and in brackets those touched at a corner.
    fn check(to: (i32, i32), expected: &str) {
        let mut text = String::new();
        supercover(Cell::new(0, 0), Cell::new(to.0, to.1), |crossing| {
            use std::fmt::Write;
            if let Some([one, other]) = crossing.touched {
                write!(text, "[{},{} {},{}]", one.x, one.y, other.x, other.y).unwrap();
            }
            write!(text, "({},{})", crossing.cell.x, crossing.cell.y).unwrap();
        });
        assert_eq!(text, expected);
    }

    #[test]
    fn lines_by_hand() {
        check((0, 0), "(0,0)");
        check((2, 0), "(0,0)(1,0)(2,0)");
        check((0, -2), "(0,0)(0,-1)(0,-2)");
        check((1, 1), "(0,0)[1,0 0,1](1,1)");
        check((-1, 1), "(0,0)[-1,0 0,1](-1,1)");
        check((2, 1), "(0,0)(1,0)(1,1)(2,1)");
        check((3, 1), "(0,0)(1,0)[2,0 1,1](2,1)(3,1)");
    }

    #[test]
    fn the_pieces_make_the_whole_line() {
        for (x, y) in [(7, 3), (-4, 9), (5, 5), (0, 3), (-8, -6)] {
            let mut end = 0.0;
            supercover(Cell::new(2, 1), Cell::new(2 + x, 1 + y), |crossing| {
                assert!((crossing.enters - end).abs() < 1e-12);
                assert!(crossing.leaves > crossing.enters);
                end = crossing.leaves;
            });
            assert!((end - 1.0).abs() < 1e-12);
        }
    }
}
