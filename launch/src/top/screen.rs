//! The terminal while the view is on it. It is given back as it was whatever happens: at the end, on
//! an error, on a panic.

use super::draw::draw;
use super::view::{Sort, View};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use std::io::{ErrorKind, IsTerminal};
use std::time::Duration;

/// The view on the terminal.
pub(super) struct Screen {
    terminal: DefaultTerminal,
    sort: Sort,
}

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    /// The end.
    Quit,
    /// The end, as by a signal.
    Interrupt,
    /// To sort the topics by the next column.
    Sort,
    /// To draw again, because the size has changed.
    Draw,
}

/// True when standard output is a terminal.
pub(super) fn is_there() -> bool {
    std::io::stdout().is_terminal()
}

impl Screen {
    /// Takes the terminal; a panic gives it back before it is told.
    ///
    /// # Errors
    /// One line when the terminal does not do.
    pub(super) fn open() -> Result<Self, String> {
        let terminal = ratatui::try_init().map_err(|error| {
            ratatui::restore();
            format!("taking the terminal: {error}; `zeronav top --once` prints a sample")
        })?;
        Ok(Self {
            terminal,
            sort: Sort::default(),
        })
    }

    /// Sorts the topics by the next column.
    pub(super) fn sort(&mut self) {
        self.sort = self.sort.next();
    }

    /// Draws the view.
    ///
    /// # Errors
    /// One line when the terminal cannot be written to.
    pub(super) fn draw(&mut self, view: &View) -> Result<(), String> {
        let sort = self.sort;
        let drawn = self.terminal.draw(|frame| draw(frame, view, sort));
        drawn.map(|_| ()).map_err(|error| problem(&error))
    }

    /// Waits for a key, so long at most.
    ///
    /// # Errors
    /// One line when the terminal is gone.
    pub(super) fn wait(pause: Duration) -> Result<Option<Asked>, String> {
        match event::poll(pause) {
            Ok(true) => Ok(asked(&event::read().map_err(|error| problem(&error))?)),
            Ok(false) => Ok(None),
            // A signal; its flag is looked at next.
            Err(error) if error.kind() == ErrorKind::Interrupted => Ok(None),
            Err(error) => Err(problem(&error)),
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

fn problem(error: &std::io::Error) -> String {
    format!("the terminal: {error}")
}

fn asked(event: &Event) -> Option<Asked> {
    match event {
        Event::Key(KeyEvent {
            code,
            modifiers,
            kind: KeyEventKind::Press | KeyEventKind::Repeat,
            ..
        }) => match code {
            KeyCode::Char('c') if modifiers.contains(KeyModifiers::CONTROL) => {
                Some(Asked::Interrupt)
            }
            KeyCode::Char('q') | KeyCode::Esc => Some(Asked::Quit),
            KeyCode::Char('s') => Some(Asked::Sort),
            _ => None,
        },
        Event::Resize(..) => Some(Asked::Draw),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_ask_for_what_the_footer_says() {
        let key = |code, modifiers| asked(&Event::Key(KeyEvent::new(code, modifiers)));
        let none = KeyModifiers::NONE;
        assert_eq!(key(KeyCode::Char('q'), none), Some(Asked::Quit));
        assert_eq!(key(KeyCode::Char('s'), none), Some(Asked::Sort));
        assert_eq!(key(KeyCode::Char('c'), none), None);
        let interrupt = key(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(interrupt, Some(Asked::Interrupt));
        assert_eq!(asked(&Event::Resize(80, 24)), Some(Asked::Draw));
    }
}
