//! Kernels for many rollouts or positions at once: eight lanes of AVX2 where the processor has them,
//! and the same numbers, bit for bit, without.
//!
//! This is the one room of the package with `unsafe`: the gathers read through a pointer, and the
//! choice of the instruction set is made at run time. The portable twin is the meaning; the tests
//! compare the two. Where no gather is needed the twin itself is compiled a second time with AVX2
//! allowed; without contraction of products and sums that gives the same bits.

use data::{Lanes, Projections, Sheet, Stretch, Turns};
use zeronav_msgs::MapCell;

#[cfg(target_arch = "x86_64")]
mod avx2;
pub(crate) mod data;
mod portable;

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

/// The nearest places on a stretch of at most 32 samples of a multiple of [`WIDTH`] points, at most
/// [`LANES_MAX`].
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

/// A computation that is worth compiling for wide vectors. [`Self::run`] and what it calls must be
/// `inline(always)`.
pub(crate) trait Kernel {
    /// Computes.
    fn run(self);
}

/// Runs a kernel, compiled once more with AVX2 where the processor has it.
pub(crate) fn run_wide(kernel: impl Kernel) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn wide(kernel: impl Kernel) {
            kernel.run();
        }
        if std::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            #[allow(unsafe_code, reason = "chosen at run time")]
            return unsafe { wide(kernel) };
        }
    }
    kernel.run();
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
    /// radius) than its radius, unless an earlier step is noted there.
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

#[cfg(test)]
mod tests {
    use super::data::LANES_MAX;
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
