//! The planners by name: a new planner is one file and one row here.

use crate::any_angle::AnyAngle;
use crate::anytime::Anytime;
use crate::astar::CAstar;
use crate::jps::{Choose, Jps};
use crate::lazy_theta::LazyTheta;
use crate::mpgaa::Mpgaa;
use crate::options::PlannerOptions;
use crate::papers::bao_full::bao_full;
use crate::papers::lwx_aco::lwx_aco;
use crate::papers::lwx_bi::lwx_bi;
use crate::papers::lwx_bi_true::LwxBiTrue;
use crate::papers::lwx_oa::lwx_oa;
use crate::papers::lwx_rrt::lwx_rrt;
use crate::papers::on_map::{OnMap, Solver};
use crate::papers::tn_3n::tn_3n;
use crate::papers::tn_apf::TnApf;
use crate::papers::tn_hyb::tn_hyb;
use crate::papers::variants;
use crate::planner::GlobalPlanner;
use crate::policy::Policy;

/// A planner that can be chosen.
#[derive(Debug, Clone, Copy)]
pub struct PlannerRow {
    /// Lower-case name in configurations, messages and tables; at most 24 bytes.
    pub key: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// Where the algorithm comes from.
    pub source: &'static str,
    /// True when it finds a path whenever there is one.
    pub complete: bool,
    /// Makes one.
    pub build: fn(&PlannerOptions) -> Box<dyn GlobalPlanner>,
}

/// Sources of the papers' planners.
const TN: &str = "[TN] three-neighbour search A* combined with artificial potential fields";
const JU: &str = "[JU] Ju, Luo, Yan: fusion of artificial potential fields and A*";
const ZM: &str = "[ZM] Zhang, Meng, 2022: A* with an improved artificial potential field";
const LWX: &str = "[LWX] Liu, Wang, Xu, 2022: optimised A*, potential field, least squares";
const BAO: &str = "[BAO] Bao et al., 2023: improved A*";

/// Every planner.
pub const PLANNERS: &[PlannerRow] = &[
    PlannerRow {
        key: "c_astar",
        title: "A* over costs",
        source: "Hart, Nilsson, Raphael, \"A Formal Basis for the Heuristic Determination of \
                 Minimum Cost Paths\", 1968; open list after Dial, 1969",
        complete: true,
        build: |options| Box::new(CAstar::new(options.map())),
    },
    PlannerRow {
        key: "mpgaa",
        title: "A* over costs that keeps a field of costs to the goal",
        source: "Hernandez, Asin, Baier, \"Reusing Previously Found A* Paths for Fast \
                 Goal-Directed Navigation in Dynamic Terrain\", AAAI 2015",
        complete: true,
        build: |options| Box::new(Mpgaa::new(options.map())),
    },
    PlannerRow {
        key: "policy",
        title: "Jumps where all cells cost the same, the kept field where they do not",
        source: "the searches of jps and mpgaa; which, is counted on the map",
        complete: true,
        build: |options| Box::new(Policy::new(options.map())),
    },
    PlannerRow {
        key: "jps",
        title: "Jump point search on bit maps, shortest ways",
        source: "Harabor, Grastien, \"Improving Jump Point Search\", ICAPS 2014",
        complete: true,
        build: |options| Box::new(Jps::new(options.map(), Choose::ByClutter)),
    },
    PlannerRow {
        key: "canonical",
        title: "Canonical A* on a bit map, shortest ways",
        source: "Sturtevant, Rabin, \"Canonical Orderings on Grids\", IJCAI 2016",
        complete: true,
        build: |options| Box::new(Jps::new(options.map(), Choose::Canonical)),
    },
    PlannerRow {
        key: "lazy_theta",
        title: "Lazy Theta*, ways at any angle",
        source: "Nash, Koenig, Tovey, \"Lazy Theta*: Any-Angle Path Planning and Path Length \
                 Analysis in 3D\", AAAI 2010",
        complete: true,
        build: |options| Box::new(LazyTheta::new(options.map())),
    },
    PlannerRow {
        key: "any_angle",
        title: "A* over costs, pulled straight where that is no dearer",
        source: "the search of mpgaa; Botea, Mueller, Schaeffer, \"Near Optimal Hierarchical \
                 Path-Finding\", 2004, for the pulling",
        complete: true,
        build: |options| Box::new(AnyAngle::new(options.map())),
    },
    PlannerRow {
        key: "anytime",
        title: "Weighted A* over costs, started again with less weight while time is left",
        source: "Richter, Thayer, Ruml, \"The Joy of Forgetting: Faster Anytime Search via \
                 Restarting\", ICAPS 2010",
        complete: true,
        build: |options| Box::new(Anytime::new(options.map())),
    },
    PlannerRow {
        key: "c_los",
        title: "A*, pulled taut",
        source: "the any-angle baseline of the papers' comparisons",
        complete: true,
        build: |options| on_map(variants::c_los(), options),
    },
    PlannerRow {
        key: "tn_a8",
        title: "A* over eight neighbours",
        source: TN,
        complete: true,
        build: |options| on_map(variants::tn_a8(options.papers.heuristic), options),
    },
    PlannerRow {
        key: "tn_apf",
        title: "Straight to the goal",
        source: TN,
        complete: false,
        build: |options| on_map(TnApf, options),
    },
    PlannerRow {
        key: "tn_3n",
        title: "Walk of three neighbours",
        source: TN,
        complete: true,
        build: |options| on_map(tn_3n(options.papers.walk, options.papers.literal), options),
    },
    PlannerRow {
        key: "tn_hyb",
        title: "Three-neighbour walk and attraction",
        source: TN,
        complete: true,
        build: |options| on_map(tn_hyb(options.papers.walk, options.papers.literal), options),
    },
    PlannerRow {
        key: "ju_astar",
        title: "A* with the straight distance",
        source: JU,
        complete: true,
        build: |options| on_map(variants::ju_astar(), options),
    },
    PlannerRow {
        key: "zm_tra",
        title: "Traditional A*",
        source: ZM,
        complete: true,
        build: |options| on_map(variants::zm_tra(), options),
    },
    PlannerRow {
        key: "zm_hw",
        title: "A* with a fixed weight",
        source: ZM,
        complete: true,
        build: |options| on_map(variants::zm_hw(options.papers.weight), options),
    },
    PlannerRow {
        key: "zm_im",
        title: "A* with a weight by obstacle distance",
        source: ZM,
        complete: true,
        build: |options| on_map(variants::zm_im(options.papers.eta), options),
    },
    PlannerRow {
        key: "lwx_ta",
        title: "Traditional A*",
        source: LWX,
        complete: true,
        build: |options| on_map(variants::lwx_ta(options.papers.literal), options),
    },
    PlannerRow {
        key: "lwx_oa",
        title: "Greedy search without an open list",
        source: LWX,
        complete: true,
        build: |options| {
            on_map(
                lwx_oa(options.papers.greedy, options.papers.literal),
                options,
            )
        },
    },
    PlannerRow {
        key: "lwx_bi",
        title: "A* from both ends to the middle",
        source: LWX,
        complete: true,
        build: |options| on_map(lwx_bi(), options),
    },
    PlannerRow {
        key: "lwx_bi_true",
        title: "Bidirectional A*",
        source: LWX,
        complete: true,
        build: |options| on_map(LwxBiTrue::default(), options),
    },
    PlannerRow {
        key: "lwx_aco",
        title: "Ant colony",
        source: LWX,
        complete: false,
        build: |options| on_map(lwx_aco(options.papers.ants, options.papers.seed), options),
    },
    PlannerRow {
        key: "lwx_rrt",
        title: "Random tree",
        source: LWX,
        complete: false,
        build: |options| on_map(lwx_rrt(options.papers.tree, options.papers.seed), options),
    },
    PlannerRow {
        key: "bao_taa",
        title: "A* with the Manhattan distance",
        source: BAO,
        complete: true,
        build: |options| on_map(variants::bao_taa(&options.papers), options),
    },
    PlannerRow {
        key: "bao_aao",
        title: "Virtual obstacles, Manhattan distance",
        source: BAO,
        complete: true,
        build: |options| on_map(variants::bao_aao(&options.papers), options),
    },
    PlannerRow {
        key: "bao_iaa",
        title: "Virtual obstacles, octile distance, spline",
        source: BAO,
        complete: true,
        build: |options| on_map(variants::bao_iaa(&options.papers), options),
    },
    PlannerRow {
        key: "bao_dij",
        title: "Dijkstra with virtual obstacles, spline",
        source: BAO,
        complete: true,
        build: |options| on_map(variants::bao_dij(&options.papers), options),
    },
    PlannerRow {
        key: "bao_full",
        title: "A* among inflated obstacles",
        source: BAO,
        complete: false,
        build: |options| on_map(bao_full(options.papers.ring), options),
    },
];

/// Keys of the planners whose ways are the shortest when all costs are 0 and no corner may be cut.
pub const EXACT: &[&str] = &["c_astar", "mpgaa", "policy", "jps", "canonical", "anytime"];

/// A method of a paper as a planner.
fn on_map<S: Solver + 'static>(solver: S, options: &PlannerOptions) -> Box<dyn GlobalPlanner> {
    Box::new(OnMap::new(solver, options.map()))
}

/// No planner has this key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no planner is called \"{key}\"; there are: {}", keys())]
pub struct UnknownPlanner {
    /// What was asked for.
    pub key: String,
}

/// The row of `key`.
///
/// # Errors
/// [`UnknownPlanner`], whose text lists the keys.
pub fn row_of(key: &str) -> Result<&'static PlannerRow, UnknownPlanner> {
    PLANNERS
        .iter()
        .find(|row| row.key == key)
        .ok_or_else(|| UnknownPlanner {
            key: key.to_owned(),
        })
}

fn keys() -> String {
    PLANNERS
        .iter()
        .map(|row| row.key)
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_unique_lower_case_and_fit_the_message() {
        for (n, row) in PLANNERS.iter().enumerate() {
            assert!(row.key.len() <= 24, "{}", row.key);
            assert_eq!(row.key, row.key.to_lowercase());
            assert!(PLANNERS[..n].iter().all(|other| other.key != row.key));
            assert_eq!(row_of(row.key).map(|found| found.key), Ok(row.key));
        }
    }

    #[test]
    fn exact_planners_are_planners() {
        for key in EXACT {
            assert!(row_of(key).is_ok_and(|row| row.complete), "{key}");
        }
    }

    #[test]
    fn an_unknown_key_is_answered_with_the_known_ones() {
        let error = row_of("best").map(|row| row.key).unwrap_err();
        assert!(error.to_string().contains("\"best\""));
        assert!(error.to_string().contains("c_astar"));
    }
}
