//! The kernels that need gathers or permutations, eight lanes at a time: the same operations in the
//! same order as in [`super::portable`].

#![allow(unsafe_code, reason = "gathers read through a pointer")]

use super::data::{LANES_MAX, Projections, SAMPLE_BITS, SAMPLES, Sheet, Stretch, WIDTH};
use core::arch::x86_64::{
    __m256, __m256i, _CMP_GT_OQ, _CMP_LT_OQ, _mm256_add_epi32, _mm256_add_ps, _mm256_and_si256,
    _mm256_andnot_si256, _mm256_blendv_ps, _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cmp_ps,
    _mm256_cvtepi32_ps, _mm256_cvttps_epi32, _mm256_div_ps, _mm256_i32gather_ps, _mm256_loadu_ps,
    _mm256_max_epi32, _mm256_max_ps, _mm256_min_epi32, _mm256_min_epu32, _mm256_min_ps,
    _mm256_movemask_ps, _mm256_mul_ps, _mm256_mullo_epi32, _mm256_or_si256,
    _mm256_permutevar8x32_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_setzero_ps,
    _mm256_setzero_si256, _mm256_slli_epi32, _mm256_sqrt_ps, _mm256_storeu_ps, _mm256_sub_epi32,
    _mm256_sub_ps,
};
use zeronav_casts::Cast;

/// True when the kernels may be called with this sheet.
pub(super) fn is_here(sheet: &Sheet<'_>) -> bool {
    let side = sheet.side.max(0).to_usize();
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
    let last = _mm256_set1_ps((sheet.side - 2).to_f32());
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
    let last = _mm256_set1_epi32(n.to_i32() - 2);
    let (zero, one) = (_mm256_setzero_si256(), _mm256_set1_epi32(1));
    let sample = _mm256_set1_epi32(SAMPLE_BITS.to_i32());
    let places = x.chunks_exact(WIDTH).zip(y.chunks_exact(WIDTH));
    for (start, (x, y)) in (0..LANES_MAX).step_by(WIDTH).zip(places) {
        // SAFETY: chunks of eight.
        let at = unsafe { (_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(y.as_ptr())) };
        let mut key = _mm256_set1_epi32(f32::MAX.to_bits().to_i32());
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
