//! The claims of [LWX].

use super::claim::{Claim, head};

/// Every one.
pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        paper: "LWX",
        id: "C1",
        tables: &["1", "2", "3"],
        text: "The optimised A* takes 55 to 71 % less time than A*.",
        headline: head("3", "expanded", "greedy vs A*", "blocky 40x40, 20.0 %", ""),
        why: "It keeps no open list and goes to the best neighbour, so where it arrives it has \
              expanded little more than its path.",
    },
    Claim {
        paper: "LWX",
        id: "C2",
        tables: &["1", "2", "3", "4"],
        text: "It finds the same path as A*.",
        headline: head(
            "1",
            "same length as A* (share)",
            "greedy, where it arrives",
            "blocky 20x20, 20.0 %",
            "",
        ),
        why: "A greedy search has no proof of anything: around an obstacle it follows the side \
              that looked nearer.",
    },
    Claim {
        paper: "LWX",
        id: "C3",
        tables: &["1", "2", "3", "4"],
        text: "It obtains a feasible path on all maps.",
        headline: head("3", "success (share)", "greedy", "blocky 40x40, 20.0 %", ""),
        why: "What happens in a dead end is not printed. Giving up there fails on many maps; \
              going back makes the search complete and its paths much longer.",
    },
    Claim {
        paper: "LWX",
        id: "C4",
        tables: &["4"],
        text: "It takes 65 % less time than bidirectional A* and 32 % fewer nodes.",
        headline: head(
            "4",
            "expanded",
            "greedy vs bidirectional",
            "blocky 20x20, 20.0 %",
            "",
        ),
        why: "The search that the paper calls bidirectional is A* from both ends to the middle of \
              the line between them.",
    },
    Claim {
        paper: "LWX",
        id: "C5",
        tables: &["5", "6"],
        text: "The whole method is 65 % faster than an ant colony and 84 % faster than a random \
              tree.",
        headline: head("6", "time", "fusion vs random tree", "blocky", ""),
        why: "A colony of fifty ants over up to a hundred iterations is slower than anything. \
              Compiled, a random tree on 20 x 20 cells takes well under a millisecond, and the \
              field and the fit take longer than that.",
    },
    Claim {
        paper: "LWX",
        id: "C6",
        tables: &["fig16"],
        text: "A hundred steps per cell cost 288 % more than ten for the same path; one is too \
              few.",
        headline: head(
            "fig16",
            "steps",
            "L = 100 vs L = 10",
            "blocky",
            "does not stop",
        ),
        why: "With steps of a fifth of a cell one per cell cannot arrive. More than ten cost more \
              only in a loop that goes on after it has arrived, and then ten times as much; one \
              that stops costs the same.",
    },
    Claim {
        paper: "LWX",
        id: "C7",
        tables: &["dyn"],
        text: "The method avoids twenty dynamic obstacles.",
        headline: head(
            "dyn",
            "arrives without a contact (share)",
            "lwx_oa and lwx_oapf, cells of 1 m",
            "move",
            "",
        ),
        why: "Two pictures and no number are printed; whether the obstacles move is not said. \
              The paper has unit cells, and the cells of the scenes are a metre, so that K_rep 1, \
              P0 1.5 m and ten steps a metre are its gains; those that this project ships are the \
              same ones on cells of half a metre. What is counted against either are mostly discs \
              that run into a robot that waits.",
    },
    Claim {
        paper: "LWX",
        id: "C8",
        tables: &["6"],
        text: "The conclusion says about 40 % less time for the whole method.",
        headline: head("6", "time", "fusion vs A*", "blocky", ""),
        why: "Of what it is 40 % less, is not said, and no table has it. Against A* alone the \
              field and the fit come on top.",
    },
    Claim {
        paper: "LWX",
        id: "C9",
        tables: &["6"],
        text: "The fitted path has fewer inflection points.",
        headline: head(
            "6",
            "inflection points",
            "fusion vs its greedy path",
            "blocky",
            "",
        ),
        why: "The corners of the grid path are compared with the changes of side of the curve.",
    },
    Claim {
        paper: "LWX",
        id: "C10",
        tables: &["6"],
        text: "It keeps more distance from obstacles.",
        headline: head(
            "6",
            "min_clearance",
            "fusion vs its greedy path",
            "blocky",
            "",
        ),
        why: "A path that cuts no corner keeps half a cell already. A repulsion that a robot \
              still gets through gaps of one cell with does not keep as much.",
    },
    Claim {
        paper: "LWX",
        id: "C11",
        tables: &["6"],
        text: "It does not get caught in local optima.",
        headline: head("6", "arrives (share)", "fusion", "blocky", ""),
        why: "Interim goals lead around most of the minima that hold the field alone; a turning \
              point that is skipped may leave the robot before a wall.",
    },
];
