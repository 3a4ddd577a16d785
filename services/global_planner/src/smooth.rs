//! Rounding: a cubic B-spline along a path, checked against the map it was made on.
//!
//! Control points lie on the path at even distances, so that steps of a grid average out; the
//! curve is that of \[BAO\] eqs. (9) to (12). What is checked is what is sent: the lines between
//! the points of the curve. Every cell that they pass has to be free, corners included, and hardly
//! dearer than the dearest of the path there: with the usual inflation a cell nearer to the
//! obstacle. Where that fails control points stand four times as close, and where that fails, too,
//! the path itself is followed: a control point that is repeated three times is passed in a straight
//! line.

use crate::line::supercover;
use crate::papers::spline::{SplineEnds, point_on, segments};
use crate::planner::{CellPath, PlanQuery};
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::Cell;
use zeronav_msgs::path::WAYPOINTS_MAX;

/// Control points in place of one where the path is followed closely.
const CLOSER: u32 = 4;

/// Points of the curve between two control points.
const PIECES: u32 = 4;

/// How much dearer than the dearest cell of the path a cell of the curve may be, of 252.
const DEARER: u8 = 25;

/// Times that pieces which fail the check are taken back before the path stays as it is.
const ROUNDS: usize = 24;

/// A line that hits a corner this exactly passes neither cell beside it. [cells]
const CORNER_CELLS: f64 = 1.0e-9;

/// How closely a piece of the path is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Closeness {
    /// By control points at the distance asked for.
    Loose,
    /// By [`CLOSER`] times as many.
    Close,
    /// As it is.
    Pinned,
}

/// Memory of the rounding, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct Smooth {
    /// Corners of the path, each with its arc length. [m]
    corners: Vec<(Point2<f64>, f64)>,
    /// How closely the path is followed, by interval between control points.
    closeness: Vec<Closeness>,
    /// Dearest cell of the path in each interval.
    dearest: Vec<u8>,
    control: Vec<Point2<f64>>,
    /// Interval that each control point begins.
    interval: Vec<usize>,
    curve: Vec<Point2<f64>>,
    chain: Vec<Cell>,
    /// Intervals in which the curve is not free.
    failed: Vec<(usize, Closeness)>,
}

impl Smooth {
    /// Rounds the path and makes `path.cells` those of the curve, unless it is rounded already or
    /// no piece of it can be, or the curve has more points than a message holds. `spacing_m`:
    /// distance of the control points, at least a cell's side.
    pub(crate) fn run(&mut self, query: &PlanQuery<'_>, spacing_m: f64, path: &mut CellPath) {
        if !path.curve.is_empty() || path.cells.len() < 3 {
            return;
        }
        let n = self.read(query, spacing_m, &path.cells);
        for _ in 0..ROUNDS {
            if self
                .closeness
                .iter()
                .all(|close| *close == Closeness::Pinned)
            {
                return;
            }
            self.place(n);
            if self.draw(query, &path.cells) {
                // A curve that no message holds must not take the place of a path that one does.
                if self.curve.len() <= WAYPOINTS_MAX {
                    core::mem::swap(&mut path.curve, &mut self.curve);
                    core::mem::swap(&mut path.cells, &mut self.chain);
                }
                return;
            }
        }
    }

    /// Reads the path; the number of its intervals.
    fn read(&mut self, query: &PlanQuery<'_>, spacing_m: f64, cells: &[Cell]) -> usize {
        let geometry = query.map.geometry;
        self.corners.clear();
        let mut arc_m = 0.0;
        // The goal itself lies in the last cell, or the path ends at that cell's centre.
        let goal = Some(query.goal.point())
            .filter(|goal| geometry.cell_at(*goal).as_ref() == cells.last());
        let centres = cells.iter().map(|cell| geometry.centre_of(*cell));
        for at in centres.chain(goal) {
            arc_m += self
                .corners
                .last()
                .map_or(0.0, |(last, _)| (at - last).norm());
            self.corners.push((at, arc_m));
        }
        let spacing_m = spacing_m.max(geometry.resolution_m);
        let n = (arc_m / spacing_m).round().to_usize().max(2);
        let interval = |at_m: f64| (at_m / arc_m * n.to_f64()).to_usize().min(n - 1);
        self.closeness.clear();
        self.closeness.resize(n, Closeness::Loose);
        self.dearest.clear();
        self.dearest.resize(n, 0);
        for (pair, arcs) in cells.windows(2).zip(self.corners.windows(2)) {
            let (from_m, line_m) = (arcs[0].1, arcs[1].1 - arcs[0].1);
            supercover(pair[0], pair[1], |crossing| {
                let at = |share: f64| interval(from_m + share * line_m);
                let cell = query.map.get(crossing.cell);
                for n in at(crossing.enters)..=at(crossing.leaves) {
                    self.dearest[n] = self.dearest[n].max(cell.map_or(0, |cell| cell.cost));
                    // The way out of the inflation stays as it is.
                    if cell.is_none_or(|cell| query.unknown.blocks(cell)) {
                        self.closeness[n] = Closeness::Pinned;
                    }
                }
            });
        }
        n
    }

    /// The point of the path at an arc length.
    fn at(&self, at_m: f64) -> Point2<f64> {
        let next = self
            .corners
            .partition_point(|(_, arc_m)| *arc_m < at_m)
            .clamp(1, self.corners.len() - 1);
        let ((a, a_m), (b, b_m)) = (self.corners[next - 1], self.corners[next]);
        let share = if b_m > a_m {
            (at_m - a_m) / (b_m - a_m)
        } else {
            1.0
        };
        a + (b - a) * share.clamp(0.0, 1.0)
    }

    /// Places the control points: one at the beginning of each interval, three where it or the
    /// one before is pinned, and three at every corner inside a pinned one.
    fn place(&mut self, n: usize) {
        let total_m = self.corners.last().map_or(0.0, |(_, arc_m)| *arc_m);
        let step_m = total_m / n.to_f64();
        self.control.clear();
        self.interval.clear();
        for k in 0..=n {
            let pinned = |k: usize| self.closeness.get(k) == Some(&Closeness::Pinned);
            let times = if pinned(k) || k > 0 && pinned(k - 1) {
                3
            } else {
                1
            };
            let from_m = step_m * k.to_f64();
            let here = k.min(n - 1);
            self.control
                .extend(core::iter::repeat_n(self.at(from_m), times));
            self.interval.extend(core::iter::repeat_n(here, times));
            match self.closeness.get(k) {
                Some(Closeness::Close) => {
                    for part in 1..CLOSER {
                        let at_m = from_m + step_m * f64::from(part) / f64::from(CLOSER);
                        self.control.push(self.at(at_m));
                        self.interval.push(here);
                    }
                }
                Some(Closeness::Pinned) => {
                    let inside = |at_m: f64| at_m > from_m && at_m < from_m + step_m;
                    for (corner, arc_m) in &self.corners {
                        if inside(*arc_m) {
                            self.control.extend([*corner; 3]);
                            self.interval.extend([here; 3]);
                        }
                    }
                }
                Some(Closeness::Loose) | None => {}
            }
        }
    }

    /// Draws the curve and its cells. False when it fails the check somewhere: the path has to be
    /// followed more closely there.
    fn draw(&mut self, query: &PlanQuery<'_>, cells: &[Cell]) -> bool {
        let geometry = query.map.geometry;
        self.curve.clear();
        self.chain.clear();
        self.failed.clear();
        let Some(first) = self.control.first() else {
            return false;
        };
        let Some(cell) = geometry.cell_at(*first) else {
            return false;
        };
        self.curve.push(*first);
        self.chain.push(cell);
        let scaled = |point: Point2<f64>| {
            let resolution_m = geometry.resolution_m;
            Point2::new(
                (point.x - geometry.origin_x_m) / resolution_m,
                (point.y - geometry.origin_y_m) / resolution_m,
            )
        };
        let mut legal = true;
        for (k, four) in segments(&self.control, SplineEnds::Phantom).enumerate() {
            let here = self.interval[k.min(self.interval.len() - 1)];
            let most = self.dearest_around(here).saturating_add(DEARER);
            // On the path itself, and not on the transition to it.
            let pinned = |n: usize| self.closeness[n] == Closeness::Pinned;
            let on_path = pinned(here)
                && (four[0] == four[1]
                    || k.checked_sub(1).is_none_or(|k| pinned(self.interval[k])));
            let accept = |cell: Cell| {
                let known = query.map.get(cell);
                let free = known.is_some_and(|cell| !query.unknown.blocks(cell));
                if on_path {
                    // A point on the corner of a cell that the path only touches.
                    (free || cells.contains(&cell)).then_some(true)
                } else {
                    Some(free && known.is_some_and(|cell| cell.cost <= most))
                }
            };
            let is_point = four[1] == four[2] && four[0] == four[1];
            let pieces = if is_point { 1 } else { PIECES };
            for piece in 1..=pieces {
                let from = self.curve[self.curve.len() - 1];
                let to = point_on(&four, f64::from(piece) / f64::from(pieces)).at;
                if (to - from).norm() < 1.0e-6 * geometry.resolution_m {
                    continue;
                }
                if !trace(scaled(from), scaled(to), &mut self.chain, accept) {
                    legal = false;
                    let failure = (here, self.closeness[here]);
                    if self.failed.last() != Some(&failure) {
                        self.failed.push(failure);
                    }
                }
                self.curve.push(to);
            }
        }
        self.follow_failures_closer();
        if legal {
            straighten(query, &mut self.chain);
        }
        legal
    }

    /// Cost of the dearest cell of the path in an interval and the two beside it.
    fn dearest_around(&self, interval: usize) -> u8 {
        let near = interval.saturating_sub(1)..(interval + 2).min(self.dearest.len());
        self.dearest[near].iter().copied().max().unwrap_or(0)
    }

    /// Follows the path more closely where the curve failed. A loose neighbour bends a piece as much
    /// as its own points do.
    fn follow_failures_closer(&mut self) {
        let closeness = &mut self.closeness;
        for (here, was) in self.failed.drain(..) {
            let around = here.saturating_sub(1)..(here + 2).min(closeness.len());
            let loose = around.clone().any(|n| closeness[n] == Closeness::Loose);
            if was != Closeness::Loose && !loose {
                closeness[here] = Closeness::Pinned;
            }
            for close in &mut closeness[around] {
                *close = (*close).max(Closeness::Close);
            }
        }
    }
}

/// Appends the cells of the straight line between two points [cells, from the map's corner] of
/// which `accept` says something; false when it says no of one of them, or of one that the line
/// touches at a corner.
fn trace(
    from: Point2<f64>,
    to: Point2<f64>,
    chain: &mut Vec<Cell>,
    accept: impl Fn(Cell) -> Option<bool>,
) -> bool {
    let cell_of =
        |point: Point2<f64>| Cell::new(point.x.floor().to_i32(), point.y.floor().to_i32());
    let (mut at, last) = (cell_of(from), cell_of(to));
    let along = to - from;
    let mut free = true;
    let mut push = |cell: Cell, chain: &mut Vec<Cell>| {
        if chain.last() != Some(&cell)
            && let Some(accepted) = accept(cell)
        {
            chain.push(cell);
            free &= accepted;
        }
    };
    let mut corners = true;
    push(at, chain);
    let border = |at: i32, from: f64, along: f64| {
        let next = f64::from(at) + if along > 0.0 { 1.0 } else { 0.0 };
        if along == 0.0 {
            f64::INFINITY
        } else {
            (next - from) / along
        }
    };
    let step = |along: f64| if along > 0.0 { 1 } else { -1 };
    // Every step comes nearer by one cell.
    for _ in 0..(last.x - at.x).abs() + (last.y - at.y).abs() {
        if at == last {
            break;
        }
        let tx = if at.x == last.x {
            f64::INFINITY
        } else {
            border(at.x, from.x, along.x)
        };
        let ty = if at.y == last.y {
            f64::INFINITY
        } else {
            border(at.y, from.y, along.y)
        };
        if (tx - ty).abs() * along.norm() < CORNER_CELLS {
            let next = Cell::new(at.x + step(along.x), at.y + step(along.y));
            let beside = [Cell::new(next.x, at.y), Cell::new(at.x, next.y)];
            corners &= beside.into_iter().all(|cell| accept(cell) != Some(false));
            at = next;
        } else if tx < ty {
            at.x += step(along.x);
        } else {
            at.y += step(along.y);
        }
        push(at, chain);
    }
    free && corners
}

/// Takes a diagonal step for two straight ones round a corner where it is legal under every rule.
fn straighten(query: &PlanQuery<'_>, chain: &mut Vec<Cell>) {
    let free = |x: i32, y: i32| {
        let cell = query.map.get(Cell::new(x, y));
        cell.is_some_and(|cell| !query.unknown.blocks(cell))
    };
    let mut kept = 0;
    for n in 0..chain.len() {
        let cell = chain[n];
        if kept >= 2 {
            let before = chain[kept - 2];
            let diagonal = (cell.x - before.x).abs() == 1 && (cell.y - before.y).abs() == 1;
            if cell == before {
                kept -= 1;
                continue;
            }
            if diagonal
                && free(before.x, before.y)
                && free(cell.x, before.y)
                && free(before.x, cell.y)
            {
                kept -= 1;
            }
        }
        chain[kept] = cell;
        kept += 1;
    }
    chain.truncate(kept);
}
