//! The control socket of a stack: what can be asked, and both ends of it.

pub(crate) mod request;
pub(crate) mod socket;
