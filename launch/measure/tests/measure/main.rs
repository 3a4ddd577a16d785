//! The measures on fixtures.

mod events;
mod fixture;
mod ways;
