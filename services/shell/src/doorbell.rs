//! Doorbells: how a process sleeps until there is a message for it.
//!
//! One listener per role, the event id is the topic's number. The wait is a `ppoll` on the
//! listener's descriptor: the middleware's own timed wait rounds deadlines up by 4 to 8 ms.

use crate::clock::now_ns;
use crate::error::StartError;
use crate::middleware::Erased;
use crate::peer::{Peer, service_name};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::prelude::{EventId, FileDescriptorBased, ipc};
use iceoryx2::service::builder::event::EventOpenError;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{NODES_MAX, RINGERS_MAX};

/// Longest time without a wake, so that latched topics reach late joiners. [ns]
pub(crate) const WAKE_AT_LEAST_NS: u64 = 50_000_000;

/// Which events rang, one bit per event id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rung(pub u64);

impl Rung {
    /// True when `event` rang.
    #[must_use]
    pub fn has(self, event: usize) -> bool {
        event < 64 && self.0 & (1 << event) != 0
    }
}

/// The own doorbell, and the pipes that wake on signals and for other threads.
#[derive(Debug)]
pub struct Doorbell {
    listener: Erased<Listener<ipc::Service>>,
    signals: UnixStream,
    /// The own end of wakers, once one was asked for.
    wakers: Option<(UnixStream, UnixStream)>,
}

/// Wakes a process from another of its threads.
#[derive(Debug)]
pub struct Waker(UnixStream);

impl Waker {
    /// Ends the wait, or the next one.
    pub fn wake(&self) {
        // A full pipe wakes, too.
        let _ = (&self.0).write(&[0]);
    }
}

impl Doorbell {
    /// Opens the doorbell of the peer's role; `signals` becomes readable on a signal and never
    /// blocks.
    ///
    /// # Errors
    /// [`StartError::System`] when the doorbell is not there or taken twice.
    pub fn open(peer: &Peer, signals: UnixStream) -> Result<Self, StartError> {
        Ok(Self {
            listener: listener(peer, peer.role())?,
            signals,
            wakers: None,
        })
    }

    /// What wakes it from another thread.
    ///
    /// # Errors
    /// What the system says.
    pub fn waker(&mut self) -> std::io::Result<Waker> {
        if self.wakers.is_none() {
            let (own, other) = UnixStream::pair()?;
            own.set_nonblocking(true)?;
            other.set_nonblocking(true)?;
            self.wakers = Some((own, other));
        }
        let other = self.wakers.as_ref().map(|(_, other)| other.try_clone());
        other
            .unwrap_or_else(|| Err(ErrorKind::NotConnected.into()))
            .map(Waker)
    }

    /// Sleeps until a ring, a signal, a waker or `deadline_ns` of the monotonic clock; says what rang.
    #[allow(clippy::must_use_candidate, reason = "one may wait for the time alone")]
    pub fn wait(&self, deadline_ns: u64) -> Rung {
        let left_ns = deadline_ns.saturating_sub(now_ns()).min(WAKE_AT_LEAST_NS);
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: i64::try_from(left_ns).unwrap_or(0),
        };
        {
            let bell = descriptor(&self.listener);
            let own = self.wakers.as_ref().map_or(&self.signals, |(own, _)| own);
            let mut descriptors = [
                PollFd::new(&bell, PollFlags::IN),
                PollFd::from_borrowed_fd(self.signals.as_fd(), PollFlags::IN),
                PollFd::from_borrowed_fd(own.as_fd(), PollFlags::IN),
            ];
            let n = if self.wakers.is_some() { 3 } else { 2 };
            // An interrupted wait is a wake like any other.
            let _ = poll(&mut descriptors[..n], Some(&timeout));
        }
        // The meaning of a signal is in its flag; its byte was only there to wake.
        drain(&self.signals);
        if let Some((own, _)) = &self.wakers {
            drain(own);
        }
        rung(&self.listener)
    }
}

/// Opens the doorbell of `role`.
fn listener(peer: &Peer, role: Role) -> Result<Erased<Listener<ipc::Service>>, StartError> {
    let name = role.doorbell();
    let failed =
        |error: &dyn core::fmt::Display| StartError::system(format!("opening {name}"), error);
    let listener = peer
        .node()
        .service_builder(&service_name(&name)?)
        .event()
        .open()
        .map_err(|error| failed(&error))?
        .listener_builder()
        .create()
        .map_err(|error| failed(&error))?;
    Ok(Erased::new(listener))
}

/// What rang since the last call.
fn rung(listener: &Listener<ipc::Service>) -> Rung {
    let mut rung = Rung::default();
    let _ = listener.try_wait(|event| {
        let id = event.id.as_value();
        if id < 64 {
            rung.0 |= 1 << id;
        }
    });
    rung
}

#[allow(
    unsafe_code,
    reason = "the middleware hands out its descriptor as a bare number only"
)]
fn descriptor(listener: &Listener<ipc::Service>) -> BorrowedFd<'_> {
    // SAFETY: the listener owns the descriptor and keeps it open and unchanged for as long as
    // it lives; the borrow ends before the listener can be dropped, and nothing closes it.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

/// The doorbells of seats that are filled on another host, heard by who carries the rings there.
#[derive(Debug)]
pub struct Overheard {
    listeners: Vec<(Role, Erased<Listener<ipc::Service>>)>,
    own: UnixStream,
    waker: Waker,
}

impl Overheard {
    /// Opens the doorbells of `roles`.
    ///
    /// # Errors
    /// As [`Doorbell::open`].
    pub fn open(peer: &Peer, roles: &[Role]) -> Result<Self, StartError> {
        let failed = |error| StartError::system("making a waker", error);
        let (own, other) = UnixStream::pair().map_err(failed)?;
        for end in [&own, &other] {
            end.set_nonblocking(true).map_err(failed)?;
        }
        let listeners = roles.iter().map(|role| Ok((*role, listener(peer, *role)?)));
        Ok(Self {
            listeners: listeners.collect::<Result<_, StartError>>()?,
            own,
            waker: Waker(other),
        })
    }

    /// What ends the wait from another thread.
    ///
    /// # Errors
    /// What the system says.
    pub fn waker(&self) -> std::io::Result<Waker> {
        self.waker.0.try_clone().map(Waker)
    }

    /// Sleeps until somebody rings, a waker, or for `at_most`; says who was rung for what.
    #[must_use]
    pub fn wait(&self, at_most: core::time::Duration) -> Vec<(Role, Rung)> {
        let timeout = Timespec {
            tv_sec: at_most.as_secs().cast_signed(),
            tv_nsec: i64::from(at_most.subsec_nanos()),
        };
        {
            let bells: Vec<BorrowedFd<'_>> =
                (self.listeners.iter().map(|(_, bell)| descriptor(bell))).collect();
            let mut looks: Vec<PollFd<'_>> = bells
                .iter()
                .map(|bell| PollFd::new(bell, PollFlags::IN))
                .collect();
            looks.push(PollFd::new(&self.own, PollFlags::IN));
            let _ = poll(&mut looks, Some(&timeout));
        }
        drain(&self.own);
        let all = self
            .listeners
            .iter()
            .map(|(role, bell)| (*role, rung(bell)));
        all.filter(|(_, rung)| rung.0 != 0).collect()
    }
}

/// Takes out what has come.
fn drain(mut pipe: &UnixStream) {
    let mut bytes = [0; 64];
    while pipe.read(&mut bytes).is_ok_and(|n| n == bytes.len()) {}
}

/// The doorbells of the others.
#[derive(Debug)]
pub struct Bells {
    notifiers: Vec<(Role, Erased<Notifier<ipc::Service>>)>,
}

impl Bells {
    /// Opens the doorbells of all services but the peer's own.
    ///
    /// # Errors
    /// [`StartError::Full`] or [`StartError::System`] naming the doorbell.
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        let mut notifiers = Vec::new();
        for role in Role::SERVICES {
            if role == peer.role() {
                continue;
            }
            let name = role.doorbell();
            let failed = |error: &dyn core::fmt::Display| {
                StartError::system(format!("opening {name}"), error)
            };
            let full = |places: usize| StartError::Full {
                what: format!("opening {name}"),
                places,
            };
            let notifier = peer
                .node()
                .service_builder(&service_name(&name)?)
                .event()
                .open()
                .map_err(|error| match error {
                    EventOpenError::ExceedsMaxNumberOfNodes => full(NODES_MAX),
                    error => failed(&error),
                })?
                .notifier_builder()
                .create()
                .map_err(|error| match error {
                    NotifierCreateError::ExceedsMaxSupportedNotifiers => full(RINGERS_MAX),
                    error => failed(&error),
                })?;
            notifiers.push((role, Erased::new(notifier)));
        }
        Ok(Self { notifiers })
    }

    /// Rings `role` with `event`. A role without a listener is no error.
    pub fn ring(&self, role: Role, event: usize) {
        if let Some((_, notifier)) = self.notifiers.iter().find(|(other, _)| *other == role) {
            let _ = notifier.notify_with_custom_event_id(EventId::new(event));
        }
    }
}
