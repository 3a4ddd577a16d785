//! Members of domains over real shared memory, and what they read, ask and say; one program, since each links
//! the middleware.

mod ask;
mod config;
mod goals;
mod history;
mod joining;
mod ports;
mod successors;
mod support;
mod topic_faults;
