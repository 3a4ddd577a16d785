//! The claims of [JU].

use super::claim::{Claim, head};

/// Every one.
pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        paper: "JU",
        id: "C1",
        tables: &["1"],
        text: "The fusion's path is 3.46 % shorter than that of A*.",
        headline: head("1", "length", "fusion vs A*", "iid", "point"),
        why: "The printed length is half a per cent above the straight line: the path crosses \
              obstacles that count as points. With obstacles as areas the fusion arrives on a \
              third of the maps, and is longer than the A* of the paper, which passes between \
              corners where areas cannot.",
    },
    Claim {
        paper: "JU",
        id: "C2",
        tables: &["1"],
        text: "It is 5.78 % shorter than that of the potential field alone.",
        headline: head("1", "length", "fusion vs APF", "iid", "point"),
        why: "Only maps on which both arrive can be compared, which with areas are few.",
    },
    Claim {
        paper: "JU",
        id: "C3",
        tables: &["1"],
        text: "It is 10 % shorter than those of references 6 and 7.",
        headline: head("1", "length", "fusion vs reference 7", "iid", "point"),
        why: "Those follow the path of A*, which goes around what the fusion crosses.",
    },
    Claim {
        paper: "JU",
        id: "C4",
        tables: &["2"],
        text: "It takes more time than all of them.",
        headline: head("2", "time", "fusion vs A*", "iid", ""),
        why: "A* and a force for every point of the path come on top of the field. A compiled A* \
              of 225 cells takes microseconds, so that against it the roll-out is everything.",
    },
    Claim {
        paper: "JU",
        id: "C5",
        tables: &["dyn"],
        text: "It avoids dynamic obstacles.",
        headline: head(
            "dyn",
            "arrives without a contact (share)",
            "ju_astar and ju_fusion",
            "discs",
            "",
        ),
        why: "Said, not shown. On maps whose gaps are one metre the field of 2 m closes most of \
              them, so that the fusion mostly waits.",
    },
    Claim {
        paper: "JU",
        id: "C6",
        tables: &["1"],
        text: "A* is shorter than the potential field alone (by its lengths in table I).",
        headline: head("1", "length", "A* vs APF", "iid", "point"),
        why: "On points the field goes nearly straight and is the shorter one, because it crosses \
              what A* goes around.",
    },
    Claim {
        paper: "JU",
        id: "C7",
        tables: &["2"],
        text: "It meets the demands of real time.",
        headline: head(
            "2",
            "a step within a control period of 20 ms (share)",
            "fusion",
            "iid",
            "point",
        ),
        why: "Compiled, a step of the field is a sum over some hundred bodies: microseconds.",
    },
];
