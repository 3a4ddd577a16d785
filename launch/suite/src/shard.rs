//! A part of a suite's runs, for one of several machines.

use core::fmt;
use core::str::FromStr;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};

/// Most parts of a suite.
const SHARDS_MAX: u32 = 100_000;

/// Part `index` of `of`, counted from 1. Which part a run belongs to depends on its name alone, so that runs
/// that are added move no others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    index: u32,
    of: u32,
}

impl Shard {
    /// The part of `of` that the run with this name belongs to, counted from 1.
    fn index_of(name: &str, of: u32) -> u32 {
        // The hash alone puts names that differ in their last letters together.
        let mut spread = Pcg64Mcg::seed_from_u64(fnv1a(FNV_OFFSET, name.as_bytes()));
        let index = spread.next_u64() % u64::from(of.max(1));
        u32::try_from(index).unwrap_or(0) + 1
    }

    /// True when the run with this name belongs to this part.
    #[must_use]
    pub fn has(self, name: &str) -> bool {
        Self::index_of(name, self.of) == self.index
    }

    /// The part that the run with this name belongs to, among as many as there are here.
    pub(super) fn sibling(self, name: &str) -> Self {
        Self {
            index: Self::index_of(name, self.of),
            ..self
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(index, of)| {
            let [index, of] = [index.parse().ok()?, of.parse().ok()?];
            Some(Self { index, of })
        });
        parsed
            .filter(|it| (1..=it.of).contains(&it.index) && it.of <= SHARDS_MAX)
            .ok_or_else(|| {
                format!("`{text}` is no shard: I/N with I from 1 to N, such as 1/4, and N at most {SHARDS_MAX}")
            })
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shard(text: &str) -> Shard {
        text.parse().expect("a shard")
    }

    #[test]
    fn shards_read_like_one_of_four() {
        assert_eq!(shard("3/4").to_string(), "3/4");
        for text in [
            "0/4", "5/4", "1", "1/", "/2", "a/b", "1/0", "-1/4", "1/100001",
        ] {
            let problem = text.parse::<Shard>().expect_err("no shard");
            assert!(problem.contains(text), "{problem}");
        }
    }

    /// Golden: a run stays in its part from one version to the next.
    #[test]
    fn a_run_belongs_to_the_same_part_everywhere() {
        let names = [
            "world_001-seed1",
            "world_001-seed2",
            "static_1_easy_000_1-seed1",
        ];
        let parts = names.map(|name| [2, 4, 1000].map(|of| Shard::index_of(name, of)));
        assert_eq!(parts, GOLDEN);
    }

    const GOLDEN: [[u32; 3]; 3] = [[2, 4, 364], [1, 1, 969], [1, 1, 497]];

    /// Every run is in one part, and parts differ as those of a fair draw do: 6 standard deviations of a
    /// binomial distribution.
    #[test]
    fn parts_share_all_runs_out_evenly() {
        let names: Vec<String> = (0..300)
            .flat_map(|world| (1..=10).map(move |seed| format!("world_{world:03}-seed{seed}")))
            .collect();
        for of in [1, 2, 3, 8, 64] {
            let sizes: Vec<usize> = (1..=of)
                .map(|index| {
                    let part = Shard { index, of };
                    names.iter().filter(|name| part.has(name)).count()
                })
                .collect();
            assert_eq!(sizes.iter().sum::<usize>(), names.len());
            let mean = 3000.0 / f64::from(of);
            let most = 6.0 * (mean * (1.0 - 1.0 / f64::from(of))).sqrt();
            for size in sizes {
                let off = f64::from(u32::try_from(size).expect("few")) - mean;
                assert!(off.abs() <= most, "{size} of {mean} in one of {of}");
            }
        }
    }
}
