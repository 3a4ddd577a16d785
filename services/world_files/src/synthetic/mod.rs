//! Worlds of our own making: drawn from a seed, the same bytes for the same seed, and checked to
//! be passable before they count.
//!
//! They have the form of the data sets that others have published, so they are read, driven and
//! scored by the same code, and tests and suites need no download:
//!
//! * [`clutter`]: static cylinders in a corridor, as in BARN;
//! * [`orbits`]: cylinders on closed or returning tracks, as in `DynaBARN`;
//! * [`crowd`]: people who avoid each other by social forces, as in recordings of pedestrians;
//! * [`course`]: the numbered worlds of `zeronav suite generated`.
//!
//! [`passage`] finds the certificate that a robot can get through.

pub mod clutter;
pub mod course;
pub mod crowd;
pub mod orbits;
pub mod passage;

pub use passage::Robot;

/// No world with these numbers can be passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("none of {tried} worlds drawn from seed {seed} can be passed: ask for less in the way")]
pub struct NoPassage {
    /// The seed.
    pub seed: u64,
    /// Worlds that were drawn.
    pub tried: u32,
}

/// Draws worlds until one can be passed.
fn first_passable<T>(
    seed: u64,
    tries: u32,
    mut draw: impl FnMut(&mut rand_pcg::Pcg64Mcg) -> Option<T>,
) -> Result<T, NoPassage> {
    let mut rng = <rand_pcg::Pcg64Mcg as rand::SeedableRng>::seed_from_u64(seed);
    (0..tries)
        .find_map(|_| draw(&mut rng))
        .ok_or(NoPassage { seed, tried: tries })
}

/// Three decimals, which is what the files of data sets hold.
fn millimetres(value: f64) -> f64 {
    (value * 1.0e3).round() / 1.0e3
}
