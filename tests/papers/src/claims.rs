//! The claims of the papers: what is said, by which row it is judged, and why it comes out as it does.

mod bao;
mod ju;
mod lwx;
mod tn;
mod zm;

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

/// A paper.
#[derive(Debug, Clone, Copy)]
pub struct Paper {
    /// Key.
    pub key: &'static str,
    /// Who and what.
    pub title: &'static str,
    /// What was missing to repeat it, and what is taken instead.
    pub setup: &'static str,
}

/// The papers, in the order of the page.
pub const PAPERS: &[Paper] = &[
    Paper {
        key: "BAO",
        title: "Bao et al., 2023: improved A* with virtual obstacles, B-spline and dynamic window",
        setup: "Sizes and shares of obstacles are printed, maps and ends are not: opposite corners of random \
                maps that can be crossed without cutting corners. Printed lengths are those of the grid path \
                before it is smoothed.",
    },
    Paper {
        key: "TN",
        title: "Three-neighbour search A* combined with artificial potential fields",
        setup: "Ranges over two maps for each of three shares of obstacles are printed, maps and ends are \
                not. The hybrid cuts no corner; A* of the paper does.",
    },
    Paper {
        key: "ZM",
        title: "Zhang, Meng, 2022: A* with an improved artificial potential field",
        setup: "Neither map nor gains are printed; table 3 repeats table 2. Random maps of 20 x 20 cells, \
                the gains of a continuous eta, and a sweep.",
    },
    Paper {
        key: "LWX",
        title: "Liu, Wang, Xu, 2022: optimised A*, potential field and least squares",
        setup: "Sizes are printed, maps, ends and gains are not. Printed are times of MATLAB; beside them \
                stand the nodes, which no machine changes.",
    },
    Paper {
        key: "JU",
        title: "Ju, Luo, Yan: fusion of A* and artificial potential field",
        setup: "Start, goal, gains and the number of obstacles are printed, the map, the radius of the \
                circle and the step are not. Obstacles of one metre, as points and as squares.",
    },
];

const fn head(
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

/// Every claim, in the order of the papers.
pub fn claims() -> impl Iterator<Item = &'static Claim> {
    let papers = [bao::CLAIMS, tn::CLAIMS, zm::CLAIMS, lwx::CLAIMS, ju::CLAIMS];
    papers.into_iter().flatten()
}

/// What all rows of a claim say of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Judged {
    /// The verdict of the row that says most against it.
    pub verdict: Verdict,
    /// Rows that can be judged: those with a printed figure and enough maps.
    pub rows: usize,
    /// Rows among them whose verdict is this one.
    pub agree: usize,
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
        let printed = self.rows(rows).filter(|row| row.printed.is_some());
        let verdicts: Vec<Verdict> = printed.map(|row| row.verdict).collect();
        let verdict = Verdict::of_all(verdicts.iter().copied())?;
        let judged = verdicts
            .iter()
            .filter(|it| !matches!(it, Verdict::NotComparable | Verdict::TooFew));
        Some(Judged {
            verdict,
            rows: judged.count(),
            agree: verdicts.iter().filter(|it| **it == verdict).count(),
        })
    }
}
