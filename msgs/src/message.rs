//! What a message is: plain numbers in a fixed order, with a hash of that order.

use crate::fields::{Number, Shape};
use core::fmt;
pub use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// A type whose layout is part of the contract.
///
/// The schema hash covers names, order, types and offsets, because the middleware compares only
/// the type name and the size: two swapped fields of equal size would go unnoticed.
pub trait Wire: Sized + 'static {
    /// Explicit, versioned name of the type, equal in every language.
    const NAME: &'static str;
    /// 64-bit FNV-1a over the layout.
    const SCHEMA: u64;
    /// What its bytes mean.
    const SHAPE: &'static Shape;
}

/// A [`Wire`] type that can lie in shared memory and be viewed as bytes.
pub trait Message: Wire + fmt::Debug + Copy + Default + bytemuck::Pod + ZeroCopySend {}

impl<T> Message for T where T: Wire + fmt::Debug + Copy + Default + bytemuck::Pod + ZeroCopySend {}

/// Start value of [`fnv1a`].
pub const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// 64-bit FNV-1a of `bytes`, continued from `state` (start with [`FNV_OFFSET`]).
///
/// Source: Fowler, Noll, Vo, "The FNV Non-Cryptographic Hash Algorithm".
#[must_use]
pub const fn fnv1a(mut state: u64, bytes: &[u8]) -> u64 {
    let mut i = 0;
    while i < bytes.len() {
        state = (state ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    state
}

macro_rules! primitive {
    ($($ty:ty = $number:ident),*) => {$(
        impl Wire for $ty {
            const NAME: &'static str = stringify!($ty);
            const SCHEMA: u64 = fnv1a(FNV_OFFSET, stringify!($ty).as_bytes());
            const SHAPE: &'static Shape = &Shape::Number(Number::$number);
        }
    )*};
}
primitive!(
    u8 = U8,
    u16 = U16,
    u32 = U32,
    u64 = U64,
    i16 = I16,
    i32 = I32,
    i64 = I64,
    f32 = F32,
    f64 = F64
);

impl<T: Wire, const N: usize> Wire for [T; N] {
    const NAME: &'static str = "array";
    const SCHEMA: u64 = fnv1a(fnv1a(T::SCHEMA, b"["), &(N as u64).to_le_bytes());
    const SHAPE: &'static Shape = &Shape::Array {
        of: T::SHAPE,
        len: N,
    };
}

/// Defines a message: `#[repr(C)]`, named, without padding, with its schema hash.
///
/// `Default` is all zero, and zero is the neutral value of every code: nothing, idle, not valid. The
/// description of a field says its unit or kind, see [`crate::fields`].
/// A module that uses this macro has [`ZeroCopySend`] in scope; its crate depends on `bytemuck`,
/// `iceoryx2-bb-derive-macros` and `iceoryx2-bb-elementary-traits`.
#[macro_export]
macro_rules! message {
    ($(#[doc = $doc:literal])* pub struct $name:ident = $type_name:literal {
        $($(#[doc = $field_doc:literal])* pub $field:ident : $ty:ty),* $(,)?
    }) => {
        $(#[doc = $doc])*
        #[repr(C)]
        #[derive(
            Debug, Clone, Copy, PartialEq,
            ::bytemuck::Pod, ::bytemuck::Zeroable,
            ::iceoryx2_bb_derive_macros::ZeroCopySend,
        )]
        #[type_name($type_name)]
        pub struct $name { $($(#[doc = $field_doc])* pub $field: $ty),* }

        impl Default for $name {
            fn default() -> Self { ::bytemuck::Zeroable::zeroed() }
        }

        impl $crate::message::Wire for $name {
            const NAME: &'static str = $type_name;
            const SCHEMA: u64 = {
                let mut hash = $crate::message::fnv1a(
                    $crate::message::FNV_OFFSET, $type_name.as_bytes());
                $(
                    hash = $crate::message::fnv1a(hash, stringify!($field).as_bytes());
                    hash = $crate::message::fnv1a(
                        hash, &<$ty as $crate::message::Wire>::SCHEMA.to_le_bytes());
                    hash = $crate::message::fnv1a(
                        hash, &(::core::mem::offset_of!($name, $field) as u64).to_le_bytes());
                )*
                hash
            };
            const SHAPE: &'static $crate::fields::Shape = &$crate::fields::Shape::Message {
                name: $type_name,
                doc: concat!($($doc),*),
                fields: &[$($crate::fields::Field {
                    name: stringify!($field),
                    doc: concat!($($field_doc),*),
                    offset: ::core::mem::offset_of!($name, $field),
                    shape: <$ty as $crate::message::Wire>::SHAPE,
                }),*],
                bytes: ::core::mem::size_of::<$name>(),
                schema: Self::SCHEMA,
            };
        }
    };
}

/// Defines the codes of a wire field: integers there, an enum in code, a checked step between.
#[macro_export]
macro_rules! codes {
    ($(#[$meta:meta])* pub enum $name:ident : $int:ty {
        $($(#[$variant_meta:meta])* $variant:ident = $code:literal => $label:literal),* $(,)?
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name { $($(#[$variant_meta])* $variant),* }

        impl $name {
            /// Every value, in the order of the codes.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The integer on the wire.
            #[must_use]
            pub const fn code(self) -> $int {
                match self { $(Self::$variant => $code),* }
            }

            /// The value of an integer from the wire; `None` when no value has it.
            #[must_use]
            pub const fn from_code(code: $int) -> Option<Self> {
                match code { $($code => Some(Self::$variant),)* _ => None }
            }

            /// Lower-case word for logs, tables and JSON.
            #[must_use]
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => $label),* }
            }
        }

        impl ::core::fmt::Display for $name {
            fn fmt(&self, f: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                f.write_str(self.label())
            }
        }
    };
}

/// Why a received message was dropped. The field is named so that a log line can say where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Refusal {
    /// The writer was built from another contract.
    #[error("schema hash of another contract in the header")]
    Schema,
    /// Written for another robot or another clock than this domain's.
    #[error("{0} is not of this domain")]
    Foreign(&'static str),
    /// The role in the header is not one that may write this topic.
    #[error("written by a role that may not write this topic")]
    Writer,
    /// The identity has no epoch or no count.
    #[error("identity without epoch or count")]
    Identity,
    /// A bit was changed after the message was written.
    #[error("the checksum does not fit")]
    Checksum,
    /// An integer code without a meaning.
    #[error("unknown code in {0}")]
    Code(&'static str),
    /// NaN or infinite where a number is needed.
    #[error("{0} is not a finite number")]
    NotFinite(&'static str),
    /// A number outside its documented range.
    #[error("{0} is out of range")]
    OutOfRange(&'static str),
    /// A slice that is longer or shorter than its header says or the contract allows.
    #[error("wrong number of {0}")]
    Length(&'static str),
}

/// Accepts finite numbers in `min..=max`.
///
/// # Errors
/// [`Refusal::NotFinite`] or [`Refusal::OutOfRange`], naming `field`.
pub fn number(value: f64, min: f64, max: f64, field: &'static str) -> Result<(), Refusal> {
    if !value.is_finite() {
        Err(Refusal::NotFinite(field))
    } else if value < min || value > max {
        Err(Refusal::OutOfRange(field))
    } else {
        Ok(())
    }
}

/// Accepts `true`.
///
/// # Errors
/// `refusal` when `condition` does not hold.
pub fn ensure(condition: bool, refusal: Refusal) -> Result<(), Refusal> {
    if condition { Ok(()) } else { Err(refusal) }
}

/// Largest coordinate that a message may carry, either sign. [m]
pub const COORDINATE_M_MAX: f64 = 1.0e6;

/// Largest speed that a message may carry, either sign. [m/s] and [rad/s]
pub const SPEED_MAX: f64 = 1.0e3;
