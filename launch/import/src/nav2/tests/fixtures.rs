//! Parameter files of our own, laid out as those of Nav2 are.

/// A robot with a dynamic window, as the files of Humble are laid out.
pub(super) const DWB: &str = r#"
amcl:
  ros__parameters:
    base_frame_id: "base_footprint"
    odom_frame_id: "odom"
    scan_topic: scan
    set_initial_pose: true
    initial_pose: {x: 1.0, y: -2.0, z: 0.0, yaw: 0.5}
controller_server:
  ros__parameters:
    use_sim_time: True
    controller_frequency: 20.0
    progress_checker_plugin: "progress_checker"
    goal_checker_plugins: ["stopped_goal_checker"]
    controller_plugins: ["FollowPath"]
    stopped_goal_checker:
      plugin: "nav2_controller::StoppedGoalChecker"
      xy_goal_tolerance: 0.2
      yaw_goal_tolerance: 0.3
    FollowPath:
      plugin: "dwb_core::DWBLocalPlanner"
      min_vel_x: -0.1
      max_vel_x: 0.26
      max_vel_y: 0.0
      max_vel_theta: 1.0
      acc_lim_x: 2.5
      acc_lim_theta: 3.2
      decel_lim_x: -2.0
      vx_samples: 20
      vtheta_samples: 80
      sim_time: 1.7
      BaseObstacle.scale: 0.02
local_costmap:
  local_costmap:
    ros__parameters:
      global_frame: odom
      robot_base_frame: base_link
      resolution: 0.05
      footprint: "[[0.3, -0.2], [-0.1, -0.2], [-0.1, 0.2], [0.3, 0.2]]"
      plugins: ["voxel_layer", "inflation_layer"]
      inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.4}
      voxel_layer:
        plugin: "nav2_costmap_2d::VoxelLayer"
        observation_sources: scan camera
        scan: {topic: /front/scan, data_type: "LaserScan"}
        camera: {topic: /points, data_type: "PointCloud2"}
global_costmap:
  global_costmap:
    ros__parameters:
      resolution: 0.1
      robot_radius: 0.22
      plugins: ["static_layer", "inflation_layer"]
      inflation_layer:
        plugin: "nav2_costmap_2d::InflationLayer"
        cost_scaling_factor: 3.0
        inflation_radius: 0.55
planner_server:
  ros__parameters:
    planner_plugins: ["GridBased"]
    GridBased:
      plugin: "nav2_navfn_planner/NavfnPlanner"
      allow_unknown: false
map_server:
  ros__parameters:
    yaml_filename: "nowhere.yaml"
velocity_smoother:
  ros__parameters:
    max_velocity: [0.24, 0.0, 1.5]
    min_velocity: [-0.26, 0.0, -1.0]
    max_accel: [1.5, 0.0, 3.0]
    max_decel: [-2.5, 0.0, -3.2]
my_node:
  ros__parameters: {a: 1, b: 2, c: 3, d: 4}
"#;

/// One with MPPI, as the files of Kilted are.
pub(super) const MPPI: &str = r#"
bt_navigator:
  ros__parameters:
    robot_base_frame: base_link
    odom_topic: odom
    error_code_name_prefixes: [backup]
controller_server:
  ros__parameters:
    controller_plugins: ["Drive"]
    Drive:
      plugin: "nav2_mppi_controller::MPPIController"
      time_steps: 80
      batch_size: 1000
      vx_max: 0.6
      wz_max: 1.9
      motion_model: "Omni"
local_costmap:
  local_costmap:
    ros__parameters:
      robot_radius: 0.22
      footprint: "[]"
      filters: ["keepout_filter"]
      keepout_filter: {plugin: "nav2_costmap_2d::KeepoutFilter", enabled: KEEPOUT_ZONE_ENABLED}
planner_server:
  ros__parameters:
    planner_plugins: ["GridBased", "Other"]
    GridBased: {plugin: "nav2_smac_planner::SmacPlannerHybrid"}
collision_monitor:
  ros__parameters:
    cmd_vel_out_topic: "cmd_vel"
    base_frame_id: "base_footprint"
    observation_sources: ["scan"]
    scan: {type: "scan", topic: "scan"}
"#;

/// One with pure pursuit below a shim, in a namespace, with wildcards.
pub(super) const RPP: &str = r#"
/**:
  ros__parameters:
    use_sim_time: true
    enable_stamped_cmd_vel: true
/robot1/controller_server:
  ros__parameters:
    FollowPath:
      plugin: "nav2_rotation_shim_controller::RotationShimController"
      primary_controller: "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
      desired_linear_vel: 0.7
      allow_reversing: true
      rotate_to_heading_angular_vel: $(var turn)
robot1:
  global_costmap:
    global_costmap:
      ros__parameters:
        robot_radius: 0.4
        plugins: ["obstacle_layer"]
        obstacle_layer:
          plugin: "nav2_costmap_2d::ObstacleLayer"
          observation_sources: base_scan
          base_scan: {topic: scan}
"#;

pub(super) const URDF: &str = r#"<robot name="cart"><link name="base_link"><collision>
  <geometry><cylinder radius="0.25" length="0.2"/></geometry></collision></link>
  <link name="laser"/><joint name="j" type="fixed"><parent link="base_link"/><child link="laser"/>
  <origin xyz="0.1 0 0.2" rpy="0 0 0"/></joint></robot>"#;
