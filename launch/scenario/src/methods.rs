//! The whole methods of five papers, `--as KEY`: a table of settings, each read like a `--set` of the command
//! line.
//!
//! All of them search with `cost_weight = 0`, because a price on nearness to obstacles is none of theirs.
//! Lengths that the papers give in cells are scaled: the cells of a map are 5 cm, theirs are as large as the
//! robot.

use zeronav_shell::nearest::unknown;

/// A method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// Word on a command line.
    pub key: &'static str,
    /// One line for people.
    pub title: &'static str,
    /// `ROLE.KEY=VALUE`, in the order in which they are laid over each other.
    pub keys: &'static [&'static str],
}

/// A path over the centres of cells as large as the robot keeps half a cell from obstacles. On cells of 5 cm it
/// would lead along the very edge of where the robot fits, and its controllers would stand there.
const HALF_A_CELL: &str = "mapping.padding_m=0.2";

/// Every method.
pub const METHODS: &[Method] = &[
    Method {
        key: "tn",
        title: "[TN] three-neighbour walk and attraction; the paper leaves the driving to its robot: dwa",
        keys: &[
            "global_planner.planner=tn_hyb",
            "global_planner.options.cost_weight=0",
            HALF_A_CELL,
            // Its cells are 0.1 m.
            "global_planner.options.papers.walk.switch_margin_cells=2",
            "local_planner.controller=dwa",
        ],
    },
    Method {
        key: "ju",
        title: "[JU] points of the A* path attract inside a potential field",
        keys: &[
            "global_planner.planner=ju_astar",
            "global_planner.options.cost_weight=0",
            HALF_A_CELL,
            "local_planner.controller=ju_fusion",
        ],
    },
    Method {
        key: "zm",
        title: "[ZM] A* weighted by nearness to obstacles, an improved potential field inside it",
        keys: &[
            "global_planner.planner=zm_im",
            "global_planner.options.cost_weight=0",
            HALF_A_CELL,
            // P0 = 3 cells of a metre, as in the controller; the map has to know clearances as long.
            "global_planner.options.papers.eta.cell_m=1.0",
            "mapping.clearance_limit_m=3.1",
            "local_planner.controller=zm_full",
        ],
    },
    Method {
        key: "lwx",
        title: "[LWX] greedy A*, a potential field over turning points, least squares",
        keys: &[
            "global_planner.planner=lwx_oa",
            "global_planner.options.cost_weight=0",
            HALF_A_CELL,
            "local_planner.controller=lwx_fusion",
        ],
    },
    Method {
        key: "bao",
        title: "[BAO] A* with virtual obstacles, a B-spline, a dynamic window",
        keys: &[
            "global_planner.planner=bao_iaa",
            "global_planner.options.cost_weight=0",
            HALF_A_CELL,
            "local_planner.controller=bao_dwa",
            // The path is followed, and the window decides while something unknown is near it.
            "local_planner.papers.bao_dwa.switch=on_detect",
        ],
    },
];

/// The method of this key.
///
/// # Errors
/// One line with the keys there are.
pub(crate) fn method(key: &str) -> Result<&'static Method, String> {
    let found = METHODS.iter().find(|method| method.key == key);
    found.ok_or_else(|| {
        let keys = METHODS.iter().map(|method| method.key);
        unknown("method", key, keys)
    })
}
