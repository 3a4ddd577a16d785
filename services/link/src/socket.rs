//! The link's end of the socket in the domain's folder: who sits in seats for processes on the other host, and who
//! fills seats of this host.

use rustix::fs::{Mode, chmod};
use std::os::unix::net::UnixListener;
use zeronav_shell::StartError;
use zeronav_shell::folder::{FILE_MODE, Folder};
use zeronav_shell::remote_seats::{
    FromLink, Held, LINK_SOCKET, Line, Program, SeatStart, ToLink, WHY_CHARS_MAX, Wanted,
};

/// Connections at a time: two processes in each seat, a supervisor, and some that have just ended.
const CLIENTS_MAX: usize = 32;

/// A process in a seat, for one on the other host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sitter {
    /// The seat.
    pub seat: SeatStart,
    /// Its process id.
    pub pid: u32,
}

#[derive(Debug)]
struct Client {
    line: Line,
    sits: Option<(Sitter, Program)>,
    /// What the supervisor says that it has filled.
    held: Option<Vec<Held>>,
    /// What it was told last.
    told: Option<FromLink>,
}

/// See the module's description.
#[derive(Debug)]
pub struct Socket {
    listener: UnixListener,
    clients: Vec<Client>,
}

impl Socket {
    /// Opens it.
    ///
    /// # Errors
    /// [`StartError::System`] with what the system says.
    pub fn open(folder: &Folder) -> Result<Self, StartError> {
        let failed =
            |error: std::io::Error| StartError::system(format!("opening {LINK_SOCKET}"), error);
        let path = folder.entry(LINK_SOCKET);
        // A link that was killed has left its own.
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(failed(error));
            }
            _ => {}
        }
        let listener = UnixListener::bind(&path).map_err(failed)?;
        chmod(&path, Mode::from_raw_mode(FILE_MODE)).map_err(|error| failed(error.into()))?;
        listener.set_nonblocking(true).map_err(failed)?;
        Ok(Self {
            listener,
            clients: Vec::new(),
        })
    }

    /// Takes in what has been said. It waits for nothing.
    pub fn poll(&mut self) {
        while self.clients.len() < CLIENTS_MAX
            && let Ok((stream, _)) = self.listener.accept()
        {
            match Line::new(stream) {
                Ok(line) => self.clients.push(Client {
                    line,
                    sits: None,
                    held: None,
                    told: None,
                }),
                Err(error) => tracing::warn!(%error, "a connection was refused"),
            }
        }
        self.clients
            .retain_mut(|client| match client.line.receive() {
                Ok(said) => {
                    for said in said {
                        match said {
                            ToLink::Sit { wanted, pid } => {
                                let seat = wanted.seat;
                                client.sits = Some((Sitter { seat, pid }, wanted.program));
                            }
                            ToLink::Filled { held } => client.held = Some(held),
                        }
                    }
                    true
                }
                // Its process has ended, or it says what means nothing.
                Err(_) => false,
            });
    }

    /// Who sits in seats for processes on the other host, but for those that were told that theirs has ended.
    #[must_use]
    pub fn sitters(&self) -> Vec<Sitter> {
        self.sitting().map(|(sitter, _)| *sitter).collect()
    }

    /// What the other host has to start for them.
    #[must_use]
    pub fn wanted(&self) -> Vec<Wanted> {
        let wanted = self.sitting().map(|(sitter, program)| Wanted {
            seat: sitter.seat,
            program: program.clone(),
        });
        wanted.collect()
    }

    fn sitting(&self) -> impl Iterator<Item = &(Sitter, Program)> {
        let clients = self.clients.iter();
        let sitting = clients.filter(|it| !matches!(it.told, Some(FromLink::Ended { .. })));
        sitting.filter_map(|client| client.sits.as_ref())
    }

    /// The seats that are filled here for the other host.
    #[must_use]
    pub fn held(&self) -> Vec<Held> {
        let held = self
            .clients
            .iter()
            .filter_map(|client| client.held.as_ref());
        held.flatten().cloned().collect()
    }

    /// Tells those who sit for processes that have ended.
    pub fn ended(&mut self, held: &[Held]) {
        for client in &mut self.clients {
            let Some((sits, _)) = &client.sits else {
                continue;
            };
            let held = held.iter().find(|held| held.seat == sits.seat);
            if let Some(held) = held
                && let Some(code) = held.ended
            {
                let why = held.why.chars().take(WHY_CHARS_MAX).collect();
                client.tell(FromLink::Ended { code, why });
            }
        }
    }

    /// Tells all who sit here that their processes have ended with this exit code, and why.
    pub fn all_ended(&mut self, code: u8, why: &str) {
        for client in self.clients.iter_mut().filter(|it| it.sits.is_some()) {
            let why = why.to_owned();
            client.tell(FromLink::Ended { code, why });
        }
    }

    /// Tells the supervisor which seats it has to fill.
    pub fn want(&mut self, run: &str, seats: &[Wanted], over: bool) {
        for client in self.clients.iter_mut().filter(|it| it.held.is_some()) {
            client.tell(FromLink::Wanted {
                run: run.to_owned(),
                seats: seats.to_vec(),
                over,
            });
        }
    }
}

impl Client {
    /// Says something, once.
    fn tell(&mut self, what: FromLink) {
        if self.told.as_ref() != Some(&what) {
            // Whoever has gone is seen with the next look.
            let _ = self.line.send(&what);
            self.told = Some(what);
        }
    }
}
