//! What is thin and stands before everything beside it: a drop of rain, or a wire.

use zeronav_casts::Cast;

/// [m] up to which neighbouring beams hit the same thing.
const SAME_M: f64 = 0.06;

/// [m] by which beams on both sides have to go on behind it; a mixed edge lies between them.
const BEFORE_M: f64 = 0.1;

/// [m] how wide it is at most, one beam at least: drops may have hit neighbouring ones.
const THIN_M: f64 = 0.01;
const THIN_BEAMS_MAX: usize = 32;

/// True when this hit and those of neighbouring beams at about its range, `apart_m` from each other [m], are on
/// something thin, with beams on both sides of it that went on far behind.
pub(crate) fn is_before(ranges: &[f32], beam: usize, apart_m: f64) -> bool {
    let behind_m = |other: usize| {
        let other_m = ranges.get(other)?;
        Some(f64::from(other_m - ranges[beam]))
    };
    let wide = (THIN_M / apart_m).to_usize().clamp(1, THIN_BEAMS_MAX);
    let mut found = 1;
    for side in [1, usize::MAX] {
        let mut other = beam.wrapping_add(side);
        while behind_m(other).is_some_and(|off_m| off_m.abs() <= SAME_M) {
            found += 1;
            if found > wide {
                return false;
            }
            other = other.wrapping_add(side);
        }
        // The next one may have hit a drop of its own.
        let next = [other, other.wrapping_add(side)];
        if !next
            .into_iter()
            .any(|other| behind_m(other).is_some_and(|off_m| off_m > BEFORE_M))
        {
            return false;
        }
    }
    true
}
