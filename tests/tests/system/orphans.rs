//! Launch is killed while the robot drives: the robot comes to rest, and nothing is left.

use rustix::process::Signal;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{RobotCommand, RobotDescription, RobotOdometry};
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Latest, Peer, Stream};
use zeronav_tests::{
    Zeronav, await_by_itself, binaries, command, executable, is_alive, leftovers, real_time_turn,
    send_signal,
};

/// By then everything is over, on a busy machine, too. How long it took is printed.
const LIMIT: Duration = Duration::from_secs(30);

/// Speed at which launch is killed, and from which on the robot drives in earnest. [m/s]
const AT_SPEED_MPS: f64 = 0.45;
const DRIVING_MPS: f64 = 0.3;

/// A guest that reads what goes to the wheels and what comes from them.
struct Tap {
    roster: RosterReader,
    description: Latest<RobotDescription>,
    command: Stream<RobotCommand>,
    odometry: Stream<RobotOdometry>,
    commands: Vec<VelocityCommand>,
    track: Vec<Odometry>,
    peer: Peer,
}

impl Tap {
    fn on(root: &Path) -> Self {
        let domain = Domain::join(root).expect("the domain is there");
        let peer = Peer::join(domain, Role::Tap, 1).expect("guests are welcome");
        Self {
            roster: RosterReader::open(&peer).expect("the roster"),
            description: peer.latest().expect("the description"),
            command: peer.stream().expect("the commands"),
            odometry: peer.stream().expect("the odometry"),
            commands: Vec::new(),
            track: Vec::new(),
            peer,
        }
    }

    /// Leaves the domain, and removes it as its last member.
    fn leave(self) {
        let Self { peer, .. } = self;
        let _ = peer.leave().close();
    }

    fn listen(&mut self) {
        self.roster.poll();
        let roster = self.roster.roster();
        self.description.poll(roster);
        self.command
            .drain(roster, |view| self.commands.push(*view.meta));
        self.odometry
            .drain(roster, |view| self.track.push(*view.meta));
    }

    fn is_driving(&self) -> bool {
        self.track
            .last()
            .is_some_and(|last| last.v_mps > AT_SPEED_MPS)
    }
}

/// A run whose robot drives, and its services.
fn driving(tap: bool) -> (Zeronav, PathBuf, Vec<u32>, Option<Tap>) {
    let mut run = Zeronav::start(&["run", "open_aisle", "--headless", "--json"]);
    run.wait_until("every service runs", |run| run.children().len() == 5);
    let root = run.domains().pop().expect("a domain");
    let mut guest = Tap::on(&root);
    run.wait_until("the robot drives", |_| {
        guest.listen();
        guest.is_driving()
    });
    let children = run.children().into_iter().map(|(pid, _)| pid).collect();
    guest.commands.clear();
    guest.track.clear();
    if tap {
        return (run, root, children, Some(guest));
    }
    guest.leave();
    (run, root, children, None)
}

/// Listens until no service is left: how long that took.
fn until_all_are_gone(tap: &mut Tap, children: &[u32]) -> Duration {
    let started = Instant::now();
    while children.iter().any(|pid| is_alive(*pid)) {
        tap.listen();
        assert!(started.elapsed() < LIMIT, "services stay");
        std::thread::sleep(Duration::from_millis(2));
    }
    tap.listen();
    let took = started.elapsed();
    eprintln!("every service is gone after {took:?}");
    took
}

/// The robot was brought to rest within its limits, and told so until the end.
#[track_caller]
fn came_to_rest(tap: &Tap) {
    let robot = *tap.description.get().expect("the robot").meta;
    let track = &tap.track;
    assert!(track.len() > 10, "{} odometry messages", track.len());
    let from_mps = track[0].v_mps;
    assert!(from_mps > DRIVING_MPS, "it did not drive: {from_mps} m/s");
    for last in &track[track.len() - 5..] {
        assert!(
            last.v_mps.abs() < 0.02 && last.w_radps.abs() < 0.05,
            "{last:?}"
        );
    }
    // 50 Hz: no jump, it really braked.
    let most_mps = 1.05 * robot.brake_mps2.max(robot.a_mps2_max) * 0.02;
    for pair in track.windows(2) {
        assert!(
            (pair[1].v_mps - pair[0].v_mps).abs() <= most_mps,
            "{pair:?}"
        );
    }
}

#[test]
fn robot_stops_when_launch_is_killed() {
    let _turn = real_time_turn();
    let (run, _root, children, tap) = driving(true);
    let mut tap = tap.expect("a guest");
    run.signal(Signal::KILL);
    let took = until_all_are_gone(&mut tap, &children);
    assert!(took < LIMIT, "{took:?}");
    came_to_rest(&tap);
    // The guard itself ramped down to zero and said so until the end.
    let commands = &tap.commands;
    let last = commands.last().expect("commands");
    assert!(last.v_mps.abs() + last.w_radps.abs() < 1.0e-9, "{last:?}");
    let between = (commands.iter())
        .filter(|command| command.v_mps > 0.02 && command.v_mps < DRIVING_MPS)
        .count();
    assert!(between >= 3, "no ramp: {commands:?}");
    tap.leave();
}

#[test]
fn nothing_is_left_after_launch_was_killed() {
    let _turn = real_time_turn();
    let (run, root, children, _) = driving(false);
    let started = Instant::now();
    run.signal(Signal::KILL);
    await_by_itself("every service is gone", || {
        !children.iter().any(|pid| is_alive(*pid))
    });
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
    assert!(started.elapsed() < LIMIT, "{:?}", started.elapsed());
}

/// A run whose mapping has started a daemon, which says its id in a file.
fn with_a_daemon() -> (Zeronav, u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let (script, said) = (folder.path().join("mapping"), folder.path().join("daemon"));
    let text = format!(
        "#!/bin/sh\nif [ \"$1\" = --domain ]; then\n  setsid sh -c 'echo $$ > {said}.new; mv {said}.new \
         {said}; exec sleep 600' > /dev/null 2>&1 < /dev/null &\nfi\nexec {mapping} \"$@\"\n",
        said = said.display(),
        mapping = binaries().join("zeronav-mapping").display()
    );
    executable(&script, &text);
    let text = format!(
        "base = [\"warehouse\", \"porter\"]\ntitle = \"daemon\"\nstart = [4.0, 6.425, 0.0]\n\
         [[goals]]\npose = [20.0, 6.425, 0.0]\n[services.mapping]\nbinary = \"{}\"\n",
        script.display()
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let mut run = Zeronav::start_in(folder, &["run", "./it.toml", "--headless", "--json"]);
    let mut daemon = None;
    run.wait_until("the daemon runs", |_| {
        let text = std::fs::read_to_string(&said).unwrap_or_default();
        daemon = text.trim().parse().ok();
        daemon.is_some()
    });
    (run, daemon.expect("its id"))
}

#[test]
fn what_a_service_has_started_ends_with_the_stack() {
    let _turn = real_time_turn();
    for signal in [Signal::INT, Signal::KILL] {
        let (run, daemon) = with_a_daemon();
        assert!(is_alive(daemon));
        run.signal(signal);
        await_by_itself("the daemon is gone", || !is_alive(daemon));
        drop(run);
    }
}

/// The folder in which launch asks the binaries for their configurations.
#[test]
fn the_folder_of_a_check_goes_with_a_launch_that_is_killed() {
    let place = tempfile::tempdir().expect("a folder");
    let (temporary, asked) = (place.path().join("tmp"), place.path().join("asked"));
    std::fs::create_dir(&temporary).expect("a folder");
    let script = place.path().join("mapping");
    let text = format!("#!/bin/sh\necho > {}\nexec sleep 600\n", asked.display());
    executable(&script, &text);
    let text = "base = [\"warehouse\", \"porter\"]\ntitle = \"asked\"\nstart = [4.0, 6.425, 0.0]\n\
                [services.mapping]\nbinary = \"./mapping\"\n";
    std::fs::write(place.path().join("it.toml"), text).expect("written");
    let mut launch = command()
        .args(["check", "./it.toml"])
        .current_dir(place.path())
        .env("TMPDIR", &temporary)
        .stdin(Stdio::null())
        .spawn()
        .expect("it starts");
    await_by_itself("a binary is asked", || asked.exists());
    let made = || std::fs::read_dir(&temporary).expect("it").flatten();
    let folder = made().next().expect("a folder").path();
    let mode = std::fs::metadata(&folder).expect("it").permissions().mode();
    assert_eq!(mode & 0o777, 0o700, "{}", folder.display());
    launch.kill().expect("it is there");
    launch.wait().expect("its end");
    await_by_itself("its folder is gone", || made().next().is_none());
}

/// The same of the folders of `contract`, in which a program is asked for its configuration first.
#[test]
fn the_folder_of_a_contract_goes_with_a_command_that_is_killed() {
    let place = tempfile::tempdir().expect("a folder");
    let (temporary, asked) = (place.path().join("tmp"), place.path().join("asked"));
    std::fs::create_dir(&temporary).expect("a folder");
    let script = place.path().join("mapping");
    let text = format!("#!/bin/sh\necho > {}\nexec sleep 600\n", asked.display());
    executable(&script, &text);
    let mut kit = command()
        .args(["contract", "mapping", "./mapping"])
        .current_dir(place.path())
        .env("TMPDIR", &temporary)
        .stdin(Stdio::null())
        .spawn()
        .expect("it starts");
    await_by_itself("the program is asked", || asked.exists());
    let made = || std::fs::read_dir(&temporary).expect("it").flatten();
    let folder = made().next().expect("a folder").path();
    let name = folder.file_name().expect("a name").to_string_lossy();
    assert!(name.starts_with("zeronav-contract-"), "{name}");
    kit.kill().expect("it is there");
    kit.wait().expect("its end");
    await_by_itself("its folder is gone", || made().next().is_none());
}

#[test]
fn robot_without_guard_stops_when_launch_is_killed() {
    let _turn = real_time_turn();
    let (run, _root, children, tap) = driving(true);
    let mut tap = tap.expect("a guest");
    let guard = run.service("collision_guard").expect("the guard");
    run.signal(Signal::STOP);
    assert!(send_signal(guard, Signal::KILL));
    run.signal(Signal::KILL);
    let took = until_all_are_gone(&mut tap, &children);
    assert!(took < LIMIT, "{took:?}");
    came_to_rest(&tap);
    tap.leave();
}

#[test]
fn hung_service_is_ended_when_launch_is_killed() {
    let _turn = real_time_turn();
    for role in ["collision_guard", "local_planner", "mapping", "robot"] {
        let (run, root, children, _) = driving(false);
        let hangs = run.service(role).expect("a service");
        let started = Instant::now();
        assert!(send_signal(hangs, Signal::STOP));
        run.signal(Signal::KILL);
        await_by_itself("every service is gone", || {
            !children.iter().any(|pid| is_alive(*pid))
        });
        await_by_itself("nothing is left", || leftovers(&root).is_empty());
        let took = started.elapsed();
        assert!(took < LIMIT, "{role}: {took:?}");
    }
}

#[test]
fn robot_with_a_hung_guard_stops_when_launch_is_killed() {
    let _turn = real_time_turn();
    let (run, _root, children, tap) = driving(true);
    let mut tap = tap.expect("a guest");
    let guard = run.service("collision_guard").expect("the guard");
    assert!(send_signal(guard, Signal::STOP));
    run.signal(Signal::KILL);
    let took = until_all_are_gone(&mut tap, &children);
    assert!(took < LIMIT, "{took:?}");
    came_to_rest(&tap);
    tap.leave();
}

#[test]
fn lockstep_processes_end_when_launch_is_killed() {
    let mut run = Zeronav::start(&["run", "unsealed", "--lockstep", "--headless", "--json"]);
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.2)
    });
    let root = run.domains().pop().expect("a domain");
    let children: Vec<u32> = run.children().into_iter().map(|(pid, _)| pid).collect();
    assert_eq!(children.len(), 5);
    let started = Instant::now();
    run.signal(Signal::KILL);
    await_by_itself("every service is gone", || {
        !children.iter().any(|pid| is_alive(*pid))
    });
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
    assert!(started.elapsed() < LIMIT, "{:?}", started.elapsed());
}

/// The domains of which a process has files open.
fn opened_domains(pid: u32) -> Vec<PathBuf> {
    let files = std::fs::read_dir(format!("/proc/{pid}/fd")).into_iter();
    let files = files.flatten().flatten();
    let paths = files.filter_map(|file| std::fs::read_link(file.path()).ok());
    let mut roots: Vec<PathBuf> = paths
        .filter_map(|path| {
            let inside = path.strip_prefix("/dev/shm").ok()?.iter().next()?;
            let is_domain = inside.to_str()?.starts_with("zn_");
            is_domain.then(|| Path::new("/dev/shm").join(inside))
        })
        .filter(|root| root.is_dir())
        .collect();
    roots.sort();
    roots.dedup();
    roots
}

/// The living processes whose temporary folder is `folder`.
fn with_temporary(folder: &Path) -> Vec<u32> {
    let entry = format!("TMPDIR={}", folder.display());
    let is_one = |pid: &u32| {
        let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        environment
            .split(|byte| *byte == 0)
            .any(|it| it == entry.as_bytes())
    };
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = processes.filter_map(|it| it.file_name().to_str()?.parse().ok());
    pids.filter(is_one).collect()
}

/// Launch is killed at any moment of its start, with and without a domain, services and a warden.
#[test]
fn nothing_is_left_of_a_launch_that_is_killed_while_it_starts() {
    for after_ms in [1, 3, 7, 12, 20, 30, 45, 65, 90, 120, 170, 240, 350, 500] {
        let temporary = tempfile::tempdir().expect("a folder");
        let mut launch = command()
            .args(["run", "open_aisle", "--lockstep", "--headless"])
            .current_dir(temporary.path())
            .env("TMPDIR", temporary.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        // The moment is what is tested.
        std::thread::sleep(Duration::from_millis(after_ms));
        let roots = opened_domains(launch.id());
        launch.kill().expect("it is there");
        launch.wait().expect("its end");
        await_by_itself("every process is gone", || {
            with_temporary(temporary.path()).is_empty()
        });
        await_by_itself("nothing is left", || {
            roots.iter().all(|root| leftovers(root).is_empty())
        });
        let left = || {
            let entries = std::fs::read_dir(temporary.path()).expect("it").flatten();
            let names = entries.map(|entry| entry.file_name());
            let temporary = names.filter(|name| name.to_string_lossy().starts_with("zeronav-"));
            temporary.collect::<Vec<_>>()
        };
        await_by_itself("no temporary folder is left", || left().is_empty());
        eprintln!("killed after {after_ms} ms: domains {roots:?}");
    }
}
