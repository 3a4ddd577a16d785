//! Every number of every message: its range is accepted up to both ends, and nothing beyond or beside
//! it; every slice has the length that its message says, up to the most that the contract allows.

mod map;
mod robot;
mod run;

use zeronav_msgs::message::Refusal;

/// The field that is named, how it is set, and its range.
type Range<M> = (&'static str, fn(&mut M, f64), [f64; 2]);

/// Speed of anything, either sign. [m/s] and [rad/s]
const SPEED: [f64; 2] = [-1.0e3, 1.0e3];

/// A place on a map, either sign. [m]
const PLACE: [f64; 2] = [-1.0e6, 1.0e6];

const COVARIANCE: [f64; 2] = [-1.0e12, 1.0e12];

/// Checks `right` with every number in turn at, beyond and beside its range.
fn ranges<M: Copy>(right: M, check: fn(&M) -> Result<(), Refusal>, ranges: &[Range<M>]) {
    assert_eq!(check(&right), Ok(()));
    for (field, set, [low, high]) in ranges {
        let with = |value: f64| {
            let mut message = right;
            set(&mut message, value);
            check(&message)
        };
        assert_eq!(with(*low), Ok(()), "{field}: {low}");
        assert_eq!(with(*high), Ok(()), "{field}: {high}");
        // Also where the field holds 32 bits.
        let beyond = |end: f64| 1.0e-6 * end.abs().max(1.0e-3);
        let (below, above) = (low - beyond(*low), high + beyond(*high));
        assert_eq!(with(below), Err(Refusal::OutOfRange(field)), "{below}");
        assert_eq!(with(above), Err(Refusal::OutOfRange(field)), "{above}");
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(with(value), Err(Refusal::NotFinite(field)));
        }
    }
}

/// Checks slices of 0 to one more than `most` items, each with the right length told and with one more.
fn lengths<T: Copy>(
    (slice, fewest, most): (&'static str, usize, usize),
    item: T,
    check: fn(u32, &[T]) -> Result<(), Refusal>,
) {
    for n in [0, 1, 2, 3, most, most + 1] {
        let told = u32::try_from(n).expect("a few");
        let items = vec![item; n];
        let right = (fewest..=most).contains(&n);
        let expected = if right {
            Ok(())
        } else {
            Err(Refusal::Length(slice))
        };
        assert_eq!(check(told, &items), expected, "{n} {slice}");
        assert_eq!(
            check(told + 1, &items),
            Err(Refusal::Length(slice)),
            "{n} {slice}"
        );
    }
}

#[allow(clippy::cast_possible_truncation, reason = "numbers on the wire")]
const fn short(value: f64) -> f32 {
    value as f32
}

/// An end of a range as a field with 32 bits holds it: the nearest number inside.
fn wire(end: f64) -> f64 {
    let near = short(end);
    let inside = if f64::from(near).abs() <= end.abs() {
        near
    } else {
        f32::from_bits(near.to_bits() - 1)
    };
    f64::from(inside)
}
