//! What moved as far as the mapping before knew, until its successor knows as much.
//!
//! A mapping that begins knows nothing of what moves until it has seen it move, some tenths of a second
//! later. To a robot at full speed what walks would stand for so long.

use crate::dynamic_obstacles::STATIC_MPS;
use zeronav_msgs::obstacles::{OBSTACLES_MAX, Obstacle};
use zeronav_msgs::time::seconds;

/// How long after it was seen something is remembered: as long as mapping expects what is hidden to come
/// out again. [s]
const LASTS_S: f64 = 1.5;

/// Distance from where it should be within which a moving obstacle is the one that is remembered. [m]
const SAME_M: f64 = 0.6;

/// Something that moved when it was seen.
#[derive(Debug, Clone, Copy)]
struct Detection {
    obstacle: Obstacle,
    /// Run time of the scan. [ns]
    run_ns: u64,
}

impl Detection {
    /// Where it should be at a run time, and how sure that is, if it went on. [ns]
    fn at(&self, run_ns: u64) -> Obstacle {
        let elapsed_s = seconds(run_ns.saturating_sub(self.run_ns));
        let mut later = self.obstacle;
        // Its number is that of a process which is gone; the successor's begin anew.
        later.track = 0;
        later.x_m += later.vx_mps * elapsed_s;
        later.y_m += later.vy_mps * elapsed_s;
        later.age_s += elapsed_s;
        later.unseen_s += elapsed_s;
        // Upper triangle by rows: xx xy xvx xvy, yy yvx yvy, vxvx vxvy, vyvy.
        let c = &mut later.covariance;
        c[0] += elapsed_s * (2.0 * c[2] + elapsed_s * c[7]);
        c[1] += elapsed_s * (c[3] + c[5] + elapsed_s * c[8]);
        c[4] += elapsed_s * (2.0 * c[6] + elapsed_s * c[9]);
        c[2] += elapsed_s * c[7];
        c[3] += elapsed_s * c[8];
        c[5] += elapsed_s * c[8];
        c[6] += elapsed_s * c[9];
        later
    }
}

fn moves(obstacle: &Obstacle) -> bool {
    obstacle.vx_mps.hypot(obstacle.vy_mps) >= STATIC_MPS
}

/// Tracked obstacles over a change of the process that tracks them.
#[derive(Debug, Clone, Default)]
pub struct Remembered {
    /// Epoch of the process that sent the newest ones; 0 = none came.
    author: u32,
    /// The newest ones, and those that are remembered behind them.
    obstacles: Vec<Obstacle>,
    n_newest: usize,
    run_ns: u64,
    before: Vec<Detection>,
}

impl Remembered {
    /// Takes in a message of `map/obstacles`: the epoch of its author and the run time of its scan. [ns]
    pub fn take(&mut self, author: u32, newest: &[Obstacle], run_ns: u64) {
        if author != self.author {
            let (of_author, seen_ns) = (&self.obstacles[..self.n_newest], self.run_ns);
            let moving = of_author.iter().filter(|obstacle| moves(obstacle));
            self.before.extend(moving.map(|obstacle| Detection {
                obstacle: *obstacle,
                run_ns: seen_ns,
            }));
            self.before.truncate(OBSTACLES_MAX);
            self.author = author;
        }
        self.before.retain(|seen| {
            let now = seen.at(run_ns);
            let is_it = |other: &Obstacle| {
                let away_m = (other.x_m - now.x_m).hypot(other.y_m - now.y_m);
                moves(other) && away_m < SAME_M
            };
            seconds(run_ns.saturating_sub(seen.run_ns)) <= LASTS_S && !newest.iter().any(is_it)
        });
        self.run_ns = run_ns;
        self.n_newest = newest.len().min(OBSTACLES_MAX);
        self.obstacles.clear();
        self.obstacles.extend_from_slice(&newest[..self.n_newest]);
        let before = self.before.iter().map(|seen| seen.at(run_ns));
        let room = OBSTACLES_MAX - self.n_newest;
        self.obstacles.extend(before.take(room));
    }

    /// Forgets what processes before the newest one knew.
    pub fn forget(&mut self) {
        self.obstacles.clear();
        self.n_newest = 0;
        self.before.clear();
    }

    /// What is tracked and what is remembered, as of the newest message.
    #[must_use]
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Epoch of the process that sent the newest message; 0 = none came.
    #[must_use]
    pub const fn author(&self) -> u32 {
        self.author
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Something at `x` that goes east, seen surely, its velocity less so.
    fn cart(track: u64, x_m: f64, vx_mps: f64) -> Obstacle {
        Obstacle {
            track,
            x_m,
            y_m: 2.0,
            vx_mps,
            radius_m: 0.3,
            covariance: [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.04, 0.0, 0.04],
            ..Obstacle::default()
        }
    }

    fn tracks(remembered: &Remembered) -> Vec<u64> {
        let obstacles = remembered.obstacles().iter();
        obstacles.map(|obstacle| obstacle.track).collect()
    }

    fn after_a_cart() -> Remembered {
        let mut remembered = Remembered::default();
        let standing = Obstacle {
            y_m: 5.0,
            ..cart(6, 1.0, 0.0)
        };
        remembered.take(1, &[cart(7, 1.0, 0.5), standing], 1000 * MS);
        assert_eq!(tracks(&remembered), [7, 6]);
        remembered
    }

    #[test]
    fn what_a_successor_does_not_know_yet_drives_on_and_grows_less_sure() {
        let mut remembered = after_a_cart();
        remembered.take(2, &[], 1600 * MS);
        let [cart] = remembered.obstacles() else {
            panic!("{remembered:?}");
        };
        assert!((cart.x_m - 1.3).abs() < 1e-9, "{cart:?}");
        // 0.01 + 0.6^2 * 0.04.
        assert!((cart.covariance[0] - 0.0244).abs() < 1e-9, "{cart:?}");
        assert!((cart.covariance[2] - 0.024).abs() < 1e-9, "{cart:?}");
        // The next one dies before it knows more.
        remembered.take(3, &[], 2400 * MS);
        assert!((remembered.obstacles()[0].x_m - 1.7).abs() < 1e-9);
        remembered.take(3, &[], 2501 * MS);
        assert_eq!(tracks(&remembered), [0; 0], "for 1.5 s");
    }

    #[test]
    fn what_the_successor_knows_takes_its_place() {
        let mut remembered = after_a_cart();
        // A track that does not move yet is no knowledge of what moves.
        remembered.take(2, &[cart(21, 1.3, 0.0)], 1600 * MS);
        assert_eq!(tracks(&remembered), [21, 0]);
        // Nor is something else that moves.
        remembered.take(2, &[cart(21, 1.3, 0.0), cart(22, 4.0, 0.5)], 1700 * MS);
        assert_eq!(tracks(&remembered), [21, 22, 0]);
        remembered.take(2, &[cart(21, 1.38, 0.45)], 1800 * MS);
        assert_eq!(tracks(&remembered), [21]);
        remembered.take(2, &[], 1900 * MS);
        assert_eq!(tracks(&remembered), [0; 0], "known and gone");
    }

    #[test]
    fn what_its_own_author_no_longer_tracks_is_gone() {
        let mut remembered = after_a_cart();
        remembered.take(1, &[], 1100 * MS);
        assert_eq!(tracks(&remembered), [0; 0]);
        remembered.take(2, &[], 1200 * MS);
        assert_eq!(tracks(&remembered), [0; 0]);
        let mut remembered = after_a_cart();
        remembered.forget();
        remembered.take(2, &[], 1200 * MS);
        assert_eq!(tracks(&remembered), [0; 0]);
    }

    #[test]
    fn there_are_never_more_than_a_message_holds() {
        let mut remembered = Remembered::default();
        let many: Vec<Obstacle> = (0..150_u32)
            .map(|n| cart(n.into(), 2.0 * f64::from(n), 0.5))
            .collect();
        for author in 1..20 {
            remembered.take(author, &many, u64::from(author) * MS);
            assert_eq!(remembered.obstacles().len(), OBSTACLES_MAX);
            remembered.take(author, &[], u64::from(author) * MS);
            assert!(remembered.before.len() <= OBSTACLES_MAX);
        }
    }
}
