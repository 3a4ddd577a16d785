//! Makes `tests/data` again, bit for bit:
//!
//! ```sh
//! cargo run --release -p zeronav-world-files --example test_data -- tests/data
//! ```

#![allow(clippy::print_stdout, reason = "a list for people")]

mod files;

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map(PathBuf::from);
    let folder = folder.ok_or("which folder? cargo run ... --example test_data -- tests/data")?;
    for (name, bytes) in files::all()? {
        let file = folder.join(&name);
        if let Some(parent) = file.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(&file, &bytes)?;
        println!("{:7} {name}", bytes.len());
    }
    Ok(())
}
