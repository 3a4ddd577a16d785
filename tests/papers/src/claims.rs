//! The claims of the papers: what is said, by which row it is judged, and why it comes out as it does.

mod bao;
mod claim;
mod ju;
mod lwx;
mod tn;
mod zm;

pub use claim::{Claim, Judged};

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

/// Every claim, in the order of the papers.
pub fn claims() -> impl Iterator<Item = &'static Claim> {
    let papers = [bao::CLAIMS, tn::CLAIMS, zm::CLAIMS, lwx::CLAIMS, ju::CLAIMS];
    papers.into_iter().flatten()
}
