//! A claim: by which rows it is judged.

use crate::row::Row;
use crate::verdict::Verdict;

/// A claim.
#[derive(Debug, Clone, Copy)]
pub struct Claim {
    /// Paper.
    pub paper: &'static str,
    /// Number within the paper.
    pub id: &'static str,
    /// Tables that its rows belong to.
    pub tables: &'static [&'static str],
    /// What the paper says, in one sentence.
    pub text: &'static str,
    /// The row whose figures stand for it: its table, metric, algorithm, and what its maps and its note
    /// contain. The verdict is that of all of its rows, see [`Claim::judged`].
    pub headline: Headline,
    /// Why it comes out so.
    pub why: &'static str,
}

/// A row that stands for a claim.
#[derive(Debug, Clone, Copy)]
pub struct Headline {
    /// Table.
    pub table: &'static str,
    /// Metric, whole.
    pub metric: &'static str,
    /// Algorithm, whole.
    pub algorithm: &'static str,
    /// Part of the maps' name.
    pub maps: &'static str,
    /// Part of the note.
    pub note: &'static str,
}

/// A row that stands for a claim, in one line.
pub(super) const fn head(
    table: &'static str,
    metric: &'static str,
    algorithm: &'static str,
    maps: &'static str,
    note: &'static str,
) -> Headline {
    Headline {
        table,
        metric,
        algorithm,
        maps,
        note,
    }
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
    pub fn rows<'a>(&self, rows: &'a [Row]) -> impl Iterator<Item = &'a Row> + use<'a> {
        let (paper, id, tables) = (self.paper, self.id, self.tables);
        rows.iter().filter(move |row| {
            row.paper == paper && row.claim == id && tables.contains(&&*row.table)
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
