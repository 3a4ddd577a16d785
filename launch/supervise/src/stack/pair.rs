//! Two processes in one seat: which of them is obeyed, and from which tick on.

use super::{Launch, Stack, seat_mut};
use crate::cleaner::Ticket;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::Seat;
use zeronav_msgs::topics::{HealthTopic, health_of};
use zeronav_shell::{Latest, Peer, StartError};

impl Stack {
    /// The membership, to open ports with.
    ///
    /// # Errors
    /// When the stack is closed.
    pub fn peer(&self) -> Result<&Peer, StartError> {
        let closed = || StartError::Usage("the stack is closed".to_owned());
        self.peer.as_ref().ok_or_else(closed)
    }

    /// Announces a newcomer in the seat of `role` and starts it; it is neither obeyed nor waited for,
    /// and hears ticks from `from_tick` on. Returns its epoch.
    ///
    /// # Errors
    /// One line naming the binary, or the process that is beside already.
    pub fn start_beside(
        &mut self,
        role: Role,
        launch: &Launch<'_>,
        from_tick: u64,
    ) -> std::io::Result<u32> {
        if let Some(other) = &self.beside {
            let problem = format!("process {} is still warm", other.pid());
            return Err(std::io::Error::other(problem));
        }
        let epoch = self.new_epoch(role);
        self.warm_up(role, epoch, from_tick);
        match self.start_as(role, epoch, launch) {
            Ok(child) => self.beside = Some(child),
            Err(error) => {
                self.end_pair(role);
                return Err(error);
            }
        }
        Ok(epoch)
    }

    /// Hears the heartbeats in the seat of `role`.
    ///
    /// # Errors
    /// When there is no place left for a reader.
    pub fn health_of(&self, role: Role) -> Result<Latest<HealthTopic>, StartError> {
        let none = || StartError::Usage(format!("{role} has no heartbeat"));
        self.peer()?.latest_on(health_of(role).ok_or_else(none)?)
    }

    /// The newcomer hears ticks from `from_tick` on. In lockstep the robot waits for its answers.
    pub fn warm_up(&mut self, role: Role, epoch: u32, from_tick: u64) {
        self.change_seat(role, |seat| {
            (seat.since_tick, seat.other, seat.other_tick) = (0, epoch, from_tick);
        });
    }

    /// The newcomer is obeyed from `tick` on; the process before it stays beside it.
    pub fn cut_over(&mut self, role: Role, tick: u64) {
        self.exchange(role);
        self.change_seat(role, |seat| {
            turn_over(seat, tick);
            // An absence of the one before is over with it, and not before: what nobody answered is not owed.
            seat.on_tick = seat.on_tick.min(tick);
        });
    }

    /// The process beside is obeyed again from `tick` on. In lockstep the one in the seat has
    /// answered every tick before `off_tick`, and the seat is empty from there to `tick`.
    pub fn roll_back(&mut self, role: Role, tick: u64, off_tick: Option<u64>) {
        self.exchange(role);
        self.change_seat(role, |seat| {
            // A cut-over that is still to come does not take place.
            let since_tick = if tick <= seat.since_tick { 0 } else { tick };
            turn_over(seat, since_tick);
            seat.other_tick = u64::MAX;
            if let Some(off_tick) = off_tick {
                (seat.off_tick, seat.on_tick) = (off_tick, tick);
            }
        });
    }

    /// One process is left in the seat of `role`.
    pub fn end_pair(&mut self, role: Role) {
        self.change_seat(role, |seat| {
            (seat.since_tick, seat.other, seat.other_tick) = (0, 0, 0);
        });
    }

    /// Takes the ended process beside out, and has removed what it left in the middleware's
    /// registry.
    pub fn bury_beside(&mut self) -> Ticket {
        self.beside = None;
        self.cleaner.ask()
    }

    /// The process beside and the one in the seat change places.
    fn exchange(&mut self, role: Role) {
        let office = self.children.iter_mut().find(|child| child.role == role);
        let (Some(office), Some(beside)) = (office, &mut self.beside) else {
            return;
        };
        core::mem::swap(office, beside);
        let (epoch, pid) = (office.epoch, office.pid());
        if let Some(seat) = seat_mut(&mut self.newest, role) {
            seat.epoch = epoch;
        }
        self.name_owner(role, pid);
    }

    fn change_seat(&mut self, role: Role, change: impl FnOnce(&mut Seat)) {
        if let Some(seat) = seat_mut(&mut self.roster, role) {
            change(seat);
        }
        self.publish_control();
    }
}

/// The other process of the seat is obeyed from `tick` on.
fn turn_over(seat: &mut Seat, tick: u64) {
    (seat.epoch, seat.other) = (seat.other, seat.epoch);
    (seat.hear_tick, seat.other_tick) = (seat.other_tick, seat.hear_tick);
    seat.since_tick = tick;
}
