//! A sequence of twists, and its beginning in the next period.

use super::batch::Batch;

/// Twists at the ends of the steps of a sample.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    v: Vec<f32>,
    w: Vec<f32>,
    known: bool,
}

impl Plan {
    /// No plan yet.
    pub(crate) fn new(steps: usize) -> Self {
        Self {
            v: vec![0.0; steps],
            w: vec![0.0; steps],
            known: false,
        }
    }

    /// True when there is one.
    pub(crate) const fn is_known(&self) -> bool {
        self.known
    }

    /// Forgets it.
    pub(crate) fn forget(&mut self) {
        self.known = false;
    }

    /// Speed and yaw rate at the end of a step. [m/s], [rad/s]
    pub(crate) fn at(&self, step: usize) -> (f32, f32) {
        (self.v[step], self.w[step])
    }

    /// The same twist all along.
    pub(crate) fn hold(&mut self, (v, w): (f32, f32)) {
        self.v.fill(v);
        self.w.fill(w);
        self.known = true;
    }

    /// That of a sample.
    pub(crate) fn take(&mut self, batch: &Batch, lane: usize) {
        for ((v, w), (from_v, from_w)) in self
            .v
            .iter_mut()
            .zip(&mut self.w)
            .zip(batch.v.iter().zip(&batch.w))
        {
            (*v, *w) = (from_v[lane], from_w[lane]);
        }
        self.known = true;
    }

    /// Begins a part of a step later, at most one; the last twist goes on.
    pub(crate) fn advance(&mut self, steps: f32) {
        let share = steps.clamp(0.0, 1.0);
        for twists in [&mut self.v, &mut self.w] {
            for i in 1..twists.len() {
                twists[i - 1] += (twists[i] - twists[i - 1]) * share;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_goes_on_where_it_was() {
        let mut plan = Plan::new(4);
        assert!(!plan.is_known());
        plan.hold((0.5, -1.0));
        assert!(plan.is_known());
        assert_eq!(plan.at(3), (0.5, -1.0));
        plan.v = vec![0.0, 1.0, 2.0, 3.0];
        plan.advance(0.5);
        assert_eq!(plan.v, [0.5, 1.5, 2.5, 3.0]);
        plan.advance(1.0);
        assert_eq!(plan.v, [1.5, 2.5, 3.0, 3.0]);
        assert_eq!(plan.w, [-1.0; 4]);
    }
}
