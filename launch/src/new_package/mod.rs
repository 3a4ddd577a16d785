//! `zeronav new`: a package for a seat, which builds, keeps the contract and drives as it is.
//!
//! Its text is an example of this source tree under another name, so that it is always one that is
//! tested.

pub mod cli;
mod cpp;
mod name;
mod place;
mod python;
mod rust;
mod sources;
pub mod template;

use cli::{NewArgs, word_of};
use name::Name;
use place::Text;
use sources::Sources;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use template::{Language, Template};
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, usage};

/// The scenario that a package comes with.
const SCENARIO: &str = include_str!("../../scenarios/blocked_aisle.toml");
const SCENARIO_FILE: &str = "blocked_aisle.toml";

/// `zeronav new`.
#[must_use]
pub fn new(arguments: &NewArgs) -> ExitCode {
    match make(arguments) {
        Ok(commands) => {
            let folder = arguments.folder.display();
            let word = word_of(arguments.role);
            say(&format!(
                "{folder}: a {word} that builds, keeps the contract and drives:\n\n"
            ));
            say(&format!("  cd {}\n", shell_word(&folder.to_string())));
            for command in commands {
                say(&format!("  {command}\n"));
            }
            ExitCode::from(EXIT_PASS)
        }
        Err(problem) => usage(&problem),
    }
}

/// Writes the package; the commands that build, test and drive it.
fn make(arguments: &NewArgs) -> Result<[String; 3], String> {
    let template = Template::find(arguments.role, arguments.lang)?;
    let name = match &arguments.name {
        Some(name) => Name::new(name)?,
        None => Name::of(&named(&arguments.folder))?,
    };
    let sources = Sources::find(arguments.zeronav.as_deref())?;
    let (mut files, build, binary, ignored) = match template.language {
        Language::Rust => {
            let files = rust::files(template, &name, &sources)?;
            (
                files,
                rust::BUILD,
                rust::binary(&name),
                rust::IGNORED.to_owned(),
            )
        }
        Language::Python => {
            let files = python::files(template, &name, &sources)?;
            (
                files,
                python::BUILD,
                python::binary(&name),
                python::IGNORED.to_owned(),
            )
        }
        Language::Cpp => {
            let files = cpp::files(template, &name, &sources)?;
            (files, cpp::BUILD, cpp::binary(&name), cpp::ignored(&name))
        }
    };
    let role = template.role;
    let zeronav = own_command();
    let commands = [
        build.to_owned(),
        format!("{zeronav} contract {role} {binary}"),
        format!("{zeronav} run ./{SCENARIO_FILE}"),
    ];
    let seat = format!("[services.{role}]\nbinary = \"{binary}\"\n");
    files.push((SCENARIO_FILE.into(), format!("{SCENARIO}\n{seat}")));
    files.push((".gitignore".into(), ignored));
    files.push(readme(template, &name, &sources, &seat, &commands));
    place::write(&arguments.folder, &files)?;
    Ok(commands)
}

/// The folder by its own name, where it is called `.` or through a link.
fn named(folder: &Path) -> PathBuf {
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

fn readme(
    template: &Template,
    name: &Name,
    sources: &Sources,
    seat: &str,
    commands: &[String; 3],
) -> Text {
    let (name, role) = (name.as_str(), template.role);
    let pages = match sources {
        Sources::Folder(folder) => folder.join("services/README.md").display().to_string(),
        Sources::Git { url, .. } => format!("services/README.md of {url}"),
    };
    let commands = commands.join("\n").replace(&own_command(), "zeronav");
    let text = format!(
        "# {name}\n\n\
         A {word} for zeronav: a program in the seat `{role}`.\n\n\
         ```sh\n{commands}\n```\n\n\
         In a scenario of your own, with the path from the folder of its file:\n\n\
         ```toml\n{seat}```\n\n\
         `zeronav swap {role} BINARY` puts it into a stack that drives. What the seat reads and what it owes:\n\
         {pages}\n",
        word = word_of(role),
    );
    ("README.md".into(), text)
}

/// How a shell in another folder finds this program: by its name, or by its path when the name leads
/// elsewhere or nowhere.
fn own_command() -> String {
    let Ok(own) = std::env::current_exe() else {
        return "zeronav".to_owned();
    };
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path)
        .map(|folder| folder.join("zeronav"))
        .find(|place| place.is_file());
    let is_own = found.and_then(|place| place.canonicalize().ok()) == own.canonicalize().ok();
    if is_own {
        "zeronav".to_owned()
    } else {
        shell_word(&own.display().to_string())
    }
}

/// A word of a shell.
fn shell_word(text: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "/-_.~+:".contains(letter);
    if !text.is_empty() && !text.starts_with('~') && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}
