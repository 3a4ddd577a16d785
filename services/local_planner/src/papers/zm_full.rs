//! `zm_full` [ZM]: the whole local method, the improved field inside A*: attraction to the next point of
//! the A* path, repulsion with the gain eta (eq. 5 to 8), escape (eq. 9) and relative velocity (eq. 10,
//! 11), each as its own part restates it.
//!
//! **Which point is next.** The paper puts its field into A*: A* gives the nodes, the field moves the
//! robot from each to the one after it. It does not say how a robot between two nodes counts. Here it
//! stands in the cell of the node that it is nearest to along the path, and the next point is the node
//! after that: half a cell to one and a half ahead. Nodes are a cell of the paper apart
//! (`papers.zm_full.point_m`), whatever the cells of the map are. The point takes the place of the goal in
//! the whole potential, in the attraction and in the factor `d^n` of eq. (6): with the far goal in the
//! factor the repulsion would outgrow the pull by the length of the way. Without a path the goal itself is
//! the next point; the escape counts its progress towards the goal.

use super::escape::Escape;
use super::law::{Law, LawInput, Push};
use super::options::ZmFullConfig;
use super::potential::{Eta, attraction, eta_repulsion, velocity_repulsion};
use super::route::{Nodes, Route};
use nalgebra::{Point2, Vector2};

/// `F = F_att + sum (F_rep1 + F_rep2) + sum F_rv`, with `F_esp = R(+-90 deg) F_rep + F_att` in place of
/// the first two where they cancel.
#[derive(Debug, Clone)]
pub struct ZmFull {
    config: ZmFullConfig,
    escape: Escape,
    route: Route,
    nodes: Nodes,
}

impl ZmFull {
    /// The method with these gains.
    #[must_use]
    pub fn new(config: &ZmFullConfig) -> Self {
        Self {
            config: *config,
            escape: Escape::new(config.escape_m, config.tries),
            route: Route::default(),
            nodes: Nodes::default(),
        }
    }

    /// Escapes begun towards this goal.
    #[must_use]
    pub const fn escapes(&self) -> u32 {
        self.escape.escapes()
    }

    /// The next point of the A* path, see the module; near its end the end, without a path the goal. [m]
    pub fn next_point(&mut self, input: &LawInput<'_>) -> Point2<f64> {
        let cell_m = self.config.point_m;
        self.nodes.take(input, cell_m);
        let place = self.route.place(input);
        place
            .and_then(|place| self.nodes.after(place.arc_m + 0.5 * cell_m).next())
            .or_else(|| self.nodes.last())
            .unwrap_or(input.goal)
    }
}

impl Law for ZmFull {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let next = self.next_point(input);
        let config = &self.config;
        let eta = Eta {
            alpha: config.alpha,
            beta: config.beta,
            p0: config.p0_m,
            is_differentiated: config.full_gradient,
        };
        let mut repel = Vector2::zeros();
        let mut sideways = Vector2::zeros();
        for body in input.bodies {
            let from = body.nearest(input.at, input.literal);
            repel += eta_repulsion(&eta, config.n, input.at, from, next);
            sideways +=
                velocity_repulsion(config.velocity, config.p0_m, input.at, input.velocity, body);
        }
        let pull = attraction(config.attract, input.at, next);
        match self
            .escape
            .push(input, (pull, repel), 1.0e-3 * config.attract)
        {
            Push::Along(force) => Push::Along(force + sideways),
            Push::Stuck => Push::Stuck,
        }
    }

    fn escapes_minima(&self) -> bool {
        true
    }
}
