//! `zeronav`: launches scenarios, supervises the services, measures replanning.

#![warn(clippy::print_stderr)]

pub mod cli;
pub mod collect;
pub mod commands;
pub mod configs;
pub mod disturbance;
pub mod draw;
pub mod drive;
pub mod ending;
pub mod environment;
pub mod exit;
pub mod floor;
pub mod interrupts;
pub mod judge;
pub mod keeper;
pub mod leave;
pub mod look;
pub mod measure;
pub mod open_files;
pub mod params;
pub mod picture;
pub mod prepare;
pub mod record;
pub mod redirect;
pub mod remote;
pub mod result;
pub mod run_plan;
pub mod scenario;
pub mod seat_report;
pub mod seen;
pub mod shared_memory;
pub mod show;
pub mod shuttle;
pub mod suite;
pub mod supervise;
pub mod trials;
pub mod version;
