//! The process: its flags, its two threads, and its end.

use crate::access::Access;
use crate::act;
use crate::feed::Feed;
use crate::handover::Handover;
use crate::server::{self, Shared};
use crate::tap::Tap;
use clap::Parser;
use std::io::{BufRead, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_shell::error::EXIT_USAGE;
use zeronav_shell::folder::Folder;
use zeronav_shell::{Domain, Peer, StartError, logs, printable, signals};

/// Port that is tried first when none is named.
const PORT: u16 = 8090;

/// Guests are not restarted.
const EPOCH: u32 = 1;

/// How much lower than that of the stack the priority of this process is.
const NICER: i32 = 5;

/// Longest link that is read. [bytes]
const LINK_BYTES_MAX: u64 = 256;

/// How long launch may take to say which scenario runs.
const NAME_LIMIT: Duration = Duration::from_secs(2);

/// How long clients may take to hear that the run is over.
const FAREWELL: Duration = Duration::from_millis(250);

/// A live page of a running stack; normally started by `zeronav view` or `zeronav run`.
#[derive(Debug, Parser)]
#[command(name = "zeronav-viewer", version)]
struct Arguments {
    /// Root folder of the run, directly under /dev/shm.
    #[arg(long, value_name = "ROOT")]
    domain: PathBuf,
    /// Port of the page on 127.0.0.1; without, 8090, or any that is free.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    /// Open the page in a browser.
    #[arg(long)]
    open: bool,
    /// Let every user of this machine look at the run, and nobody change anything from the page.
    #[arg(long)]
    view_only: bool,
    /// Serve the page under the link of a viewer that was there before, a line on standard input, where its
    /// port is free.
    #[arg(long, conflicts_with_all = ["port", "view_only"])]
    come_back: bool,
}

/// Joins a run, serves its page and ends with it.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(EXIT_USAGE));
        }
    };
    logs::quiet_middleware();
    match view(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&error.to_string());
            error.exit_code()
        }
    }
}

fn view(arguments: &Arguments) -> Result<(), StartError> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in signals::stopping() {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| StartError::system("catching signals", error))?;
    }
    // The stack comes first. Where the system does not allow even that, it goes on as it is.
    let _ = rustix::process::nice(NICER);
    let (listener, access) = open_page(arguments)?;
    let link = access.link();
    let root = arguments.domain.clone();
    let peer = Peer::join(Domain::join(&root)?, Role::Tap, EPOCH)?;
    let opened = || Folder::open(&root).map_err(|error| StartError::system("the domain", error));
    let feed = Arc::new(Feed::new());
    let mut tap = Tap::open(&peer, scenario(&opened()?))?;
    let shared = Shared::new(Arc::clone(&feed), access, opened()?);
    start_server(listener, shared)?;
    if arguments.view_only {
        complain("--view-only: every user of this machine can look at this run, without a token");
    }
    let _ = writeln!(std::io::stdout(), "{link}");
    let _ = std::io::stdout().flush();
    let mut handover = None;
    if arguments.open {
        match Handover::begin(&opened()?, &link) {
            Ok(begun) => handover = Some(begun),
            Err(why) => complain(&format!("{why}; open the link by hand")),
        }
    }
    tap.run(&peer, &feed, || {
        handover.take_if(|handover| handover.is_over(feed.watchers() > 0));
        stop.load(Ordering::Relaxed) || peer.domain().is_orphaned()
    });
    feed.end();
    let began = Instant::now();
    while feed.watchers() > 0 && began.elapsed() < FAREWELL {
        std::thread::sleep(Duration::from_millis(5));
    }
    drop(tap);
    // Of a run that is over, launch removes what this cannot.
    let _ = peer.leave().close();
    Ok(())
}

/// The port, and who may do what there.
fn open_page(arguments: &Arguments) -> Result<(TcpListener, Access), StartError> {
    if let Some(link) = arguments.come_back.then(link_before).flatten()
        && let Some(access) = Access::of_link(&link)
        && let Ok(listener) = bind(Some(access.port()))
    {
        return Ok((listener, access));
    }
    let listener = bind(arguments.port)?;
    let port = listener
        .local_addr()
        .map_err(|error| StartError::system("the port", error))?;
    let access = Access::new(port.port(), arguments.view_only)
        .map_err(|error| StartError::system("making a token", error))?;
    Ok((listener, access))
}

/// The link of the viewer before, from standard input.
fn link_before() -> Option<String> {
    let mut line = String::new();
    let mut input = std::io::stdin().lock().take(LINK_BYTES_MAX);
    input.read_line(&mut line).ok()?;
    Some(line.trim().to_owned())
}

/// The port that was asked for; without, the usual one or any.
fn bind(port: Option<u16>) -> Result<TcpListener, StartError> {
    let bind = |port| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let bound = match port {
        Some(port) => bind(port).map_err(|error| match error.kind() {
            ErrorKind::AddrInUse => StartError::Usage(format!(
                "--port {port}: taken by another process; name another one, or none for any"
            )),
            _ => StartError::Usage(format!("--port {port}: {error}")),
        })?,
        None => bind(PORT)
            .or_else(|_| bind(0))
            .map_err(|error| StartError::system("opening a port on 127.0.0.1", error))?,
    };
    bound
        .set_nonblocking(true)
        .map_err(|error| StartError::system("the port", error))?;
    Ok(bound)
}

/// Name of the scenario that runs; empty when launch does not say.
fn scenario(folder: &Folder) -> String {
    let began = Instant::now();
    loop {
        if let Some(report) = act::report(folder) {
            return report["scenario"].as_str().unwrap_or("").to_owned();
        }
        if began.elapsed() > NAME_LIMIT {
            return String::new();
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Serves on a thread of its own: whatever clients do, the stack is read on.
fn start_server(listener: TcpListener, shared: Shared) -> Result<(), StartError> {
    let failed = |error| StartError::system("starting the server", error);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_io()
        .enable_time()
        .max_blocking_threads(8)
        .build()
        .map_err(failed)?;
    let serve = move || {
        runtime.block_on(async {
            match tokio::net::TcpListener::from_std(listener) {
                Ok(listener) => server::serve(listener, Arc::new(shared)).await,
                Err(error) => tracing::error!(%error, "the port cannot be served"),
            }
        });
    };
    let started = std::thread::Builder::new()
        .name("server".to_owned())
        .spawn(serve);
    started.map(|_| ()).map_err(failed)
}

fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "zeronav-viewer: {}", printable(text));
}
