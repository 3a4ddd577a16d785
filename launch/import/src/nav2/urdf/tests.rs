use super::*;

const ROBOT: &str = r#"<?xml version="1.0"?>
<robot name="cart">
  <link name="base_footprint"/>
  <link name="base_link">
    <collision>
      <origin xyz="-0.1 0 0.1" rpy="0 0 0"/>
      <geometry><box size="0.6 0.4 0.2"/></geometry>
    </collision>
  </link>
  <joint name="base" type="fixed">
    <parent link="base_footprint"/><child link="base_link"/>
    <origin xyz="0 0 0.05"/>
  </joint>
  <link name="mast"/>
  <joint name="mast" type="fixed">
    <parent link="base_link"/><child link="mast"/>
    <origin xyz="0.1 0 0.2" rpy="0 0 1.5707963267948966"/>
  </joint>
  <link name="laser_frame"/>
  <joint name="laser" type="fixed">
    <parent link="mast"/><child link="laser_frame"/>
    <origin xyz="0.05 0 0.1" rpy="0 0 1.5707963267948966"/>
  </joint>
  <link name="wheel"/>
  <joint name="wheel" type="continuous">
    <parent link="base_link"/><child link="wheel"/>
  </joint>
  <transmission name="t"><joint name="wheel"/></transmission>
</robot>"#;

#[test]
fn a_chain_of_fixed_joints_gives_the_mount_and_the_box_the_outline() {
    let urdf = read(ROBOT).expect("a robot");
    for base in ["base_link", "base_footprint"] {
        let mount = urdf.mount(base).expect("a mount");
        assert_eq!(mount.link, "laser_frame");
        assert_eq!(format!("{:?}", mount.pose), "[0.1, 0.05, 3.1416]");
        assert!(!mount.is_inverted);
        let (outline, link) = urdf.outline(base).expect("an outline");
        assert_eq!(link, "base_link");
        let corners = vec![[-0.4, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.4, 0.2]];
        assert_eq!(outline, Outline::Polygon(corners));
    }
}

#[test]
fn a_joint_that_moves_a_tilt_and_a_turn_upside_down_are_told() {
    let loose = ROBOT.replace("\"laser\" type=\"fixed\"", "\"laser\" type=\"revolute\"");
    let why = read(&loose)
        .expect("a robot")
        .mount("base_link")
        .expect_err("it moves");
    assert!(why.contains("no chain of fixed joints"), "{why}");
    let at = r#"xyz="0.05 0 0.1" rpy="0 0 1.5707963267948966""#;
    let tilted = ROBOT.replace(at, r#"rpy="0 0.3 0""#);
    let why = read(&tilted)
        .expect("a robot")
        .mount("base_link")
        .expect_err("tilted");
    assert!(why.contains("tilted"), "{why}");
    let inverted = ROBOT.replace(at, r#"rpy="3.141592653589793 0 0""#);
    let mount = read(&inverted)
        .expect("a robot")
        .mount("base_link")
        .expect("a mount");
    assert!(
        mount.is_inverted && format!("{:.4}", mount.pose[2]) == "1.5708",
        "{mount:?}"
    );
}

#[test]
fn a_cylinder_in_the_middle_is_a_disc_and_one_beside_it_a_polygon_around_it() {
    let round = ROBOT.replace(
        r#"<box size="0.6 0.4 0.2"/>"#,
        r#"<cylinder radius="0.3" length="0.2"/>"#,
    );
    let (outline, _) = read(&round)
        .expect("a robot")
        .outline("base_link")
        .expect("it");
    let Outline::Polygon(corners) = outline else {
        panic!("{outline:?}");
    };
    assert!(outline::inscribed_m(&corners) > 0.2 - 1e-3, "{corners:?}");
    assert_eq!(corners.len(), 16);
    let middle = round.replace("-0.1 0 0.1", "0 0 0.1");
    let (outline, _) = read(&middle)
        .expect("a robot")
        .outline("base_link")
        .expect("it");
    assert_eq!(outline, Outline::Disc(0.3));
    let mesh = ROBOT.replace(
        r#"<box size="0.6 0.4 0.2"/>"#,
        r#"<mesh filename="a.stl"/>"#,
    );
    let why = read(&mesh)
        .expect("a robot")
        .outline("base_link")
        .expect_err("a mesh");
    assert!(why.contains("mesh"), "{why}");
}

#[test]
fn what_is_no_urdf_is_rejected_with_its_line() {
    for (text, line, word) in [
        ("robot: 1\n", 1, "not XML"),
        ("<robot>\n<link>\n</joint>", 3, "not XML"),
        ("<sdf/>", 1, "no URDF"),
        ("<robot/>", 1, "no link"),
        ("<robot>\n<link/>\n</robot>", 2, "no name"),
        (
            "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:include filename=\"a\"/></robot>",
            2,
            "`xacro FILE",
        ),
        (
            "<robot>\n<link name=\"a\"><collision><geometry><sphere radius=\"-1\"/></geometry></collision></link></robot>",
            2,
            "above 0",
        ),
        (
            "<robot>\n<joint name=\"j\"><parent link=\"a\"/><child link=\"b\"/><origin xyz=\"0 nan 0\"/></joint></robot>",
            2,
            "3 numbers",
        ),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><robot/>", 1, "not XML"),
    ] {
        let (at, why) = read(text).expect_err(text);
        assert_eq!(at, Some(line), "{text}: {why}");
        assert!(why.contains(word), "{text}: {why}");
    }
}

#[test]
fn deep_elements_and_circles_of_joints_end() {
    let deep = format!("<robot>{}", "<a>".repeat(150_000));
    read(&deep).expect_err("never closed");
    let deep = format!(
        "<robot>{}{}</robot>",
        "<a>".repeat(50_000),
        "</a>".repeat(50_000)
    );
    read(&deep).expect_err("no link");
    let circle = ROBOT.replace(
        "<link name=\"wheel\"/>",
        "<joint name=\"c\" type=\"fixed\"><parent link=\"laser_frame\"/><child link=\"base_footprint\"/></joint>",
    );
    let urdf = read(&circle).expect("a robot");
    assert!(urdf.mount("base_link").is_ok());
}
