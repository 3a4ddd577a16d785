//! The claims of the papers: what is said, by which row it is judged, and why it comes out as it does.

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
    /// The row that stands for it: its table, metric, algorithm, and what its maps and its note
    /// contain.
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

/// Every claim.
pub const CLAIMS: &[Claim] = &[
    Claim {
        paper: "BAO",
        id: "C1",
        tables: &["1", "2", "3", "4"],
        text: "The improved A* (IAA) finds paths as short as Dijkstra's.",
        headline: head("2", "same length (share)", "IAA = Dijkstra", "blocky", ""),
        why: "With a consistent estimate A* is exact, and the octile distance is consistent: the four equal \
              pairs of the paper could not have come out otherwise. It is checked on every map; one \
              difference would end the measurement.",
    },
    Claim {
        paper: "BAO",
        id: "C2",
        tables: &["1", "2", "3", "4"],
        text: "IAA's paths are shorter than those of virtual obstacles with the Manhattan distance (AAO).",
        headline: head("2", "length", "IAA vs AAO", "blocky", ""),
        why: "The Manhattan distance is too large where diagonal steps are allowed, so that AAO settles for \
              longer ways. The sign is sure; the mean over many maps is smaller than the single maps of \
              the paper, which lie at the far end of the spread.",
    },
    Claim {
        paper: "BAO",
        id: "C3",
        tables: &["1", "2", "3", "4"],
        text: "IAA needs half to a third of Dijkstra's time.",
        headline: head("2", "expanded", "IAA vs Dijkstra", "blocky", ""),
        why: "An estimate spares nodes, the more the less is in the way; counted in expansions the saving is \
              of the printed size, and times follow the nodes.",
    },
    Claim {
        paper: "BAO",
        id: "C4",
        tables: &["1", "2", "3", "4"],
        text: "Safety costs length against the traditional A* (TAA), except on the sparse map.",
        headline: head("2", "length", "IAA vs TAA", "blocky", ""),
        why: "Two effects work against each other: keeping off corners makes paths longer, the better \
              estimate makes them shorter. Which of them wins depends on the clutter, so that single maps \
              show either sign, as those of the paper do.",
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
        why: "It is the shortest of those made of eight directions. Pulled taut, the same path cuts no \
              corner either and is shorter on nearly every map.",
    },
    Claim {
        paper: "BAO",
        id: "C6",
        tables: &["1", "2", "3", "4"],
        text: "Inflating all obstacles (reference 31) fails at 30 % and 38.9 %.",
        headline: head("4", "success (share)", "full inflation", "blocky", ""),
        why: "A ring around every obstacle closes gaps of one and two cells, of which maps so dense consist. \
              On the sparse maps, where the paper prints a success each, it fails on about half, and on \
              all with single cells.",
    },
    Claim {
        paper: "BAO",
        id: "C7",
        tables: &["1", "2", "3", "4"],
        text: "Only a few virtual obstacles are set, about as many by IAA as by Dijkstra.",
        headline: head("4", "virtual obstacles on the path", "IAA", "blocky", ""),
        why: "Counted along the final path the numbers are within a factor of three of the printed ones, either \
              way; counted over the whole search there are many times as many, and most for Dijkstra, which the \
              paper cannot have meant.",
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
        why: "With every cell as a control point the curve keeps 0.465 cells from every obstacle: that \
              follows from the moves that cut no corner, and was found on every map.",
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
        why: "Two pictures and no number are printed. In the scenes assumed here a robot that follows its path \
              blindly collides; rates, intervals and those of this project's own defaults stand in the rows.",
    },
    Claim {
        paper: "TN",
        id: "C1",
        tables: &["1"],
        text: "The hybrid searches 88.85 % fewer nodes than A*.",
        headline: head(
            "1",
            "cells examined",
            "hybrid vs A*",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "Three cells a step along one walk are fewer than eight around every node of a search. The paper \
              does not count what sight lines and floods look at; with them the saving is smaller.",
    },
    Claim {
        paper: "TN",
        id: "C2",
        tables: &["1"],
        text: "It takes 77.05 % less time.",
        headline: head(
            "1",
            "time",
            "hybrid vs A*",
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
            "hybrid vs A*, same corners",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "Nothing on the grid is shorter than optimal A* under the same corner rule, and the walk around an \
              obstacle is always on the same side. Straight lines at any angle can be shorter: A* pulled \
              taut is, by about as much as is printed.",
    },
    Claim {
        paper: "TN",
        id: "C4",
        tables: &["1"],
        text: "Nothing is claimed about maps that the method does not solve.",
        headline: head(
            "1",
            "success (share)",
            "hybrid as printed",
            "blocky 20x20, 25.0 %, corners",
            "",
        ),
        why: "As printed the walk has no memory and turns in circles or ends in a pocket; on how many maps, grows \
              with the clutter. Remembering where it has been and going back makes it complete, with longer \
              ways, and that is how it is measured above.",
    },
    Claim {
        paper: "TN",
        id: "C5",
        tables: &["3"],
        text: "On the robot it takes 11.30 % less time and 4.00 % less length than Dijkstra.",
        headline: head("3", "length", "hybrid with ladder vs Dijkstra", "55x60", ""),
        why: "One drive in a corridor that is not described. Simulated with blocks the hybrid is faster and \
              longer.",
    },
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
        why: "A weight above 1 makes the search greedy; with 1.5, which is not printed, it saves more than the \
              paper's.",
    },
    Claim {
        paper: "ZM",
        id: "C2",
        tables: &["1", "2", "3"],
        text: "The adaptive weight (IM_APF_A*) searches about as few nodes as the fixed one, fewer after an \
               obstacle appears.",
        headline: head(
            "2",
            "expanded",
            "IM_APF_A* vs H_W_A*, the second search",
            "blocky",
            "",
        ),
        why: "A weight above 1 is given to nodes near obstacles alone: in the open the search is plain A*, and beside \
              obstacles nodes get a higher f and are left for later. It is less greedy just where the paper wants \
              it fast. None of the gains that were tried comes near the fixed weight.",
    },
    Claim {
        paper: "ZM",
        id: "C3",
        tables: &["1"],
        text: "The adaptive weight is more than twice as fast as the fixed one at the same number of nodes.",
        headline: head(
            "1",
            "time",
            "IM_APF_A* vs H_W_A*",
            "blocky 20x20, 15.0 %",
            "",
        ),
        why: "A distance to obstacles and an exponential for every node cannot make the same search faster.",
    },
    Claim {
        paper: "ZM",
        id: "C4",
        tables: &["2", "3"],
        text: "The robot does not collide with an obstacle that appears.",
        headline: head(
            "2",
            "no contact (share)",
            "zm_im and zm_full",
            "obstacle",
            "",
        ),
        why: "Driven by the real stack with the paper's planner and local method: no contact, though it arrives on \
              six maps of ten only. The pilot of this project brakes before contact whatever a controller \
              asks for.",
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
        why: "A weighted search is at most as good as A*; the table is right and the abstract is not. The paths \
              are longer by less than printed.",
    },
    Claim {
        paper: "LWX",
        id: "C1",
        tables: &["1", "2", "3"],
        text: "The optimised A* takes 55 to 71 % less time than A*.",
        headline: head("3", "expanded", "greedy vs A*", "blocky 40x40, 20.0 %", ""),
        why: "It keeps no open list and goes to the best neighbour, so where it arrives it has expanded little \
              more than its path.",
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
        why: "A greedy search has no proof of anything: around an obstacle it follows the side that looked \
              nearer.",
    },
    Claim {
        paper: "LWX",
        id: "C3",
        tables: &["1", "2", "3", "4"],
        text: "It obtains a feasible path on all maps.",
        headline: head("3", "success (share)", "greedy", "blocky 40x40, 20.0 %", ""),
        why: "What happens in a dead end is not printed. Giving up there fails on many maps; going back makes the \
              search complete and its paths much longer.",
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
        why: "The search that the paper calls bidirectional is A* from both ends to the middle of the line \
              between them.",
    },
    Claim {
        paper: "LWX",
        id: "C5",
        tables: &["5", "6"],
        text: "The whole method is 65 % faster than an ant colony and 84 % faster than a random tree.",
        headline: head("6", "time", "fusion vs random tree", "blocky", ""),
        why: "A colony of fifty ants over up to a hundred iterations is slower than anything. Compiled, a random \
              tree on 20 x 20 cells takes well under a millisecond, and the field and the fit take longer \
              than that.",
    },
    Claim {
        paper: "LWX",
        id: "C6",
        tables: &["fig16"],
        text: "A hundred steps per cell cost 288 % more than ten for the same path; one is too few.",
        headline: head(
            "fig16",
            "steps",
            "L = 100 vs L = 10",
            "blocky",
            "does not stop",
        ),
        why: "With steps of a fifth of a cell one per cell cannot arrive. More than ten cost more only in a loop \
              that goes on after it has arrived, and then ten times as much; one that stops costs the same.",
    },
    Claim {
        paper: "LWX",
        id: "C7",
        tables: &["dyn"],
        text: "The method avoids twenty dynamic obstacles.",
        headline: head(
            "dyn",
            "arrives without a contact (share)",
            "lwx_oa and lwx_oapf",
            "move",
            "",
        ),
        why: "Two pictures and no number are printed; whether the obstacles move is not said. What is counted \
              against it are mostly discs that run into a robot that waits.",
    },
    Claim {
        paper: "JU",
        id: "C1",
        tables: &["1"],
        text: "The fusion's path is 3.46 % shorter than that of A*.",
        headline: head("1", "length", "fusion vs A*", "iid", "point"),
        why: "The printed length is half a per cent above the straight line: the path crosses obstacles that count \
              as points. With obstacles as areas the fusion arrives on a third of the maps, and is longer \
              than the A* of the paper, which passes between corners where areas cannot.",
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
        why: "A* and a force for every point of the path come on top of the field. A compiled A* of 225 cells \
              takes microseconds, so that against it the roll-out is everything.",
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
        why: "Said, not shown. On maps whose gaps are one metre the field of 2 m closes most of them, so that \
              the fusion mostly waits.",
    },
];
