//! The claims of [ZM].

use super::claim::{Claim, head};

/// Every one.
pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        paper: "ZM",
        id: "C1",
        tables: &["1"],
        text: "Weighted searches look at fewer nodes than A*.",
        headline: head(
            "1",
            "expanded",
            "H_W_A* vs TRA_A*",
            "blocky 20x20, 15.0 %",
            "",
        ),
        why: "A weight above 1 makes the search greedy; with 1.5, which is not printed, it saves \
              more than the paper's.",
    },
    Claim {
        paper: "ZM",
        id: "C2",
        tables: &["1", "2", "3"],
        text: "The adaptive weight (IM_APF_A*) searches about as few nodes as the fixed one, \
              fewer after an obstacle appears.",
        headline: head(
            "2",
            "expanded",
            "IM_APF_A* vs H_W_A*, the second search",
            "blocky",
            "",
        ),
        why: "A weight above 1 is given to nodes near obstacles alone: in the open the search is \
              plain A*, and beside obstacles nodes get a higher f and are left for later. It is \
              less greedy just where the paper wants it fast. None of the gains that were tried \
              comes near the fixed weight.",
    },
    Claim {
        paper: "ZM",
        id: "C3",
        tables: &["1"],
        text: "The adaptive weight is more than twice as fast as the fixed one at the same number \
              of nodes.",
        headline: head(
            "1",
            "time",
            "IM_APF_A* vs H_W_A*",
            "blocky 20x20, 15.0 %",
            "",
        ),
        why: "A distance to obstacles and an exponential for every node cannot make the same \
              search faster.",
    },
    Claim {
        paper: "ZM",
        id: "C4",
        tables: &["2", "3"],
        text: "The robot does not collide with an obstacle that appears.",
        headline: head(
            "2",
            "no contact (share)",
            "zm_im and zm_full, nobody brakes",
            "obstacle",
            "",
        ),
        why: "A disc that the force alone moves, without a brake, as in the paper: the repulsion \
              grows without a bound towards an obstacle, so that no walk touches one; about one \
              in ten is caught before its goal instead. In the real stack nothing is touched \
              either, but there the pilot of this project brakes before contact whatever a \
              controller asks for.",
    },
    Claim {
        paper: "ZM",
        id: "C5",
        tables: &["1"],
        text: "The abstract claims a shorter path; table 1 prints 30 nodes instead of 26.",
        headline: head(
            "1",
            "cells of the path",
            "H_W_A* vs TRA_A*",
            "blocky 20x20, 15.0 %",
            "",
        ),
        why: "A weighted search is at most as good as A*; the table is right and the abstract is \
              not. The paths are longer by less than printed.",
    },
    Claim {
        paper: "ZM",
        id: "C6",
        tables: &["1", "2", "3"],
        text: "Weighted searches take less time than A*, and the adaptive one less than the fixed \
              one.",
        headline: head("1", "time", "H_W_A* vs TRA_A*", "blocky 20x20, 15.0 %", ""),
        why: "Times follow the nodes; a distance to obstacles and an exponential for every node \
              come on top of those of the adaptive weight.",
    },
    Claim {
        paper: "ZM",
        id: "C7",
        tables: &["1"],
        text: "The paths are smoother.",
        headline: head(
            "1",
            "turning points",
            "IM_APF_A* vs TRA_A*",
            "blocky 20x20, 15.0 %",
            "",
        ),
        why: "Said, not measured in the paper. A path on a grid turns where the search leaves it, \
              and keeping off obstacles makes it turn more.",
    },
];
