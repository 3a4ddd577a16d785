//! Carries the topics of a stack between two hosts, over Zenoh.
//!
//! On each host a stack has a domain of its own. The link of a host reads what is written there and somebody
//! reads on the other host, and writes what comes from there: for the seats of a host the others are simply
//! there. It rings whom the message would have rung. On the host of launch a small process, `zeronav-remote-seat`,
//! sits in each seat that is filled on the other host, and ends when the process there does: so launch starts it,
//! watches it and starts it again like any other.
//!
//! | what | where |
//! |---|---|
//! | what is sent from link to link | [`frame`] |
//! | which start of the other host is heard, and what of it is lost | [`other`] |
//! | by how much the clocks of the hosts differ, and how well that is known | [`clock_offset`] |
//! | a topic's messages in both directions, with stamps of the host's own clock | [`lane`], [`lanes`] |
//! | what was carried, for launch | [`account`] |
//! | which seats are filled where | [`seats`], over the socket of [`socket`] |
//! | Zenoh: named ends, TLS | [`session`], queues of both directions in [`queue`] |
//! | certificates by which the hosts know each other | [`keys`] |
//! | the processes | [`process`], [`remote_seat`] |

pub mod account;
pub mod clock_offset;
pub mod config;
pub mod frame;
pub mod keys;
pub mod lane;
pub mod lanes;
pub mod other;
pub mod process;
pub mod queue;
pub mod remote_seat;
pub mod seats;
pub mod session;
pub mod socket;
