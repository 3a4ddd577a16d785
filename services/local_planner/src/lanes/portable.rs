//! The meaning of the kernels.

#![allow(
    clippy::inline_always,
    reason = "compiled once more with AVX2 only where it is inlined"
)]

use super::data::{
    LANES_MAX, Lanes, Projection, Projections, SAMPLE_BITS, Sheet, Stretch, Turns, WIDTH, narrow,
};
use zeronav_casts::Cast;
use zeronav_msgs::MapCell;

#[inline(always)]
pub(super) fn strike(x: &[f32], y: &[f32], disc: [f32; 3], step: f32, first: &mut [f32]) {
    let squared = disc[2] * disc[2];
    for ((x, y), first) in x.iter().zip(y).zip(first) {
        let (dx, dy) = (x - disc[0], y - disc[1]);
        let struck = if dx * dx + dy * dy < squared {
            step
        } else {
            f32::INFINITY
        };
        *first = if struck < *first { struck } else { *first };
    }
}

#[inline(always)]
pub(super) fn advance(
    driven: f32,
    chord: (&[f32], &[f32]),
    from: (&[f32], &[f32]),
    x: &mut [f32],
    y: &mut [f32],
) {
    for ((x, from), chord) in x.iter_mut().zip(from.0).zip(chord.0) {
        *x = from + driven * chord;
    }
    for ((y, from), chord) in y.iter_mut().zip(from.1).zip(chord.1) {
        *y = from + driven * chord;
    }
}

#[allow(clippy::needless_range_loop, reason = "a dozen arrays lane by lane")]
#[inline(always)]
pub(super) fn turn(
    n: usize,
    turns: &mut Turns,
    (chord_x, chord_y): (&mut Lanes, &mut Lanes),
    (cos, sin): (&mut Lanes, &mut Lanes),
    turned: &mut Lanes,
) {
    for i in 0..n.min(LANES_MAX) {
        let (half_cos, half_sin) = (turns.half_cos[i], turns.half_sin[i]);
        let from = (turns.cos[i], turns.sin[i]);
        // The chord points along half the step's turn.
        let along = (
            from.0 * half_cos - from.1 * half_sin,
            from.1 * half_cos + from.0 * half_sin,
        );
        chord_x[i] = narrow(turns.chord[i] * along.0);
        chord_y[i] = narrow(turns.chord[i] * along.1);
        turns.cos[i] = along.0 * half_cos - along.1 * half_sin;
        turns.sin[i] = along.1 * half_cos + along.0 * half_sin;
        cos[i] = narrow(turns.cos[i]);
        sin[i] = narrow(turns.sin[i]);
        turns.turned[i] += turns.angle[i];
        turned[i] = narrow(turns.turned[i]);
    }
}

#[inline(always)]
pub(super) fn note_space(
    space: &[f32],
    (need, step, counts): (f32, f32, bool),
    hit: &mut [f32],
    least: &mut [f32],
) {
    for ((space, hit), least) in space.iter().zip(hit).zip(least) {
        let first = if *space < need { step } else { f32::INFINITY };
        *hit = if first < *hit { first } else { *hit };
        let seen = counts && *hit > step && *space < *least;
        *least = if seen { *space } else { *least };
    }
}

#[inline(always)]
pub(super) fn lower_block(
    cells: &mut [f32],
    (from, to, side): (usize, usize, usize),
    (x, y): (f32, f32),
    scale: f32,
) {
    for (row, cells) in cells.chunks_exact_mut(side).enumerate() {
        let dy = (row.to_f32() - y) * scale;
        for (cell, column) in cells[from..=to].iter_mut().zip(from.to_i32()..) {
            let dx = (column.to_f32() - x) * scale;
            let squared = dx * dx + dy * dy;
            *cell = if squared < *cell { squared } else { *cell };
        }
    }
}

#[inline(always)]
pub(super) fn settle_row(cells: &mut [f32], squared: &mut [f32]) {
    for (cell, squared) in cells.iter_mut().zip(squared) {
        let distance = squared.sqrt();
        *cell = if distance < *cell { distance } else { *cell };
        *squared = f32::INFINITY;
    }
}

#[inline(always)]
pub(super) fn clearances(cells: &[MapCell], clearances: &mut [f32]) {
    for (to, from) in clearances.iter_mut().zip(cells) {
        *to = f32::from(from.clearance_mm) * 1.0e-3;
    }
}

/// The nearest place on a stretch of at most 32 samples.
fn place_on(stretch: &Stretch, x: f32, y: f32) -> Projection {
    // The squared distance with the sample's index in its last five bits (micrometres), so
    // that a minimum finds both without branches: numbers that are not negative are in the
    // order of their bits.
    let mut key = f32::MAX.to_bits();
    for (i, bits) in (0..stretch.n.max(1)).zip(0_u32..) {
        let (dx, dy) = (stretch.x[i] - x, stretch.y[i] - y);
        key = key.min(((dx * dx + dy * dy).to_bits() & !SAMPLE_BITS) | bits);
    }
    let nearest = (key & SAMPLE_BITS) as usize;
    let direction = (stretch.direction_x[nearest], stretch.direction_y[nearest]);
    let Some(last) = stretch.n.checked_sub(2) else {
        return Projection {
            along: stretch.start[nearest],
            beside: f32::from_bits(key & !SAMPLE_BITS).sqrt(),
            direction,
        };
    };
    // The nearest point lies on one of the two ways that meet at the nearest sample.
    let on = |i: usize| {
        let (dx, dy) = (x - stretch.x[i], y - stretch.y[i]);
        let along = (dx * stretch.step_x[i] + dy * stretch.step_y[i]) * stretch.inverse[i];
        let along = along.clamp(0.0, 1.0);
        let (dx, dy) = (
            dx - along * stretch.step_x[i],
            dy - along * stretch.step_y[i],
        );
        let squared = dx * dx + dy * dy;
        (squared, stretch.start[i] + along * stretch.arc[i])
    };
    let before = on(nearest.saturating_sub(1).min(last));
    let after = on(nearest.min(last));
    let (squared, along) = if after.0 < before.0 { after } else { before };
    Projection {
        along,
        beside: squared.sqrt(),
        direction,
    }
}

/// See [`super::places_on`].
pub(super) fn places_on(stretch: &Stretch, x: &[f32], y: &[f32], found: &mut Projections) {
    for (i, (x, y)) in x.iter().zip(y).enumerate().take(LANES_MAX) {
        let place = place_on(stretch, *x, *y);
        found.along[i] = place.along;
        found.beside[i] = place.beside;
        (found.direction_x[i], found.direction_y[i]) = place.direction;
    }
}

fn nearest(sheet: &Sheet<'_>, x: f32, y: f32) -> f32 {
    let last = sheet.side - 1;
    let column = (x * sheet.inverse + sheet.centre.0 + 0.5)
        .to_i32()
        .clamp(0, last);
    let row = (y * sheet.inverse + sheet.centre.1 + 0.5)
        .to_i32()
        .clamp(0, last);
    sheet.cells[(row * sheet.side + column).to_usize()]
}

pub(super) fn least_nearest_m(sheet: &Sheet<'_>, x: &[f32], y: &[f32]) -> f32 {
    x.iter().zip(y).fold(f32::INFINITY, |least, (x, y)| {
        least.min(nearest(sheet, *x, *y))
    })
}

/// See [`crate::field::ClearanceField::bound_m`].
fn bound(sheet: &Sheet<'_>, x: f32, y: f32) -> f32 {
    let last = (sheet.side - 2).to_f32();
    let u = (x * sheet.inverse + sheet.centre.0).clamp(0.0, last);
    let v = (y * sheet.inverse + sheet.centre.1).clamp(0.0, last);
    let (column, row) = (u.to_i32(), v.to_i32());
    let (fu, fv) = (u - column.to_f32(), v - row.to_f32());
    let start = (row * sheet.side + column).to_usize();
    let side = sheet.side.to_usize();
    let (b0, b1) = (sheet.cells[start], sheet.cells[start + 1]);
    let (a0, a1) = (sheet.cells[start + side], sheet.cells[start + side + 1]);
    let low = b0 + (b1 - b0) * fu;
    let high = a0 + (a1 - a0) * fu;
    let value = low + (high - low) * fv;
    let h = sheet.resolution_m;
    if value > 1.5 * h {
        value - h * h / (8.0 * (value - core::f32::consts::FRAC_1_SQRT_2 * h))
    } else {
        let (du, dv) = (fu.min(1.0 - fu), fv.min(1.0 - fv));
        let below = if fu < 0.5 { b0 } else { b1 };
        let above = if fu < 0.5 { a0 } else { a1 };
        let nearest = if fv < 0.5 { below } else { above };
        nearest - (du * du + dv * dv).sqrt() * h
    }
}

pub(super) fn lower_space_around(
    sheet: &Sheet<'_>,
    (x, y): (&[f32], &[f32]),
    (cos, sin): (&[f32], &[f32]),
    (discs, need): (&[[f32; 3]], f32),
    space: &mut [f32],
) {
    for start in (0..x.len()).step_by(WIDTH) {
        let space = &mut space[start..start + WIDTH];
        for [dx, dy, radius] in discs {
            let (mut at_x, mut at_y) = ([0.0_f32; WIDTH], [0.0_f32; WIDTH]);
            for i in 0..WIDTH {
                let (cos, sin) = (cos[start + i], sin[start + i]);
                at_x[i] = x[start + i] + cos * dx - sin * dy;
                at_y[i] = y[start + i] + sin * dx + cos * dy;
            }
            lower_space(sheet, &at_x, &at_y, *radius, space);
            if space.iter().all(|space| *space < need) {
                break;
            }
        }
    }
}

pub(super) fn lower_space(
    sheet: &Sheet<'_>,
    x: &[f32],
    y: &[f32],
    radius_m: f32,
    space: &mut [f32],
) {
    let slack = core::f32::consts::FRAC_1_SQRT_2 * sheet.resolution_m;
    for ((x, y), space) in x.iter().zip(y).zip(space) {
        if nearest(sheet, *x, *y) < radius_m + *space + slack {
            *space = space.min(bound(sheet, *x, *y) - radius_m);
        }
    }
}
