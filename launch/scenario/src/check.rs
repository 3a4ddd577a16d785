//! Can it work? Everything that is known to be wrong before anything is started.

use super::{
    COORDINATE_M_MAX, ExpectSpec, FAULTS_MAX, GoalSpec, KEEP_S_MIN, Outcome, RandomFaults,
    Scenario, ScenarioError, StackFault, TIME_LIMIT_S_MAX, TOLERANCE, YAW_RAD_MAX,
};
use crate::{companions, hosts, zones};
use core::f64::consts::PI;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::map::{TILES_PER_KEYFRAME_MAX, tiles_of};
use zeronav_msgs::task::GOALS_MAX;
use zeronav_msgs::{Pose, Role};
use zeronav_params::{ParameterError, Parameters};
use zeronav_shell::nearest::unknown;
use zeronav_shell::printable::{printable, printable_lines};
use zeronav_world::error::{SpecError, number};
use zeronav_world::{Footprint, World};
use zeronav_world_files::{MapWarning, WorldError};

/// What a check of a scenario leaves: the world, ready to be asked.
#[derive(Debug, Clone)]
pub struct Checked {
    /// The world of the scenario.
    pub world: World,
    /// The outline of its robot.
    pub footprint: Footprint,
    /// Warnings: what is probably not intended.
    pub warnings: Vec<MapWarning>,
}

/// What an examination of a scenario leaves.
#[derive(Debug)]
pub(super) struct Examined {
    /// The world, when it could be made.
    pub(super) checked: Option<Checked>,
    /// Everything that is wrong.
    pub(super) wrong: Vec<ScenarioError>,
}

impl Scenario {
    /// Checks every number, reads the map file, and asks the world whether the robot can stand at
    /// its start and at its goals.
    ///
    /// # Errors
    /// Every value that cannot be, with file, line and field.
    pub fn validate(&self) -> Result<Checked, ScenarioError> {
        let Examined { checked, wrong } = self.examine();
        match (checked, ScenarioError::of(wrong)) {
            (Some(checked), None) => Ok(checked),
            (_, Some(error)) => Err(error),
            (None, None) => Err(self.error_at("world", "cannot be made")),
        }
    }

    /// True when every companion has a name that it can have.
    #[must_use]
    pub fn can_name_companions(&self) -> bool {
        let mut names = self.companions.keys();
        names.all(|name| companions::refusal(name).is_none())
    }

    /// Does what [`Self::validate`] does, and goes on after what is wrong.
    pub(super) fn examine(&self) -> Examined {
        let mut wrong = self.check_robot();
        wrong.extend(self.check_ranges());
        // What compares numbers says nothing of those that cannot be.
        if wrong.is_empty() {
            wrong.extend(self.check_rates().err());
        }
        wrong.extend(self.check_faults(wrong.is_empty()));
        wrong.extend(self.check_words());
        wrong.extend(self.check_swaps().err());
        wrong.extend(companions::check(&self.companions));
        wrong.extend(hosts::check(&self.hosts));
        wrong.extend(hosts::check_services(
            &self.hosts,
            (&self.faults, self.random_faults.as_ref()),
            self.restart.hang_after_s,
        ));
        let refused = |error: SpecError| self.error_at(&error.field, &error.why);
        let mut all = Vec::new();
        let loaded = zeronav_world_files::load(&self.world).map_err(|error| match error {
            WorldError::Map(error) => self.error_at("world.map", &error.to_string()),
            WorldError::Data { field, error } => {
                self.error_at(&format!("world.{field}"), &error.to_string())
            }
            WorldError::Spec(error) => refused(error.within("world")),
        });
        let loaded = loaded.map_err(|error| all.push(error)).ok();
        let world = loaded.as_ref().map(|(world, _)| world);
        let footprint = self.robot.footprint().ok();
        wrong.extend(world.and_then(|world| self.check_size(world).err()));
        wrong.extend(self.check_start(world, footprint.as_ref()).err());
        wrong.extend(self.check_goals(world, footprint.as_ref()));
        // A goal that cannot be reached is a fair thing to call unreachable.
        let wants_room = self.expect.outcome == Outcome::Reached;
        let place = world.zip(footprint.as_ref()).filter(|_| wants_room);
        let goals = self.goals.iter().map(|goal| (&goal.pose, goal.tolerance_m));
        wrong.extend(zones::check(&self.zones, goals, place));
        if let (Some(world), Some(footprint)) = (world, &footprint) {
            wrong.extend(self.check_trials(world, footprint).err());
        }
        all.extend(wrong.into_iter().map(refused));
        let checked = loaded
            .zip(footprint)
            .map(|((world, warnings), footprint)| Checked {
                world,
                footprint,
                warnings,
            });
        Examined {
            checked,
            wrong: all,
        }
    }

    fn check_words(&self) -> Vec<SpecError> {
        let mut wrong = Vec::new();
        if self.title.trim().is_empty() {
            wrong.push(SpecError::new("title", "must not be empty"));
        }
        wrong.extend(check_text(&self.name, "name of the file", false).err());
        wrong.extend(check_text(&self.group, "group", false).err());
        wrong.extend(check_text(&self.title, "title", false).err());
        wrong.extend(check_text(&self.description, "description", true).err());
        for (index, obstacle) in self.world.obstacles.iter().enumerate() {
            let field = format!("world.obstacles[{index}].name");
            wrong.extend(check_text(&obstacle.name, &field, false).err());
        }
        wrong.extend(self.check_expectations());
        wrong
    }

    fn check_expectations(&self) -> Vec<SpecError> {
        let mut wrong = Vec::new();
        let expect = &self.expect;
        if !self.foresight.is_none() && (*expect != ExpectSpec::default() || self.trials.is_some())
        {
            let why = "a scenario that expects something or has trials is judged, and what is \
                       judged is told nothing";
            wrong.push(SpecError::new("foresight", why));
        }
        if expect.outcome == Outcome::Unreachable && self.goals.is_empty() {
            let why = "nothing can be unreachable without a goal";
            wrong.push(SpecError::new("expect.outcome", why));
        }
        if let (Some(min), Some(max)) = (expect.obstacle_replans_min, expect.obstacle_replans_max)
            && min > max
        {
            let why = format!("{min} is above obstacle_replans_max {max}");
            wrong.push(SpecError::new("expect.obstacle_replans_min", why));
        }
        for (value, field) in [
            (expect.driven_m_min, "expect.driven_m_min"),
            (expect.goal_distance_m_max, "expect.goal_distance_m_max"),
        ] {
            wrong.extend(value.and_then(|value| number(value, 0.0, 1.0e6, field).err()));
        }
        for label in expect.interventions_min.keys() {
            let known = |code| Intervention::from_code(code).map(Intervention::label);
            let known: Vec<&str> = (1..=u16::MAX).map_while(known).collect();
            if !known.contains(&label.as_str()) {
                let field = format!("expect.interventions_min.{label}");
                wrong.push(SpecError::new(field, unknown("reason", label, known)));
            }
        }
        wrong
    }

    fn check_faults(&self, are_numbers_right: bool) -> Vec<SpecError> {
        if self.faults.len() > FAULTS_MAX {
            let why = format!("{} faults, at most {FAULTS_MAX}", self.faults.len());
            return vec![SpecError::new("faults", why)];
        }
        let mut wrong = Vec::new();
        for (index, fault) in self.faults.iter().enumerate() {
            let checked = fault.check().and_then(|()| {
                let why = "is missing: say when, such as { at_s = 3.0 }";
                let begins = fault.begins().map(|_| ());
                begins.ok_or_else(|| SpecError::new("begins", why))?;
                if are_numbers_right {
                    self.check_delay(fault)?;
                }
                Ok(())
            });
            let at = |error: SpecError| error.within(&format!("faults[{index}]"));
            wrong.extend(checked.err().map(at));
        }
        let random = self.random_faults.as_ref().map(RandomFaults::check);
        let random = random.and_then(Result::err);
        wrong.extend(random.map(|error| error.within("random_faults")));
        wrong
    }

    /// Accepts delays that the hang watch does not take for a hang.
    ///
    /// # Errors
    /// The field, and the longest delay.
    pub fn check_delay(&self, fault: &StackFault) -> Result<(), SpecError> {
        let most_ms = self.restart.hang_after_s * 500.0;
        match fault {
            StackFault::Slow { by_ms, .. } if *by_ms > most_ms => {
                let why = format!(
                    "{by_ms} ms would be taken for a hang: at most half of restart.hang_after_s, \
                     {most_ms} ms"
                );
                Err(SpecError::new("by_ms", why))
            }
            _ => Ok(()),
        }
    }

    /// Accepts swaps of seats that can be swapped, one after the other, and one shadow at most.
    fn check_swaps(&self) -> Result<(), SpecError> {
        let mut last_s = 0.0;
        for (index, swap) in self.swaps.iter().enumerate() {
            let at = |field: &str| format!("swaps[{index}].{field}");
            number(swap.at_s, 0.0, TIME_LIMIT_S_MAX, &at("at_s"))?;
            number(swap.shadow_s, 0.0, TIME_LIMIT_S_MAX, &at("shadow_s"))?;
            number(swap.keep_s, KEEP_S_MIN, TIME_LIMIT_S_MAX, &at("keep_s"))?;
            if swap.at_s < last_s {
                let why = format!("the swap above is not over before {last_s} s");
                return Err(SpecError::new(at("at_s"), why));
            }
            last_s = swap.at_s + swap.shadow_s + swap.keep_s;
            let others = Role::SERVICES
                .into_iter()
                .filter(|role| *role != Role::Robot);
            let known: Vec<&str> = others.map(Role::label).collect();
            if !known.contains(&swap.service.as_str()) {
                let why = unknown("service that can be swapped", &swap.service, known);
                return Err(SpecError::new(at("service"), why));
            }
        }
        let shadows: Vec<Role> = self.shadows().map(|(role, _)| role).collect();
        let field = |role: &Role| format!("services.{role}.shadow");
        match shadows.as_slice() {
            [] => Ok(()),
            [Role::Robot, ..] => {
                let why = "the robot keeps the time and has no shadow";
                Err(SpecError::new(field(&Role::Robot), why.to_owned()))
            }
            [_] if self.swaps.is_empty() => Ok(()),
            [role] | [_, role, ..] => {
                let why = "one shadow or swap at a time";
                Err(SpecError::new(field(role), why.to_owned()))
            }
        }
    }

    fn check_robot(&self) -> Vec<SpecError> {
        let mut wrong: Vec<SpecError> = self.robot.footprint().err().into_iter().collect();
        let parameters = check_all(&self.robot).into_iter().map(SpecError::from);
        let outline = ["radius_m", "footprint_m"];
        let is_said = !wrong.is_empty();
        wrong.extend(
            parameters.filter(|error| !is_said || !outline.contains(&error.field.as_str())),
        );
        if wrong.is_empty() {
            wrong.extend(self.robot.check().err());
        }
        let within = |error: SpecError| error.within("robot");
        wrong.into_iter().map(within).collect()
    }

    fn check_ranges(&self) -> Vec<SpecError> {
        let mut wrong = within(check_all(&self.run), "run");
        wrong.extend(within(check_all(&self.restart), "restart"));
        for (role, scheduling) in self.scheduling() {
            let field = format!("services.{role}.scheduling");
            wrong.extend(within(check_all(&scheduling), &field));
        }
        wrong
    }

    fn check_rates(&self) -> Result<(), SpecError> {
        let (tick_hz, lidar_hz) = (self.run.tick_hz, self.robot.lidar.rate_hz);
        if tick_hz >= lidar_hz {
            return Ok(());
        }
        let why = format!("{tick_hz} ticks per second are fewer than the lidar's {lidar_hz} scans");
        Err(SpecError::new("run.tick_hz", why))
    }

    /// The map must fit into one keyframe.
    fn check_size(&self, world: &World) -> Result<(), SpecError> {
        let geometry = world.geometry();
        let (columns, rows) = tiles_of(geometry);
        if columns as usize * rows as usize <= TILES_PER_KEYFRAME_MAX {
            return Ok(());
        }
        let field = if self.world.map.is_some() {
            "world.map"
        } else if self.world.generated.is_some() {
            "world.generated"
        } else {
            "world.area_m"
        };
        let why = format!(
            "{} x {} cells are more than {TILES_PER_KEYFRAME_MAX} tiles of 32 x 32: make it \
             smaller or its cells larger",
            geometry.width, geometry.height
        );
        Err(SpecError::new(field, why))
    }

    /// Of what cannot be made, nothing is checked that needs it.
    fn check_start(
        &self,
        world: Option<&World>,
        footprint: Option<&Footprint>,
    ) -> Result<(), SpecError> {
        self.check_pose(world, &self.start, "start")?;
        let Some((world, footprint)) = world.zip(footprint) else {
            return Ok(());
        };
        let standing = "the robot is in";
        if world.touches(footprint, &self.start) {
            let robot = footprint.placed(&self.start);
            let shape = world
                .shapes()
                .iter()
                .position(|shape| robot.distance_m(shape.placed()) <= 0.0);
            let what = shape.map_or_else(
                || "an occupied cell of the map file".to_owned(),
                |index| format!("world.shapes[{index}]"),
            );
            let why = format!("{standing} {what}: move start");
            return Err(SpecError::new("start", why));
        }
        for (index, obstacle) in world.obstacles().iter().enumerate() {
            let robot = footprint.placed(&self.start);
            if obstacle.is_there_from_the_start()
                && robot.distance_m(obstacle.shape.placed()) <= 0.0
            {
                let name = &obstacle.spec.name;
                let why =
                    format!("{standing} world.obstacles[{index}] \"{name}\": move start or it");
                return Err(SpecError::new("start", why));
            }
        }
        Ok(())
    }

    fn check_goals(&self, world: Option<&World>, footprint: Option<&Footprint>) -> Vec<SpecError> {
        if self.goals.len() > GOALS_MAX {
            let why = format!("{} goals, at most {GOALS_MAX}", self.goals.len());
            return vec![SpecError::new("goals", why)];
        }
        // A goal inside a wall is a fair thing to call unreachable.
        let wants_room = self.expect.outcome == Outcome::Reached;
        let goals = self.goals.iter().enumerate();
        let wrong = goals.filter_map(|(index, goal)| {
            let checked = self.check_goal(world, footprint, goal, wants_room);
            Some(checked.err()?.within(&format!("goals[{index}]")))
        });
        wrong.collect()
    }

    fn check_goal(
        &self,
        world: Option<&World>,
        footprint: Option<&Footprint>,
        goal: &GoalSpec,
        wants_room: bool,
    ) -> Result<(), SpecError> {
        let [least, most] = TOLERANCE;
        number(goal.tolerance_m, least, most, "tolerance_m")?;
        let yaw_rad = goal.yaw_tolerance_rad;
        number(yaw_rad, least, most, "yaw_tolerance_rad")?;
        self.check_pose(world, &goal.pose, "pose")?;
        let Some((world, footprint)) = world.zip(footprint) else {
            return Ok(());
        };
        let free = || world.free_pose_near(footprint, &goal.pose, goal.tolerance());
        if !wants_room || free().is_some() {
            return Ok(());
        }
        let yaw = if yaw_rad < PI {
            format!(" and {yaw_rad} rad")
        } else {
            String::new()
        };
        let why = format!(
            "the robot finds no room within {} m{yaw} of it: move the goal or widen its tolerance",
            goal.tolerance_m
        );
        Err(SpecError::new("pose", why))
    }

    fn check_trials(&self, world: &World, footprint: &Footprint) -> Result<(), SpecError> {
        let Some(trials) = &self.trials else {
            return Ok(());
        };
        let within = |error: SpecError| error.within("trials");
        let known = world
            .obstacles()
            .iter()
            .find(|obstacle| obstacle.spec.name == trials.obstacle);
        let Some(obstacle) = known else {
            let known = world.obstacles().iter().map(|one| one.spec.name.as_str());
            let why = unknown("obstacle", &trials.obstacle, known);
            return Err(within(SpecError::new("obstacle", why)));
        };
        for (index, goal) in trials.goals.iter().enumerate() {
            self.check_goal(Some(world), Some(footprint), goal, true)
                .map_err(|error| within(error.within(&format!("goals[{index}]"))))?;
        }
        for (index, end) in trials.line_m.iter().enumerate() {
            let pose = Pose::new(end[0], end[1], 0.0);
            self.check_pose(Some(world), &pose, &format!("line_m[{index}]"))
                .map_err(within)?;
        }
        let [from, to] = trials.line_m;
        if (to[0] - from[0]).hypot(to[1] - from[1]) < 1.0e-3 {
            return Err(within(SpecError::new(
                "line_m",
                "the two ends are the same",
            )));
        }
        let centre = obstacle.shape.pose().point();
        let reach_m = obstacle
            .shape
            .outline()
            .iter()
            .map(|corner| (corner - centre).norm())
            .fold(0.0, f64::max);
        let least_m = reach_m + footprint.circumscribed_radius_m();
        number(trials.ahead_m, least_m, 1.0e3, "ahead_m").map_err(within)
    }

    /// Accepts finite poses on the map, if there is one.
    fn check_pose(&self, world: Option<&World>, pose: &Pose, field: &str) -> Result<(), SpecError> {
        for (axis, value) in [pose.x_m, pose.y_m].into_iter().enumerate() {
            let field = format!("{field}[{axis}]");
            number(value, -COORDINATE_M_MAX, COORDINATE_M_MAX, &field)?;
        }
        number(
            pose.yaw_rad,
            -YAW_RAD_MAX,
            YAW_RAD_MAX,
            &format!("{field}[2]"),
        )?;
        let Some(world) = world.filter(|world| !world.contains(pose.point())) else {
            return Ok(());
        };
        let g = world.geometry();
        let (width_m, height_m) = (
            f64::from(g.width) * g.resolution_m,
            f64::from(g.height) * g.resolution_m,
        );
        let why = format!(
            "[{}, {}] lies beside the map of {}, which covers x {:.2} to {:.2} m, y {:.2} to \
             {:.2} m",
            pose.x_m,
            pose.y_m,
            self.name,
            g.origin_x_m,
            g.origin_x_m + width_m,
            g.origin_y_m,
            g.origin_y_m + height_m
        );
        Err(SpecError::new(field, why))
    }
}

fn check_all<P: Parameters>(config: &P) -> Option<ParameterError> {
    zeronav_params::check(config).err()
}

fn within(errors: impl IntoIterator<Item = ParameterError>, place: &str) -> Vec<SpecError> {
    let place = |error| SpecError::from(error).within(place);
    errors.into_iter().map(place).collect()
}

/// Accepts texts that look in a terminal as they do in the file; with `lines`, of several lines.
fn check_text(text: &str, field: &str, lines: bool) -> Result<(), SpecError> {
    let text = text.replace('\t', " ");
    let shown = if lines {
        printable_lines(&text)
    } else {
        printable(&text)
    };
    if shown == text {
        return Ok(());
    }
    let why = format!("must not hold control characters: {shown}");
    Err(SpecError::new(field, why))
}
