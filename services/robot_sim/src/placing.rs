//! Obstacles that are put into the world while it runs.

use crate::obstacles::Obstacle;
use std::collections::BTreeMap;
use zeronav_msgs::truth::{Placement, TRUTH_OBSTACLES_MAX};
use zeronav_world::{Convex, Shape, ShapeSpec};

/// Placements whose time has not come; the newest of each obstacle.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pending {
    by_index: BTreeMap<u32, Placement>,
}

impl Pending {
    /// Takes in a placement at run time `run_ns`: it changes `obstacles` when its time has come, and
    /// waits otherwise.
    pub(crate) fn take(
        &mut self,
        obstacles: &mut Vec<Obstacle>,
        placement: &Placement,
        run_ns: u64,
    ) {
        self.by_index.insert(placement.index, *placement);
        self.apply(obstacles, run_ns);
    }

    /// Changes `obstacles` by the placements whose time has come at `run_ns`, by their index: one
    /// behind the last adds an obstacle.
    pub(crate) fn apply(&mut self, obstacles: &mut Vec<Obstacle>, run_ns: u64) {
        self.by_index.retain(|_, placement| {
            let waits = placement.from_run_ns > run_ns;
            if !waits {
                place(obstacles, placement);
            }
            waits
        });
    }
}

/// Puts an obstacle of the list somewhere for a time; see
/// [`Simulator::place`](crate::Simulator::place).
fn place(obstacles: &mut Vec<Obstacle>, placement: &Placement) {
    let index = placement.index as usize;
    let form = form_of(placement);
    if let Some(form) = &form
        && index == obstacles.len()
        && index < TRUTH_OBSTACLES_MAX
    {
        obstacles.push(Obstacle::absent(form.clone()));
    }
    let Some(obstacle) = obstacles.get_mut(index) else {
        return;
    };
    if let Some(form) = form {
        obstacle.take_form(form);
    }
    let until_ns = (placement.until_run_ns != 0).then_some(placement.until_run_ns);
    obstacle.place(placement.pose, placement.from_run_ns, until_ns);
}

/// The form that a placement gives its obstacle, in its own frame; `None` when it keeps the one that
/// it has. A side that is too small makes no form.
fn form_of(placement: &Placement) -> Option<Convex> {
    let (x_m, y_m) = (placement.size_x_m, placement.size_y_m);
    let centre_m = [0.0, 0.0];
    let spec = if y_m > 0.0 {
        ShapeSpec::Box {
            centre_m,
            size_m: [x_m, y_m],
            yaw_rad: 0.0,
        }
    } else {
        ShapeSpec::Disc {
            centre_m,
            radius_m: 0.5 * x_m,
        }
    };
    Some(Shape::new(&spec).ok()?.form().clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::Pose;

    fn placement(index: u32, from_run_ns: u64, size_m: [f64; 2]) -> Placement {
        Placement {
            index,
            from_run_ns,
            pose: Pose::new(3.0, 1.0, 0.0),
            size_x_m: size_m[0],
            size_y_m: size_m[1],
            ..Placement::default()
        }
    }

    #[test]
    fn obstacles_are_added_behind_the_last_and_change_their_form() {
        let mut obstacles = Vec::new();
        place(&mut obstacles, &placement(1, 5, [1.0, 2.0]));
        assert!(obstacles.is_empty(), "index 0 is missing");
        place(&mut obstacles, &placement(0, 5, [0.0, 0.0]));
        assert!(obstacles.is_empty(), "it has no form");
        place(&mut obstacles, &placement(0, 5, [1.0, 2.0]));
        assert!(!obstacles[0].exists_at(4) && obstacles[0].exists_at(5));
        let extent = obstacles[0].placed_at(5).bounds().extents();
        assert!((extent.x - 1.0).abs() < 1.0e-6 && (extent.y - 2.0).abs() < 1.0e-6);
        place(&mut obstacles, &placement(0, 9, [0.6, 0.0]));
        assert!(!obstacles[0].exists_at(8), "it is placed again");
        assert!(obstacles[0].placed_at(9).is_disc());
        let gone = Placement {
            until_run_ns: 12,
            ..placement(0, 9, [0.0, 0.0])
        };
        place(&mut obstacles, &gone);
        assert!(obstacles[0].exists_at(11) && !obstacles[0].exists_at(12));
        assert!(obstacles[0].placed_at(9).is_disc(), "it keeps its form");
    }

    #[test]
    fn a_placement_waits_for_its_time_and_the_newest_of_an_obstacle_counts() {
        let (mut obstacles, mut pending) = (Vec::new(), Pending::default());
        // The one behind the last comes first: both are added in order.
        pending.take(&mut obstacles, &placement(1, 9, [1.0, 1.0]), 4);
        pending.take(&mut obstacles, &placement(0, 9, [1.0, 1.0]), 4);
        pending.apply(&mut obstacles, 8);
        assert!(obstacles.is_empty(), "their time has not come");
        pending.apply(&mut obstacles, 9);
        assert_eq!(obstacles.len(), 2);
        // It stays where it is until it is somewhere else.
        let moved = Placement {
            pose: Pose::new(5.0, 1.0, 0.0),
            ..placement(0, 20, [0.0, 0.0])
        };
        pending.take(&mut obstacles, &moved, 10);
        pending.apply(&mut obstacles, 19);
        assert!(obstacles[0].exists_at(19));
        let x_m = |obstacles: &[Obstacle], run_ns| obstacles[0].pose_at(run_ns).x_m;
        assert!((x_m(&obstacles, 19) - 3.0).abs() < 1.0e-12);
        let again = Placement {
            pose: Pose::new(6.0, 1.0, 0.0),
            ..moved
        };
        pending.take(&mut obstacles, &again, 19);
        pending.apply(&mut obstacles, 20);
        assert!((x_m(&obstacles, 20) - 6.0).abs() < 1.0e-12);
        assert!(pending.by_index.is_empty(), "each is applied once");
    }

    #[test]
    fn their_number_is_bounded() {
        let mut obstacles = Vec::new();
        for index in 0..=u32::try_from(TRUTH_OBSTACLES_MAX).unwrap_or(0) {
            place(&mut obstacles, &placement(index, 5, [1.0, 1.0]));
        }
        assert_eq!(obstacles.len(), TRUTH_OBSTACLES_MAX);
    }
}
