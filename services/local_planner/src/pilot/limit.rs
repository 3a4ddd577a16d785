//! What limits the speed of a period, to explain it. Nothing is decided by it.

use crate::situation::Situation;
use zeronav_motion::Twist;
use zeronav_msgs::command::RequestCause;

/// Share of the highest speed by which a motion is slower than it could be when something else than
/// the limit decided.
const SLOWER_SHARE: f64 = 0.1;

/// The limit that was lowest, and what it allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limit {
    pub(crate) cause: RequestCause,
    /// [m/s] fastest forward speed; 0 = the cause sets none.
    pub(crate) v_mps: f64,
    /// What decided when the motion is slower than that.
    pub(crate) slower: RequestCause,
}

impl Limit {
    /// Not told.
    pub(crate) const NONE: Self = Self::of(RequestCause::None);

    /// A cause that sets no speed.
    pub(crate) const fn of(cause: RequestCause) -> Self {
        Self::at(cause, 0.0)
    }

    /// A cause and the fastest forward speed that it allows. [m/s]
    pub(crate) const fn at(cause: RequestCause, v_mps: f64) -> Self {
        Self {
            cause,
            v_mps,
            slower: RequestCause::Critics,
        }
    }

    /// The lowest of what the path, the goal and the inputs allow; the first of equal ones. [m/s]
    pub(crate) fn lowest(of: &[(RequestCause, f64)]) -> Self {
        of.iter().fold(
            Self::at(RequestCause::None, f64::INFINITY),
            |least, &(cause, v_mps)| {
                if v_mps < least.v_mps {
                    Self::at(cause, v_mps)
                } else {
                    least
                }
            },
        )
    }

    /// What decided a motion from one twist towards another that was `wanted`, and the fastest speed
    /// that it allows. [m/s]
    pub(crate) fn with(
        self,
        situation: &Situation<'_>,
        window_s: f64,
        from: Twist,
        wanted: Twist,
    ) -> (RequestCause, f64) {
        let robot = situation.robot;
        // Faster than that no motion of this period was looked at.
        let reachable_mps = (from.v_mps + robot.a_mps2_max * window_s).min(self.v_mps);
        let is_slower = wanted.v_mps + SLOWER_SHARE * robot.v_mps_max < reachable_mps;
        if is_slower && self.slower != self.cause {
            return (self.slower, wanted.v_mps.max(0.0));
        }
        (self.cause, self.v_mps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_limit_is_named_and_of_equal_ones_the_first() {
        let limit = Limit::lowest(&[
            (RequestCause::Free, 0.8),
            (RequestCause::Goal, 0.5),
            (RequestCause::Corner, 0.5),
            (RequestCause::Heading, f64::INFINITY),
        ]);
        assert_eq!(limit.cause, RequestCause::Goal);
        assert!((limit.v_mps - 0.5).abs() < 1e-12);
        let free = Limit::lowest(&[(RequestCause::Free, 0.8), (RequestCause::Goal, 0.8)]);
        assert_eq!(free.cause, RequestCause::Free);
    }
}
