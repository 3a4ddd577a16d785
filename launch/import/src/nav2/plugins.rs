//! Which plugins a file loads, under which names, and their next of kin.

use super::parameters::Sections;

/// Nodes that are asked for more than once.
pub(super) const CONTROLLERS_NODE: &str = "controller_server";
/// The node of the planners.
pub(super) const PLANNERS_NODE: &str = "planner_server";
/// The node of the local costmap.
pub(super) const LOCAL: &str = "local_costmap/local_costmap";
/// The node of the global costmap.
pub(super) const GLOBAL: &str = "global_costmap/global_costmap";
/// The node that stops the robot.
pub(super) const MONITOR: &str = "collision_monitor";

/// A controller of Nav2, by how its parameters are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Controller {
    /// Dynamic window.
    Dwb,
    /// Model predictive path integral.
    Mppi,
    /// Regulated pure pursuit.
    Rpp,
    /// Graceful motion control.
    Graceful,
    /// Timed elastic band.
    Teb,
    /// Any other.
    Other,
}

/// A plugin and its next of kin.
#[derive(Debug)]
pub(super) struct Kin<K> {
    /// End of the plugin's name.
    pub(super) plugin: &'static str,
    /// What it is here.
    pub(super) kind: K,
    /// Our key; `None` = the default.
    pub(super) key: Option<&'static str>,
    /// What is different.
    pub(super) means: &'static str,
}

const fn kin<K>(
    plugin: &'static str,
    kind: K,
    key: Option<&'static str>,
    means: &'static str,
) -> Kin<K> {
    Kin {
        plugin,
        kind,
        key,
        means,
    }
}

/// Controllers, with the plugin that Nav2 takes when a file names none in front.
pub(super) const CONTROLLERS: [Kin<Controller>; 5] = [
    kin(
        "DWBLocalPlanner",
        Controller::Dwb,
        Some("dwa"),
        "critics have other weights",
    ),
    kin(
        "MPPIController",
        Controller::Mppi,
        Some("mppi"),
        "critics have other weights",
    ),
    kin(
        "RegulatedPurePursuitController",
        Controller::Rpp,
        None,
        "no pure pursuit is there: the default avoids obstacles beside the path, where Nav2 stops",
    ),
    kin(
        "GracefulController",
        Controller::Graceful,
        None,
        "no graceful motion control is there: the default avoids obstacles beside the path, where Nav2 stops",
    ),
    kin(
        "TebLocalPlannerROS",
        Controller::Teb,
        None,
        "no timed elastic band is there",
    ),
];

/// Planners, with the plugin that Nav2 takes when a file names none in front.
pub(super) const PLANNERS: [Kin<()>; 5] = [
    kin(
        "NavfnPlanner",
        (),
        Some("mpgaa"),
        "both keep a field of costs to the goal",
    ),
    kin(
        "SmacPlanner2D",
        (),
        Some("c_astar"),
        "both are A* over costs on cells",
    ),
    kin(
        "ThetaStarPlanner",
        (),
        Some("lazy_theta"),
        "both plan at any angle",
    ),
    kin(
        "SmacPlannerHybrid",
        (),
        None,
        "paths have no least turning radius: the robot must be able to turn on the spot",
    ),
    kin(
        "SmacPlannerLattice",
        (),
        None,
        "paths have no motion primitives: the robot must be able to turn on the spot",
    ),
];

/// Our controller and planner when a plugin has no kin.
pub(super) const DEFAULT_CONTROLLER: &str = "beam";
/// See [`DEFAULT_CONTROLLER`].
pub(super) const DEFAULT_PLANNER: &str = "mpgaa";

/// The names under which plugins are loaded.
#[derive(Debug)]
pub(super) struct Plugins<'a> {
    sections: &'a Sections,
    /// Of the controller: the first one.
    pub(super) controller: &'a str,
    /// The plugin that follows paths, below a rotation shim, too.
    pub(super) controller_plugin: &'a str,
    /// What it is.
    pub(super) kind: Controller,
    /// Of the goal checker: the first one.
    goal: &'a str,
    /// Of the planner: the first one.
    pub(super) planner: &'a str,
    /// Its plugin.
    pub(super) planner_plugin: &'a str,
}

/// True for plugins written with `::` and with `/`.
pub(super) fn is(plugin: &str, name: &str) -> bool {
    plugin.rsplit([':', '/']).next() == Some(name)
}

impl<'a> Plugins<'a> {
    /// The plugins of a file.
    pub(super) fn of(sections: &'a Sections) -> Self {
        let first = |node, list, default| {
            sections
                .texts(node, list)
                .first()
                .copied()
                .unwrap_or(default)
        };
        let plugin = |node, name: &str, key| sections.text(node, &format!("{name}.{key}"));
        let controller = first(CONTROLLERS_NODE, "controller_plugins", "FollowPath");
        let outer = plugin(CONTROLLERS_NODE, controller, "plugin");
        let shimmed = outer
            .filter(|it| is(it, "RotationShimController"))
            .and_then(|_| plugin(CONTROLLERS_NODE, controller, "primary_controller"));
        let controller_plugin = shimmed.or(outer).unwrap_or("dwb_core::DWBLocalPlanner");
        let known = CONTROLLERS
            .iter()
            .find(|it| is(controller_plugin, it.plugin));
        let goal = sections
            .text(CONTROLLERS_NODE, "goal_checker_plugin")
            .unwrap_or("goal_checker");
        let planner = first(PLANNERS_NODE, "planner_plugins", "GridBased");
        Self {
            sections,
            controller,
            controller_plugin,
            kind: known.map_or(Controller::Other, |it| it.kind),
            goal: first(CONTROLLERS_NODE, "goal_checker_plugins", goal),
            planner,
            planner_plugin: plugin(PLANNERS_NODE, planner, "plugin")
                .unwrap_or("nav2_navfn_planner::NavfnPlanner"),
        }
    }

    /// A row's parameter of `node` with the names that this file gives its plugins; `None` when there is no such plugin.
    pub(super) fn named(&self, node: &str, parameter: &str) -> Option<String> {
        let Some((placeholder, rest)) = parameter
            .strip_prefix('{')
            .and_then(|it| it.split_once('}'))
        else {
            return Some(parameter.to_owned());
        };
        let name = match placeholder {
            "controller" => self.controller.to_owned(),
            "goal" => self.goal.to_owned(),
            "planner" => self.planner.to_owned(),
            "inflation" => self.layer(node, &["InflationLayer"])?.to_owned(),
            "scan" if node == MONITOR => self.source(node, "", "type", "scan")?,
            "scan" => {
                let layers = ["ObstacleLayer", "VoxelLayer", "SpatioTemporalVoxelLayer"];
                let layer = self.layer(node, &layers)?;
                self.source(node, &format!("{layer}."), "data_type", "LaserScan")?
            }
            _ => return None,
        };
        Some(name + rest)
    }

    /// The layers and filters of a costmap that are switched on, with their plugins.
    pub(super) fn layers(&self, node: &str) -> Vec<(&'a str, &'a str)> {
        let lists = ["plugins", "filters"].map(|list| self.sections.texts(node, list));
        let plugin = |name: &&'a str| self.sections.text(node, &format!("{name}.plugin"));
        let all = lists.into_iter().flatten();
        all.filter_map(|name| Some((name, plugin(&name)?)))
            .collect()
    }

    fn layer(&self, node: &str, plugins: &[&str]) -> Option<&'a str> {
        let layers = self.layers(node);
        let named = |it: &&(&str, &str)| plugins.iter().any(|name| is(it.1, name));
        layers.iter().find(named).map(|(name, _)| *name)
    }

    /// The sources below `above`, with their types; `usual` is the one of a source that names none.
    pub(super) fn sources(
        &self,
        node: &str,
        above: &str,
        (kind, usual): (&str, &'a str),
    ) -> Vec<(String, &'a str)> {
        let list = format!("{above}observation_sources");
        let text = self.sections.text(node, &list).unwrap_or_default();
        let mut names = self.sections.texts(node, &list);
        names.extend(text.split_whitespace());
        let typed = names.into_iter().map(|name| {
            let name = format!("{above}{name}");
            let typed = self.sections.text(node, &format!("{name}.{kind}"));
            (name, typed.unwrap_or(usual))
        });
        typed.collect()
    }

    fn source(&self, node: &str, above: &str, kind: &str, wanted: &'a str) -> Option<String> {
        let sources = self.sources(node, above, (kind, wanted));
        let found = sources.into_iter().find(|(_, typed)| *typed == wanted);
        found.map(|(name, _)| name)
    }
}
