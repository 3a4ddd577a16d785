//! Arguments of `zeronav new`.

use super::template::Language;
use clap::Args;
use std::path::PathBuf;
use zeronav_msgs::role::Role;
use zeronav_shell::nearest::unknown;

/// Short words for the seats that a package can be made for, beside the names of the seats.
const WORDS: [(&str, Role); 4] = [
    ("planner", Role::GlobalPlanner),
    ("controller", Role::LocalPlanner),
    ("guard", Role::CollisionGuard),
    ("mapping", Role::Mapping),
];

/// Arguments of `zeronav new`.
#[derive(Debug, Clone, Args)]
pub struct NewArgs {
    /// What it is for: planner, controller, guard or mapping; the seats' own names are understood,
    /// too.
    #[arg(value_name = "planner|controller|guard|mapping", value_parser = seat)]
    pub role: Role,
    /// Folder to make; one that exists has to be empty. Its last part is the package's name.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Language to write it in.
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    pub lang: Language,
    /// Name of the package, where it shall not be that of the folder: a letter, then letters, digits
    /// and underscores, all small.
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Sources of zeronav that it is built with: a checkout's folder, or for Rust and Python the
    /// address of a git repository. Without, the sources that this program was built from.
    #[arg(long, value_name = "PATH|URL")]
    pub zeronav: Option<String>,
}

/// A seat by its short word or its name.
fn seat(word: &str) -> Result<Role, String> {
    let known = WORDS
        .iter()
        .find(|(short, role)| *short == word || role.label() == word);
    known.map(|(_, role)| *role).ok_or_else(|| {
        unknown(
            "seat to write a package for",
            word,
            WORDS.map(|(short, _)| short),
        )
    })
}

/// The short word of a seat.
pub(crate) fn word_of(role: Role) -> &'static str {
    let known = WORDS.iter().find(|(_, of)| *of == role);
    known.map_or(role.label(), |(word, _)| word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seat_has_two_names_and_the_robot_none() {
        assert_eq!(seat("controller"), Ok(Role::LocalPlanner));
        assert_eq!(seat("local_planner"), Ok(Role::LocalPlanner));
        assert!(seat("gard").is_err_and(|why| why.contains("did you mean `guard`?")));
        assert!(seat("robot").is_err());
    }
}
