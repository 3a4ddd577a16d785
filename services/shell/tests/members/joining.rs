//! The members of a domain: joining and leaving, the seats, the doorbells.

use super::support::House;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::io::Write;
use std::os::unix::net::UnixStream;
use zeronav_msgs::header::SHADOW_EPOCH_MIN;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::topics::MapUpdate;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::{Bells, Doorbell, Rung};
use zeronav_shell::seat::{SeatLock, is_taken, shadow_epoch};
use zeronav_shell::{Domain, StartError, domain};

const SECOND_NS: u64 = 1_000_000_000;

#[test]
fn of_several_rings_none_is_lost() {
    let house = House::new();
    let mapping = house.join(Role::Mapping, 1);
    let robot = house.join(Role::Robot, 1);
    let (signals, mut signal) = UnixStream::pair().expect("a pair");
    signals.set_nonblocking(true).expect("a flag");
    let bell = Doorbell::open(&mapping, signals).expect("the doorbell");
    let bells = Bells::open(&robot).expect("the doorbells");
    for event in [3, 40, 7] {
        bells.ring(Role::Mapping, event);
    }
    let rung = bell.wait(now_ns() + SECOND_NS);
    for event in [3, 7, 40] {
        assert!(rung.has(event), "event {event} is lost: {rung:?}");
    }
    assert!(!rung.has(4));
    assert_eq!(bell.wait(0), Rung::default(), "a ring is heard once");
    // A signal wakes, and once.
    signal.write_all(&[0]).expect("written");
    let (began_ns, pause_ns) = (now_ns(), 20_000_000);
    bell.wait(began_ns + pause_ns);
    assert!(now_ns() < began_ns + pause_ns, "the signal did not wake");
    let began_ns = now_ns();
    bell.wait(began_ns + pause_ns);
    assert!(now_ns() >= began_ns + pause_ns, "the signal woke twice");
}

#[test]
fn a_seat_is_taken_once_and_free_again_when_its_owner_has_gone() {
    let house = House::new();
    let root = house.root();
    let domain = || Domain::join(&root).expect("the domain");
    let guard = Role::CollisionGuard;
    assert!(!is_taken(domain().folder(), guard));
    assert!(SeatLock::handed_over(&domain(), guard).is_none());
    let seat = SeatLock::take(&domain(), guard).expect("a free seat");
    assert!(!seat.is_from_launch() && is_taken(domain().folder(), guard));
    let error = SeatLock::take(&domain(), guard).expect_err("it is taken");
    assert!(matches!(error, StartError::Usage(_)), "{error}");
    let owner = format!("taken by process {};", std::process::id());
    assert!(error.to_string().contains(&owner), "{error}");
    // Other seats are others' business; a descriptor in a child's hands holds the seat, too.
    SeatLock::take(&domain(), Role::Mapping).expect("a free seat");
    let mut child = std::process::Command::new("sleep")
        .arg("60")
        .stdin(seat.for_child().expect("a descriptor"))
        .spawn()
        .expect("a child");
    drop(seat);
    assert!(is_taken(domain().folder(), guard), "the child holds it");
    child.kill().expect("it is there");
    child.wait().expect("its end");
    assert!(!is_taken(domain().folder(), guard));
    SeatLock::take(&domain(), guard).expect("free again");
}

#[test]
fn what_a_shadow_did_is_recorded_nowhere() {
    let house = House::new();
    let tap = house.join(Role::Tap, 1);
    let mut reader = tap.span_reader().expect("a reader");
    let mut writer = tap.span_writer().expect("a writer");
    assert!(shadow_epoch() >= SHADOW_EPOCH_MIN);
    for epoch in [1, SHADOW_EPOCH_MIN - 1, shadow_epoch(), SHADOW_EPOCH_MIN] {
        writer.write(Span {
            role: Role::CollisionGuard.code(),
            kind: SpanKind::Answer.code(),
            epoch,
            tick: 1,
            ..Span::default()
        });
    }
    let mut epochs = Vec::new();
    reader.drain(|span| epochs.push(span.epoch));
    assert_eq!(epochs, [1, SHADOW_EPOCH_MIN - 1]);
}

#[test]
fn a_live_domain_is_left_alone_and_a_dead_one_is_removed() {
    let house = House::new();
    let root = house.root();
    assert!(
        !domain::sweep(&root).expect("a look"),
        "a live domain was removed"
    );
    assert!(domain::all().contains(&root));
    assert!(root.is_dir());

    // A folder whose members are all gone, as after a kill -9 of everybody.
    let dead = Domain::create().expect("a domain");
    let dead_root = dead.root().to_owned();
    let segment = format!("{}_segment.data", dead_root.display());
    std::fs::write(&segment, b"left behind").expect("written");
    drop(dead);
    assert!(domain::sweep(&dead_root).expect("a look"));
    assert!(!dead_root.exists() && !std::path::Path::new(&segment).exists());
}

#[test]
fn members_see_that_whoever_made_the_domain_is_gone() {
    let launch = Domain::create().expect("a domain");
    let root = launch.root().to_owned();
    let [one, other] = [0, 1].map(|_| Domain::join(&root).expect("the domain"));
    for member in [&launch, &one, &other] {
        assert!(!member.is_orphaned());
    }
    drop(launch);
    for member in [&one, &other, &one] {
        assert!(member.is_orphaned());
    }
    assert!(!one.close().expect("a look"), "one is left");
    assert!(other.close().expect("a look"), "the last takes it away");
    assert!(!root.exists());
}

#[test]
fn folders_that_are_no_domain_are_refused() {
    for root in [
        "/tmp",
        "/dev/shm/zn_nobody_is_here_",
        "/dev/shm",
        "relative",
    ] {
        let error = Domain::join(std::path::Path::new(root)).expect_err("no domain");
        assert!(matches!(error, StartError::Usage(_)), "{root}: {error}");
    }
}

#[test]
fn domains_are_made_while_others_sweep() {
    let done = std::sync::atomic::AtomicBool::new(false);
    let relaxed = std::sync::atomic::Ordering::Relaxed;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(relaxed) {
                let _ = domain::sweep_dead();
            }
        });
        let made: Vec<_> = (0..200)
            .map(|_| {
                let domain = Domain::create().map_err(|error| error.to_string())?;
                let root = domain.root().to_owned();
                let closed = domain.close().map_err(|error| error.to_string())?;
                (closed && !root.exists())
                    .then_some(())
                    .ok_or_else(|| format!("{} is left", root.display()))
            })
            .collect();
        done.store(true, relaxed);
        for result in made {
            result.expect("made, and gone when its last member left");
        }
    });
}

#[test]
fn no_file_of_a_domain_is_open_to_other_users() {
    use std::os::unix::fs::MetadataExt;
    let house = House::new();
    let _writer = house.join(Role::Mapping, 1).writer::<MapUpdate>(4);
    let root = house.root();
    let folder = std::fs::symlink_metadata(&root).expect("the root folder");
    assert_eq!(folder.mode() & 0o7777, 0o700);
    let name = root.file_name().and_then(|name| name.to_str());
    let name = name.expect("a name").to_owned() + "_";
    let (mut files, mut counters) = (0, 0);
    for entry in std::fs::read_dir("/dev/shm")
        .expect("it is there")
        .flatten()
    {
        let file = entry.file_name().into_string().unwrap_or_default();
        let Ok(metadata) = entry.metadata() else {
            continue;
        };
        if file.starts_with(&name) {
            let mode = metadata.mode() & 0o7777;
            assert_eq!(mode & 0o077, 0, "{file} has mode {mode:04o}");
            counters += usize::from(file.ends_with(".global_mgmt"));
            files += 1;
        }
    }
    assert!(files > 20, "{files} files");
    assert_eq!(counters, 1, "the middleware made a counter of its own");
}

#[test]
fn a_corrupt_counter_of_nodes_is_named_and_not_waited_for() {
    let domain = Domain::create().expect("a domain");
    let entries = std::fs::read_dir("/dev/shm")
        .expect("it is there")
        .flatten();
    let counter = entries.map(|entry| entry.path()).find(|path| {
        let path = path.to_string_lossy();
        path.contains(domain.prefix()) && path.ends_with(".global_mgmt")
    });
    let counter = std::fs::File::options()
        .write(true)
        .open(counter.expect("a counter"));
    counter.expect("it is ours").set_len(0).expect("cut");
    let error = Domain::join(domain.root()).expect_err("it is corrupt");
    assert!(error.to_string().contains("counter of nodes"), "{error}");
    assert!(domain.close().expect("closed"));
}

/// The middleware says no more than that something has failed.
#[test]
fn an_error_of_the_middleware_names_what_the_system_is_short_of() {
    let said = |why: &str| StartError::system("opening a topic", why).to_string();
    let own = getrlimit(Resource::As);
    // Far above what this process needs: only that there is a limit counts.
    let most = 1 << 46;
    let limited = Rlimit {
        current: Some(own.maximum.map_or(most, |maximum| maximum.min(most))),
        ..own
    };
    setrlimit(Resource::As, limited).expect("a soft limit");
    let (vague, clear) = (said("InternalFailure"), said("it does not exist"));
    setrlimit(Resource::As, own).expect("as it was");
    let hint = "; the address space is limited: see `ulimit -v`";
    assert_eq!(vague, format!("opening a topic: InternalFailure{hint}"));
    assert_eq!(clear, "opening a topic: it does not exist");
}
