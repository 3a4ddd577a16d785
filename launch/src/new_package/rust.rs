//! A package in Rust: a workspace of its own, with the versions of zeronav's lock file.

use super::name::Name;
use super::place::Text;
use super::sources::Sources;
use super::template::Template;

/// The lock file of this source tree.
const LOCK: &str = include_str!("../../../Cargo.lock");

/// Where cargo puts the binary.
pub(crate) fn binary(name: &Name) -> String {
    format!("./target/debug/{}", name.as_str())
}

/// What builds it, in its folder.
pub(crate) const BUILD: &str = "cargo build";

/// What git ignores.
pub(crate) const IGNORED: &str = "/target\n/runs\n";

/// The files.
///
/// # Errors
/// The lock file of the sources cannot be read.
pub(crate) fn files(
    template: &Template,
    name: &Name,
    sources: &Sources,
) -> Result<Vec<Text>, String> {
    // The middleware is one exact version, and the rest is what was tested.
    let lock = match sources {
        Sources::Folder(folder) => {
            let file = folder.join("Cargo.lock");
            std::fs::read_to_string(&file)
                .map_err(|error| format!("{}: {error}", file.display()))?
        }
        Sources::Git { .. } => LOCK.to_owned(),
    };
    Ok(vec![
        ("Cargo.toml".into(), manifest(template, name, sources)),
        ("Cargo.lock".into(), lock),
        ("src/main.rs".into(), template.text(name)),
    ])
}

fn manifest(template: &Template, name: &Name, sources: &Sources) -> String {
    let own = [
        ("zeronav-msgs", "msgs"),
        ("zeronav-shell", "services/shell"),
    ];
    let mut dependencies = String::new();
    for (package, folder) in own.iter().chain(template.packages) {
        let source = match sources {
            Sources::Folder(root) => {
                format!("path = {}", quoted(&root.join(folder).to_string_lossy()))
            }
            Sources::Git { url, commit } => {
                let rev = commit
                    .as_ref()
                    .map(|commit| format!(", rev = {}", quoted(commit)));
                format!("git = {}{}", quoted(url), rev.unwrap_or_default())
            }
        };
        let line = format!("{package} = {{ {source} }}\n");
        dependencies += &line;
    }
    let (name, registry) = (name.as_str(), template.registry);
    format!(
        r#"[package]
name = "{name}"
version = "0.1.0"
edition = "2024"
publish = false

[workspace]

[dependencies]
# The middleware's exact version comes with the shell; the versions of the rest are those of Cargo.lock.
{dependencies}{registry}
[profile.dev]
opt-level = 2
debug = "line-tables-only"

[profile.dev.build-override]
opt-level = 0
"#
    )
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}
