//! `zeronav`: launches scenarios, supervises the services, measures replanning.

#![warn(clippy::print_stderr)]

pub mod began;
pub mod busy;
pub mod cli;
mod collect;
pub mod commands;
mod companions;
pub mod compare;
pub mod completions;
mod configs;
mod control;
mod disturbance;
pub mod doctor;
mod drive;
mod ending;
mod film;
pub mod floor;
mod judge;
mod keeper;
mod known_words;
pub mod latency;
pub mod live_view;
pub mod logs;
pub mod look;
pub mod map_save;
pub mod new_package;
mod open_files;
mod orders;
pub mod params;
pub mod picture;
mod placed;
mod prepare;
mod program;
mod record;

pub mod remote;
pub mod report;
mod run_plan;
mod running;
mod seat_report;
pub mod show;
mod shuttle;
pub mod start_up;
mod starvation;
mod stay_result;
mod swap;
mod swap_order;
pub mod top;
pub mod topics;
mod trials;
pub mod why;
