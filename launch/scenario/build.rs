//! Lists the files of `scenarios/` and `worlds/` for `library.rs`, so that a file that is
//! there is built in and none can be forgotten.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::{env, fs, io};

fn main() -> Result<(), Box<dyn Error>> {
    let (package, out) = (env::var("CARGO_MANIFEST_DIR")?, env::var("OUT_DIR")?);
    let mut list = String::new();
    for (folder, name) in [("scenarios", "SCENARIOS"), ("worlds", "WORLDS")] {
        writeln!(io::stdout(), "cargo::rerun-if-changed=../{folder}")?;
        let mut files = fs::read_dir(Path::new(&package).join("..").join(folder))?
            .map(|entry| Ok(entry?.path()))
            .collect::<io::Result<Vec<_>>>()?;
        files.retain(|file| file.extension().is_some_and(|ending| ending == "toml"));
        files.sort();
        writeln!(list, "const {name}: [(&str, &str); {}] = [", files.len())?;
        for file in files {
            let stem = file.file_stem().and_then(|stem| stem.to_str());
            let (Some(stem), Some(file)) = (stem, file.to_str()) else {
                return Err("the name of a file is no text".into());
            };
            writeln!(list, "    ({stem:?}, include_str!({file:?})),")?;
        }
        writeln!(list, "];")?;
    }
    fs::write(Path::new(&out).join("library.rs"), list)?;
    Ok(())
}
