//! What can be said at the prompt.

use super::moment::Moment;
use zeronav_console::arguments::service_role;
use zeronav_msgs::role::Role;

/// What the words are.
pub(super) const HELP: &str = "\
step [N]      run N ticks (default 1)
back [N]      go back N ticks: drives the run again from its start
goto TICK|TIMEs  pause there, forwards or back
attach [ROLE] start the debugger on the process in this seat (default: the last one)
why           why the robot does what it does
continue      drive to the end
quit          end the run
In the debugger `shell zeronav step N` allows N more ticks; the process runs them when you continue or detach.
";

/// A line at the prompt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Word {
    /// Do so many ticks.
    Step(u64),
    /// Stand so many ticks earlier.
    Back(u64),
    /// Stand there.
    Goto(Moment),
    /// Start the debugger; without a role on the seat of before.
    Attach(Option<Role>),
    /// Say why the robot does what it does.
    Why,
    /// Drive to the end.
    Continue,
    /// Say what can be said.
    Help,
    /// End the run.
    Quit,
    /// An empty line.
    Nothing,
}

impl Word {
    /// What a line says; words may be cut short to their first letter.
    ///
    /// # Errors
    /// One line.
    pub(super) fn of(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let count = |text: Option<&&str>| match text {
            None => Ok(1),
            Some(text) => (text.parse().ok().filter(|n| *n >= 1))
                .ok_or_else(|| format!("`{text}` is no number of ticks")),
        };
        let (first, rest) = words.split_first().unwrap_or((&"", &[]));
        if rest.len() > 1 {
            return Err(format!(
                "`{}` is too much after {first}; `help` lists what can be said",
                rest[1]
            ));
        }
        let word = rest.first();
        Ok(match *first {
            "" => Self::Nothing,
            "step" | "s" => Self::Step(count(word)?),
            "back" | "b" => Self::Back(count(word)?),
            "goto" | "g" => Self::Goto(
                word.ok_or("goto where? a tick, or a time such as 20.6s")?
                    .parse()?,
            ),
            "attach" | "a" => Self::Attach(word.map(|name| service_role(name)).transpose()?),
            "why" | "w" => Self::Why,
            "continue" | "c" => Self::Continue,
            "help" | "h" | "?" => Self::Help,
            "quit" | "q" => Self::Quit,
            other => {
                return Err(format!(
                    "`{other}` is none of: step, back, goto, attach, why, continue, help, quit"
                ));
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_of_the_help_is_one() {
        for line in HELP.lines().filter(|line| !line.starts_with("In the")) {
            let word = line.split_whitespace().next().expect("a word");
            let of = if word == "goto" {
                Word::of("goto 3")
            } else {
                Word::of(word)
            };
            assert!(of.is_ok(), "{word}: {of:?}");
            assert_eq!(
                Word::of(&line[..1]).is_ok(),
                word != "goto",
                "{word} cut short"
            );
        }
    }

    #[test]
    fn counts_moments_and_seats_are_read() {
        assert_eq!(Word::of(" step  20 "), Ok(Word::Step(20)));
        assert_eq!(Word::of("b"), Ok(Word::Back(1)));
        assert_eq!(Word::of("goto 2.5s"), Ok(Word::Goto(Moment::Time(2.5))));
        assert_eq!(
            Word::of("attach mapping"),
            Ok(Word::Attach(Some(Role::Mapping)))
        );
        assert_eq!(Word::of("\t"), Ok(Word::Nothing));
        for wrong in [
            "step 0",
            "step -1",
            "back x",
            "goto",
            "goto 0",
            "attach maping",
            "jump",
            "step 1 2",
        ] {
            assert!(Word::of(wrong).is_err(), "{wrong}");
        }
    }
}
