//! Messages: their fields and meaning, and what foreign bytes make of them.

mod fields;
mod foreign_bytes;
mod meaning;
mod replica;
mod waiting;
