//! Words of a command line that more than one command takes.

use std::ffi::OsString;
use std::path::PathBuf;
use zeronav_casts::Cast;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::DELAY_STEP_NS;
use zeronav_msgs::time::seconds;
use zeronav_shell::nearest::unknown;

/// The first of these words that holds a line break or another control character, made readable. Names
/// with such characters would break the lines in which messages and reports show them.
#[must_use]
pub fn unprintable(words: impl IntoIterator<Item = OsString>) -> Option<String> {
    let mut words = words
        .into_iter()
        .map(|word| word.to_string_lossy().into_owned());
    let word = words.find(|word| word.chars().any(char::is_control))?;
    Some(word.escape_debug().to_string())
}

/// The seat of a service by its name.
///
/// # Errors
/// One line that says what such a word looks like.
pub fn service_role(name: &str) -> Result<Role, String> {
    let role = Role::from_label(name).filter(|role| Role::SERVICES.contains(role));
    role.ok_or_else(|| {
        unknown(
            "service",
            name,
            Role::SERVICES.iter().map(|role| role.label()),
        )
    })
}

/// `global_planner=./my_planner` as a seat and a binary.
///
/// # Errors
/// One line that says what such a word looks like.
pub fn seat(text: &str) -> Result<(Role, PathBuf), String> {
    let (role, binary) = text
        .split_once('=')
        .ok_or("a seat and its binary read like global_planner=./my_planner")?;
    if binary.is_empty() {
        return Err("the binary is missing".to_owned());
    }
    Ok((service_role(role)?, PathBuf::from(binary)))
}

/// `global_planner=5ms` as a seat and its delay in steps of
/// [`zeronav_msgs::run::DELAY_STEP_NS`].
///
/// # Errors
/// One line that says what such a word looks like.
pub fn delay(text: &str) -> Result<(Role, u16), String> {
    let (role, time) = text
        .split_once('=')
        .ok_or("a delay reads like global_planner=5ms")?;
    let role = service_role(role)?;
    if role == Role::Robot {
        return Err("the robot keeps the time and cannot be delayed".to_owned());
    }
    let (number, unit_us) = match (time.strip_suffix("ms"), time.strip_suffix("us")) {
        (Some(number), _) => (number, 1.0e3),
        (None, Some(number)) => (number, 1.0),
        (None, None) => return Err("the time needs its unit, ms or us".to_owned()),
    };
    let number: f64 = number
        .parse()
        .map_err(|_| format!("`{number}` is no number"))?;
    let step_us = 1.0e6 * seconds(DELAY_STEP_NS);
    let steps = (number * unit_us / step_us).round();
    if !(1.0..=f64::from(u16::MAX)).contains(&steps) {
        return Err("a delay lasts 10us to 655ms".to_owned());
    }
    Ok((role, steps.to_u16()))
}

/// A number of hours: more than none, and at most a year.
///
/// # Errors
/// One line that says what such a word looks like.
pub fn hours(text: &str) -> Result<f64, String> {
    /// A year. [h]
    const MOST: f64 = 8766.0;
    let number: Result<f64, _> = text.parse();
    let hours = number.map_err(|_| format!("`{text}` is no number of hours"))?;
    if hours > 0.0 && hours <= MOST {
        Ok(hours)
    } else {
        Err(format!("{text}: more than 0 and at most {MOST} hours"))
    }
}

/// `plan/path=0.3` as a topic and a share of its messages; without a share it is all.
///
/// # Errors
/// One line that says what such a word looks like.
pub fn topic_share(text: &str) -> Result<(String, f64), String> {
    let (topic, share) = text.split_once('=').unwrap_or((text, "1"));
    let number: Result<f64, _> = share.parse();
    let share = number.map_err(|_| format!("`{share}` is no share such as 0.3"))?;
    Ok((topic.to_owned(), share))
}

/// `robot/scan=50ms` as a topic and a time. [ms]
///
/// # Errors
/// One line that says what such a word looks like.
pub fn topic_delay(text: &str) -> Result<(String, f64), String> {
    let example = "a delay reads like robot/scan=50ms";
    let (topic, time) = text.split_once('=').ok_or(example)?;
    Ok((topic.to_owned(), time_s(time)? * 1.0e3))
}

/// `mapping=-200ms` as a seat and an offset. [ms]
///
/// # Errors
/// One line that says what such a word looks like.
pub fn clock_offset(text: &str) -> Result<(Role, f64), String> {
    let example = "an offset reads like mapping=+200ms";
    let (role, time) = text.split_once('=').ok_or(example)?;
    let (sign, time) = match time.strip_prefix('-') {
        Some(time) => (-1.0, time),
        None => (1.0, time.strip_prefix('+').unwrap_or(time)),
    };
    Ok((service_role(role)?, sign * time_s(time)? * 1.0e3))
}

/// A time such as `5s` or `500ms`. [s]
///
/// # Errors
/// One line that says what such a word looks like.
pub fn time_s(text: &str) -> Result<f64, String> {
    let (number, unit_s) = match (text.strip_suffix("ms"), text.strip_suffix('s')) {
        (Some(number), _) => (number, 1.0e-3),
        (None, Some(number)) => (number, 1.0),
        // As clap writes a default.
        (None, None) => (text, 1.0),
    };
    let number: f64 = number
        .trim()
        .parse()
        .map_err(|_| format!("`{text}` is no time such as 5s or 500ms"))?;
    if !number.is_finite() || number < 0.0 {
        return Err(format!("`{text}`: a time is not below 0"));
    }
    Ok(number * unit_s)
}
