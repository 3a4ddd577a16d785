//! The claims of [BAO].

use super::claim::{Claim, head};

/// Every one.
pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        paper: "BAO",
        id: "C1",
        tables: &["1", "2", "3", "4"],
        text: "The improved A* (IAA) finds paths as short as Dijkstra's.",
        headline: head("2", "same length (share)", "IAA = Dijkstra", "blocky", ""),
        why: "With a consistent estimate A* is exact, and the octile distance is consistent: the \
              four equal pairs of the paper could not have come out otherwise. It is checked on \
              every map; one difference would end the measurement.",
    },
    Claim {
        paper: "BAO",
        id: "C2",
        tables: &["1", "2", "3", "4"],
        text: "IAA's paths are shorter than those of virtual obstacles with the Manhattan \
              distance (AAO).",
        headline: head("2", "length", "IAA vs AAO", "blocky", ""),
        why: "The Manhattan distance is too large where diagonal steps are allowed, so that AAO \
              settles for longer ways. The sign is sure; the mean over many maps is smaller than \
              the single maps of the paper, which lie at the far end of the spread.",
    },
    Claim {
        paper: "BAO",
        id: "C3",
        tables: &["1", "2", "3", "4"],
        text: "IAA needs half to a third of Dijkstra's time.",
        headline: head("2", "expanded", "IAA vs Dijkstra", "blocky", ""),
        why: "An estimate spares nodes, the more the less is in the way; counted in expansions \
              the saving is of the printed size, and times follow the nodes.",
    },
    Claim {
        paper: "BAO",
        id: "C4",
        tables: &["1", "2", "3", "4"],
        text: "Safety costs length against the traditional A* (TAA), except on the sparse map.",
        headline: head("2", "length", "IAA vs TAA", "blocky", ""),
        why: "Two effects work against each other: keeping off corners makes paths longer, the \
              better estimate makes them shorter. Which of them wins depends on the clutter, so \
              that single maps show either sign, as those of the paper do.",
    },
    Claim {
        paper: "BAO",
        id: "C5",
        tables: &["1", "2", "3", "4"],
        text: "IAA's path is the shortest in all cases.",
        headline: head(
            "2",
            "nothing shorter that cuts no corner (share)",
            "IAA, against pulled A*",
            "blocky",
            "",
        ),
        why: "It is the shortest of those made of eight directions. Pulled taut, the same path \
              cuts no corner either and is shorter on nearly every map.",
    },
    Claim {
        paper: "BAO",
        id: "C6",
        tables: &["1", "2", "3", "4"],
        text: "Inflating all obstacles (reference 31) fails at 30 % and 38.9 %.",
        headline: head("4", "success (share)", "full inflation", "blocky", ""),
        why: "A ring around every obstacle closes gaps of one and two cells, of which maps so \
              dense consist. On the sparse maps, where the paper prints a success each, it fails \
              on about half, and on all with single cells.",
    },
    Claim {
        paper: "BAO",
        id: "C7",
        tables: &["1", "2", "3", "4"],
        text: "Only a few virtual obstacles are set, about as many by IAA as by Dijkstra.",
        headline: head("4", "virtual obstacles on the path", "IAA", "blocky", ""),
        why: "Counted along the final path the numbers are of the printed size on sparse maps and \
              many times as large on dense ones; counted over the whole search there are more \
              still, and most for Dijkstra, which the paper cannot have meant.",
    },
    Claim {
        paper: "BAO",
        id: "C8",
        tables: &["1", "2", "3", "4"],
        text: "The B-spline smooths the path and stays safe.",
        headline: head(
            "2",
            "curve keeps 0.465 cells from every obstacle (share)",
            "IAA's spline",
            "blocky",
            "",
        ),
        why: "With every cell as a control point the curve keeps 0.465 cells from every obstacle: \
              that follows from the moves that cut no corner, and was found on every map.",
    },
    Claim {
        paper: "BAO",
        id: "C9",
        tables: &["dyn"],
        text: "The robot leaves its path for unknown and moving obstacles and comes back to it.",
        headline: head(
            "dyn",
            "arrives without a contact (share)",
            "bao_iaa and bao_dwa",
            "discs",
            "",
        ),
        why: "Two pictures and no number are printed. In the scenes assumed here a robot that \
              follows its path blindly collides; rates, intervals and those of this project's own \
              defaults stand in the rows. The path keeps half a cell off obstacles, as one over \
              the centres of the paper's cells does: along the edge of where the robot just fits, \
              where the shortest way on cells of 5 cm leads, no arc has any clearance and the \
              window stands for ever. Contacts are mostly walkers that run into it.",
    },
    Claim {
        paper: "BAO",
        id: "C10",
        tables: &["1", "2", "3", "4"],
        text: "IAA needs basically the same time as AAO (as printed 5 % less in table 1, 60 %, 40 % \
               and 532 % more in the others).",
        headline: head("1", "time", "IAA vs AAO", "blocky", ""),
        why: "Of the first table \"basically the same\" is judged, of the others the printed times, \
              which speak against the text. The larger estimate of AAO is greedier, so that it \
              expands less and finds longer ways.",
    },
    Claim {
        paper: "BAO",
        id: "C11",
        tables: &["1", "2", "3", "4"],
        text: "IAA is shorter and faster than full inflation (reference 31).",
        headline: head("2", "length", "IAA vs full inflation", "blocky", ""),
        why: "Only maps on which full inflation finds a way can be compared; its ring makes ways \
              longer, and fills the map before the search.",
    },
    Claim {
        paper: "BAO",
        id: "C12",
        tables: &["1", "2", "3", "4"],
        text: "The robot moves over fewer grids with IAA.",
        headline: head("2", "moving grids", "IAA vs AAO", "blocky", ""),
        why: "A shorter path of the same kind of steps has fewer cells; against the traditional \
              A*, which cuts corners, it depends on the map.",
    },
];
