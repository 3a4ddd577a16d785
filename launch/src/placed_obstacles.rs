//! Obstacles that clients put into the simulated world while a stack runs.

use zeronav_msgs::Pose;
use zeronav_msgs::truth::{Placement, SIZE_M_MAX, TRUTH_OBSTACLES_MAX};
use zeronav_observe::control::ObstacleChange;
use zeronav_world::ShapeSpec;
use zeronav_world::error::number;

/// Longest name. [bytes]
const NAME_BYTES_MAX: usize = 64;

/// Smallest side. [m]
const SIZE_M_MIN: f64 = 0.01;

/// What clients have placed. All of it is sent with every change, so that none is missed.
#[derive(Debug)]
pub(crate) struct PlacedObstacles {
    /// Names by index, the scenario's first.
    names: Vec<String>,
    /// How many of them are the scenario's.
    n_scripted: usize,
    placements: Vec<Placement>,
}

impl PlacedObstacles {
    /// Nothing is placed yet in a world with obstacles of these names.
    pub(crate) fn new(names: impl IntoIterator<Item = String>) -> Self {
        let names: Vec<String> = names.into_iter().collect();
        Self {
            n_scripted: names.len(),
            names,
            placements: Vec::new(),
        }
    }

    /// The placement that a change which takes effect at `run_ns` comes to.
    ///
    /// # Errors
    /// Why the change cannot be made.
    pub(crate) fn plan(
        &self,
        name: &str,
        change: &ObstacleChange,
        run_ns: u64,
    ) -> Result<Placement, String> {
        let known = self.names.iter().position(|known| known == name);
        let there = known.filter(|index| self.is_there(*index));
        let before = there.and_then(|index| self.placement(index)).copied();
        let missing = || format!("there is no obstacle {name}; {}", self.known());
        Ok(match *change {
            ObstacleChange::Add { pose, size_m } => {
                if there.is_some() {
                    return Err(format!("{name} is there already; move or remove it"));
                }
                check_name(name)?;
                let size_m = checked(size_m)?;
                let index = known.unwrap_or(self.names.len());
                if index >= TRUTH_OBSTACLES_MAX {
                    return Err(format!(
                        "a world has {TRUTH_OBSTACLES_MAX} obstacles at most"
                    ));
                }
                Placement {
                    index: u32::try_from(index).unwrap_or(u32::MAX),
                    from_run_ns: run_ns,
                    pose: pose_of(pose)?,
                    size_x_m: size_m[0],
                    size_y_m: size_m[1],
                    ..Placement::default()
                }
            }
            ObstacleChange::Move { pose } => {
                let index = there.ok_or_else(missing)?;
                Placement {
                    index: u32::try_from(index).unwrap_or(u32::MAX),
                    from_run_ns: run_ns,
                    until_run_ns: 0,
                    pose: pose_of(pose)?,
                    ..before.unwrap_or_default()
                }
            }
            ObstacleChange::Remove => {
                let index = there.ok_or_else(missing)?;
                let never = Placement {
                    index: u32::try_from(index).unwrap_or(u32::MAX),
                    from_run_ns: run_ns,
                    ..Placement::default()
                };
                Placement {
                    until_run_ns: run_ns.max(1),
                    ..before.unwrap_or(never)
                }
            }
        })
    }

    /// Takes a planned placement in; returns everything that is to be sent.
    pub(crate) fn take(&mut self, name: &str, placement: Placement) -> &[Placement] {
        if placement.index as usize == self.names.len() {
            self.names.push(name.to_owned());
        }
        self.placements
            .retain(|other| other.index != placement.index);
        self.placements.push(placement);
        // An index behind the last adds one: they come in order.
        self.placements.sort_by_key(|placement| placement.index);
        &self.placements
    }

    /// The newest placement of an obstacle.
    fn placement(&self, index: usize) -> Option<&Placement> {
        let at = |placement: &&Placement| placement.index as usize == index;
        self.placements.iter().find(at)
    }

    /// True until it is removed. One of the scenario is there whatever its script says.
    fn is_there(&self, index: usize) -> bool {
        self.placement(index)
            .map_or(index < self.n_scripted, |placement| {
                placement.until_run_ns == 0
            })
    }

    fn known(&self) -> String {
        let there: Vec<&str> = (self.names.iter().enumerate())
            .filter(|(index, _)| self.is_there(*index))
            .map(|(_, name)| name.as_str())
            .collect();
        if there.is_empty() {
            "the world has none".to_owned()
        } else {
            format!("there are {}", there.join(", "))
        }
    }
}

fn check_name(name: &str) -> Result<(), String> {
    let plain = |character: char| character.is_ascii_alphanumeric() || "_-.".contains(character);
    if name.is_empty() || name.len() > NAME_BYTES_MAX || !name.chars().all(plain) {
        return Err(format!(
            "a name has 1 to {NAME_BYTES_MAX} letters, digits, `_`, `-` and `.`"
        ));
    }
    Ok(())
}

/// The sides; the second is 0 for a disc.
fn checked(size_m: [f64; 2]) -> Result<[f64; 2], String> {
    let range = |side: f64, least: f64, what: &str| {
        let checked = number(side, least, SIZE_M_MAX, "");
        checked.map_err(|error| format!("the {what} {}", error.why))
    };
    range(size_m[0], SIZE_M_MIN, "size")?;
    let least = if size_m[1] == 0.0 { 0.0 } else { SIZE_M_MIN };
    range(size_m[1], least, "second side")?;
    Ok(size_m)
}

fn pose_of([x_m, y_m, yaw_rad]: [f64; 3]) -> Result<Pose, String> {
    let pose = Pose::new(x_m, y_m, yaw_rad);
    pose.check("pose").map_err(|error| error.to_string())?;
    Ok(pose)
}

/// The shape of a placed obstacle; `None` when it keeps that of the scenario.
pub(crate) fn shape_of(placement: &Placement) -> Option<ShapeSpec> {
    let centre_m = [placement.pose.x_m, placement.pose.y_m];
    match (placement.size_x_m, placement.size_y_m) {
        (x_m, _) if x_m <= 0.0 => None,
        (x_m, y_m) if y_m > 0.0 => Some(ShapeSpec::Box {
            centre_m,
            size_m: [x_m, y_m],
            yaw_rad: placement.pose.yaw_rad,
        }),
        (x_m, _) => Some(ShapeSpec::Disc {
            centre_m,
            radius_m: 0.5 * x_m,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl PlacedObstacles {
        fn change(
            &mut self,
            name: &str,
            change: &ObstacleChange,
            run_ns: u64,
        ) -> Result<&[Placement], String> {
            let placement = self.plan(name, change, run_ns)?;
            Ok(self.take(name, placement))
        }
    }

    const ADD: ObstacleChange = ObstacleChange::Add {
        pose: [3.0, 1.0, 0.5],
        size_m: [0.8, 1.2],
    };

    const REMOVE: ObstacleChange = ObstacleChange::Remove;

    #[test]
    fn a_placed_obstacle_is_moved_removed_and_added_again_at_its_index() {
        let mut placed = PlacedObstacles::new(["door".to_owned()]);
        let sent = placed.change("crate", &ADD, 10).expect("added");
        assert_eq!((sent[0].index, sent[0].from_run_ns), (1, 10));
        assert!(placed.change("crate", &ADD, 11).is_err(), "it is there");
        let there = ObstacleChange::Move {
            pose: [4.0, 1.0, 0.0],
        };
        let sent = placed.change("crate", &there, 20).expect("moved");
        assert_eq!((sent[0].from_run_ns, sent[0].size_y_m), (20, 1.2));
        let sent = placed.change("crate", &ObstacleChange::Remove, 30);
        let gone = sent.expect("removed")[0];
        assert_eq!((gone.from_run_ns, gone.until_run_ns), (20, 30));
        let sent = placed.change("crate", &ADD, 40).expect("added");
        assert_eq!((sent.len(), sent[0].index, sent[0].until_run_ns), (1, 1, 0));
    }

    #[test]
    fn obstacles_of_the_scenario_are_moved_and_removed_and_all_changes_are_sent() {
        let mut placed = PlacedObstacles::new(["door".to_owned(), "cart".to_owned()]);
        placed.change("crate", &ADD, 5).expect("added");
        let sent = placed.change("door", &ObstacleChange::Remove, 7);
        let sent = sent.expect("removed");
        assert_eq!([sent[0].index, sent[1].index], [0, 2], "in order");
        assert_eq!((sent[0].from_run_ns, sent[0].until_run_ns), (7, 7));
        assert!(sent[0].size_x_m <= 0.0, "it keeps its form");
        assert!(placed.change("cart", &ADD, 8).is_err(), "it is there");
        placed.change("cart", &REMOVE, 8).expect("removed");
        assert!(placed.change("cart", &ADD, 9).is_ok(), "a form of its own");
    }

    #[test]
    fn what_was_removed_is_not_there_any_more() {
        let mut placed = PlacedObstacles::new(["door".to_owned(), "cart".to_owned()]);
        placed.change("crate", &ADD, 5).expect("added");
        let there = ObstacleChange::Move { pose: [4.0; 3] };
        for name in ["crate", "door"] {
            placed.change(name, &REMOVE, 7).expect("removed");
            for again in [&REMOVE, &there] {
                let why = placed.change(name, again, 8).expect_err("it is gone");
                assert!(why.starts_with("there is no obstacle"), "{why}");
                assert!(!why.ends_with(name), "{why}");
            }
        }
        let why = placed.change("box", &REMOVE, 9).expect_err("unknown");
        assert_eq!(why, "there is no obstacle box; there are cart");
        placed.change("cart", &REMOVE, 9).expect("removed");
        let why = placed.change("box", &REMOVE, 9).expect_err("unknown");
        assert_eq!(why, "there is no obstacle box; the world has none");
    }

    #[test]
    fn bad_changes_change_nothing() {
        let mut placed = PlacedObstacles::new([]);
        let add = |pose, size_m| ObstacleChange::Add { pose, size_m };
        for (name, change) in [
            ("a b", ADD),
            ("", ADD),
            ("x", add([f64::NAN, 0.0, 0.0], [1.0, 1.0])),
            ("x", add([0.0; 3], [0.0, 1.0])),
            ("x", add([0.0; 3], [1.0, -1.0])),
            ("x", add([0.0; 3], [1.0e9, 1.0])),
            ("nothing", ObstacleChange::Remove),
            ("nothing", ObstacleChange::Move { pose: [0.0; 3] }),
        ] {
            assert!(
                placed.change(name, &change, 5).is_err(),
                "{name} {change:?}"
            );
        }
        assert!(placed.names.is_empty() && placed.placements.is_empty());
    }
}
