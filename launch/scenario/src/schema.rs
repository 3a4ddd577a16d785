//! The JSON schema of a scenario's document, for editors. Ranges of parameters come from where they are
//! declared; what only the whole scenario can tell (a start inside a wall) is left to
//! [`Scenario::validate`](super::Scenario::validate). A document may build on others: nothing is required at its top.

#[cfg(test)]
mod tests;

use super::{
    CLOCK_MS, COORDINATE_M_MAX, DELAY_MS, FAULTS_MAX, KEEP_S_MIN, KINDS, RunSpec, SHARE, SLOW_MS,
    TIME_LIMIT_S_MAX, TOLERANCE, YAW_RAD_MAX, faultable,
};
use crate::restart::RestartSpec;
use crate::scheduling::SchedulingSpec;
use crate::{companions, hosts, zones};
use serde_json::{Map, Value, json};
use zeronav_msgs::Role;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::grid::RESOLUTION_M;
use zeronav_msgs::truth::TRUTH_OBSTACLES_MAX;
use zeronav_params::{Parameter, Type, describe};
use zeronav_robot_description::RobotSpec;
use zeronav_world::shape::{SHAPE_SIZE_M_MIN, SHAPE_YAW_RAD_MAX};
use zeronav_world::spec::PERSON_RADIUS_M;
use zeronav_world::track::ROWS_MAX;
use zeronav_world::world::{LASTS_S_MIN, NEAR_M, SPEED_MPS_MAX, TIME_S_MAX};

/// The schema; `services` are the parameters of the stock services.
#[must_use]
pub fn schema(services: &[(Role, Vec<Parameter>)]) -> Value {
    let seats = services.iter().map(|(role, parameters)| {
        // The robot's configuration is the rest of the scenario.
        let config = match role {
            Role::Robot => json!({ "type": "object" }),
            _ => object(parameters),
        };
        (role.label().to_owned(), seat(&config))
    });
    let fields = fields([
        (
            "base",
            json!({ "type": ["string", "array"], "items": { "type": "string" } }),
        ),
        ("variant", text()),
        (
            "variants",
            json!({ "type": "object", "additionalProperties": { "$ref": "#" } }),
        ),
        ("group", text()),
        ("title", text()),
        ("description", text()),
        ("run", object(&describe::<RunSpec>())),
        ("world", world()),
        ("robot", robot()),
        ("start", pose()),
        ("goals", list(&goal())),
        ("zones", zones::schema()),
        ("services", closed(seats.collect(), &[])),
        ("static_map", json!({ "type": "boolean" })),
        ("restart", object(&describe::<RestartSpec>())),
        ("faults", at_most(FAULTS_MAX, &stack_fault())),
        ("random_faults", random_faults()),
        ("swaps", list(&swap())),
        ("companions", companions::schema()),
        ("hosts", hosts::schema()),
        ("expect", expect()),
        ("foresight", foresight()),
        ("trials", trials()),
    ]);
    let mut schema = closed(fields, &[]);
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = "A scenario of zeronav".into();
    schema
}

/// The table that holds `parameters`, with their groups as tables in it.
fn object(parameters: &[Parameter]) -> Value {
    let mut root = closed(Map::new(), &[]);
    for parameter in parameters {
        let (groups, name) = match parameter.path.rsplit_once('.') {
            Some((groups, name)) => (groups.split('.').collect(), name),
            None => (Vec::new(), parameter.path.as_str()),
        };
        let table = groups.into_iter().fold(&mut root, |table, group| {
            let inner = &mut table["properties"][group];
            if inner.is_null() {
                *inner = closed(Map::new(), &[]);
            }
            inner
        });
        table["properties"][name] = leaf(parameter);
    }
    root
}

/// The value of a parameter.
fn leaf(parameter: &Parameter) -> Value {
    let mut schema = Map::new();
    let mut number = numbers(parameter.min, parameter.max);
    let unit = if parameter.unit.is_empty() {
        String::new()
    } else {
        format!(" [{}]", parameter.unit)
    };
    schema.insert(
        "description".to_owned(),
        format!("{}{unit}", parameter.description).into(),
    );
    schema.insert("type".to_owned(), parameter.kind.to_string().into());
    match parameter.kind {
        Type::Number | Type::Integer => schema.append(&mut number),
        Type::String if !parameter.choices.is_empty() => {
            let keys = parameter.choices.iter().map(|choice| choice.key.as_str());
            schema.insert("enum".to_owned(), keys.collect());
        }
        Type::String | Type::Boolean | Type::Array => {}
    }
    match json!(parameter.value) {
        Value::Null => {}
        default => {
            schema.insert("default".to_owned(), default);
        }
    }
    Value::Object(schema)
}

/// The bounds of a number. The smallest positive one means everything above 0.
fn numbers(min: Option<f64>, max: Option<f64>) -> Map<String, Value> {
    let least = match min {
        Some(f64::MIN_POSITIVE) => Some(("exclusiveMinimum", 0.0)),
        min => min.map(|min| ("minimum", min)),
    };
    let bounds = least.into_iter().chain(max.map(|max| ("maximum", max)));
    bounds
        .map(|(name, bound)| (name.to_owned(), bound.into()))
        .collect()
}

/// A table with these fields and no others.
fn closed(fields: Map<String, Value>, required: &[&str]) -> Value {
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": Value::Object(fields),
        "required": required,
    })
}

/// What services are told of what moves.
fn foresight() -> Value {
    let choice = |keys: [&str; 2]| json!({ "type": "string", "enum": keys, "default": keys[0] });
    let perceive = ("perceive", choice(["sensed", "truth"]));
    let predict = ("predict", choice(["model", "truth"]));
    closed(fields([perceive, predict]), &[])
}

fn fields<const N: usize>(fields: [(&str, Value); N]) -> Map<String, Value> {
    let owned = fields.map(|(name, schema)| (name.to_owned(), schema));
    owned.into_iter().collect()
}

fn text() -> Value {
    json!({ "type": "string" })
}

fn number() -> Value {
    json!({ "type": "number" })
}

fn ranged(min: f64, max: f64) -> Value {
    json!({ "type": "number", "minimum": min, "maximum": max })
}

fn whole() -> Value {
    json!({ "type": "integer", "minimum": 0 })
}

fn list(item: &Value) -> Value {
    json!({ "type": "array", "items": item })
}

/// A list of exactly these.
fn tuple<const N: usize>(items: [Value; N]) -> Value {
    json!({ "type": "array", "prefixItems": Value::Array(items.into()), "minItems": N, "maxItems": N })
}

/// Exactly one of these tables, each with the field `kind` of its name.
fn kinds<const N: usize>(kinds: [(&str, Map<String, Value>, &[&str]); N]) -> Value {
    let kinds = kinds.map(|(kind, mut fields, required)| {
        fields.insert("kind".to_owned(), json!({ "const": kind }));
        let required: Vec<&str> = required.iter().copied().chain(["kind"]).collect();
        closed(fields, &required)
    });
    json!({ "oneOf": kinds.to_vec() })
}

fn coordinate() -> Value {
    ranged(-COORDINATE_M_MAX, COORDINATE_M_MAX)
}

/// `[x, y]`. [m]
fn point() -> Value {
    tuple([coordinate(), coordinate()])
}

/// `[x, y, yaw]`. [m, m, rad]
fn pose() -> Value {
    tuple([
        coordinate(),
        coordinate(),
        ranged(-YAW_RAD_MAX, YAW_RAD_MAX),
    ])
}

fn goal() -> Value {
    let [least, most] = TOLERANCE;
    let tolerance = ranged(least, most);
    let fields = fields([
        ("pose", pose()),
        ("tolerance_m", tolerance.clone()),
        ("yaw_tolerance_rad", tolerance),
    ]);
    closed(fields, &["pose"])
}

/// A seat: another binary knows its own configuration.
fn seat(config: &Value) -> Value {
    let any = json!({ "type": "object" });
    let shadow = fields([("binary", text()), ("config", any.clone())]);
    let fields = fields([
        ("binary", text()),
        ("config", any),
        ("shadow", closed(shadow, &[])),
        ("scheduling", object(&describe::<SchedulingSpec>())),
    ]);
    let mut seat = closed(fields, &[]);
    seat["if"] = json!({ "not": { "required": ["binary"] } });
    seat["then"] = json!({ "properties": { "config": config } });
    seat
}

/// A seat that is not the robot's.
fn other_seat() -> Value {
    let others = (Role::SERVICES.into_iter()).filter(|role| *role != Role::Robot);
    let others: Vec<&str> = others.map(Role::label).collect();
    json!({ "enum": others })
}

fn swap() -> Value {
    let fields = fields([
        ("service", other_seat()),
        ("at_s", ranged(0.0, TIME_LIMIT_S_MAX)),
        ("binary", text()),
        ("config", json!({ "type": "object" })),
        ("shadow_s", ranged(0.0, TIME_LIMIT_S_MAX)),
        ("keep_s", ranged(KEEP_S_MIN, TIME_LIMIT_S_MAX)),
        ("require", text()),
    ]);
    closed(fields, &["service", "at_s"])
}

/// When something begins: a run time, or a place of the robot.
fn trigger() -> Value {
    let near = fields([
        ("point_m", point()),
        ("distance_m", ranged(NEAR_M[0], NEAR_M[1])),
    ]);
    let trigger = fields([
        ("at_s", ranged(0.0, TIME_S_MAX)),
        ("robot_near", closed(near, &["point_m", "distance_m"])),
    ]);
    closed(trigger, &[])
}

fn stack_fault() -> Value {
    let of = |fields_of_kind: &[(&str, Value)]| {
        let mut all = fields([("begins", trigger())]);
        let more = fields_of_kind.iter();
        all.extend(more.map(|(name, schema)| ((*name).to_owned(), schema.clone())));
        all
    };
    let service = ("service", other_seat());
    let names: Vec<&str> = faultable().map(|row| row.name).collect();
    let topic = ("topic", json!({ "enum": names }));
    let lasts = ("lasts_s", ranged(LASTS_S_MIN, TIME_LIMIT_S_MAX));
    let by = |[min, max]: [f64; 2]| ("by_ms", ranged(min, max));
    let share = ("share", ranged(SHARE[0], SHARE[1]));
    let stop = of(&[service.clone(), lasts.clone()]);
    let slow = of(&[service.clone(), lasts.clone(), by(SLOW_MS)]);
    let clock = of(&[service.clone(), lasts.clone(), by(CLOCK_MS)]);
    let some = of(&[topic.clone(), lasts.clone(), share]);
    let delay = of(&[topic, lasts.clone(), by(DELAY_MS)]);
    let machine = of(&[lasts]);
    kinds([
        ("kill", of(&[service]), &["service", "begins"]),
        ("stop", stop, &["service", "begins"]),
        ("slow", slow, &["service", "begins", "by_ms"]),
        ("drop", some.clone(), &["topic", "begins", "share"]),
        ("delay", delay, &["topic", "begins", "by_ms"]),
        ("corrupt", some, &["topic", "begins"]),
        ("clock", clock, &["service", "begins", "by_ms"]),
        ("fill_shm", machine.clone(), &["begins"]),
        ("disk_full", machine, &["begins"]),
    ])
}

fn random_faults() -> Value {
    let time = || ranged(0.0, TIME_LIMIT_S_MAX);
    let fields = fields([
        ("count", whole()),
        ("from_s", time()),
        ("until_s", time()),
        ("seed", whole()),
        (
            "kinds",
            list(&json!({ "enum": KINDS.map(|kind| kind.name) })),
        ),
        ("services", list(&other_seat())),
    ]);
    closed(fields, &["count", "until_s"])
}

fn expect() -> Value {
    let label = |code| Intervention::from_code(code).map(Intervention::label);
    let labels: Vec<&str> = (1..=u16::MAX).map_while(label).collect();
    let reasons = json!({
        "type": "object",
        "propertyNames": { "enum": labels },
        "additionalProperties": whole(),
    });
    let metres = || ranged(0.0, 1.0e6);
    let outcome = json!({ "enum": ["reached", "unreachable", "timeout"] });
    let fields = fields([
        ("outcome", outcome),
        ("contacts_max", whole()),
        ("obstacle_replans_min", whole()),
        ("obstacle_replans_max", whole()),
        ("driven_m_min", metres()),
        ("goal_distance_m_max", metres()),
        ("interventions_min", reasons),
        ("restarts_min", whole()),
    ]);
    closed(fields, &[])
}

fn trials() -> Value {
    let fields = fields([
        ("obstacle", text()),
        ("goals", tuple([goal(), goal()])),
        ("line_m", tuple([point(), point()])),
        ("ahead_m", number()),
    ]);
    closed(fields, &["obstacle", "goals", "line_m", "ahead_m"])
}

fn robot() -> Value {
    let mut robot = object(&RobotSpec::parameters(""));
    let fields = &mut robot["properties"];
    fields["footprint_m"]["items"] = tuple([number(), number()]);
    fields["faults"]["items"] = fault();
    let pose = &mut fields["lidar"]["properties"]["pose"];
    pose["prefixItems"] = json!([number(), number(), number()]);
    (pose["minItems"], pose["maxItems"]) = (3.into(), 3.into());
    // `false` switches a preset's off.
    for name in ["slip", "odometry"] {
        fields[name] = json!({ "anyOf": [{ "type": "boolean" }, fields[name].take()] });
    }
    robot
}

fn fault() -> Value {
    let begins = fields([("at_s", number()), ("driven_m", number())]);
    let with = |more: &[(&str, Value)]| {
        let mut all = fields([("begins", closed(begins.clone(), &[]))]);
        all.extend(
            more.iter()
                .map(|(name, schema)| ((*name).to_owned(), schema.clone())),
        );
        all
    };
    let lasts = ("lasts_s", number());
    let looks = (
        "looks",
        json!({ "enum": ["silent", "no_return", "invalid"] }),
    );
    let shift = ("shift", tuple([number(), number(), number()]));
    let share = |name| (name, ranged(0.0, 1.0));
    kinds([
        ("lidar_blackout", with(&[lasts.clone(), looks]), &["begins"]),
        (
            "lidar_frozen",
            with(core::slice::from_ref(&lasts)),
            &["begins"],
        ),
        (
            "lidar_turned",
            with(&[lasts.clone(), ("angle_rad", number())]),
            &["begins", "angle_rad"],
        ),
        ("odometry_jump", with(&[shift]), &["begins", "shift"]),
        (
            "slip",
            with(&[lasts, share("forward_ratio"), share("turn_ratio")]),
            &["begins"],
        ),
    ])
}

/// A moment of a recording. [s]
fn moment() -> Value {
    ranged(-TIME_S_MAX, TIME_S_MAX)
}

/// Side of a cell. [m]
fn resolution() -> Value {
    ranged(RESOLUTION_M[0], RESOLUTION_M[1])
}

/// A list with at most so many items.
fn at_most(most: usize, item: &Value) -> Value {
    json!({ "type": "array", "items": item, "maxItems": most })
}

fn world() -> Value {
    let dynabarn = fields([("file", text()), ("phase_s", moment())]);
    let pedestrians = fields([
        ("file", text()),
        ("from_s", moment()),
        ("duration_s", ranged(0.0, TIME_S_MAX)),
        ("radius_m", ranged(PERSON_RADIUS_M[0], PERSON_RADIUS_M[1])),
    ]);
    let fields = fields([
        ("map", text()),
        ("barn", text()),
        ("dynabarn", closed(dynabarn, &["file"])),
        ("pedestrians", closed(pedestrians, &["file"])),
        ("generated", generated()),
        ("area_m", tuple([point(), point()])),
        ("resolution_m", resolution()),
        ("shapes", list(&shape())),
        ("obstacles", at_most(TRUTH_OBSTACLES_MAX, &obstacle())),
    ]);
    closed(fields, &[])
}

fn generated() -> Value {
    let side = || fields([("side_cells_max", whole())]);
    let family = kinds([
        ("iid", Map::new(), &[]),
        ("blocky", side(), &[]),
        ("concave", side(), &[]),
        ("corridor", fields([("width_cells", whole())]), &[]),
    ]);
    let cell = || tuple([whole(), whole()]);
    let fields = fields([
        ("family", family),
        ("size_cells", cell()),
        ("ratio", ranged(0.0, 1.0)),
        ("start_cell", cell()),
        ("goal_cell", cell()),
        ("seed", whole()),
        ("resolution_m", resolution()),
    ]);
    closed(fields, &["family", "size_cells"])
}

fn shape() -> Value {
    let size = || ranged(SHAPE_SIZE_M_MIN, COORDINATE_M_MAX);
    let boxed = fields([
        ("centre_m", point()),
        ("size_m", tuple([size(), size()])),
        ("yaw_rad", ranged(-SHAPE_YAW_RAD_MAX, SHAPE_YAW_RAD_MAX)),
    ]);
    let disc = fields([("centre_m", point()), ("radius_m", size())]);
    let polygon = fields([("corners_m", list(&point()))]);
    kinds([
        ("box", boxed, &["centre_m", "size_m"]),
        ("disc", disc, &["centre_m", "radius_m"]),
        ("polygon", polygon, &["corners_m"]),
    ])
}

fn obstacle() -> Value {
    let velocity = || ranged(-SPEED_MPS_MAX, SPEED_MPS_MAX);
    let track = at_most(ROWS_MAX, &tuple([moment(), coordinate(), coordinate()]));
    let fields = fields([
        ("name", text()),
        ("shape", shape()),
        ("appears", trigger()),
        ("lasts_s", ranged(LASTS_S_MIN, TIME_S_MAX)),
        ("waypoints_m", list(&point())),
        ("speed_mps", ranged(0.0, SPEED_MPS_MAX)),
        ("repeat", json!({ "type": "boolean" })),
        ("starts", trigger()),
        ("bounces_mps", tuple([velocity(), velocity()])),
        ("track", track),
        ("track_from_s", moment()),
    ]);
    closed(fields, &["name", "shape"])
}
