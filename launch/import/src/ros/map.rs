//! The map of a bag: the one that its robot knew.

use crate::log::{LogMap, Report};
use std::collections::BTreeMap;
use zeronav_msgs::grid::{RESOLUTION_M, SIDE_CELLS_MAX};
use zeronav_msgs::message::COORDINATE_M_MAX;
use zeronav_ros_messages::messages::OccupancyGrid;
use zeronav_ros_messages::received::{decoded, plain_frame, planar_pose};

/// Its type.
pub(super) const MAP: &str = "nav_msgs/msg/OccupancyGrid";

/// Most topics beside the one that is meant of which a map is held.
const HELD_MAX: usize = 3;

/// The topic on which a `map_server`, and a node that maps, publish.
const USUAL: &str = "/map";

/// The newest map of each topic, and how many there were.
#[derive(Default)]
pub(super) struct Maps(BTreeMap<String, (LogMap, u64)>);

impl Maps {
    /// Takes in a message on `topic`; `None` when it is no map. Of others than the topic `named`, if there is one, no
    /// map is held.
    pub(super) fn take(&mut self, (topic, named): (&str, Option<&str>), data: &[u8]) -> Option<()> {
        let map = read(data)?;
        let is_meant = topic == named.unwrap_or(USUAL);
        if let Some((held, n)) = self.0.get_mut(topic) {
            (*held, *n) = (map, *n + 1);
        } else if is_meant || (named.is_none() && self.0.len() < HELD_MAX) {
            self.0.insert(topic.to_owned(), (map, 1));
        }
        Some(())
    }

    /// The map on the topic `named`, on the only one, or on the usual one; what is missing and assumed goes into `report`.
    ///
    /// # Errors
    /// When there is none on the topic that was named.
    pub(super) fn chosen(
        mut self,
        named: Option<&str>,
        report: &mut Report,
    ) -> Result<Option<LogMap>, String> {
        let names: Vec<String> = self.0.keys().cloned().collect();
        let topic = match (named, &names[..]) {
            (Some(named), _) if !self.0.contains_key(named) => {
                return Err(format!("no {MAP} that can be read is on {named}"));
            }
            (Some(named), _) => named.to_owned(),
            (None, []) => {
                report.missing.push("no map".to_owned());
                return Ok(None);
            }
            (None, [only]) => only.clone(),
            (None, several) if several.iter().any(|it| it == USUAL) => USUAL.to_owned(),
            (None, several) => {
                let several = several.join(", ");
                let missing = &mut report.missing;
                missing.push(format!(
                    "which map is meant: name it with --map ({several})"
                ));
                return Ok(None);
            }
        };
        let Some((map, n)) = self.0.remove(&topic) else {
            return Ok(None);
        };
        if n > 1 {
            report.assumed.push(format!(
                "the map that is known from the beginning is the last of {n} on {topic}"
            ));
        }
        if map.frame != "map" {
            let frame = &map.frame;
            let assumed = &mut report.assumed;
            assumed.push(format!(
                "the frame of the map ({frame}) is what others call map"
            ));
        }
        Ok(Some(map))
    }
}

/// A map whose numbers can be those of one.
fn read(data: &[u8]) -> Option<LogMap> {
    let it: OccupancyGrid = decoded(data)?;
    let info = it.info;
    let corner = planar_pose(&info.origin.position, &info.origin.orientation)?;
    let resolution_m = shortest(info.resolution);
    let [least_m, most_m] = RESOLUTION_M;
    let sides = 1..=SIDE_CELLS_MAX;
    let n_cells = u64::from(info.width) * u64::from(info.height);
    let is_sound = (least_m..=most_m).contains(&resolution_m)
        && sides.contains(&info.width)
        && sides.contains(&info.height)
        && n_cells == it.data.len() as u64
        && [corner.x_m, corner.y_m]
            .iter()
            .all(|at| at.abs() <= COORDINATE_M_MAX);
    is_sound.then(|| LogMap {
        frame: plain_frame(&it.header.frame_id).to_owned(),
        corner,
        resolution_m,
        size: (info.width, info.height),
        cells: it.data,
    })
}

/// The number that was meant: 0.05 is no number of 32 bits, and far from the origin the error adds up.
fn shortest(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::NAN)
}
