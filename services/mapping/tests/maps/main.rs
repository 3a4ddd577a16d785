//! Maps from scans, poses and tracks.

#[path = "../support/mod.rs"]
mod support;

mod drift;
mod exact;
mod lost;
mod mapper;
mod moving;
mod paper_rows;
mod pose;
mod rest;
mod told;
mod under_robot;
mod window;
mod zones;
