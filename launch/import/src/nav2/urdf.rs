//! The part of a URDF that a scenario wants: where the lidar is mounted, and the outline of the base.

use super::outline;
use core::f64::consts::{PI, TAU};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::BTreeMap;

/// Most elements, texts and comments of a file.
const NODES_MAX: u32 = 200_000;

/// Corners that stand for a cylinder which is not in the middle.
const ROUND_CORNERS: u32 = 16;

/// Tilt from which a lidar does not look around horizontally. [rad]
const TILT_RAD_MAX: f64 = 0.1;

/// A rigid motion: the columns of a rotation, and a translation. [m]
#[derive(Debug, Clone, Copy, PartialEq)]
struct Motion {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

/// A shape of a collision element.
#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// Full sides. [m]
    Box([f64; 3]),
    /// Radius and length along z. [m]
    Cylinder([f64; 2]),
    /// Radius. [m]
    Sphere(f64),
    /// A mesh, which is not read.
    Mesh,
}

/// A joint that never moves, or one that does.
#[derive(Debug, Clone)]
struct Joint {
    parent: String,
    is_fixed: bool,
    parent_from_child: Motion,
}

/// A robot of a URDF.
#[derive(Debug, Clone, Default)]
pub(super) struct Urdf {
    /// Collision shapes of each link.
    links: BTreeMap<String, Vec<(Motion, Shape)>>,
    /// The joint above each link.
    joints: BTreeMap<String, Joint>,
}

/// Where the lidar is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mount {
    /// Its link.
    pub(super) link: String,
    /// `base_from_laser` as `[x, y, yaw]`. [m, m, rad]
    pub(super) pose: [f64; 3],
    /// True when it is mounted upside down.
    pub(super) is_inverted: bool,
}

/// The outline of a link.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Outline {
    /// Radius of a disc. [m]
    Disc(f64),
    /// Corners of a convex polygon, counter-clockwise. [m]
    Polygon(Vec<[f64; 2]>),
}

/// The robot of a text.
///
/// # Errors
/// Line, if there is one, and what is wrong.
pub(super) fn read(text: &str) -> Result<Urdf, (Option<u32>, String)> {
    let options = ParsingOptions {
        nodes_limit: NODES_MAX,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| (Some(error.pos().row), format!("is not XML: {error}")))?;
    let row = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row;
    let root = document.root_element();
    let is_xacro = |node: Node<'_, '_>| {
        let space = node.tag_name().namespace();
        space.is_some_and(|it| it.contains("xacro"))
    };
    if let Some(node) = document.descendants().find(|it| is_xacro(*it)) {
        let why = "is a xacro file: write it out first with `xacro FILE > robot.urdf`";
        return Err((Some(row(node)), why.to_owned()));
    }
    if root.tag_name().name() != "robot" {
        let why = format!(
            "begins with <{}>, not with <robot>: it is no URDF",
            root.tag_name().name()
        );
        return Err((Some(row(root)), why));
    }
    let mut urdf = Urdf::default();
    for node in root.children().filter(Node::is_element) {
        let read = match node.tag_name().name() {
            "link" => urdf.take_link(node),
            "joint" => urdf.take_joint(node),
            _ => Ok(()),
        };
        read.map_err(|why| (Some(row(node)), why))?;
    }
    if urdf.links.is_empty() {
        return Err((Some(row(root)), "has no link".to_owned()));
    }
    Ok(urdf)
}

impl Urdf {
    fn take_link(&mut self, node: Node<'_, '_>) -> Result<(), String> {
        let name = attribute(node, "name")?;
        let mut shapes = Vec::new();
        for collision in elements(node, "collision") {
            let at = |why: String| format!("link {name}: {why}");
            let motion = origin(collision).map_err(at)?;
            let geometry = elements(collision, "geometry").next();
            let form = geometry.and_then(|it| it.children().find(Node::is_element));
            let Some(form) = form else { continue };
            let shape = shape(form).map_err(at)?;
            shapes.push((motion, shape));
        }
        self.links.insert(name.to_owned(), shapes);
        Ok(())
    }

    fn take_joint(&mut self, node: Node<'_, '_>) -> Result<(), String> {
        let name = attribute(node, "name")?;
        let at = |why: String| format!("joint {name}: {why}");
        // A transmission has joints without parents.
        let end = |which| elements(node, which).next();
        let (Some(parent), Some(child)) = (end("parent"), end("child")) else {
            return Ok(());
        };
        let joint = Joint {
            parent: attribute(parent, "link").map_err(at)?.to_owned(),
            is_fixed: node.attribute("type") == Some("fixed"),
            parent_from_child: origin(node).map_err(at)?,
        };
        let child = attribute(child, "link").map_err(at)?;
        self.joints.insert(child.to_owned(), joint);
        Ok(())
    }

    /// True when there is a link of this name.
    pub(super) fn has(&self, link: &str) -> bool {
        self.links.contains_key(link)
    }

    /// `from` up to the link that no joint holds; with the link and how it lies in it, as long as joints are fixed.
    fn above(&self, from: &str) -> Vec<(String, Motion)> {
        let (mut link, mut motion) = (from.to_owned(), Motion::NONE);
        let mut chain = vec![(link.clone(), motion)];
        // A circle of joints ends, too.
        while let Some(joint) = self.joints.get(&link).filter(|it| it.is_fixed)
            && chain.len() <= self.joints.len()
        {
            motion = joint.parent_from_child.then(&motion);
            link.clone_from(&joint.parent);
            chain.push((link.clone(), motion));
        }
        chain
    }

    /// How `link` lies in `base` when fixed joints alone are between them, above either.
    fn base_from(&self, base: &str, link: &str) -> Option<Motion> {
        let above_base = self.above(base);
        let mut above_link = self.above(link).into_iter();
        above_link.find_map(|(common, common_from_link)| {
            let (_, common_from_base) = above_base.iter().find(|(it, _)| *it == common)?;
            Some(common_from_base.inverse().then(&common_from_link))
        })
    }

    /// Where the lidar is in `base`.
    ///
    /// # Errors
    /// Why that cannot be told.
    pub(super) fn mount(&self, base: &str) -> Result<Mount, String> {
        let lidar = |name: &&String| {
            let name = name.to_lowercase();
            let words = ["laser", "lidar", "scan", "hokuyo", "sick", "velodyne"];
            words.iter().any(|it| name.contains(it))
        };
        let candidates: Vec<&String> = self.links.keys().filter(lidar).collect();
        if candidates.is_empty() {
            let why = "no link has `laser`, `lidar` or `scan` in its name";
            return Err(why.to_owned());
        }
        let mut placed = candidates
            .iter()
            .filter_map(|link| Some((*link, self.base_from(base, link)?)));
        let found = placed.next();
        let Some((link, base_from_laser)) = found else {
            let why = format!(
                "no chain of fixed joints leads from {base} to {}",
                candidates[0]
            );
            return Err(why);
        };
        let [x_axis, _, z_axis] = base_from_laser.rotation;
        if z_axis[2].abs() < TILT_RAD_MAX.cos() {
            return Err(format!("{link} is tilted: its scans are not horizontal"));
        }
        let [x, y, _] = base_from_laser.translation;
        if x.abs().max(y.abs()) > 100.0 {
            return Err(format!("{link} is more than 100 m away from {base}"));
        }
        Ok(Mount {
            link: link.clone(),
            pose: [x, y, f64::atan2(x_axis[1], x_axis[0])].map(rounded),
            is_inverted: z_axis[2] < 0.0,
        })
    }

    /// The outline of the collision geometry of `base`, and the link that has it: `base`, or one that is fixed to it
    /// and called `base_link` or `base_footprint`.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn outline(&self, base: &str) -> Result<(Outline, String), String> {
        let solid = |link: &&str| self.links.get(*link).is_some_and(|it| !it.is_empty());
        let near = [
            base,
            "base_link",
            "base_footprint",
            "chassis",
            "chassis_link",
        ];
        let link = near.iter().copied().filter(solid);
        let mut placed = link.filter_map(|link| Some((link, self.base_from(base, link)?)));
        let Some((link, base_from_link)) = placed.next() else {
            return Err(format!("no collision geometry is on {base}"));
        };
        let shapes = self.links.get(link).map_or(&[][..], Vec::as_slice);
        let mut points = Vec::new();
        for (link_from_shape, shape) in shapes {
            let motion = base_from_link.then(link_from_shape);
            if let (Shape::Cylinder([radius_m, _]) | Shape::Sphere(radius_m), 1) =
                (shape, shapes.len())
                && motion.is_upright_in_the_middle()
            {
                return Ok((Outline::Disc(*radius_m), link.to_owned()));
            }
            points.extend(corners(&motion, shape).ok_or_else(|| {
                format!("the collision geometry of {link} is a mesh, which is not read")
            })?);
        }
        let (hull, _) = outline::upright(&outline::hull(&points))
            .map_err(|why| format!("the collision geometry of {link} {why}"))?;
        let hull = hull.into_iter().map(|it| it.map(rounded));
        Ok((Outline::Polygon(hull.collect()), link.to_owned()))
    }
}

/// The corners of a shape, seen from above; `None` of a mesh. [m]
fn corners(motion: &Motion, shape: &Shape) -> Option<Vec<[f64; 2]>> {
    let signs = [-0.5, 0.5];
    let round = |radius_m: f64, half_m: f64| {
        // Around the circle, so that nothing is left out.
        let radius_m = radius_m / (PI / f64::from(ROUND_CORNERS)).cos();
        let turn = |n: u32| TAU * (f64::from(n) + 0.5) / f64::from(ROUND_CORNERS);
        let ring = (0..ROUND_CORNERS).map(turn).map(f64::sin_cos);
        let ring = ring.map(move |(sin, cos)| [radius_m * cos, radius_m * sin]);
        ring.flat_map(move |[x, y]| [[x, y, -half_m], [x, y, half_m]])
    };
    let points: Vec<[f64; 3]> = match shape {
        Shape::Box([x, y, z]) => signs
            .iter()
            .flat_map(|a| signs.iter().map(move |b| (a, b)))
            .flat_map(|(a, b)| signs.iter().map(move |c| [a * x, b * y, c * z]))
            .collect(),
        Shape::Cylinder([radius_m, length_m]) => round(*radius_m, 0.5 * length_m).collect(),
        Shape::Sphere(radius_m) => {
            let flat = Motion {
                rotation: Motion::NONE.rotation,
                ..*motion
            };
            return Some(seen(&flat, &round(*radius_m, 0.0).collect::<Vec<_>>()));
        }
        Shape::Mesh => return None,
    };
    Some(seen(motion, &points))
}

/// Points from above.
fn seen(motion: &Motion, points: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let points = points.iter().map(|it| motion.of(*it));
    points.map(|[x, y, _]| [x, y]).collect()
}

impl Motion {
    const NONE: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// Fixed-axis roll, pitch, yaw, as in URDF. [rad]
    fn new(translation: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Self {
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
        Self {
            rotation: [
                [cy * cp, sy * cp, -sp],
                [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
                [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
            ],
            translation,
        }
    }

    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.rotation;
        core::array::from_fn(|row| a[row] * x + b[row] * y + c[row] * z)
    }

    fn of(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(point);
        core::array::from_fn(|row| turned[row] + self.translation[row])
    }

    /// This motion after `first`.
    fn then(&self, first: &Self) -> Self {
        Self {
            rotation: first.rotation.map(|column| self.turned(column)),
            translation: self.of(first.translation),
        }
    }

    fn inverse(&self) -> Self {
        let back = Self {
            rotation: core::array::from_fn(|column| self.rotation.map(|axis| axis[column])),
            translation: [0.0; 3],
        };
        Self {
            translation: back.turned(self.translation).map(|it| -it),
            ..back
        }
    }

    /// True when z stays z and the origin stays on it.
    fn is_upright_in_the_middle(&self) -> bool {
        let [x, y, _] = self.translation;
        x.hypot(y) < 1.0e-3 && self.rotation[2][2].abs() > 1.0 - 1.0e-6
    }
}

/// To a tenth of a millimetre, or of a milliradian: a URDF knows no more.
fn rounded(value: f64) -> f64 {
    // Without the minus of a zero.
    (value * 1.0e4).round() / 1.0e4 + 0.0
}

fn elements<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    let children = node.children().filter(Node::is_element);
    children.filter(move |it| it.tag_name().name() == name)
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, String> {
    let missing = || format!("<{}> has no {name}", node.tag_name().name());
    node.attribute(name).ok_or_else(missing)
}

/// The `origin` of a joint or a collision element.
fn origin(node: Node<'_, '_>) -> Result<Motion, String> {
    let Some(origin) = elements(node, "origin").next() else {
        return Ok(Motion::NONE);
    };
    let of = |name| {
        origin
            .attribute(name)
            .map_or(Ok([0.0; 3]), |it| numbers(name, it))
    };
    Ok(Motion::new(of("xyz")?, of("rpy")?))
}

fn shape(form: Node<'_, '_>) -> Result<Shape, String> {
    let one = |name| {
        let [value] = numbers(name, attribute(form, name)?)?;
        positive(name, value)
    };
    match form.tag_name().name() {
        "box" => {
            let sides = numbers("size", attribute(form, "size")?)?;
            for side in sides {
                positive("size", side)?;
            }
            Ok(Shape::Box(sides))
        }
        "cylinder" => Ok(Shape::Cylinder([one("radius")?, one("length")?])),
        "sphere" => Ok(Shape::Sphere(one("radius")?)),
        _ => Ok(Shape::Mesh),
    }
}

fn positive(name: &str, value: f64) -> Result<f64, String> {
    if value > 0.0 {
        Ok(value)
    } else {
        Err(format!("{name} must be above 0, not {value}"))
    }
}

fn numbers<const N: usize>(name: &str, text: &str) -> Result<[f64; N], String> {
    let read: Vec<f64> = text
        .split_whitespace()
        .map_while(|it| it.parse().ok())
        .filter(|it: &f64| it.is_finite() && it.abs() < 1.0e6)
        .collect();
    if text.split_whitespace().count() != N {
        return Err(format!("{name} must be {N} numbers, not {text:?}"));
    }
    read.try_into()
        .map_err(|_| format!("{name} must be {N} numbers below a million, not {text:?}"))
}

#[cfg(test)]
mod tests;
