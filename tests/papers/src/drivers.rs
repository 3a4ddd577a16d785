//! Who drives the scenes: names for the rows and the settings that the stack is started with.
//!
//! The papers' planners search with `cost_weight = 0`: a price on nearness to obstacles is none of theirs.
//! Lengths in cells are scaled to the scenes, whose cells are a metre on a map of 5 cm.

/// A driver.
#[derive(Debug, Clone, Copy)]
pub struct Driver {
    /// Name in the rows.
    pub name: &'static str,
    /// `ROLE.KEY=VALUE`, as of `zeronav suite --set`.
    pub settings: &'static [&'static str],
}

/// The defaults of this project.
pub const DEFAULTS: Driver = Driver {
    name: "the defaults of this project",
    settings: &[],
};

/// [JU].
pub const JU: Driver = Driver {
    name: "ju_astar and ju_fusion",
    settings: &[
        "global_planner.planner=ju_astar",
        "global_planner.options.cost_weight=0",
        "local_planner.controller=ju_fusion",
    ],
};

/// [LWX] as this project ships it: its gains in cells, on cells of half a metre.
pub const LWX: Driver = Driver {
    name: "lwx_oa and lwx_oapf",
    settings: &[
        "global_planner.planner=lwx_oa",
        "global_planner.options.cost_weight=0",
        "local_planner.controller=lwx_oapf",
    ],
};

/// [LWX] on the cells of a metre that the scenes have: the gains of the paper as they are.
pub const LWX_CELLS: Driver = Driver {
    name: "lwx_oa and lwx_oapf, cells of 1 m",
    settings: &[
        "global_planner.planner=lwx_oa",
        "global_planner.options.cost_weight=0",
        "local_planner.controller=lwx_oapf",
        "local_planner.papers.lwx_oapf.repel=1.0",
        "local_planner.papers.lwx_oapf.reach_m=1.5",
        "local_planner.papers.lwx_oapf.steps_per_m=10.0",
    ],
};

/// [ZM] with the fixed weight.
pub const ZM_HW: Driver = Driver {
    name: "zm_hw and zm_full",
    settings: &[
        "global_planner.planner=zm_hw",
        "global_planner.options.cost_weight=0",
        "local_planner.controller=zm_full",
    ],
};

/// [ZM] with the adaptive one, whose distances are in cells.
pub const ZM_IM: Driver = Driver {
    name: "zm_im and zm_full",
    settings: &[
        "global_planner.planner=zm_im",
        "global_planner.options.cost_weight=0",
        "global_planner.options.papers.eta.cell_m=1.0",
        "mapping.clearance_limit_m=3.1",
        "local_planner.controller=zm_full",
    ],
};

/// [BAO].
pub const BAO: Driver = Driver {
    name: "bao_iaa and bao_dwa",
    settings: &[
        "global_planner.planner=bao_iaa",
        "global_planner.options.cost_weight=0",
        "local_planner.controller=bao_dwa",
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_search_without_a_price_on_nearness() {
        for driver in [JU, LWX, LWX_CELLS, ZM_HW, ZM_IM, BAO] {
            let unpriced = "global_planner.options.cost_weight=0";
            assert!(driver.settings.contains(&unpriced), "{driver:?}");
        }
    }
}
