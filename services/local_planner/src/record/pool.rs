//! A few of many rollouts: a spread, and the cheapest.

use zeronav_msgs::rollouts::{ROLLOUT_POINTS_MAX, Rollout};

/// Of successive numbers, multiples of this are spread evenly over all 32-bit numbers, whatever the
/// step between the numbers: 2^32 divided by the golden ratio.
const LOT: u32 = 0x9e37_79b9;

/// Rollouts of one outcome. Of all that are offered those with the lowest lots are kept: the more are
/// offered, the lower the lots must be.
#[derive(Debug)]
pub(super) struct Pool {
    most: usize,
    highest_lot: u32,
    spread: Vec<(u32, Rollout)>,
    cheapest: Option<Rollout>,
}

impl Pool {
    /// An empty one that keeps at most so many, and the cheapest.
    pub(super) fn new(most: usize) -> Self {
        Self {
            most,
            highest_lot: u32::MAX,
            spread: Vec::with_capacity(most),
            cheapest: None,
        }
    }

    pub(super) fn clear(&mut self) {
        self.highest_lot = u32::MAX;
        self.spread.clear();
        self.cheapest = None;
    }

    /// The rollout with this number, which is drawn when it is kept.
    pub(super) fn offer(&mut self, number: u32, cost: f32, draw: impl FnOnce() -> Rollout) {
        let lot = number.wrapping_add(1).wrapping_mul(LOT);
        while lot <= self.highest_lot && self.spread.len() == self.most {
            self.highest_lot /= 2;
            let highest = self.highest_lot;
            self.spread.retain(|(lot, _)| *lot <= highest);
        }
        let is_cheapest = self.cheapest.is_none_or(|cheapest| cost < cheapest.cost);
        if lot > self.highest_lot && !is_cheapest {
            return;
        }
        let rollout = draw();
        if is_cheapest {
            self.cheapest = Some(rollout);
        }
        if lot <= self.highest_lot {
            self.spread.push((lot, rollout));
        }
    }

    /// All that are kept, none twice.
    pub(super) fn all(&self) -> impl Iterator<Item = &Rollout> {
        let spread = || self.spread.iter().map(|(_, rollout)| rollout);
        let cheapest = self.cheapest.as_ref();
        let is_new = move |one: &&Rollout| !spread().any(|other| is_same(other, one));
        spread().chain(cheapest.filter(is_new))
    }
}

/// True for the same motion.
pub(super) fn is_same(a: &Rollout, b: &Rollout) -> bool {
    let bits = |along: [f32; ROLLOUT_POINTS_MAX]| along.map(f32::to_bits);
    let twist = |rollout: &Rollout| (rollout.v_mps.to_bits(), rollout.w_radps.to_bits());
    twist(a) == twist(b) && bits(a.x_m) == bits(b.x_m) && bits(a.y_m) == bits(b.y_m)
}
