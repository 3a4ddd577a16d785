//! A reader that joins a long run gets data on every topic: latched ones at once, the others with
//! the next message.

use std::path::PathBuf;
use std::time::{Duration, Instant};
use zeronav_msgs::header::Id;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{
    Discipline, PlanRequests, RobotDescription, SimPlacement, TaskPose, Topic, TopicRow,
    TopicVisitor, topics, visit_topics,
};
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Peer, Roster, StartError};
use zeronav_tests::{Zeronav, leftovers};

/// How much run time passes before anybody joins. [s]
const LATE_S: f64 = 15.0;

/// Most wall time until the last message of a latched topic is there: its writer wakes every
/// 50 ms at least, on a loaded machine later.
const AT_ONCE: Duration = Duration::from_secs(20);

/// Up and down an aisle for longer than that. Mapping is told what moves, so that the simulator
/// says it.
fn scenario() -> String {
    let goals = (0..8).map(|leg| {
        let x_m = if leg % 2 == 0 { 12.5 } else { 5.0 };
        format!("[[goals]]\npose = [{x_m}, 6.425, 0.0]\nyaw_tolerance_rad = 3.15\n")
    });
    "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\nstart = [4.0, 6.425, 0.0]\n\
     [run]\ntime_limit_s = 1000.0\n[foresight]\nperceive = \"truth\"\n\
     [[zones]]\nname = \"far\"\nkind = \"keepout\"\npolygon = [[20.0, 17.0], [21.0, 17.0], [20.0, 18.0]]\n"
        .to_owned()
        + &goals.collect::<String>()
}

/// Looks once; the identity of what came, [`Id::NONE`] for a record.
type Look = Box<dyn FnMut(&Roster) -> Option<Id>>;

/// A reader of every topic, made when it is visited.
struct Readers<'a> {
    peer: &'a Peer,
    all: Vec<(&'static TopicRow, Look)>,
}

impl TopicVisitor for Readers<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        let mut stream = self.peer.stream_on::<T>(row)?;
        let look = move |roster: &Roster| stream.take(roster, |view| view.header.id());
        self.all.push((row, Box::new(look)));
        Ok(())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        let mut spans = self.peer.span_reader()?;
        let look = move |_: &Roster| spans.take().map(|_| Id::NONE);
        self.all.push((row, Box::new(look)));
        Ok(())
    }
}

/// No plan is asked for while there is one, only trials place obstacles, and no client says where
/// the robot is.
fn is_silent(row: &TopicRow) -> bool {
    let silent = [PlanRequests::ROW, SimPlacement::ROW, TaskPose::ROW];
    silent.iter().any(|silent| silent.name == row.name)
}

#[test]
fn readers_that_join_late_get_data_on_every_topic() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), scenario()).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let mut run = Zeronav::start_in(folder, &arguments);
    run.wait_until("it is late", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"]
            .as_f64()
            .is_some_and(|time_s| time_s > LATE_S)
    });
    let root = run.domains().pop().expect("a domain");

    let peer = Peer::join(Domain::join(&root).expect("the domain"), Role::Tap, 1);
    let peer = peer.expect("a place");
    let mut roster = RosterReader::open(&peer).expect("the roster");
    roster.await_known().expect("the roster, which is latched");
    let mut readers = Readers {
        peer: &peer,
        all: Vec::new(),
    };
    visit_topics(&mut readers).expect("a place on every topic");
    let mut left = readers.all;
    assert_eq!(left.len(), topics().len());
    left.retain(|(row, _)| !is_silent(row));
    let joined = Instant::now();
    while !left.is_empty() {
        roster.poll();
        left.retain_mut(|(row, look)| {
            let came = look(roster.roster());
            if let Some(id) = came
                && row.name == RobotDescription::ROW.name
            {
                assert_eq!(id, Id::new(1, 1), "sent once, at the start");
            }
            came.is_none()
        });
        let waits: Vec<&str> = left.iter().map(|(row, _)| row.name).collect();
        assert!(
            !run.has_ended(),
            "the run ended before data came on {waits:?}"
        );
        let latched = |(row, _): &(&TopicRow, Look)| row.discipline == Discipline::Latched;
        let is_late = joined.elapsed() > AT_ONCE && left.iter().any(latched);
        assert!(!is_late, "no last message on {waits:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    drop((left, roster));
    let _ = peer.leave().close();
    run.signal(rustix::process::Signal::INT);
    let _ = run.finish();
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}
