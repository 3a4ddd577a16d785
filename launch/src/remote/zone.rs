//! `zeronav zone`: where the robot may not go, while it drives.

use super::cli::{StackArgs, coordinate};
use super::verbs::make;
use crate::control::request::{Reply, Request};
use crate::running;
use clap::{Args, Subcommand};
use core::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_scenario::zones::{ZoneSpec, ZoneWord};
use zeronav_shell::printable;

/// Arguments of `zeronav zone`.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct ZoneArgs {
    /// What becomes of it.
    #[command(subcommand)]
    pub change: ZoneCommand,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// What becomes of a zone.
#[derive(Debug, Clone, Subcommand)]
#[command(allow_negative_numbers = true)]
pub enum ZoneCommand {
    /// Put a zone, in place of one of the same name; without another kind the robot keeps out of it.
    #[command(allow_negative_numbers = true)]
    Add {
        /// What it is called.
        name: String,
        /// What it asks for.
        #[command(flatten)]
        kind: KindArgs,
        /// Corners in the map frame, in order; two are those of a rectangle. [m]
        #[arg(value_name = "X Y", num_args = 4.., value_parser = coordinate, required_unless_present = "mask")]
        corners: Vec<f64>,
    },
    /// Take one away.
    Remove {
        /// What it is called.
        name: String,
    },
    /// Say which zones hold.
    List,
}

/// What a zone asks for.
#[derive(Debug, Clone, Args)]
#[group(multiple = false)]
pub struct KindArgs {
    /// The robot drives no faster inside. [m/s]
    #[arg(long, value_name = "MPS")]
    pub limit: Option<f64>,
    /// The robot drives no faster inside than this share of its fastest speed. [%]
    #[arg(long, value_name = "PERCENT")]
    pub percent: Option<f64>,
    /// Cells inside cost at least so much, 1 to 252.
    #[arg(long, value_name = "COST")]
    pub cost: Option<f64>,
    /// A preferred lane: cells outside of all lanes cost at least so much, 1 to 252.
    #[arg(long, value_name = "COST")]
    pub lane: Option<f64>,
    /// A mask of a costmap filter, in place of corners: its YAML file says `type`, `base` and `multiplier`.
    #[arg(long, value_name = "MASK.yaml", conflicts_with = "corners")]
    pub mask: Option<PathBuf>,
}

/// `zeronav zone`.
#[must_use]
pub fn zone(arguments: &ZoneArgs) -> ExitCode {
    let (request, done) = match &arguments.change {
        ZoneCommand::Add {
            name,
            kind,
            corners,
        } => match spec(name, kind, corners) {
            Ok(zone) => (Request::ZoneAdd { zone }, "added"),
            Err(problem) => return usage(&problem),
        },
        ZoneCommand::Remove { name } => (Request::ZoneRemove { name: name.clone() }, "removed"),
        ZoneCommand::List => return list(&arguments.stack),
    };
    make(&arguments.stack, &request, done)
}

fn spec(name: &str, kind: &KindArgs, corners: &[f64]) -> Result<ZoneSpec, String> {
    if corners.len() % 2 == 1 {
        return Err("corners are pairs of X and Y".to_owned());
    }
    let pairs = corners.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
    let polygon = match pairs.collect::<Vec<_>>().as_slice() {
        [[x0, y0], [x1, y1]] => vec![[*x0, *y0], [*x1, *y0], [*x1, *y1], [*x0, *y1]],
        corners => corners.to_vec(),
    };
    let word = if kind.limit.or(kind.percent).is_some() {
        ZoneWord::SpeedLimit
    } else if kind.cost.is_some() {
        ZoneWord::Cost
    } else if kind.lane.is_some() {
        ZoneWord::Lane
    } else {
        ZoneWord::Keepout
    };
    // Launch runs in another folder.
    let mask = kind.mask.as_ref().map(std::path::absolute).transpose();
    let mask = mask.map_err(|error| format!("the path of the mask: {error}"))?;
    Ok(ZoneSpec {
        name: name.to_owned(),
        kind: mask.is_none().then_some(word),
        polygon,
        mask,
        limit_mps: kind.limit,
        percent: kind.percent,
        cost: kind.cost.or(kind.lane),
    })
}

fn list(arguments: &StackArgs) -> ExitCode {
    let asked = running::find(arguments.domain.as_deref())
        .and_then(|stack| Ok((stack.ask(&Request::Zones)?, stack)));
    match asked {
        Ok((Reply::Zones(zones), _)) if arguments.json => say_json(&zones),
        Ok((Reply::Zones(zones), _)) if zones.is_empty() => say("no zones\n"),
        Ok((Reply::Zones(zones), _)) => say(&in_words(&zones)),
        Ok((_, stack)) => return usage(&stack.refusal("the answer is not what was asked for")),
        Err(problem) => return usage(&problem),
    }
    ExitCode::from(EXIT_PASS)
}

fn in_words(zones: &[ZoneSpec]) -> String {
    let mut text = String::new();
    for zone in zones {
        let asks = match (zone.kind, zone.limit_mps, zone.percent) {
            (None, ..) => "as its mask says".to_owned(),
            (Some(ZoneWord::Keepout), ..) => "keepout".to_owned(),
            (Some(ZoneWord::SpeedLimit), Some(limit_mps), _) => format!("at most {limit_mps} m/s"),
            (Some(ZoneWord::SpeedLimit), ..) => {
                format!(
                    "at most {} % of the speed",
                    zone.percent.unwrap_or_default()
                )
            }
            (Some(ZoneWord::Cost), ..) => format!("cost {}", zone.cost.unwrap_or_default()),
            (Some(ZoneWord::Lane), ..) => {
                format!(
                    "preferred lane, beside it cost {}",
                    zone.cost.unwrap_or_default()
                )
            }
        };
        let corners = || {
            let corners = zone.polygon.iter();
            let corners = corners.map(|[x_m, y_m]| format!("({x_m}, {y_m})"));
            corners.collect::<Vec<_>>().join(" ")
        };
        let place = zone.mask.as_ref().map_or_else(corners, |file| {
            printable(&file.display().to_string()).into_owned()
        });
        let _ = writeln!(text, "{:<20} {asks:<24} {place}", printable(&zone.name));
    }
    text
}
