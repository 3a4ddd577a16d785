//! Worlds of BARN, static cylinders in a corridor (Perille, Truong, Xiao, Stone, "Benchmarking
//! Metric Ground Navigation", SSRR 2020), as CSV files `x_m,y_m,r_m` with one cylinder a line.
//!
//! ```no_run
//! # fn main() -> Result<(), zeronav_world_files::DataError> {
//! use zeronav_world_files::{barn, barn::BarnWorld};
//! let world = BarnWorld::load("worlds/world_001.csv".as_ref())?;
//! let (spec, start, goal) = (world.spec(), barn::START, barn::GOAL);
//! # Ok(())
//! # }
//! ```

use crate::table::{DataError, Table};
use core::f64::consts::FRAC_PI_2;
use std::path::Path;
use zeronav_msgs::Pose;
use zeronav_world::spec::{ShapeSpec, WorldSpec};

/// Where the challenge puts the robot, `map_from_base`.
pub const START: Pose = Pose::new(-2.25, 3.0, FRAC_PI_2);

/// Where it sends it; any yaw will do.
pub const GOAL: Pose = Pose::new(-2.25, 13.0, FRAC_PI_2);

/// How near counts as there. [m]
pub const GOAL_TOLERANCE_M: f64 = 1.0;

/// Run time that the challenge allows. [s]
pub const TIME_LIMIT_S: f64 = 100.0;

/// Area of every world: the corridor, the field, and the open end with the goal. [m]
const AREA_M: [[f64; 2]; 2] = [[-4.5, 0.0], [0.0, 15.0]];

/// Most cylinders of a world; the corridor's lattice has 1920 places.
const CYLINDERS_MAX: usize = 4096;

/// A world.
#[derive(Debug, Clone, PartialEq)]
pub struct BarnWorld {
    /// `[x, y, radius]` of every cylinder, walls included. [m]
    pub cylinders: Vec<[f64; 3]>,
}

impl BarnWorld {
    /// Reads a world.
    ///
    /// # Errors
    /// See [`DataError`].
    pub fn load(file: &Path) -> Result<Self, DataError> {
        let table = Table::read(file, "x_m,y_m,r_m")?;
        let mut cylinders = Vec::new();
        for row in table.rows() {
            if cylinders.len() == CYLINDERS_MAX {
                return Err(row.refused(format!("more than {CYLINDERS_MAX} cylinders")));
            }
            cylinders.push([
                row.number(0, -100.0, 100.0)?,
                row.number(1, -100.0, 100.0)?,
                row.number(2, 1.0e-3, 10.0)?,
            ]);
        }
        Ok(Self { cylinders })
    }

    /// The cylinders as shapes.
    #[must_use]
    pub fn shapes(&self) -> Vec<ShapeSpec> {
        let shape = |[x, y, radius_m]: &[f64; 3]| ShapeSpec::Disc {
            centre_m: [*x, *y],
            radius_m: *radius_m,
        };
        self.cylinders.iter().map(shape).collect()
    }

    /// The world for a scenario, cells of 5 cm.
    #[must_use]
    pub fn spec(&self) -> WorldSpec {
        WorldSpec {
            shapes: self.shapes(),
            ..WorldSpec::area(AREA_M[0], AREA_M[1])
        }
    }
}
