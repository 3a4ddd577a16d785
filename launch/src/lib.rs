//! `zeronav`: launches scenarios, supervises the services, measures replanning.

#![warn(clippy::print_stderr)]

mod arguments;
mod aside;
pub mod cli;
mod collect;
pub mod commands;
pub mod completions;
mod configs;
pub mod contract_kit;
mod control;
mod disturbance;
pub mod doctor;
pub mod draw;
mod drive;
mod ending;
pub mod environment;
pub mod exit;
mod faults;
pub mod floor;
mod interrupts;
mod judge;
mod keeper;
mod leave;
pub mod logs;
pub mod look;
pub mod map_save;
pub mod measure;
pub mod new_package;
mod open_files;
mod orders;
pub mod params;
mod picture;
mod placed;
mod prepare;
mod reasons;
mod record;

pub mod remote;
pub mod result;
mod run_plan;
mod running;
pub mod scenario;
mod seat_report;
mod seen;
mod shared_memory;
pub mod show;
mod shuttle;
mod stay_result;
mod suite;
pub mod supervise;
mod swap;
pub mod top;
pub mod topics;
mod trials;
mod version;
pub mod why;
