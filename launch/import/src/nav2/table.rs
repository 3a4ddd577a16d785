//! What is carried over: a row for each parameter of Nav2, and one for each field of a scenario.

use super::plugins::Controller::{self, Dwb, Graceful, Mppi, Rpp, Teb};
use super::plugins::{CONTROLLERS_NODE, GLOBAL, LOCAL, MONITOR, PLANNERS_NODE};

/// How a parameter is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// A number that is not negative.
    Positive,
    /// A number; above 0 it is 0: the slowest speed forward is none backward.
    Backward,
    /// The size of a number, whatever its sign.
    Size,
    /// A speed backward that is written without its sign.
    Opposite,
    /// A whole number.
    Count,
    /// Whether the robot drives backwards; if so, as fast as forward.
    Reverses,
    /// A boolean.
    Switch,
    /// Whether unknown cells may be crossed.
    Unknown,
    /// A footprint.
    Corners,
    /// The name of a topic.
    Topic,
    /// The name of a frame.
    Frame,
}

/// A parameter and where it goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Node.
    pub(super) node: &'static str,
    /// Name below the node; `{controller}`, `{goal}`, `{planner}`, `{inflation}` and `{scan}` stand for the names that a
    /// file gives its plugins and its lidar.
    pub(super) parameter: &'static str,
    /// Item of a list.
    pub(super) item: Option<usize>,
    /// The controller that has it; `None` = none or any.
    pub(super) of: Option<Controller>,
    /// How it is read.
    pub(super) form: Form,
    /// Path of the field in the scenario.
    pub(super) to: &'static str,
    /// What Nav2 takes when the file has the node, and the controller, but none of the node's parameters for this field.
    pub(super) otherwise: Option<f64>,
}

impl Row {
    const fn of(self, controller: Controller) -> Self {
        Self {
            of: Some(controller),
            ..self
        }
    }

    const fn or(self, otherwise: f64) -> Self {
        Self {
            otherwise: Some(otherwise),
            ..self
        }
    }

    const fn item(self, item: usize) -> Self {
        Self {
            item: Some(item),
            ..self
        }
    }
}

const fn row(node: &'static str, parameter: &'static str, form: Form, to: &'static str) -> Row {
    Row {
        node,
        parameter,
        item: None,
        of: None,
        form,
        to,
        otherwise: None,
    }
}

const CONTROL: &str = CONTROLLERS_NODE;
const SMOOTHER: &str = "velocity_smoother";
const NAVIGATOR: &str = "bt_navigator";
const AMCL: &str = "amcl";

const V_MAX: &str = "robot.v_mps_max";
const V_MIN: &str = "robot.v_mps_min";
const W_MAX: &str = "robot.w_radps_max";
const A_MAX: &str = "robot.a_mps2_max";
const BRAKE: &str = "robot.brake_mps2";
const ALPHA: &str = "robot.alpha_radps2_max";
const FOOTPRINT: &str = "robot.footprint_m";
const RADIUS: &str = "robot.radius_m";
const RESOLUTION: &str = "world.resolution_m";
const INFLATION: &str = "services.mapping.config.inflation_radius_m";
const SCALING: &str = "services.mapping.config.cost_scaling_factor";
const TOLERANCE: &str = "goals.tolerance_m";
const YAW_TOLERANCE: &str = "goals.yaw_tolerance_rad";
const SCAN: &str = "services.robot.config.ros.scan_topic";
const ODOM: &str = "services.robot.config.ros.odom_topic";
const CMD_VEL: &str = "services.robot.config.ros.cmd_vel_topic";
const STAMPED: &str = "services.robot.config.ros.cmd_vel_stamped";
const ODOM_FRAME: &str = "services.robot.config.ros.odom_frame";
const BASE_FRAME: &str = "services.robot.config.ros.base_frame";
const SIM_TIME: &str = "services.robot.config.ros.use_sim_time";

// Names and defaults as in the sources of Nav2, Humble to Lyrical. Of several rows for one field the first that the file
// has counts, or the strictest: see `FIELDS`.
/// The parameters of Nav2.
#[rustfmt::skip]
pub(super) const ROWS: &[Row] = &[
    // Outline: Nav2 takes the radius when there is no footprint.
    row(LOCAL, "footprint", Form::Corners, FOOTPRINT),
    row(LOCAL, "robot_radius", Form::Positive, RADIUS),
    row(GLOBAL, "footprint", Form::Corners, FOOTPRINT),
    row(GLOBAL, "robot_radius", Form::Positive, RADIUS),
    // Costs: those of the global costmap decide which way is taken.
    row(GLOBAL, "resolution", Form::Positive, RESOLUTION),
    row(LOCAL, "resolution", Form::Positive, RESOLUTION),
    row(GLOBAL, "{inflation}.inflation_radius", Form::Positive, INFLATION).or(0.55),
    row(LOCAL, "{inflation}.inflation_radius", Form::Positive, INFLATION).or(0.55),
    row(GLOBAL, "{inflation}.cost_scaling_factor", Form::Positive, SCALING).or(10.0),
    row(LOCAL, "{inflation}.cost_scaling_factor", Form::Positive, SCALING).or(10.0),
    // Limits of the controller.
    row(CONTROL, "{controller}.max_vel_x", Form::Positive, V_MAX).of(Dwb),
    row(CONTROL, "{controller}.min_vel_x", Form::Backward, V_MIN).of(Dwb).or(0.0),
    row(CONTROL, "{controller}.max_vel_theta", Form::Positive, W_MAX).of(Dwb),
    row(CONTROL, "{controller}.acc_lim_x", Form::Positive, A_MAX).of(Dwb),
    row(CONTROL, "{controller}.decel_lim_x", Form::Size, BRAKE).of(Dwb),
    row(CONTROL, "{controller}.acc_lim_theta", Form::Positive, ALPHA).of(Dwb),
    row(CONTROL, "{controller}.vx_max", Form::Positive, V_MAX).of(Mppi).or(0.5),
    row(CONTROL, "{controller}.vx_min", Form::Backward, V_MIN).of(Mppi).or(-0.35),
    row(CONTROL, "{controller}.wz_max", Form::Positive, W_MAX).of(Mppi).or(1.9),
    row(CONTROL, "{controller}.ax_max", Form::Positive, A_MAX).of(Mppi).or(3.0),
    row(CONTROL, "{controller}.ax_min", Form::Size, BRAKE).of(Mppi).or(-3.0),
    row(CONTROL, "{controller}.az_max", Form::Positive, ALPHA).of(Mppi).or(3.5),
    row(CONTROL, "{controller}.desired_linear_vel", Form::Positive, V_MAX).of(Rpp),
    row(CONTROL, "{controller}.max_linear_vel", Form::Positive, V_MAX).of(Rpp).or(0.5),
    row(CONTROL, "{controller}.allow_reversing", Form::Reverses, V_MIN).of(Rpp).or(0.0),
    row(CONTROL, "{controller}.max_angular_vel", Form::Positive, W_MAX).of(Rpp),
    row(CONTROL, "{controller}.rotate_to_heading_angular_vel", Form::Positive, W_MAX).of(Rpp).or(1.8),
    row(CONTROL, "{controller}.max_linear_accel", Form::Positive, A_MAX).of(Rpp),
    row(CONTROL, "{controller}.max_linear_decel", Form::Size, BRAKE).of(Rpp),
    row(CONTROL, "{controller}.max_angular_accel", Form::Positive, ALPHA).of(Rpp).or(3.2),
    row(CONTROL, "{controller}.v_linear_max", Form::Positive, V_MAX).of(Graceful).or(0.5),
    row(CONTROL, "{controller}.allow_backward", Form::Reverses, V_MIN).of(Graceful).or(0.0),
    row(CONTROL, "{controller}.v_angular_max", Form::Positive, W_MAX).of(Graceful).or(1.0),
    row(CONTROL, "{controller}.max_vel_x", Form::Positive, V_MAX).of(Teb),
    row(CONTROL, "{controller}.max_vel_x_backwards", Form::Opposite, V_MIN).of(Teb),
    row(CONTROL, "{controller}.max_vel_theta", Form::Positive, W_MAX).of(Teb),
    row(CONTROL, "{controller}.acc_lim_x", Form::Positive, A_MAX).of(Teb),
    row(CONTROL, "{controller}.acc_lim_theta", Form::Positive, ALPHA).of(Teb),
    // Limits of what comes behind every controller.
    row(SMOOTHER, "max_velocity", Form::Positive, V_MAX).item(0).or(0.5),
    row(SMOOTHER, "min_velocity", Form::Backward, V_MIN).item(0).or(-0.5),
    row(SMOOTHER, "max_velocity", Form::Positive, W_MAX).item(2).or(2.5),
    row(SMOOTHER, "max_accel", Form::Positive, A_MAX).item(0).or(2.5),
    row(SMOOTHER, "max_decel", Form::Size, BRAKE).item(0).or(-2.5),
    row(SMOOTHER, "max_accel", Form::Positive, ALPHA).item(2).or(3.2),
    // Goals.
    row(CONTROL, "{goal}.xy_goal_tolerance", Form::Positive, TOLERANCE).or(0.25),
    row(CONTROL, "{goal}.yaw_goal_tolerance", Form::Positive, YAW_TOLERANCE).or(0.25),
    // How controllers of a kin look ahead.
    row(CONTROL, "{controller}.sim_time", Form::Positive, "services.local_planner.config.dwa.horizon_s").of(Dwb),
    row(CONTROL, "{controller}.vx_samples", Form::Count, "services.local_planner.config.dwa.speeds").of(Dwb),
    row(CONTROL, "{controller}.vtheta_samples", Form::Count, "services.local_planner.config.dwa.yaw_rates").of(Dwb),
    row(CONTROL, "{controller}.batch_size", Form::Count, "services.local_planner.config.mppi.samples").of(Mppi),
    row(CONTROL, "{controller}.time_steps", Form::Count, "services.local_planner.config.mppi.steps").of(Mppi),
    row(CONTROL, "{controller}.model_dt", Form::Positive, "services.local_planner.config.mppi.step_s").of(Mppi),
    row(CONTROL, "{controller}.vx_std", Form::Positive, "services.local_planner.config.mppi.speed_std_mps").of(Mppi),
    row(CONTROL, "{controller}.wz_std", Form::Positive, "services.local_planner.config.mppi.yaw_rate_std_radps").of(Mppi),
    row(PLANNERS_NODE, "{planner}.allow_unknown", Form::Unknown, "services.global_planner.config.unknown"),
    // The robot's side of ROS.
    row(LOCAL, "{scan}.topic", Form::Topic, SCAN),
    row(GLOBAL, "{scan}.topic", Form::Topic, SCAN),
    row(MONITOR, "{scan}.topic", Form::Topic, SCAN),
    row(AMCL, "scan_topic", Form::Topic, SCAN),
    row(NAVIGATOR, "odom_topic", Form::Topic, ODOM),
    row(CONTROL, "odom_topic", Form::Topic, ODOM),
    row(SMOOTHER, "odom_topic", Form::Topic, ODOM),
    row(MONITOR, "cmd_vel_out_topic", Form::Topic, CMD_VEL),
    row(CONTROL, "enable_stamped_cmd_vel", Form::Switch, STAMPED),
    row(SMOOTHER, "enable_stamped_cmd_vel", Form::Switch, STAMPED),
    row(MONITOR, "enable_stamped_cmd_vel", Form::Switch, STAMPED),
    row(LOCAL, "global_frame", Form::Frame, ODOM_FRAME),
    row(AMCL, "odom_frame_id", Form::Frame, ODOM_FRAME),
    row(MONITOR, "odom_frame_id", Form::Frame, ODOM_FRAME),
    row(LOCAL, "robot_base_frame", Form::Frame, BASE_FRAME),
    row(GLOBAL, "robot_base_frame", Form::Frame, BASE_FRAME),
    row(NAVIGATOR, "robot_base_frame", Form::Frame, BASE_FRAME),
    row(MONITOR, "base_frame_id", Form::Frame, BASE_FRAME),
    row(AMCL, "base_frame_id", Form::Frame, BASE_FRAME),
    row(NAVIGATOR, "use_sim_time", Form::Switch, SIM_TIME),
    row(CONTROL, "use_sim_time", Form::Switch, SIM_TIME),
    row(LOCAL, "use_sim_time", Form::Switch, SIM_TIME),
    row(GLOBAL, "use_sim_time", Form::Switch, SIM_TIME),
    row(PLANNERS_NODE, "use_sim_time", Form::Switch, SIM_TIME),
    row(AMCL, "use_sim_time", Form::Switch, SIM_TIME),
];

/// Which of several values counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// That of the first row.
    First,
    /// The smallest.
    Least,
    /// The largest.
    Most,
}

/// A field that a parameter becomes.
#[derive(Debug)]
pub(super) struct Field {
    /// Its path in the scenario; `goals` stands for each of them.
    pub(super) path: &'static str,
    /// Which of several values counts.
    pub(super) choice: Choice,
    /// Smallest and largest number; empty of what is no number.
    pub(super) range: Option<[f64; 2]>,
    /// True when a number out of range is left out instead of being rejected.
    pub(super) may_be_left: bool,
}

const fn field(path: &'static str, choice: Choice, range: [f64; 2]) -> Field {
    Field {
        path,
        choice,
        range: Some(range),
        may_be_left: false,
    }
}

const fn tuning(path: &'static str, range: [f64; 2]) -> Field {
    Field {
        may_be_left: true,
        ..field(path, Choice::First, range)
    }
}

const fn word(path: &'static str) -> Field {
    Field {
        path,
        choice: Choice::First,
        range: None,
        may_be_left: false,
    }
}

const RATE: [f64; 2] = [1.0e-3, 1.0e3];

/// Fields in the order in which they are looked at: how fast backward depends on how fast forward.
#[rustfmt::skip]
pub(super) const FIELDS: &[Field] = &[
    word(FOOTPRINT),
    field(RADIUS, Choice::First, [1.0e-3, 100.0]),
    field(V_MAX, Choice::Least, RATE),
    field(V_MIN, Choice::Most, [-1.0e3, 0.0]),
    field(W_MAX, Choice::Least, RATE),
    field(A_MAX, Choice::Least, RATE),
    field(BRAKE, Choice::Least, RATE),
    field(ALPHA, Choice::Least, RATE),
    field(RESOLUTION, Choice::First, [1.0e-3, 10.0]),
    field(INFLATION, Choice::First, [0.0, 65.535]),
    field(SCALING, Choice::First, [0.0, 1.0e3]),
    field(TOLERANCE, Choice::First, [1.0e-3, 1.0e3]),
    field(YAW_TOLERANCE, Choice::First, [1.0e-3, 1.0e3]),
    tuning("services.local_planner.config.dwa.horizon_s", [0.2, 10.0]),
    tuning("services.local_planner.config.dwa.speeds", [2.0, 64.0]),
    tuning("services.local_planner.config.dwa.yaw_rates", [3.0, 64.0]),
    tuning("services.local_planner.config.mppi.samples", [40.0, 20_000.0]),
    tuning("services.local_planner.config.mppi.steps", [14.0, 64.0]),
    tuning("services.local_planner.config.mppi.step_s", [0.02, 0.1]),
    tuning("services.local_planner.config.mppi.speed_std_mps", [0.001, 10.0]),
    tuning("services.local_planner.config.mppi.yaw_rate_std_radps", [0.001, 10.0]),
    word("services.global_planner.config.unknown"),
    word(SCAN), word(ODOM), word(CMD_VEL), word(STAMPED), word(ODOM_FRAME), word(BASE_FRAME), word(SIM_TIME),
];
