//! The contract as data: everything that a service in another language has to agree on.

use core::convert::Infallible;
use zeronav_msgs::fields::{Field, Shape};
use zeronav_msgs::labels::{ENUMS, label};
use zeronav_msgs::message::{self, Wire};
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{self, Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_msgs::user::UserEnvelope;
use zeronav_msgs::{
    description, foresight, grid, header, health, map, obstacles, rollouts, run, user, zones,
};

/// The contract.
pub(crate) struct Contract {
    /// Every message and part of one, parts before what they are part of.
    pub(crate) messages: Vec<Structure>,
    /// Every topic.
    pub(crate) topics: Vec<TopicLayout>,
    /// The codes of fields.
    pub(crate) codes: Vec<Codes>,
    /// Name and value of numbers.
    pub(crate) constants: Vec<(&'static str, f64)>,
}

/// A message, or a part of one.
pub(crate) struct Structure {
    /// Its name as a type of a program.
    pub(crate) name: String,
    /// Its name in every language.
    pub(crate) type_name: &'static str,
    /// Its description.
    pub(crate) doc: &'static str,
    /// Its size. [bytes]
    pub(crate) bytes: usize,
    /// Its schema hash.
    pub(crate) schema: u64,
    /// Its fields in order.
    pub(crate) fields: &'static [Field],
}

/// A topic and what its messages are made of.
pub(crate) struct TopicLayout {
    /// Its row.
    pub(crate) row: &'static TopicRow,
    /// Name of the type of header and fixed fields; `None` for records.
    pub(crate) envelope: Option<String>,
    /// An item of the slice.
    pub(crate) item: &'static Shape,
}

/// The codes of a field.
pub(crate) struct Codes {
    /// Their name in Rust.
    pub(crate) name: &'static str,
    /// Code and label of each.
    pub(crate) values: Vec<(u16, &'static str)>,
}

impl Contract {
    /// The contract of this build.
    pub(crate) fn new() -> Self {
        let mut collector = Collector::default();
        match visit_topics(&mut collector) {
            Ok(()) => {}
        }
        collector.add(UserEnvelope::SHAPE);
        Self {
            messages: collector.messages,
            topics: collector.topics,
            codes: codes(),
            constants: constants(),
        }
    }
}

/// The name of a type of a program: `Pose` for `zeronav.Pose.v1`, `RobotScanEnvelope` for header and
/// fixed fields of a topic, `zeronav.robot.scan.v1`.
pub(crate) fn name_of(type_name: &str) -> String {
    let parts: Vec<&str> = type_name.split('.').collect();
    let parts = &parts[1..parts.len() - 1];
    let is_type = parts.len() == 1 && parts[0].starts_with(char::is_uppercase);
    let words = parts.iter().flat_map(|part| part.split('_'));
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    let name: String = words.map(capital).collect();
    if is_type { name } else { name + "Envelope" }
}

#[derive(Default)]
struct Collector {
    messages: Vec<Structure>,
    topics: Vec<TopicLayout>,
}

impl Collector {
    /// Adds what `shape` is made of, its parts first; its name when it is a message.
    fn add(&mut self, shape: &'static Shape) -> Option<String> {
        match shape {
            Shape::Number(_) => None,
            Shape::Array { of, .. } => self.add(of),
            Shape::Message {
                name: type_name,
                doc,
                fields,
                bytes,
                schema,
            } => {
                for field in *fields {
                    self.add(field.shape);
                }
                let name = name_of(type_name);
                if !self.messages.iter().any(|other| other.name == name) {
                    self.messages.push(Structure {
                        name: name.clone(),
                        type_name,
                        doc,
                        bytes: *bytes,
                        schema: *schema,
                        fields,
                    });
                }
                Some(name)
            }
        }
    }
}

impl TopicVisitor for Collector {
    type Error = Infallible;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Infallible> {
        let envelope = self.add(T::Envelope::SHAPE);
        let item = T::Item::SHAPE;
        self.add(item);
        self.topics.push(TopicLayout {
            row,
            envelope,
            item,
        });
        Ok(())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), Infallible> {
        let item = Span::SHAPE;
        self.add(item);
        self.topics.push(TopicLayout {
            row,
            envelope: None,
            item,
        });
        Ok(())
    }
}

/// Highest code of an enum.
const CODE_MAX: u16 = 255;

fn codes() -> Vec<Codes> {
    let of = |name: &&'static str| Codes {
        name,
        values: (0..=CODE_MAX)
            .filter_map(|code| Some((code, label(name, code)?)))
            .collect(),
    };
    ENUMS.iter().map(of).collect()
}

#[allow(
    clippy::cast_precision_loss,
    clippy::cast_lossless,
    reason = "numbers below 2^53"
)]
fn constants() -> Vec<(&'static str, f64)> {
    macro_rules! constants {
        ($($module:ident::{$($name:ident),* $(,)?}),* $(,)?) => {
            vec![$($((stringify!($name), $module::$name as f64)),*),*]
        };
    }
    constants![
        header::{SHADOW_EPOCH_MIN},
        message::{COORDINATE_M_MAX, SPEED_MAX},
        run::{CLOCK_OFFSET_MS_MAX, DELAY_STEP_NS, DELAY_US_MAX, SHARE_ALL},
        foresight::{FORESIGHT_PERCEIVE, FORESIGHT_PREDICT},
        topics::{EVENT_MAX, EVENT_NEED_KEYFRAME, NODES_MAX, READERS_MAX, WRITERS_MAX},
        grid::{SIDE_CELLS_MAX},
        map::{
            TILE_CELLS, COST_FREE, COST_CIRCUMSCRIBED_MAX, COST_INSCRIBED, COST_LETHAL,
            COST_UNKNOWN, FLAG_STATIC, FLAG_SENSED, FLAG_VIRTUAL, FLAG_REGULARISED, FLAG_UNKNOWN,
            FLAG_KEEPOUT,
        },
        user::{
            FORM_BYTES_MAX, USER_BORROWED, USER_BUFFER, USER_BYTES_MAX, USER_NAME_BYTES_MAX, USER_POOL,
        },
        description::{ACTUATION_DELAY_NS_MAX},
        zones::{
            ZONES_MAX, ZONE_CORNERS_MAX, ZONE_COST_MAX, ZONE_NAME_BYTES, ZONE_PARTS_MAX, ZONE_PERCENT_MIN,
            ZONE_SPEED_MPS_MIN,
        },
        obstacles::{OBSTACLE_RADIUS_M_MAX},
        rollouts::{ROLLOUT_COST_MAX, ROLLOUT_POINTS_MAX},
        health::{
            REASON_SCAN, REASON_ODOMETRY, REASON_MAP, REASON_PATH, REASON_REQUEST,
            REASON_REFUSED, REASON_NO_LOAN, REASON_TOO_LONG, REASON_ZONES,
        },
    ]
}
