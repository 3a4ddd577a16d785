//! A drawn world on its way into a scenario.

use super::super::case::{goal, numbers};
use super::robots::Body;
use core::f64::consts::PI;
use nalgebra::{Isometry2, Point2, Vector2};
use toml::{Table, Value};
use zeronav_msgs::Pose;
use zeronav_world::spec::{Near, ObstacleSpec, ShapeSpec, Trigger};

/// Thickness of the walls around a hall. [m]
pub(super) const WALL_M: f64 = 0.2;

/// A goal: where, how near [m], and how near in yaw [rad].
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub(super) pose: Pose,
    pub(super) tolerance_m: f64,
    pub(super) yaw_tolerance_rad: f64,
}

impl Aim {
    /// Any yaw.
    pub(super) fn place(x_m: f64, y_m: f64) -> Self {
        Self {
            pose: Pose::new(x_m, y_m, 0.0),
            tolerance_m: 0.2,
            yaw_tolerance_rad: PI,
        }
    }
}

/// A drawn world, its lower left corner at the origin.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    /// What it is about, in a line.
    pub(super) title: String,
    /// Width and height of its area. [m]
    pub(super) size_m: [f64; 2],
    /// What stands: centre and size of boxes. [m]
    pub(super) boxes: Vec<([f64; 2], [f64; 2])>,
    /// What comes, goes or moves.
    pub(super) obstacles: Vec<ObstacleSpec>,
    /// The robot.
    pub(super) body: Body,
    /// Its faults.
    pub(super) faults: Vec<Table>,
    /// True when it knows what stands.
    pub(super) static_map: bool,
    /// `map_from_base` at the start.
    pub(super) start: Pose,
    /// The goals, in order.
    pub(super) goals: Vec<Aim>,
    /// Run time that it may take beside driving. [s]
    pub(super) extra_s: f64,
}

impl Scene {
    /// A hall with walls around it and nothing in it. [m]
    pub(super) fn hall(title: String, [width_m, height_m]: [f64; 2], body: Body) -> Self {
        let (half_m, long) = (0.5 * WALL_M, [width_m, WALL_M]);
        let tall = [WALL_M, height_m - 2.0 * WALL_M];
        let (x_m, y_m) = (0.5 * width_m, 0.5 * height_m);
        Self {
            title,
            size_m: [width_m, height_m],
            boxes: vec![
                ([x_m, half_m], long),
                ([x_m, height_m - half_m], long),
                ([half_m, y_m], tall),
                ([width_m - half_m, y_m], tall),
            ],
            obstacles: Vec::new(),
            body,
            faults: Vec::new(),
            static_map: false,
            start: Pose::default(),
            goals: Vec::new(),
            extra_s: 0.0,
        }
    }

    /// A box between two corners. [m]
    pub(super) fn block(&mut self, low: [f64; 2], high: [f64; 2]) {
        let middle = |axis: usize| 0.5 * (low[axis] + high[axis]);
        self.boxes
            .push(([middle(0), middle(1)], [high[0] - low[0], high[1] - low[1]]));
    }

    /// A wall across the hall from `x_m` on, `thick_m` thick, with a door of this width whose middle is at
    /// `door_m`. [m]
    pub(super) fn wall_with_door(&mut self, [x_m, thick_m]: [f64; 2], [door_m, width_m]: [f64; 2]) {
        let end_m = x_m + thick_m;
        let height_m = self.size_m[1];
        self.block([x_m, WALL_M], [end_m, door_m - 0.5 * width_m]);
        self.block([x_m, door_m + 0.5 * width_m], [end_m, height_m - WALL_M]);
    }

    /// Somebody or something that is there from `at_s` for `lasts_s`.
    pub(super) fn visitor(&mut self, shape: ShapeSpec, at_s: f64, lasts_s: f64) {
        self.obstacles.push(ObstacleSpec {
            appears: Some(Trigger {
                at_s: Some(at_s),
                robot_near: None,
            }),
            lasts_s: Some(lasts_s),
            ..ObstacleSpec::standing("visitor", shape)
        });
    }

    /// A box that drops when the robot comes within `distance_m` of a point. [m]
    pub(super) fn drop_box(
        &mut self,
        centre_m: [f64; 2],
        size_m: [f64; 2],
        point_m: [f64; 2],
        distance_m: f64,
    ) {
        let shape = ShapeSpec::Box {
            centre_m,
            size_m,
            yaw_rad: 0.0,
        };
        self.obstacles.push(ObstacleSpec {
            appears: Some(Trigger {
                at_s: None,
                robot_near: Some(Near {
                    point_m,
                    distance_m,
                }),
            }),
            ..ObstacleSpec::standing("box", shape)
        });
    }

    /// The scenario, turned by an angle about the middle of its area. [rad]
    ///
    /// # Errors
    /// One line about a value without a TOML form.
    pub(super) fn table(self, name: &str, angle_rad: f64) -> Result<Table, String> {
        let turn = Turn::new(self.size_m, angle_rad);
        let mut world = Table::new();
        let area_m = vec![Value::from(vec![0.0, 0.0]), turn.size_m.to_vec().into()];
        world.insert("area_m".into(), area_m.into());
        world.insert("resolution_m".into(), 0.05.into());
        let shape = |(centre_m, size_m): &([f64; 2], [f64; 2])| {
            form(&turn.shape(ShapeSpec::Box {
                centre_m: *centre_m,
                size_m: *size_m,
                yaw_rad: 0.0,
            }))
        };
        let shapes = self
            .boxes
            .iter()
            .map(shape)
            .collect::<Result<Vec<_>, _>>()?;
        world.insert("shapes".into(), shapes.into());
        let obstacles = self
            .obstacles
            .into_iter()
            .map(|one| form(&turn.obstacle(one)));
        world.insert(
            "obstacles".into(),
            obstacles.collect::<Result<Vec<_>, _>>()?.into(),
        );
        let mut robot = self.body.robot;
        robot.insert("faults".into(), self.faults.into());
        let goals = self.goals.iter().map(|aim| {
            let mut table = goal(turn.pose(aim.pose), aim.tolerance_m);
            table.insert("yaw_tolerance_rad".into(), aim.yaw_tolerance_rad.into());
            table
        });
        let mut sheet = Table::new();
        sheet.insert("title".into(), format!("{name}: {}", self.title).into());
        sheet.insert("start".into(), numbers(turn.pose(self.start)));
        sheet.insert("static_map".into(), self.static_map.into());
        sheet.insert("world".into(), world.into());
        sheet.insert("robot".into(), robot.into());
        sheet.insert("goals".into(), goals.collect::<Vec<_>>().into());
        Ok(sheet)
    }
}

fn form(value: &impl serde::Serialize) -> Result<Table, String> {
    Table::try_from(value).map_err(|error| error.to_string())
}

/// A world turned about the middle of its area, which then is the middle of a larger one.
struct Turn {
    angle_rad: f64,
    new_from_old: Isometry2<f64>,
    size_m: [f64; 2],
}

impl Turn {
    fn new([width_m, height_m]: [f64; 2], angle_rad: f64) -> Self {
        let (sin, cos) = (angle_rad.sin().abs(), angle_rad.cos().abs());
        let size_m = [
            (width_m * cos + height_m * sin).ceil(),
            (width_m * sin + height_m * cos).ceil(),
        ];
        let rotation = Isometry2::rotation(angle_rad);
        let middle = rotation * Vector2::new(0.5 * width_m, 0.5 * height_m);
        let shift = Vector2::new(0.5 * size_m[0], 0.5 * size_m[1]) - middle;
        Self {
            angle_rad,
            new_from_old: Isometry2::new(shift, angle_rad),
            size_m,
        }
    }

    fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let at = self.new_from_old * Point2::new(x, y);
        [at.x, at.y]
    }

    fn pose(&self, pose: Pose) -> Pose {
        Pose::from(self.new_from_old * pose.isometry())
    }

    fn shape(&self, shape: ShapeSpec) -> ShapeSpec {
        match shape {
            ShapeSpec::Box {
                centre_m,
                size_m,
                yaw_rad,
            } => ShapeSpec::Box {
                centre_m: self.point(centre_m),
                size_m,
                yaw_rad: yaw_rad + self.angle_rad,
            },
            ShapeSpec::Disc { centre_m, radius_m } => ShapeSpec::Disc {
                centre_m: self.point(centre_m),
                radius_m,
            },
            ShapeSpec::Polygon { corners_m } => ShapeSpec::Polygon {
                corners_m: corners_m.into_iter().map(|at| self.point(at)).collect(),
            },
        }
    }

    fn obstacle(&self, mut obstacle: ObstacleSpec) -> ObstacleSpec {
        obstacle.shape = self.shape(obstacle.shape);
        let triggers = [&mut obstacle.appears, &mut obstacle.starts];
        for near in triggers
            .into_iter()
            .flatten()
            .filter_map(|trigger| trigger.robot_near.as_mut())
        {
            near.point_m = self.point(near.point_m);
        }
        for at in &mut obstacle.waypoints_m {
            *at = self.point(*at);
        }
        for row in &mut obstacle.track {
            let [x, y] = self.point([row[1], row[2]]);
            *row = [row[0], x, y];
        }
        obstacle
    }
}
