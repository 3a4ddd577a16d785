//! Writes the contract for services in other languages:
//!
//! ```sh
//! cargo run -p zeronav-msgs --example bindings
//! ```
//!
//! `msgs/tests/bindings.rs` holds the files current.

mod contract;
mod cpp;
mod python;
mod words;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let contract = contract::Contract::new();
    for (file, text) in [
        (python::FILE, python::text(&contract)),
        (cpp::FILE, cpp::text(&contract)),
    ] {
        std::fs::write(workspace.join(file), text)?;
    }
    Ok(())
}
