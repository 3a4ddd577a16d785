//! A service as a process: flags, exit codes, what it prints, how it leaves.
//!
//! This program is the service, too: `run` reads the flags of a whole process. Without a harness, as
//! the flags are not those of a test; a word selects the cases whose names contain it.

#![allow(clippy::print_stdout, reason = "what a test harness would print")]

use serde::{Deserialize, Serialize};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Output, Stdio};
use std::time::{Duration, Instant};
use zeronav_msgs::health::{Health, HealthState};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};
use zeronav_msgs::topics::{HealthTopic, RunClockTopic, RunControlTopic, health_of};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::peer::Topics;
use zeronav_shell::{
    Domain, Draft, Peer, Rates, Roster, Service, Shell, StartError, Stream, Writer, domain,
};

/// Set for the process that is the service: which of the two.
const SERVICE: &str = "ZERONAV_TEST_SERVICE";

/// When a case is given up. A bound for what hangs, no measure.
const HANGS: Duration = Duration::from_secs(60);

const GUARD: Role = Role::CollisionGuard;

/// A configuration with one value that can be refused.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Config {
    period_s: f64,
    crashes: bool,
}

/// A service that does nothing, and says nothing of itself.
struct Plain;

impl Service for Plain {
    const ROLE: Role = GUARD;
    type Config = Config;

    fn check(config: &Config) -> Result<(), StartError> {
        let is_right = config.period_s >= 0.0;
        is_right
            .then_some(())
            .ok_or_else(|| StartError::config("period_s", "must not be negative"))
    }

    fn check_rates(config: &Config, rates: Rates) -> Result<(), StartError> {
        let is_right = config.period_s <= rates.scan_s;
        is_right
            .then_some(())
            .ok_or_else(|| StartError::config("period_s", "must not exceed that of the scans"))
    }

    fn open(shell: &mut Shell, config: Config) -> Result<Self, StartError> {
        shell.ready();
        let crash = StartError::system("opening", "it is broken");
        (!config.crashes).then_some(Self).ok_or(crash)
    }

    fn wake(&mut self, _shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        Ok(())
    }
}

/// A service with an algorithm, which sees the robot at rest.
struct Resting;

impl Service for Resting {
    const ROLE: Role = GUARD;
    type Config = Config;

    fn algorithms() -> Vec<(&'static str, String)> {
        vec![("brake", "stops the robot".to_owned())]
    }

    fn open(shell: &mut Shell, _config: Config) -> Result<Self, StartError> {
        shell.ready();
        Ok(Self)
    }

    fn wake(&mut self, _shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        true
    }
}

/// Launch's side of a run with a guard.
struct Launch {
    clock: Writer<RunClockTopic>,
    control: Writer<RunControlTopic>,
    health: Stream<HealthTopic>,
    roster: Roster,
    _topics: Topics,
    peer: Peer,
}

impl Launch {
    fn new() -> Self {
        let peer = Peer::join(Domain::create().expect("a domain"), Role::Launch, 1);
        let peer = peer.expect("launch joins");
        let topics = peer.create_topics().expect("topics");
        let row = health_of(GUARD).expect("a row");
        let roster = Roster {
            clock: RunClock {
                mode: RunMode::RealTime.code(),
                tick_ns: 20_000_000,
                ..RunClock::default()
            },
            seats: vec![Seat {
                role: GUARD.code(),
                epoch: 1,
                ..Seat::default()
            }],
            ..Roster::default()
        };
        let mut launch = Self {
            clock: peer.writer(0).expect("a writer"),
            control: peer.writer(1).expect("a writer"),
            health: peer.stream_on(row).expect("a reader"),
            roster,
            _topics: topics,
            peer,
        };
        launch.say(0);
        launch
    }

    fn say(&mut self, stopping: u16) {
        let draft = Draft::default();
        let control = RunControl {
            n_seats: 1,
            stopping,
            ..RunControl::default()
        };
        let clock = self.clock.publish(&draft, self.roster.clock, &[]);
        let control = self.control.publish(&draft, control, &self.roster.seats);
        assert!(clock.is_some() && control.is_some());
    }
}

/// A run whose service is a process. Ends it and removes the domain, whatever happens.
struct Run {
    launch: Option<Launch>,
    root: PathBuf,
    child: Option<Child>,
}

impl Run {
    /// A run with this service, which is ready.
    fn of(service: &str) -> Self {
        let launch = Launch::new();
        let root = launch.peer.domain().root().to_owned();
        let mut run = Self {
            launch: Some(launch),
            root,
            child: None,
        };
        let mut command = command(service, &["--epoch", "1", "--domain"]);
        command.arg(&run.root);
        run.child = Some(command.spawn().expect("a process"));
        run.until(|health| health.state() == Some(HealthState::Ready));
        run
    }

    /// Waits for a heartbeat like that; launch wakes meanwhile.
    fn until(&mut self, is_it: impl Fn(&Health) -> bool) -> Health {
        let launch = self.launch.as_mut().expect("launch");
        let child = self.child.as_mut().expect("a process");
        let began = Instant::now();
        loop {
            launch.clock.refresh();
            launch.control.refresh();
            let mut found = None;
            launch.health.drain(&launch.roster, |view| {
                if is_it(view.meta) {
                    found = Some(*view.meta);
                }
            });
            if let Some(health) = found {
                return health;
            }
            let ended = child.try_wait().expect("a look");
            assert_eq!(ended, None, "the process ended");
            assert!(began.elapsed() < HANGS, "no such heartbeat");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn ask_to_stop(&self) {
        let child = self.child.as_ref().expect("a process");
        let pid = rustix::process::Pid::from_child(child);
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).expect("it runs");
    }

    /// What it said and how it ended.
    fn end(&mut self) -> Output {
        ended(self.child.take().expect("a process"))
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
        self.launch = None;
        let swept = domain::sweep(&self.root);
        assert!(
            matches!(swept, Ok(true)) || std::thread::panicking(),
            "{} is left: {swept:?}",
            self.root.display()
        );
    }
}

/// This program as a service.
fn command(service: &str, flags: &[&str]) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("its own path"));
    command
        .env(SERVICE, service)
        .args(flags)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Waits for the end of a process that says less than a pipe holds; one that hangs is killed.
fn ended(mut child: Child) -> Output {
    let began = Instant::now();
    while child.try_wait().expect("a look").is_none() {
        if began.elapsed() >= HANGS {
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    child.wait_with_output().expect("its output")
}

fn output(service: &str, flags: &[&str]) -> Output {
    ended(command(service, flags).spawn().expect("a process"))
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("text")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("text")
}

/// A process that ended by itself with this code.
#[track_caller]
fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.signal(), None, "{output:?}");
    assert_eq!(output.status.code(), Some(code), "{output:?}");
}

/// One line that is no event of a log.
#[track_caller]
fn assert_one_plain_line(text: &str) {
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(!text.contains("ERROR"), "{text}");
}

/// A file with this configuration.
fn configured(text: &str) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(&file, text).expect("written");
    file
}

fn of(path: &Path) -> &str {
    path.to_str().expect("a path of text")
}

fn wrong_flags_are_one_line_and_exit_code_2() {
    let output = output("plain", &["--epoch", "0", "--domain", "d"]);
    assert_code(&output, 2);
    assert_eq!(stdout(&output), "");
    let line = stderr(&output);
    assert_one_plain_line(&line);
    assert!(line.contains("--epoch"), "{line}");
}

fn help_is_printed_and_is_no_error() {
    let output = output("plain", &["--help"]);
    assert_code(&output, 0);
    assert!(stdout(&output).contains("--domain"), "{output:?}");
    assert_eq!(stderr(&output), "");
}

fn the_list_has_a_line_for_each_algorithm_and_none_without() {
    let resting = output("resting", &["--list"]);
    assert_code(&resting, 0);
    assert_eq!(stdout(&resting), "brake\tstops the robot\n");
    let plain = output("plain", &["--list"]);
    assert_code(&plain, 0);
    assert_eq!(stdout(&plain), "");
}

fn a_service_without_parameters_prints_an_empty_list() {
    let output = output("plain", &["--print-params"]);
    assert_code(&output, 0);
    assert_eq!(stdout(&output), "[]\n");
}

fn the_configuration_is_printed_as_it_would_be_used() {
    let file = configured("period_s = 0.5\n");
    let output = output("plain", &["--print-config", "--config", of(file.path())]);
    assert_code(&output, 0);
    assert_eq!(stdout(&output), "period_s = 0.5\ncrashes = false\n");
    assert_eq!(stderr(&output), "");
}

fn a_configuration_that_is_refused_is_one_line_when_it_is_to_be_printed() {
    let file = configured("period_s = -1.0\n");
    let output = output("plain", &["--print-config", "--config", of(file.path())]);
    assert_code(&output, 2);
    let line = stderr(&output);
    assert_one_plain_line(&line);
    assert!(line.contains("period_s: must not be negative"), "{line}");
}

fn a_configuration_is_held_against_the_rates_of_a_run() {
    let file = configured("period_s = 0.5\n");
    let print = |rates| {
        let path = of(file.path());
        output(
            "plain",
            &["--print-config", "--config", path, "--rates", rates],
        )
    };
    assert_code(&print("50,1"), 0);
    let refused = print("50,10");
    assert_code(&refused, 2);
    let line = stderr(&refused);
    assert!(line.contains("must not exceed that of the scans"), "{line}");
}

fn a_configuration_that_is_refused_at_the_start_is_an_event_of_the_log() {
    let file = configured("period_s = -1.0\n");
    let flags = ["--domain", "d", "--epoch", "1", "--config", of(file.path())];
    let output = output("plain", &flags);
    assert_code(&output, 2);
    let log = stderr(&output);
    assert!(log.contains("ERROR"), "{log}");
    assert!(log.contains("collision_guard"), "{log}");
    assert!(log.contains("period_s: must not be negative"), "{log}");
}

fn a_run_that_is_over_is_named_with_exit_code_2() {
    let root = "/dev/shm/zn_nobody_is_";
    let output = output("plain", &["--epoch", "1", "--domain", root]);
    assert_code(&output, 2);
    assert!(stderr(&output).contains("the run is over"), "{output:?}");
}

fn what_may_pass_ends_the_process_with_exit_code_1() {
    let launch = Launch::new();
    let root = launch.peer.domain().root().to_owned();
    let run = Run {
        launch: Some(launch),
        root,
        child: None,
    };
    let file = configured("crashes = true\n");
    let flags = [
        "--shadow",
        "--config",
        of(file.path()),
        "--domain",
        of(&run.root),
    ];
    let output = output("plain", &flags);
    assert_code(&output, 1);
    let log = stderr(&output);
    assert!(log.contains("opening: it is broken"), "{log}");
}

fn a_service_at_rest_leaves_when_it_is_asked_and_says_that_it_stops() {
    let mut run = Run::of("plain");
    run.launch.as_mut().expect("launch").say(1);
    run.ask_to_stop();
    let output = run.end();
    assert_code(&output, 0);
    let launch = run.launch.as_mut().expect("launch");
    let mut last = None;
    launch
        .health
        .drain(&launch.roster, |view| last = view.meta.state());
    assert_eq!(last, Some(HealthState::Stopping));
    assert!(run.root.exists(), "the run is launch's to remove");
}

fn a_service_without_work_wakes_at_its_period() {
    let mut run = Run::of("plain");
    // Read before and after what is counted: a slow machine makes the time longer, not the count
    // higher.
    let began = Instant::now();
    let first = run.until(|_| true);
    let last = run.until(|health| health.progress >= first.progress + 10);
    let wakes = u128::from(last.progress - first.progress);
    // At most one of the wakes had begun its pause before the clock was read.
    let pauses = wakes.saturating_sub(2);
    assert!(began.elapsed().as_millis() >= 50 * pauses, "{wakes} wakes");
    run.ask_to_stop();
    assert_code(&run.end(), 0);
}

fn the_last_service_of_a_run_without_launch_removes_it() {
    let mut run = Run::of("resting");
    run.launch = None;
    let output = run.end();
    assert_code(&output, 0);
    let log = stderr(&output);
    assert!(log.contains("launch is gone"), "{log}");
    assert!(!log.contains("did not come to rest"), "{log}");
    assert!(!run.root.exists(), "{} is left", run.root.display());
}

fn a_service_that_does_not_know_whether_the_robot_stopped_waits_for_it() {
    let mut run = Run::of("plain");
    run.launch = None;
    let output = run.end();
    assert_code(&output, 0);
    let log = stderr(&output);
    assert!(log.contains("did not come to rest in time"), "{log}");
    assert!(!run.root.exists(), "{} is left", run.root.display());
}

/// Every case once, by its name.
macro_rules! cases {
    ($($name:ident),* $(,)?) => {
        const CASES: &[(&str, fn())] = &[$((stringify!($name), $name)),*];
    };
}

cases! {
    wrong_flags_are_one_line_and_exit_code_2,
    help_is_printed_and_is_no_error,
    the_list_has_a_line_for_each_algorithm_and_none_without,
    a_service_without_parameters_prints_an_empty_list,
    the_configuration_is_printed_as_it_would_be_used,
    a_configuration_that_is_refused_is_one_line_when_it_is_to_be_printed,
    a_configuration_is_held_against_the_rates_of_a_run,
    a_configuration_that_is_refused_at_the_start_is_an_event_of_the_log,
    a_run_that_is_over_is_named_with_exit_code_2,
    what_may_pass_ends_the_process_with_exit_code_1,
    a_service_at_rest_leaves_when_it_is_asked_and_says_that_it_stops,
    a_service_without_work_wakes_at_its_period,
    the_last_service_of_a_run_without_launch_removes_it,
    a_service_that_does_not_know_whether_the_robot_stopped_waits_for_it,
}

fn main() -> ExitCode {
    match std::env::var(SERVICE).as_deref() {
        Ok("plain") => return zeronav_shell::run::<Plain>(),
        Ok("resting") => return zeronav_shell::run::<Resting>(),
        _ => {}
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    let takes_value =
        |word: &str| matches!(word, "--test-threads" | "--skip" | "--color" | "--format");
    let mut before = "";
    let filter = words.iter().find(|word| {
        let option = core::mem::replace(&mut before, word.as_str());
        !word.starts_with('-') && !takes_value(option)
    });
    let chosen = CASES
        .iter()
        .filter(|(name, _)| filter.is_none_or(|word| name.contains(word.as_str())));
    if words.iter().any(|word| word == "--list") {
        for (name, _) in chosen {
            println!("{name}: test");
        }
        return ExitCode::SUCCESS;
    }
    // One after the other: a process that another case has just forked holds this one's locks until it is
    // its own program. One that fails panics with its message, which ends the program.
    for (name, case) in chosen {
        case();
        println!("test {name} ... ok");
    }
    ExitCode::SUCCESS
}
