//! Casts between numeric types, for counts, cells, beams and times whose range the caller knows.
//!
//! Each gives what `as` gives in a release build:
//! - integer to float: exact up to 2^53 (`f64`) or 2^24 (`f32`), rounded to the nearest beyond;
//! - `f64` to `f32`: rounded to the nearest, infinite beyond its range;
//! - float to integer: towards zero, saturated at the ends of the range, 0 for NaN;
//! - integer to integer: the value. A debug build panics where it does not fit; a release build
//!   keeps the low bits. Where these are meant: [`low_u32`], [`low_u8`].

/// A number that is cast.
pub trait Cast: Copy {
    /// See the crate.
    fn to_f64(self) -> f64;
    /// See the crate.
    fn to_f32(self) -> f32;
    /// See the crate.
    fn to_usize(self) -> usize;
    /// See the crate.
    fn to_u64(self) -> u64;
    /// See the crate.
    fn to_u32(self) -> u32;
    /// See the crate.
    fn to_u16(self) -> u16;
    /// See the crate.
    fn to_u8(self) -> u8;
    /// See the crate.
    fn to_i64(self) -> i64;
    /// See the crate.
    fn to_i32(self) -> i32;
    /// See the crate.
    fn to_i16(self) -> i16;
    /// See the crate.
    fn to_i8(self) -> i8;
}

macro_rules! cast {
    ($number:ty, $check:ident: $($name:ident $to:ty),*) => {$(
        #[inline]
        fn $name(self) -> $to {
            cast!($check self $to);
            self as $to
        }
    )*};
    (checked $number:ident $to:ty) => {
        debug_assert!(<$to>::try_from($number).is_ok(), "{} is no {}", $number, stringify!($to));
    };
    (saturated $number:ident $to:ty) => {};
}

macro_rules! casts {
    ($check:ident: $($number:ty),*) => {$(
        #[allow(
            clippy::cast_lossless,
            clippy::cast_possible_truncation,
            clippy::cast_possible_wrap,
            clippy::cast_precision_loss,
            clippy::cast_sign_loss,
            clippy::unnecessary_cast,
            reason = "this is the place for them; the crate says what each gives"
        )]
        impl Cast for $number {
            cast!($number, saturated: to_f64 f64, to_f32 f32);
            cast!($number, $check: to_usize usize, to_u64 u64, to_u32 u32, to_u16 u16, to_u8 u8);
            cast!($number, $check: to_i64 i64, to_i32 i32, to_i16 i16, to_i8 i8);
        }
    )*};
}

casts!(saturated: f64, f32);
casts!(checked: usize, u128, u64, u32, u16, u8, isize, i128, i64, i32, i16, i8);

/// The low 32 bits.
#[allow(clippy::cast_possible_truncation, reason = "it is meant")]
#[inline]
#[must_use]
pub const fn low_u32(bits: u64) -> u32 {
    bits as u32
}

/// The low 8 bits.
#[allow(clippy::cast_possible_truncation, reason = "it is meant")]
#[inline]
#[must_use]
pub const fn low_u8(bits: u64) -> u8 {
    bits as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_become_integers_towards_zero_and_saturated() {
        assert_eq!((-1.9).to_i32(), -1);
        assert_eq!(2.9f32.to_usize(), 2);
        assert_eq!((-3.0).to_u64(), 0);
        assert_eq!(1.0e9.to_u16(), u16::MAX);
        assert_eq!(f64::NEG_INFINITY.to_i64(), i64::MIN);
        assert_eq!(f64::NAN.to_u8(), 0);
    }

    #[test]
    fn integers_become_the_nearest_float() {
        assert_eq!(
            ((1u64 << 53) + 1).to_f64().to_bits(),
            (2.0f64).powi(53).to_bits()
        );
        assert_eq!(16_777_217i32.to_f32().to_bits(), 16_777_216f32.to_bits());
        assert_eq!(0.1.to_f32().to_bits(), 0.1f32.to_bits());
    }

    #[test]
    fn integers_that_fit_keep_their_value() {
        assert_eq!(255usize.to_u8(), u8::MAX);
        assert_eq!((-40i64).to_i16(), -40);
        assert_eq!(7i32.to_u64(), 7);
    }

    #[test]
    fn low_bits_are_kept() {
        assert_eq!(low_u32(0x1_2345_6789), 0x2345_6789);
        assert_eq!(low_u8(0x1ff), u8::MAX);
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "-1 is no usize")]
    fn an_integer_that_does_not_fit_is_found_in_a_debug_build() {
        let _ = (-1i32).to_usize();
    }
}
