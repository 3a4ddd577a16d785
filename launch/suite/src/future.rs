//! A world whose future is known: everything in it that comes, goes or moves is a disc that does so at
//! times of its own, whatever the robot does.

use super::oracle::robot::{Abilities, Disc};
use nalgebra::Point2;
use std::path::Path;
use zeronav_scenario::Scenario;
use zeronav_world::track::Track;
use zeronav_world::{Obstacle, World};

/// A world whose future is known, and the robot in it.
pub(super) struct Future {
    /// What the world and the robot were made of.
    pub(super) scenario: Scenario,
    /// What stands.
    pub(super) world: World,
    /// What moves.
    pub(super) movers: Vec<Mover>,
    /// What the robot can do.
    pub(super) abilities: Abilities,
}

/// A disc that stands, walks or follows a track.
pub(super) struct Mover {
    /// Its name.
    pub(super) name: String,
    track: Track,
    /// Its radius. [m]
    pub(super) radius_m: f64,
    /// Run time from which it is there. [s]
    pub(super) appears_s: f64,
    lasts_s: f64,
}

impl Mover {
    /// `None` when its future depends on the robot or on what it bounces off, it walks in rounds, or it is
    /// no disc.
    fn new(obstacle: &Obstacle) -> Option<Self> {
        let spec = &obstacle.spec;
        let radius_m = obstacle.shape.form().form().as_ball()?.radius;
        let appears_s = match &spec.appears {
            Some(trigger) => trigger.at_s.filter(|_| trigger.robot_near.is_none())?,
            None => 0.0,
        };
        if spec.starts.is_some() || spec.bounces_mps.is_some() {
            return None;
        }
        let track = if spec.track.is_empty() {
            walk(obstacle)?
        } else {
            Track::new(&spec.track, spec.repeat, spec.track_from_s)
        };
        Some(Self {
            name: spec.name.clone(),
            track,
            radius_m,
            appears_s,
            lasts_s: spec.lasts_s.unwrap_or(f64::INFINITY),
        })
    }

    /// Where it is at a run time; `None` while it is nowhere. [s]
    pub(super) fn at(&self, t_s: f64) -> Option<Disc> {
        let since_s = t_s - self.appears_s;
        let at = (0.0..self.lasts_s)
            .contains(&since_s)
            .then(|| self.track.at(since_s))?;
        Some(([at.x, at.y], self.radius_m))
    }

    /// Somebody of 0.3 m who is there from the start and walks along rows of time, x and y, for
    /// tests.
    #[cfg(test)]
    pub(super) fn walking(rows: &[[f64; 3]]) -> Self {
        Self {
            name: "walker".to_owned(),
            track: Track::new(rows, false, 0.0),
            radius_m: 0.3,
            appears_s: 0.0,
            lasts_s: f64::INFINITY,
        }
    }
}

/// The track of what walks along its waypoints once, or stands; `None` when it walks in rounds.
fn walk(obstacle: &Obstacle) -> Option<Track> {
    let spec = &obstacle.spec;
    let mut at = obstacle.shape.pose().point();
    let mut rows = vec![[0.0, at.x, at.y]];
    if spec.waypoints_m.is_empty() || spec.speed_mps <= 0.0 {
        return Some(Track::new(&rows, false, 0.0));
    }
    let mut time_s = 0.0;
    for next in spec.waypoints_m.iter().map(|next| Point2::from(*next)) {
        time_s += (next - at).norm() / spec.speed_mps;
        at = next;
        rows.push([time_s, at.x, at.y]);
    }
    (!spec.repeat).then(|| Track::new(&rows, false, 0.0))
}

impl Future {
    /// The world of a scenario.
    ///
    /// # Errors
    /// One line naming the file, or what in it has an unknown future.
    pub(super) fn of(file: &Path) -> Result<Self, String> {
        let name = file.to_str().ok_or_else(|| {
            let file = file.display();
            format!("the name of {file} is not valid UTF-8")
        })?;
        let scenario = Scenario::load(name).map_err(|error| error.to_string())?;
        let checked = scenario.validate().map_err(|error| error.to_string())?;
        let mover = |obstacle: &Obstacle| {
            Mover::new(obstacle).ok_or_else(|| {
                let what = &obstacle.spec.name;
                format!("{name}: cannot predict \"{what}\": only discs that move by themselves are supported")
            })
        };
        let movers = checked.world.obstacles().iter().map(mover);
        Ok(Self {
            movers: movers.collect::<Result<_, _>>()?,
            abilities: Abilities::new(&scenario.robot, &checked.footprint),
            world: checked.world,
            scenario,
        })
    }
}

/// A scenario `it.toml` for tests: a hall, a robot of 0.25 m that brakes with 1 m/s^2, and a
/// pedestrian who walks past x = 5 from `y = 0` at 1 m/s, from t = 2 s on.
#[cfg(test)]
pub(super) fn walker(more: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        r#"
        title = "Test"
        start = [1.0, 2.0, 0.0]
        [world]
        area_m = [[0.0, 0.0], [10.0, 5.0]]
        [[world.obstacles]]
        name = "walker"
        shape = {{ kind = "disc", centre_m = [5.0, 0.0], radius_m = 0.3 }}
        appears = {{ at_s = 2.0 }}
        track = [[7.0, 5.0, 0.0], [11.0, 5.0, 4.0]]
        track_from_s = 7.0
        {more}
        [robot]
        radius_m = 0.25
        v_mps_max = 1.0
        w_radps_max = 2.0
        a_mps2_max = 1.0
        alpha_radps2_max = 4.0
        lidar = {{ n_beams = 360, rate_hz = 10.0, range_m_min = 0.1, range_m_max = 12.0 }}
        "#
    );
    std::fs::write(folder.path().join("it.toml"), text).unwrap();
    folder
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(more: &str) -> Result<Future, String> {
        Future::of(&walker(more).path().join("it.toml"))
    }

    #[test]
    fn people_are_where_they_were_recorded() {
        let walker = &of("").unwrap().movers[0];
        assert_eq!(walker.at(1.9), None);
        assert_eq!(walker.at(3.5), Some(([5.0, 1.5], 0.3)));
        assert!(of("lasts_s = 1.0").unwrap().movers[0].at(3.1).is_none());
    }

    #[test]
    fn who_stands_or_walks_has_a_future_too() {
        let more = |text: &str| format!("[[world.obstacles]]\nname = \"other\"\n{text}");
        let disc = "shape = { kind = \"disc\", centre_m = [2.0, 1.0], radius_m = 0.4 }";
        let visit = format!("{disc}\nappears = {{ at_s = 3.0 }}\nlasts_s = 2.0");
        let visitor = &of(&more(&visit)).unwrap().movers[1];
        assert_eq!(
            [2.9, 3.0, 4.9, 5.1].map(|t_s| visitor.at(t_s).map(|(at, _)| at)),
            [None, Some([2.0, 1.0]), Some([2.0, 1.0]), None]
        );
        let way = format!("{disc}\nwaypoints_m = [[4.0, 1.0], [4.0, 2.0]]\nspeed_mps = 0.5");
        let walker = &of(&more(&way)).unwrap().movers[1];
        assert_eq!(
            [0.0, 2.0, 5.0, 9.0].map(|t_s| walker.at(t_s).unwrap().0),
            [[2.0, 1.0], [3.0, 1.0], [4.0, 1.5], [4.0, 2.0]]
        );
        assert!(of(&more(&format!("{way}\nrepeat = true"))).is_err());
    }

    #[test]
    fn who_waits_for_the_robot_has_no_future_of_its_own() {
        let near = "starts = { robot_near = { point_m = [1.0, 1.0], distance_m = 1.0 } }";
        let refused = of(near).err().unwrap();
        assert!(refused.contains("walker"), "{refused}");
        assert_eq!(refused.lines().count(), 1);
    }
}
