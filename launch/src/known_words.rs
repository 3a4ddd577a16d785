//! What can be named on a command line, for completions: scenarios, seats, algorithms.

use clap::builder::PossibleValuesParser;
use clap::{Arg, Command};
use zeronav_msgs::role::Role;
use zeronav_scenario::methods::METHODS;
use zeronav_supervise::algorithms;

/// `command` with the words that its arguments can be. Only completions are made of it: as a parser
/// it would refuse paths and say less about a slip.
pub(crate) fn with_known_words(command: Command) -> Command {
    let words = Words {
        scenarios: zeronav_scenario::list()
            .into_iter()
            .map(|one| one.name)
            .collect(),
        roles: Role::SERVICES.map(|role| role.label().to_owned()).to_vec(),
        planners: keys(Role::GlobalPlanner),
        controllers: keys(Role::LocalPlanner),
    };
    words.in_command(command)
}

/// The algorithms of a seat; none where its binary is not there to be asked.
fn keys(role: Role) -> Vec<String> {
    let listed = algorithms::of(role).unwrap_or_default();
    listed.into_iter().map(|one| one.key).collect()
}

struct Words {
    scenarios: Vec<String>,
    roles: Vec<String>,
    planners: Vec<String>,
    controllers: Vec<String>,
}

impl Words {
    fn in_command(&self, command: Command) -> Command {
        let own = command.mut_args(|arg| self.in_argument(arg));
        own.mut_subcommands(|inner| self.in_command(inner))
    }

    fn in_argument(&self, arg: Arg) -> Arg {
        let words: Vec<String> = match arg.get_id().as_str() {
            "scenario" => self.scenarios.clone(),
            "role" | "external" => self.roles.clone(),
            "writer" => (self.roles.iter().cloned())
                .chain([Role::Launch.label().to_owned()])
                .collect(),
            "controller" => self.controllers.clone(),
            "set" => {
                let planners = self.planners.iter().map(|key| format!("planner={key}"));
                let controllers = self.controllers.iter();
                planners
                    .chain(controllers.map(|key| format!("controller={key}")))
                    .collect()
            }
            "setting" => {
                let of = |seat: &str, key: &str, words: &[String]| {
                    let full = words.iter().map(|word| format!("{seat}.{key}={word}"));
                    full.collect::<Vec<String>>()
                };
                let mut words = of("global_planner", "planner", &self.planners);
                words.extend(of("local_planner", "controller", &self.controllers));
                words
            }
            "method" => METHODS.iter().map(|it| it.key.to_owned()).collect(),
            _ => return arg,
        };
        if words.is_empty() {
            return arg;
        }
        // The parser takes words that live as long as the program, which ends with its completions.
        let words = words.into_iter().map(|word| &*word.leak());
        arg.value_parser(PossibleValuesParser::new(
            words.collect::<Vec<&'static str>>(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::{Words, with_known_words};
    use crate::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn completions_know_scenarios_seats_and_algorithms() {
        let word = |word: &str| vec![word.to_owned()];
        let words = Words {
            scenarios: word("my_scenario"),
            roles: word("my_seat"),
            planners: word("my_planner"),
            controllers: word("my_controller"),
        };
        let mut script = Vec::new();
        let mut command = words.in_command(Cli::command());
        clap_complete::generate(
            clap_complete::Shell::Zsh,
            &mut command,
            "zeronav",
            &mut script,
        );
        let script = String::from_utf8(script).expect("text");
        for known in [
            "my_scenario",
            "my_seat",
            "planner=my_planner",
            "controller=my_controller",
        ] {
            assert!(script.contains(known), "{known}");
        }
        with_known_words(Cli::command()).debug_assert();
    }

    #[test]
    fn every_verb_that_takes_a_domain_takes_it_from_the_environment() {
        let mut n = 0;
        let mut commands = vec![Cli::command()];
        while let Some(command) = commands.pop() {
            commands.extend(command.get_subcommands().cloned());
            let domains = command
                .get_arguments()
                .filter(|arg| arg.get_id() == "domain");
            for domain in domains {
                assert_eq!(domain.get_env(), Some("ZERONAV_DOMAIN".as_ref()));
                n += 1;
            }
        }
        assert!(n > 10, "{n}");
    }
}
