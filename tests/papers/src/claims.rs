//! The claims of the papers: what is said, by which row it is judged, and why it comes out as it does.
//! Each paper is a file in `claims/`.

use crate::row::Row;
use crate::verdict::Verdict;
use serde::Deserialize;
use std::sync::LazyLock;

/// A paper.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Key.
    #[serde(skip)]
    pub key: &'static str,
    /// Who and what.
    pub title: String,
    /// What was missing to repeat it, and what is taken instead.
    pub setup: String,
    /// What it says.
    pub claims: Vec<Claim>,
}

/// A claim.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Paper.
    #[serde(skip)]
    pub paper: &'static str,
    /// Number within the paper.
    pub id: String,
    /// Tables that its rows belong to.
    pub tables: Vec<String>,
    /// What the paper says, in one sentence.
    pub text: String,
    /// The row whose figures stand for it. The verdict is that of all of its rows, see [`Claim::judged`].
    pub headline: Headline,
    /// Why it comes out so.
    pub why: String,
}

/// A row that stands for a claim.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Headline {
    /// Table.
    pub table: String,
    /// Metric, whole.
    pub metric: String,
    /// Algorithm, whole.
    pub algorithm: String,
    /// Part of the maps' name.
    pub maps: String,
    /// Part of the note.
    #[serde(default)]
    pub note: String,
}

/// Key and file of each paper, in the order of the page.
const FILES: [(&str, &str); 5] = [
    ("BAO", include_str!("claims/bao.toml")),
    ("TN", include_str!("claims/tn.toml")),
    ("ZM", include_str!("claims/zm.toml")),
    ("LWX", include_str!("claims/lwx.toml")),
    ("JU", include_str!("claims/ju.toml")),
];

static PAPERS: LazyLock<Vec<Paper>> = LazyLock::new(|| {
    let read = |(key, text): (&'static str, &str)| {
        let mut paper: Paper =
            toml::from_str(text).unwrap_or_else(|error| panic!("{key}: {error}"));
        paper.key = key;
        for claim in &mut paper.claims {
            claim.paper = key;
        }
        paper
    };
    FILES.map(read).into()
});

/// The papers, in the order of the page.
///
/// # Panics
/// When one of the files, which are part of this program, is damaged.
#[must_use]
pub fn papers() -> &'static [Paper] {
    &PAPERS
}

/// Every claim, in the order of the papers.
///
/// # Panics
/// As [`papers`].
pub fn claims() -> impl Iterator<Item = &'static Claim> {
    papers().iter().flat_map(|paper| &paper.claims)
}

/// What all rows of a claim say of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Judged {
    /// See [`Verdict::of_all`].
    pub verdict: Verdict,
    /// Rows that can be judged: those with something to compare with and enough maps.
    pub rows: usize,
    /// Rows among them whose verdict is this one.
    pub agree: usize,
    /// How many of them came out how, where they differ and none of them is a counterexample to what is said of
    /// all maps; empty where [`Self::verdict`] is the claim's.
    pub mixed: Vec<(Verdict, usize)>,
}

impl Claim {
    /// Its rows among all that were measured.
    pub fn rows<'a>(&'a self, rows: &'a [Row]) -> impl Iterator<Item = &'a Row> {
        rows.iter().filter(|row| {
            row.paper == self.paper && row.claim == self.id && self.tables.contains(&row.table)
        })
    }

    /// What all of its rows say; `None` when none of them can be judged.
    #[must_use]
    pub fn judged(&self, rows: &[Row]) -> Option<Judged> {
        let verdicts: Vec<Verdict> = self.rows(rows).map(|row| row.verdict).collect();
        let verdict = Verdict::of_all(verdicts.iter().copied())?;
        let of = |verdict: Verdict| verdicts.iter().filter(|it| **it == verdict).count();
        let silent = of(Verdict::NotComparable) + of(Verdict::TooFew);
        let (rows_judged, agree) = (verdicts.len() - silent, of(verdict));
        let is_refuted =
            (self.rows(rows)).any(|row| row.universal && row.verdict == Verdict::NotReproduced);
        let is_mixed = agree < rows_judged && verdict != Verdict::Artefact && !is_refuted;
        let mut mixed = Vec::new();
        if is_mixed {
            mixed.extend(Verdict::FROM_THE_BEST.map(|verdict| (verdict, of(verdict))));
            mixed.retain(|(_, n)| *n > 0);
        }
        Some(Judged {
            verdict,
            rows: rows_judged,
            agree,
            mixed,
        })
    }
}
