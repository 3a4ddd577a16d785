//! The claims of [TN].

use super::claim::{Claim, head};

/// Every one.
pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        paper: "TN",
        id: "C1",
        tables: &["1"],
        text: "The hybrid searches 88.85 % fewer nodes than A*.",
        headline: head(
            "1",
            "cells examined",
            "hybrid, visited vs A*",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "Three cells a step along one walk are fewer than eight around every node of a \
              search. The paper does not count what sight lines and floods look at; with them the \
              saving is smaller.",
    },
    Claim {
        paper: "TN",
        id: "C2",
        tables: &["1"],
        text: "It takes 77.05 % less time.",
        headline: head(
            "1",
            "time",
            "hybrid, visited vs A*",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "Times follow what is really looked at, sight lines and floods included.",
    },
    Claim {
        paper: "TN",
        id: "C3",
        tables: &["1"],
        text: "Its paths are 5.58 % shorter than those of A*.",
        headline: head(
            "1",
            "length",
            "hybrid, visited vs A*, same corners",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "Nothing on the grid is shorter than optimal A* under the same corner rule, and the \
              walk around an obstacle is always on the same side. Straight lines at any angle can \
              be shorter: A* pulled taut is, by about as much as is printed.",
    },
    Claim {
        paper: "TN",
        id: "C4",
        tables: &["1"],
        text: "Nothing is claimed about maps that the method does not solve.",
        headline: head(
            "1",
            "success (share)",
            "hybrid, visited",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "The text leaves open what the walk knows of cells that it has searched. Without a \
              memory it turns in circles, as the text says it dies in pockets, and going back it \
              is complete, each on longer ways than the one before: claims 1 to 3 are measured \
              for all three.",
    },
    Claim {
        paper: "TN",
        id: "C5",
        tables: &["3"],
        text: "On the robot it takes 11.30 % less time and 4.00 % less length than A*.",
        headline: head("3", "length", "hybrid with ladder vs A*", "55x60", ""),
        why: "One drive in a corridor that is not described. Simulated with blocks the hybrid is \
              faster and longer.",
    },
    Claim {
        paper: "TN",
        id: "C6",
        tables: &["1"],
        text: "Its paths have fewer turning points than those of A*.",
        headline: head(
            "1",
            "turning points",
            "hybrid, visited vs A*",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "Where the way is free the hybrid goes straight at any angle; around obstacles its \
              walk turns at every step that A* would turn at, and where it is shut in at more.",
    },
    Claim {
        paper: "TN",
        id: "C7",
        tables: &["1"],
        text: "It does not fall into concave obstacles.",
        headline: head("1", "success (share)", "hybrid, visited", "concave", ""),
        why: "A trap on the straight line is filled before it is entered. One that is met from \
              within, or whose rectangle holds an end of the way, is not filled, and the walk is \
              then left to what it remembers.",
    },
];
