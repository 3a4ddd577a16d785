//! Clearance for many positions at once: eight lanes of AVX2 where the processor has them, and the
//! same numbers, bit for bit, without.
//!
//! This is the one file of the package with `unsafe`: the gathers read through a pointer, and the
//! choice of the instruction set is made at run time. The portable twin is the meaning; the tests
//! compare the two. Where no gather is needed the twin itself is compiled a second time with AVX2
//! allowed; without contraction of products and sums that gives the same bits.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "indices of a window of at most 1024 cells, clamped before use"
)]

use crate::dwa::row::{Rated, TimedWorth};
use crate::fan::{LANES_MAX, Lanes, Turns};
use crate::field::Sheet;
use crate::local_path::{Projection, Projections, SAMPLES, Stretch};
use crate::surroundings::narrow;
use zeronav_msgs::MapCell;

/// Lanes that are worked on together; slices are multiples of it.
pub(crate) const WIDTH: usize = 8;

/// Least clearance at the cells that hold the positions, at most infinity. [m]
///
/// The slices are equally long, a multiple of [`WIDTH`].
pub(crate) fn least_nearest_m(sheet: &Sheet<'_>, x: &[f32], y: &[f32]) -> f32 {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_here(sheet) {
        // SAFETY: the processor has AVX2, and the sheet holds side x side cells.
        #[allow(unsafe_code, reason = "chosen at run time")]
        return unsafe { avx2::least_nearest_m(sheet, x, y) };
    }
    portable::least_nearest_m(sheet, x, y)
}

/// Lowers `space` at every lane to the bound on the clearance less `radius_m`, unless the cell
/// that holds the position already tells that it would not be lower. [m]
///
/// All slices are equally long, a multiple of [`WIDTH`].
pub(crate) fn lower_space(
    sheet: &Sheet<'_>,
    x: &[f32],
    y: &[f32],
    radius_m: f32,
    space: &mut [f32],
) {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_here(sheet) {
        // SAFETY: the processor has AVX2, and the sheet holds side x side cells.
        #[allow(unsafe_code, reason = "chosen at run time")]
        unsafe {
            avx2::lower_space(sheet, x, y, radius_m, space);
        }
        return;
    }
    portable::lower_space(sheet, x, y, radius_m, space);
}

/// [`lower_space`] around an outline covered by `discs` (x, y in `base`, radius), at headings with
/// this cosine and sine. Exact where the space stays at least `need`. [m]
///
/// All slices are equally long, a multiple of [`WIDTH`].
pub(crate) fn lower_space_around(
    sheet: &Sheet<'_>,
    at: (&[f32], &[f32]),
    heading: (&[f32], &[f32]),
    (discs, need): (&[[f32; 3]], f32),
    space: &mut [f32],
) {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_here(sheet) {
        // SAFETY: the processor has AVX2, and the sheet holds side x side cells.
        #[allow(unsafe_code, reason = "chosen at run time")]
        unsafe {
            avx2::lower_space_around(sheet, at, heading, (discs, need), space);
        }
        return;
    }
    portable::lower_space_around(sheet, at, heading, (discs, need), space);
}

/// Bits of a number that tell a sample of a stretch.
const SAMPLE: u32 = SAMPLES as u32 - 1;

/// The nearest place on a stretch of at most 32 samples.
pub(crate) fn place_on(stretch: &Stretch, x: f32, y: f32) -> Projection {
    portable::place_on(stretch, x, y)
}

/// [`place_on`] for a multiple of [`WIDTH`] points, at most [`LANES_MAX`].
pub(crate) fn places_on(stretch: &Stretch, x: &[f32], y: &[f32], found: &mut Projections) {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && stretch.n >= 2 {
        // SAFETY: the processor has AVX2.
        #[allow(unsafe_code, reason = "chosen at run time")]
        unsafe {
            avx2::places_on(stretch, x, y, found);
        }
        return;
    }
    portable::places_on(stretch, x, y, found);
}

/// Compiles a portable kernel twice and chooses at run time.
macro_rules! compiled_twice {
    ($($(#[$meta:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?);)*) => {
        $(
            $(#[$meta])*
            pub(crate) fn $name($($argument: $type),*) {
                #[cfg(target_arch = "x86_64")]
                {
                    #[target_feature(enable = "avx2")]
                    fn wide($($argument: $type),*) {
                        portable::$name($($argument),*);
                    }
                    if std::is_x86_feature_detected!("avx2") {
                        // SAFETY: the processor has AVX2.
                        #[allow(unsafe_code, reason = "chosen at run time")]
                        return unsafe { wide($($argument),*) };
                    }
                }
                portable::$name($($argument),*);
            }
        )*
    };
}

compiled_twice! {
    /// Marks `first` with `step` at the lanes that are nearer to the centre of a disc (x, y,
    /// radius) than its radius, unless an earlier step stands there.
    fn strike(x: &[f32], y: &[f32], disc: [f32; 3], step: f32, first: &mut [f32]);

    /// One step of a row: the ends of chords of `driven` metres.
    fn advance(
        driven: f32,
        chord: (&[f32], &[f32]),
        from: (&[f32], &[f32]),
        x: &mut [f32],
        y: &mut [f32],
    );

    /// One step of the turns of `n` lanes: chords per metre driven (x, y), headings at its end
    /// (cosine, sine), and what was turned until then. [rad]
    fn turn(
        n: usize,
        turns: &mut Turns,
        chords: (&mut Lanes, &mut Lanes),
        headings: (&mut Lanes, &mut Lanes),
        turned: &mut Lanes,
    );

    /// With (need, step, counts): marks the lanes with less than `need` as hit in `step` unless
    /// they were hit before, and lowers the least space of those that were not, when it `counts`.
    fn note_space(
        space: &[f32],
        terms: (f32, f32, bool),
        hit: &mut [f32],
        least: &mut [f32],
    );

    /// What the rollouts of a speed with these yaw rates are worth.
    fn rate(terms: &TimedWorth, yaw_rates: &[f64], rated: &mut Rated);

    /// Lowers squared distances in whole rows of `side` cells, between the columns `from` and `to`
    /// (inclusive), to those from a point `at` (column, row). Cells are `scale` metres wide. [m^2]
    fn lower_block(
        cells: &mut [f32],
        columns: (usize, usize, usize),
        at: (f32, f32),
        scale: f32,
    );

    /// Lowers clearances to the roots of squared distances, and forgets these.
    fn settle_row(cells: &mut [f32], squared: &mut [f32]);

    /// Clearances of a row of the map. [m]
    fn clearances(cells: &[MapCell], clearances: &mut [f32]);
}

/// The meaning of the kernels.
#[allow(
    clippy::inline_always,
    reason = "compiled once more with AVX2 only where it is inlined"
)]
mod portable {
    use super::{
        LANES_MAX, Lanes, MapCell, Projection, Projections, Rated, SAMPLE, Sheet, Stretch,
        TimedWorth, Turns, WIDTH, narrow,
    };

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
    pub(super) fn rate(terms: &TimedWorth, yaw_rates: &[f64], rated: &mut Rated) {
        rated.rate(terms, yaw_rates);
    }

    #[inline(always)]
    pub(super) fn lower_block(
        cells: &mut [f32],
        (from, to, side): (usize, usize, usize),
        (x, y): (f32, f32),
        scale: f32,
    ) {
        for (row, cells) in cells.chunks_exact_mut(side).enumerate() {
            let dy = (row as f32 - y) * scale;
            for (cell, column) in cells[from..=to].iter_mut().zip(from as i32..) {
                let dx = (column as f32 - x) * scale;
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

    /// See [`super::place_on`].
    pub(super) fn place_on(stretch: &Stretch, x: f32, y: f32) -> Projection {
        // The squared distance with the sample's index in its last five bits (micrometres), so
        // that a minimum finds both without branches: numbers that are not negative are in the
        // order of their bits.
        let mut key = f32::MAX.to_bits();
        for (i, bits) in (0..stretch.n.max(1)).zip(0_u32..) {
            let (dx, dy) = (stretch.x[i] - x, stretch.y[i] - y);
            key = key.min(((dx * dx + dy * dy).to_bits() & !SAMPLE) | bits);
        }
        let nearest = (key & SAMPLE) as usize;
        let direction = (stretch.direction_x[nearest], stretch.direction_y[nearest]);
        let Some(last) = stretch.n.checked_sub(2) else {
            return Projection {
                along: stretch.start[nearest],
                beside: f32::from_bits(key & !SAMPLE).sqrt(),
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
        let column = ((x * sheet.inverse + sheet.centre.0 + 0.5) as i32).clamp(0, last);
        let row = ((y * sheet.inverse + sheet.centre.1 + 0.5) as i32).clamp(0, last);
        sheet.cells[(row * sheet.side + column) as usize]
    }

    pub(super) fn least_nearest_m(sheet: &Sheet<'_>, x: &[f32], y: &[f32]) -> f32 {
        x.iter().zip(y).fold(f32::INFINITY, |least, (x, y)| {
            least.min(nearest(sheet, *x, *y))
        })
    }

    /// See [`crate::field::ClearanceField::bound_m`].
    fn bound(sheet: &Sheet<'_>, x: f32, y: f32) -> f32 {
        let last = (sheet.side - 2) as f32;
        let u = (x * sheet.inverse + sheet.centre.0).clamp(0.0, last);
        let v = (y * sheet.inverse + sheet.centre.1).clamp(0.0, last);
        let (column, row) = (u as i32, v as i32);
        let (fu, fv) = (u - column as f32, v - row as f32);
        let start = (row * sheet.side + column) as usize;
        let side = sheet.side as usize;
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
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "gathers read through a pointer")]
mod avx2 {
    use super::{LANES_MAX, Projections, SAMPLE, SAMPLES, Sheet, Stretch, WIDTH};
    use core::arch::x86_64::{
        __m256, __m256i, _CMP_GT_OQ, _CMP_LT_OQ, _mm256_add_epi32, _mm256_add_ps, _mm256_and_si256,
        _mm256_andnot_si256, _mm256_blendv_ps, _mm256_castps_si256, _mm256_castsi256_ps,
        _mm256_cmp_ps, _mm256_cvtepi32_ps, _mm256_cvttps_epi32, _mm256_div_ps, _mm256_i32gather_ps,
        _mm256_loadu_ps, _mm256_max_epi32, _mm256_max_ps, _mm256_min_epi32, _mm256_min_epu32,
        _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_mullo_epi32, _mm256_or_si256,
        _mm256_permutevar8x32_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_setzero_ps,
        _mm256_setzero_si256, _mm256_slli_epi32, _mm256_sqrt_ps, _mm256_storeu_ps,
        _mm256_sub_epi32, _mm256_sub_ps,
    };

    /// True when the kernels may be called with this sheet.
    pub(super) fn is_here(sheet: &Sheet<'_>) -> bool {
        let side = sheet.side.max(0) as usize;
        std::is_x86_feature_detected!("avx2") && side >= 2 && sheet.cells.len() >= side * side
    }

    /// Clearance at the cells that hold eight positions.
    #[target_feature(enable = "avx2")]
    unsafe fn nearest(sheet: &Sheet<'_>, x: __m256, y: __m256) -> __m256 {
        let inverse = _mm256_set1_ps(sheet.inverse);
        let half = _mm256_set1_ps(0.5);
        let (zero, last) = (_mm256_setzero_si256(), _mm256_set1_epi32(sheet.side - 1));
        let index = |at: __m256, centre: f32| -> __m256i {
            let shifted = _mm256_add_ps(_mm256_mul_ps(at, inverse), _mm256_set1_ps(centre));
            let index = _mm256_cvttps_epi32(_mm256_add_ps(shifted, half));
            _mm256_min_epi32(_mm256_max_epi32(index, zero), last)
        };
        let (column, row) = (index(x, sheet.centre.0), index(y, sheet.centre.1));
        let start = _mm256_mullo_epi32(row, _mm256_set1_epi32(sheet.side));
        // SAFETY: both indices are clamped to the sheet, which holds side x side cells.
        unsafe { _mm256_i32gather_ps::<4>(sheet.cells.as_ptr(), _mm256_add_epi32(start, column)) }
    }

    /// See the portable twin.
    ///
    /// # Safety
    /// Only where [`is_here`] says so.
    #[target_feature(enable = "avx2")]
    pub(super) unsafe fn least_nearest_m(sheet: &Sheet<'_>, x: &[f32], y: &[f32]) -> f32 {
        let mut least = _mm256_set1_ps(f32::INFINITY);
        for (x, y) in x.chunks_exact(WIDTH).zip(y.chunks_exact(WIDTH)) {
            // SAFETY: chunks of eight; the caller vouches for the sheet.
            unsafe {
                let at = (_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(y.as_ptr()));
                least = _mm256_min_ps(least, nearest(sheet, at.0, at.1));
            }
        }
        let mut lanes = [0.0_f32; WIDTH];
        // SAFETY: eight lanes.
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), least) };
        lanes.into_iter().fold(f32::INFINITY, f32::min)
    }

    /// The portable `bound` for eight positions, the same operations in the same order.
    #[target_feature(enable = "avx2")]
    unsafe fn bound(sheet: &Sheet<'_>, x: __m256, y: __m256) -> __m256 {
        let inverse = _mm256_set1_ps(sheet.inverse);
        let zero = _mm256_setzero_ps();
        let last = _mm256_set1_ps((sheet.side - 2) as f32);
        let place = |at: __m256, centre: f32| {
            let shifted = _mm256_add_ps(_mm256_mul_ps(at, inverse), _mm256_set1_ps(centre));
            _mm256_min_ps(_mm256_max_ps(shifted, zero), last)
        };
        let (u, v) = (place(x, sheet.centre.0), place(y, sheet.centre.1));
        let (column, row) = (_mm256_cvttps_epi32(u), _mm256_cvttps_epi32(v));
        let fu = _mm256_sub_ps(u, _mm256_cvtepi32_ps(column));
        let fv = _mm256_sub_ps(v, _mm256_cvtepi32_ps(row));
        let side = _mm256_set1_epi32(sheet.side);
        let start = _mm256_add_epi32(_mm256_mullo_epi32(row, side), column);
        let up = _mm256_add_epi32(start, side);
        let base = sheet.cells.as_ptr();
        let one = _mm256_set1_epi32(1);
        // SAFETY: the places are clamped below the last cell, so all four neighbours exist.
        let (b0, b1, a0, a1) = unsafe {
            (
                _mm256_i32gather_ps::<4>(base, start),
                _mm256_i32gather_ps::<4>(base, _mm256_add_epi32(start, one)),
                _mm256_i32gather_ps::<4>(base, up),
                _mm256_i32gather_ps::<4>(base, _mm256_add_epi32(up, one)),
            )
        };
        let between = |from: __m256, to: __m256, share: __m256| {
            _mm256_add_ps(from, _mm256_mul_ps(_mm256_sub_ps(to, from), share))
        };
        let low = between(b0, b1, fu);
        let high = between(a0, a1, fu);
        let value = between(low, high, fv);
        let h = sheet.resolution_m;
        let ridge = _mm256_set1_ps(core::f32::consts::FRAC_1_SQRT_2 * h);
        let curved = _mm256_div_ps(
            _mm256_set1_ps(h * h),
            _mm256_mul_ps(_mm256_set1_ps(8.0), _mm256_sub_ps(value, ridge)),
        );
        let far = _mm256_sub_ps(value, curved);
        let unit = _mm256_set1_ps(1.0);
        let du = _mm256_min_ps(fu, _mm256_sub_ps(unit, fu));
        let dv = _mm256_min_ps(fv, _mm256_sub_ps(unit, fv));
        let half = _mm256_set1_ps(0.5);
        let left = _mm256_cmp_ps::<_CMP_LT_OQ>(fu, half);
        let lower = _mm256_cmp_ps::<_CMP_LT_OQ>(fv, half);
        let below = _mm256_blendv_ps(b1, b0, left);
        let above = _mm256_blendv_ps(a1, a0, left);
        let corner = _mm256_blendv_ps(above, below, lower);
        let squared = _mm256_add_ps(_mm256_mul_ps(du, du), _mm256_mul_ps(dv, dv));
        let way = _mm256_mul_ps(_mm256_sqrt_ps(squared), _mm256_set1_ps(h));
        let near = _mm256_sub_ps(corner, way);
        let is_far = _mm256_cmp_ps::<_CMP_GT_OQ>(value, _mm256_set1_ps(1.5 * h));
        _mm256_blendv_ps(near, far, is_far)
    }

    /// Entries of a table at eight samples; bits 3 and 4 of the indices lie in the signs of `high`.
    #[target_feature(enable = "avx2")]
    fn look_up(table: &[f32; SAMPLES], at: __m256i, high: (__m256, __m256)) -> __m256 {
        let part = |n: usize| {
            // SAFETY: four parts of eight.
            let part = unsafe { _mm256_loadu_ps(table[WIDTH * n..][..WIDTH].as_ptr()) };
            _mm256_permutevar8x32_ps(part, at)
        };
        let low = _mm256_blendv_ps(part(0), part(1), high.0);
        _mm256_blendv_ps(low, _mm256_blendv_ps(part(2), part(3), high.0), high.1)
    }

    /// The nearest place on eight ways of a stretch: squared distance, and along the path.
    #[target_feature(enable = "avx2")]
    fn nearest_on(stretch: &Stretch, at: (__m256, __m256), way: __m256i) -> (__m256, __m256) {
        let high = high_bits(way);
        let of = |table: &[f32; SAMPLES]| look_up(table, way, high);
        let (step_x, step_y) = (of(&stretch.step_x), of(&stretch.step_y));
        let dx = _mm256_sub_ps(at.0, of(&stretch.x));
        let dy = _mm256_sub_ps(at.1, of(&stretch.y));
        let dot = _mm256_add_ps(_mm256_mul_ps(dx, step_x), _mm256_mul_ps(dy, step_y));
        let share = _mm256_mul_ps(dot, of(&stretch.inverse));
        let share = _mm256_max_ps(_mm256_setzero_ps(), share);
        let share = _mm256_min_ps(_mm256_set1_ps(1.0), share);
        let dx = _mm256_sub_ps(dx, _mm256_mul_ps(share, step_x));
        let dy = _mm256_sub_ps(dy, _mm256_mul_ps(share, step_y));
        let squared = _mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy));
        let along = _mm256_mul_ps(share, of(&stretch.arc));
        (squared, _mm256_add_ps(of(&stretch.start), along))
    }

    /// Bits 3 and 4 of eight indices as signs.
    #[target_feature(enable = "avx2")]
    fn high_bits(index: __m256i) -> (__m256, __m256) {
        (
            _mm256_castsi256_ps(_mm256_slli_epi32::<28>(index)),
            _mm256_castsi256_ps(_mm256_slli_epi32::<27>(index)),
        )
    }

    /// See the portable twin; for at least two samples.
    #[target_feature(enable = "avx2")]
    pub(super) fn places_on(stretch: &Stretch, x: &[f32], y: &[f32], found: &mut Projections) {
        let n = stretch.n.min(SAMPLES);
        let last = _mm256_set1_epi32(n as i32 - 2);
        let (zero, one) = (_mm256_setzero_si256(), _mm256_set1_epi32(1));
        let sample = _mm256_set1_epi32(SAMPLE as i32);
        let places = x.chunks_exact(WIDTH).zip(y.chunks_exact(WIDTH));
        for (start, (x, y)) in (0..LANES_MAX).step_by(WIDTH).zip(places) {
            // SAFETY: chunks of eight.
            let at = unsafe { (_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(y.as_ptr())) };
            let mut key = _mm256_set1_epi32(f32::MAX.to_bits() as i32);
            let mut index = zero;
            for (x, y) in stretch.x[..n].iter().zip(&stretch.y[..n]) {
                let dx = _mm256_sub_ps(_mm256_set1_ps(*x), at.0);
                let dy = _mm256_sub_ps(_mm256_set1_ps(*y), at.1);
                let squared = _mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy));
                let bits = _mm256_andnot_si256(sample, _mm256_castps_si256(squared));
                key = _mm256_min_epu32(key, _mm256_or_si256(bits, index));
                index = _mm256_add_epi32(index, one);
            }
            let nearest = _mm256_and_si256(key, sample);
            let before = _mm256_max_epi32(_mm256_sub_epi32(nearest, one), zero);
            let before = nearest_on(stretch, at, _mm256_min_epi32(before, last));
            let after = nearest_on(stretch, at, _mm256_min_epi32(nearest, last));
            let nearer = _mm256_cmp_ps::<_CMP_LT_OQ>(after.0, before.0);
            let squared = _mm256_blendv_ps(before.0, after.0, nearer);
            let high = high_bits(nearest);
            let lanes = start..start + WIDTH;
            let put = |to: &mut [f32; LANES_MAX], value: __m256| {
                // SAFETY: eight lanes.
                unsafe { _mm256_storeu_ps(to[lanes.clone()].as_mut_ptr(), value) };
            };
            put(
                &mut found.along,
                _mm256_blendv_ps(before.1, after.1, nearer),
            );
            put(&mut found.beside, _mm256_sqrt_ps(squared));
            put(
                &mut found.direction_x,
                look_up(&stretch.direction_x, nearest, high),
            );
            put(
                &mut found.direction_y,
                look_up(&stretch.direction_y, nearest, high),
            );
        }
    }

    /// See the portable twin.
    ///
    /// # Safety
    /// Only where [`is_here`] says so.
    #[target_feature(enable = "avx2")]
    pub(super) unsafe fn lower_space(
        sheet: &Sheet<'_>,
        x: &[f32],
        y: &[f32],
        radius_m: f32,
        space: &mut [f32],
    ) {
        let slack = _mm256_set1_ps(core::f32::consts::FRAC_1_SQRT_2 * sheet.resolution_m);
        let radius = _mm256_set1_ps(radius_m);
        let places = x.chunks_exact(WIDTH).zip(y.chunks_exact(WIDTH));
        for ((x, y), space) in places.zip(space.chunks_exact_mut(WIDTH)) {
            // SAFETY: chunks of eight; the caller vouches for the sheet.
            unsafe {
                let (x, y) = (_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(y.as_ptr()));
                let now = _mm256_loadu_ps(space.as_ptr());
                let enough = _mm256_add_ps(_mm256_add_ps(radius, now), slack);
                let short = _mm256_cmp_ps::<_CMP_LT_OQ>(nearest(sheet, x, y), enough);
                if _mm256_movemask_ps(short) == 0 {
                    continue;
                }
                let lowered = _mm256_min_ps(now, _mm256_sub_ps(bound(sheet, x, y), radius));
                let chosen = _mm256_blendv_ps(now, lowered, short);
                _mm256_storeu_ps(space.as_mut_ptr(), chosen);
            }
        }
    }

    /// See the portable twin.
    ///
    /// # Safety
    /// Only where [`is_here`] says so.
    #[target_feature(enable = "avx2")]
    pub(super) unsafe fn lower_space_around(
        sheet: &Sheet<'_>,
        at: (&[f32], &[f32]),
        heading: (&[f32], &[f32]),
        (discs, need): (&[[f32; 3]], f32),
        space: &mut [f32],
    ) {
        let slack = _mm256_set1_ps(core::f32::consts::FRAC_1_SQRT_2 * sheet.resolution_m);
        let need = _mm256_set1_ps(need);
        let places = at.0.chunks_exact(WIDTH).zip(at.1.chunks_exact(WIDTH));
        let headings = heading
            .0
            .chunks_exact(WIDTH)
            .zip(heading.1.chunks_exact(WIDTH));
        let lanes = places.zip(headings).zip(space.chunks_exact_mut(WIDTH));
        for (((x, y), (cos, sin)), space) in lanes {
            // SAFETY: chunks of eight; the caller vouches for the sheet.
            unsafe {
                let (x, y) = (_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(y.as_ptr()));
                let (cos, sin) = (_mm256_loadu_ps(cos.as_ptr()), _mm256_loadu_ps(sin.as_ptr()));
                let mut now = _mm256_loadu_ps(space.as_ptr());
                for disc in discs {
                    let (dx, dy) = (_mm256_set1_ps(disc[0]), _mm256_set1_ps(disc[1]));
                    let radius = _mm256_set1_ps(disc[2]);
                    let at_x = _mm256_sub_ps(
                        _mm256_add_ps(x, _mm256_mul_ps(cos, dx)),
                        _mm256_mul_ps(sin, dy),
                    );
                    let at_y = _mm256_add_ps(
                        _mm256_add_ps(y, _mm256_mul_ps(sin, dx)),
                        _mm256_mul_ps(cos, dy),
                    );
                    let enough = _mm256_add_ps(_mm256_add_ps(radius, now), slack);
                    let short = _mm256_cmp_ps::<_CMP_LT_OQ>(nearest(sheet, at_x, at_y), enough);
                    if _mm256_movemask_ps(short) != 0 {
                        let bound = bound(sheet, at_x, at_y);
                        let lowered = _mm256_min_ps(now, _mm256_sub_ps(bound, radius));
                        now = _mm256_blendv_ps(now, lowered, short);
                    }
                    let blocked = _mm256_cmp_ps::<_CMP_LT_OQ>(now, need);
                    if _mm256_movemask_ps(blocked) == 0xFF {
                        break;
                    }
                }
                _mm256_storeu_ps(space.as_mut_ptr(), now);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    #[test]
    fn the_twins_agree_bit_for_bit() {
        let mut random = Pcg32::seed_from_u64(5);
        let side = 61;
        let cells: Vec<f32> = (0..side * side)
            .map(|_| random.random_range(0.0..0.8))
            .collect();
        let sheet = Sheet {
            cells: &cells,
            side,
            centre: (30.2, 29.7),
            resolution_m: 0.05,
            inverse: 20.0,
        };
        for _ in 0..200 {
            let place = |random: &mut Pcg32| {
                let places: Vec<f32> = (0..48).map(|_| random.random_range(-2.0..2.0)).collect();
                places
            };
            let (x, y) = (place(&mut random), place(&mut random));
            let expected = portable::least_nearest_m(&sheet, &x, &y);
            assert_eq!(
                least_nearest_m(&sheet, &x, &y).to_bits(),
                expected.to_bits()
            );
            let start: Vec<f32> = (0..48).map(|_| random.random_range(-0.1..0.3)).collect();
            let (mut found, mut expected) = (start.clone(), start);
            lower_space(&sheet, &x, &y, 0.2, &mut found);
            portable::lower_space(&sheet, &x, &y, 0.2, &mut expected);
            let bits = |space: &[f32]| space.iter().map(|s| s.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&found), bits(&expected));
            let yaws: Vec<f32> = (0..48).map(|_| random.random_range(-3.0..3.0)).collect();
            let cos: Vec<f32> = yaws.iter().map(|yaw| yaw.cos()).collect();
            let sin: Vec<f32> = yaws.iter().map(|yaw| yaw.sin()).collect();
            let discs = [[0.1, 0.05, 0.1], [-0.1, 0.02, 0.15], [0.2, -0.1, 0.05]];
            let (at, heading) = ((&x[..], &y[..]), (&cos[..], &sin[..]));
            let (mut found, mut expected) = (vec![0.2; 48], vec![0.2; 48]);
            lower_space_around(&sheet, at, heading, (&discs, 0.02), &mut found);
            portable::lower_space_around(&sheet, at, heading, (&discs, 0.02), &mut expected);
            assert_eq!(bits(&found), bits(&expected));
        }
    }

    #[test]
    fn the_twins_find_the_same_places_on_a_stretch() {
        let mut random = Pcg32::seed_from_u64(6);
        for n in [1, 2, 3, 7, 8, 9, 31, 32].repeat(20) {
            let mut samples = || core::array::from_fn(|_| random.random_range(-1.5_f32..1.5));
            let stretch = Stretch {
                n,
                x: samples(),
                y: samples(),
                step_x: samples(),
                step_y: samples(),
                inverse: samples().map(f32::abs),
                arc: samples(),
                start: samples(),
                direction_x: samples(),
                direction_y: samples(),
            };
            let mut points = || -> Vec<f32> {
                let lanes = 0..LANES_MAX;
                lanes.map(|_| random.random_range(-2.0..2.0)).collect()
            };
            let (x, y) = (points(), points());
            let (mut found, mut expected) = (Projections::default(), Projections::default());
            places_on(&stretch, &x, &y, &mut found);
            portable::places_on(&stretch, &x, &y, &mut expected);
            let bits = |lanes: &Lanes| lanes.map(f32::to_bits);
            assert_eq!(bits(&found.along), bits(&expected.along));
            assert_eq!(bits(&found.beside), bits(&expected.beside));
            assert_eq!(bits(&found.direction_x), bits(&expected.direction_x));
            assert_eq!(bits(&found.direction_y), bits(&expected.direction_y));
        }
    }
}
