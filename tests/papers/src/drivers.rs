//! Who drives the scenes: names for the rows and the settings that the stack is started with.
//!
//! The papers' planners search with `cost_weight = 0`: a price on nearness to obstacles is none of theirs.
//! Lengths in cells are scaled to the scenes, whose cells are a metre on a map of 5 cm.

/// What the path of [BAO] keeps from obstacles besides the robot's radius, see
/// [`crate::scenes::BAO_PADDING_M`]. The potential fields do without: they push off the edges by themselves, and
/// on maps whose passages are a cell wide fewer of them arrive with it (of 12 scenes of [JU] 2 instead of 9, of
/// 24 of [LWX] with the gains as shipped 14 instead of 19).
pub const HALF_A_CELL: &str = "mapping.padding_m=0.2";

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
        HALF_A_CELL,
        "local_planner.controller=bao_dwa",
    ],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{BAO_PADDING_M, BaoMap};
    use zeronav_global_planner::PaperOptions;
    use zeronav_local_planner::papers::options::ZmFullConfig;
    use zeronav_local_planner::papers::potential::Gains;

    /// The number that a driver sets a key to.
    fn number(driver: &Driver, key: &str) -> f64 {
        let value = |it: &&str| it.strip_prefix(key)?.strip_prefix('=')?.parse::<f64>().ok();
        let found = driver.settings.iter().find_map(value);
        found.unwrap_or_else(|| panic!("{driver:?} has no {key}"))
    }

    #[test]
    fn the_path_of_bao_keeps_half_a_cell_off() {
        let set = number(&BAO, "mapping.padding_m");
        assert!((set - BAO_PADDING_M).abs() < 1e-9, "{set}");
        let text = BaoMap::new(1).unwrap().empty().planned_by("bao_iaa").text;
        assert!(!text.contains("padding_m"), "{text}");
        let scene = BaoMap::new(1).unwrap().empty().half_a_cell_off();
        assert!(scene.text.contains("padding_m = 0.2"), "{}", scene.text);
        for driver in [JU, LWX, LWX_CELLS, ZM_HW, ZM_IM] {
            assert!(!driver.settings.contains(&HALF_A_CELL), "{driver:?}");
        }
    }

    /// The cells of the scenes are a metre, those of the map 5 cm: three cells of those would be 0.15 m.
    #[test]
    fn lengths_in_cells_are_those_of_the_scenes() {
        let cell_m = number(&ZM_IM, "global_planner.options.papers.eta.cell_m");
        let reach_m = cell_m * PaperOptions::default().eta.p0_cells;
        assert!(
            (reach_m - ZmFullConfig::default().p0_m).abs() < 1e-9,
            "{reach_m}"
        );
        assert!(number(&ZM_IM, "mapping.clearance_limit_m") > reach_m);
        let of_lwx =
            |key: &str| number(&LWX_CELLS, &format!("local_planner.papers.lwx_oapf.{key}"));
        let own = [of_lwx("repel"), of_lwx("reach_m"), of_lwx("steps_per_m")];
        for (own, papers) in own.iter().zip([Gains::LWX.repel, Gains::LWX.reach, 10.0]) {
            assert!((own - papers).abs() < 1e-9, "{own} and {papers}");
        }
    }

    #[test]
    fn the_papers_search_without_a_price_on_nearness() {
        for driver in [JU, LWX, LWX_CELLS, ZM_HW, ZM_IM, BAO] {
            let unpriced = "global_planner.options.cost_weight=0";
            assert!(driver.settings.contains(&unpriced), "{driver:?}");
        }
    }
}
