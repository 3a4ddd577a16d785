//! A parameter read as its row says.

use super::outline::{self, Mended};
use super::parameters::Sections;
use super::table::{Form, Row};
use super::yaml::Value;
use zeronav_casts::Cast;

/// What a parameter gives.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Given {
    /// A value of a scenario.
    Is(toml::Value),
    /// Corners, convex and counter-clockwise, and what was changed. [m]
    Outline(Vec<[f64; 2]>, Mended),
    /// The robot drives backwards, as fast as forward.
    Reverses,
    /// Nothing: it is empty.
    Nothing,
    /// Something that a launch file puts in its place.
    Later,
}

impl Given {
    /// The number that it is.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Is(toml::Value::Float(it)) => Some(*it),
            Self::Is(toml::Value::Integer(it)) => Some((*it).to_f64()),
            _ => None,
        }
    }
}

/// Reads `value`, which stands in the place of `row`.
///
/// # Errors
/// What is wrong with it.
pub(super) fn read(row: &Row, value: &Value, sections: &Sections) -> Result<Given, String> {
    if let Value::Text(text) = value
        && is_filled_in_later(text)
    {
        return Ok(Given::Later);
    }
    if *value == Value::Nothing {
        return Ok(Given::Nothing);
    }
    let value = match row.item {
        Some(item) => item_of(value, item)?,
        None => value,
    };
    let number = |it: f64| Ok(Given::Is(toml::Value::Float(it + 0.0)));
    match row.form {
        Form::Positive => number(positive(value)?),
        Form::Size => number(finite(value)?.abs()),
        Form::Opposite => number(-positive(value)?),
        Form::Backward => number(finite(value)?.min(0.0)),
        Form::Count => count(value),
        Form::Reverses if switch(value)? => Ok(Given::Reverses),
        Form::Reverses => number(0.0),
        Form::Switch => Ok(Given::Is(switch(value)?.into())),
        Form::Unknown => {
            let word = if switch(value)? { "free" } else { "lethal" };
            Ok(Given::Is(word.into()))
        }
        Form::Corners => {
            let corners = outline::corners_of(value)?;
            if corners.is_empty() {
                return Ok(Given::Nothing);
            }
            let (corners, mended) = outline::upright(&corners)?;
            Ok(Given::Outline(corners, mended))
        }
        Form::Topic => match text(value)? {
            "" => Ok(Given::Nothing),
            name => Ok(Given::Is(
                topic(name, &sections.namespace(row.node))?.into(),
            )),
        },
        Form::Frame => match text(value)?.trim_start_matches('/') {
            "" => Ok(Given::Nothing),
            name if name.chars().any(char::is_control) => {
                Err(format!("must be the name of a frame, not {name:?}"))
            }
            name => Ok(Given::Is(name.into())),
        },
    }
}

/// `$(var x)` and `<robot_namespace>`.
fn is_filled_in_later(text: &str) -> bool {
    text.contains("$(") || text.contains("${") || text.contains('<')
}

/// An item of a list. With six, roll and pitch are before yaw, as newer smoothers have it.
fn item_of(value: &Value, item: usize) -> Result<&Value, String> {
    let Value::List(items) = value else {
        return Err(format!("must be a list [x, y, theta], not {value}"));
    };
    let item = if items.len() == 6 && item == 2 {
        5
    } else {
        item
    };
    match items.get(item) {
        Some(node) => Ok(&node.value),
        None => Err(format!("must be a list [x, y, theta], not {value}")),
    }
}

fn finite(value: &Value) -> Result<f64, String> {
    match value {
        Value::Number(it) if it.is_finite() => Ok(*it),
        Value::Number(it) => Err(format!("must be a finite number, not {it}")),
        other => Err(format!("must be a number, not {other}")),
    }
}

fn positive(value: &Value) -> Result<f64, String> {
    match finite(value)? {
        it if it < 0.0 => Err(format!("must not be negative: {it}")),
        it => Ok(it),
    }
}

fn count(value: &Value) -> Result<Given, String> {
    let number = positive(value)?;
    if number.fract() != 0.0 || number > 1.0e9 {
        return Err(format!("must be a whole number, not {number}"));
    }
    let whole = number.to_i64();
    Ok(Given::Is(whole.into()))
}

fn switch(value: &Value) -> Result<bool, String> {
    match value {
        Value::Switch(it) => Ok(*it),
        other => Err(format!("must be true or false, not {other}")),
    }
}

fn text(value: &Value) -> Result<&str, String> {
    match value {
        Value::Text(it) => Ok(it),
        other => Err(format!("must be a name, not {other}")),
    }
}

/// The whole name of a topic, for a node in `namespace`.
fn topic(name: &str, namespace: &str) -> Result<String, String> {
    let whole = if name.starts_with('/') {
        name.to_owned()
    } else {
        format!("{namespace}/{name}")
    };
    let is_part = |part: &str| {
        let plain = |it: char| it.is_ascii_alphanumeric() || it == '_';
        !part.is_empty()
            && part.chars().all(plain)
            && !part.starts_with(|it: char| it.is_ascii_digit())
    };
    if whole[1..].split('/').all(is_part) && whole.len() <= 200 {
        Ok(whole)
    } else {
        Err(format!("cannot be the name of a topic: {name:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nav2::yaml;

    fn sections() -> Sections {
        let text = "robot1:\n  amcl:\n    ros__parameters: {}\n";
        Sections::of(&yaml::read(text).expect("YAML")).expect("sections")
    }

    fn read_as(form: Form, text: &str) -> Result<Given, String> {
        let row = Row {
            node: "amcl",
            parameter: "it",
            item: None,
            of: None,
            form,
            to: "robot",
            otherwise: None,
        };
        read(&row, &yaml::read(text).expect("YAML").value, &sections())
    }

    #[test]
    fn signs_follow_the_form() {
        let number = |form, text| read_as(form, text).map(|it| it.number());
        assert_eq!(number(Form::Positive, "0.5"), Ok(Some(0.5)));
        assert_eq!(number(Form::Size, "-2.5"), Ok(Some(2.5)));
        assert_eq!(number(Form::Backward, "-0.35"), Ok(Some(-0.35)));
        assert_eq!(number(Form::Backward, "0.1"), Ok(Some(0.0)));
        assert_eq!(number(Form::Opposite, "0.2"), Ok(Some(-0.2)));
        assert_eq!(number(Form::Count, "20"), Ok(Some(20.0)));
        assert_eq!(read_as(Form::Reverses, "true"), Ok(Given::Reverses));
        assert_eq!(number(Form::Reverses, "false"), Ok(Some(0.0)));
    }

    #[test]
    fn values_of_another_kind_are_rejected_and_those_of_a_launch_file_come_later() {
        for (form, text) in [
            (Form::Positive, "-0.5"),
            (Form::Positive, ".nan"),
            (Form::Positive, ".inf"),
            (Form::Positive, "fast"),
            (Form::Positive, "'0.5'"),
            (Form::Size, "-.inf"),
            (Form::Count, "2.5"),
            (Form::Switch, "1"),
            (Form::Topic, "a//b"),
            (Form::Topic, "3d"),
            (Form::Topic, "/"),
            (Form::Topic, "[scan]"),
            (Form::Frame, "1"),
        ] {
            read_as(form, text).expect_err(text);
        }
        assert_eq!(read_as(Form::Positive, "$(var v_max)"), Ok(Given::Later));
        assert_eq!(
            read_as(Form::Topic, "<robot_namespace>/scan"),
            Ok(Given::Later)
        );
        assert_eq!(read_as(Form::Corners, "'[]'"), Ok(Given::Nothing));
    }

    #[test]
    fn a_relative_topic_is_in_the_namespace_of_its_node() {
        let name = |text| read_as(Form::Topic, text);
        assert_eq!(name("scan"), Ok(Given::Is("/robot1/scan".into())));
        assert_eq!(name("/scan"), Ok(Given::Is("/scan".into())));
        assert_eq!(
            read_as(Form::Frame, "/base_link"),
            Ok(Given::Is("base_link".into()))
        );
    }
}
