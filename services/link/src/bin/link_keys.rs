//! `zeronav-link-keys`: see `zeronav link keys --help`.

use clap::Parser;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_link::keys::{Named, make};
use zeronav_shell::flags::one_line;

/// Make keys and certificates by which two hosts know each other.
#[derive(Debug, Parser)]
struct Args {
    /// A new folder.
    folder: PathBuf,
    /// Hosts, with the names and addresses by which they are found.
    #[arg(required = true, value_name = "HOST=ADDRESS,...", value_parser = Named::parse)]
    hosts: Vec<Named>,
}

fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) if error.use_stderr() => return refused(&one_line(&error)),
        Err(error) => {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
    };
    if let Err(problem) = make(&args.folder, &args.hosts) {
        return refused(&problem);
    }
    let mut output = std::io::stdout().lock();
    for Named { host, .. } in &args.hosts {
        let _ = writeln!(
            output,
            "{host}: ca.pem, {host}.pem and {host}.key in a folder of its own, which `keys` names"
        );
    }
    ExitCode::SUCCESS
}

fn refused(problem: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "{problem}");
    ExitCode::from(2)
}
