//! Where a scripted obstacle is, was and will be.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_robot_sim::obstacles::Obstacle;

/// Time before and after a moment over which its velocity is a mean: recorded ways are straight from
/// sample to sample and turn at once. [s]
const HALF_S: f64 = 0.05;

/// An obstacle whose whole way is known.
#[derive(Debug)]
pub(super) struct Course {
    obstacle: Obstacle,
}

impl Course {
    /// Of an obstacle that waits for nobody and bounces off nothing.
    pub(super) fn new(described: &zeronav_world::Obstacle) -> Self {
        Self {
            obstacle: Obstacle::new(described),
        }
    }

    /// Where it is `ahead_s` after `run_ns`; `None` when it is gone by then, or somewhere else at once
    /// in between. [m]
    pub(super) fn ahead(&self, run_ns: u64, ahead_s: f64) -> Option<Point2<f64>> {
        let then_ns = run_ns + nanoseconds(ahead_s);
        self.goes_on(run_ns, then_ns)
            .then(|| self.obstacle.pose_at(then_ns).point())
    }

    /// How it moves at `run_ns`; zero when it is not there. [m/s]
    pub(super) fn velocity(&self, run_ns: u64) -> Vector2<f64> {
        let half_ns = nanoseconds(HALF_S);
        let before_ns = run_ns.saturating_sub(half_ns);
        let from_ns = if self.goes_on(before_ns, run_ns) {
            before_ns
        } else {
            run_ns
        };
        let to_ns = if self.goes_on(run_ns, run_ns + half_ns) {
            run_ns + half_ns
        } else {
            run_ns
        };
        let way = self.obstacle.pose_at(to_ns).point() - self.obstacle.pose_at(from_ns).point();
        if to_ns > from_ns {
            way / seconds(to_ns - from_ns)
        } else {
            Vector2::zeros()
        }
    }

    /// True when it jumps after `from_ns` and until `to_ns`.
    pub(super) fn jumps(&self, from_ns: u64, to_ns: u64) -> bool {
        let jump_ns = self.obstacle.next_jump_run_ns(from_ns);
        jump_ns.is_some_and(|jump_ns| jump_ns <= to_ns)
    }

    /// True when it is there at both moments and goes from one to the other.
    fn goes_on(&self, from_ns: u64, to_ns: u64) -> bool {
        self.obstacle.exists_at(from_ns)
            && self.obstacle.exists_at(to_ns)
            && !self.jumps(from_ns, to_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_world::{ObstacleSpec, Shape, ShapeSpec};

    /// 1 m/s along x from x = 0 for 4 s, then at once back.
    fn course(lasts_s: Option<f64>) -> Course {
        let shape = ShapeSpec::Disc {
            centre_m: [0.0, 0.0],
            radius_m: 0.3,
        };
        let spec = ObstacleSpec {
            track: vec![[0.0, 0.0, 0.0], [4.0, 4.0, 0.0]],
            repeat: true,
            lasts_s,
            ..ObstacleSpec::standing("walker", shape.clone())
        };
        let shape = Shape::new(&shape).expect("a shape");
        Course::new(&zeronav_world::Obstacle { spec, shape })
    }

    #[test]
    fn the_future_ends_where_it_jumps_or_vanishes() {
        let round = course(None);
        let there = round.ahead(1_000_000_000, 2.0).expect("it is there");
        assert!((there - Point2::new(3.0, 0.0)).norm() < 1e-9);
        assert_eq!(round.ahead(2_500_000_000, 2.0), None);
        assert!(round.jumps(3_900_000_000, 4_100_000_000));
        assert!(!round.jumps(4_100_000_000, 4_200_000_000));
        assert_eq!(course(Some(2.0)).ahead(1_500_000_000, 1.0), None);
    }

    #[test]
    fn a_jump_is_no_velocity() {
        let round = course(None);
        for run_ns in [0, 1_000_000_000, 3_990_000_000, 4_010_000_000] {
            let velocity = round.velocity(run_ns);
            assert!(
                (velocity - Vector2::new(1.0, 0.0)).norm() < 1e-6,
                "{velocity}"
            );
        }
        assert!(course(Some(2.0)).velocity(2_500_000_000).norm() < 1e-12);
    }
}
