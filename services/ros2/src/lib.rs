//! A robot of ROS 2 in the robot's seat of a stack, and the stack in the tools of ROS 2, without an installation of ROS.
//!
//! How to read this crate: [`inputs`] turns what a robot sends into measurements of the contract, by way of [`stamps`]
//! (clocks), [`frames`] (transforms) and [`publishers`]; [`timeline`] gives them run time and ticks. All of that is
//! pure. [`network`] joins the network, [`inbox`] hears; [`seat`] is the process in the seat, [`beside`] the companion, and
//! [`doctor`] says what is in the way of a drive.

#![forbid(unsafe_code)]

#[cfg(all(feature = "humble", feature = "jazzy"))]
compile_error!(
    "the features `humble` and `jazzy` exclude each other: --no-default-features --features humble"
);

pub mod anchor;
pub mod beside;
pub mod config;
pub mod doctor;
pub mod frames;
pub mod inbox;
pub mod inputs;
pub mod network;
pub mod publishers;
pub mod seat;
pub mod stamps;
pub mod timeline;
