//! Messages that are lost, late or corrupted on purpose, over real shared memory.

use super::support::House;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{
    RunClock, RunControl, RunMode, SHARE_ALL, Seat, TOPIC_FAULTS_MAX, TopicFault, TopicFaultKind,
};
use zeronav_msgs::topics::{ControlRequest, RobotOdometry, Topic};
use zeronav_shell::{Draft, Input, Roster};

/// What the guard reads, with one topic disturbed.
fn roster(fault: TopicFault, mode: RunMode) -> Roster {
    let seat = |role: Role| Seat {
        role: role.code(),
        epoch: 1,
        ..Seat::default()
    };
    let mut topic_faults = [TopicFault::default(); TOPIC_FAULTS_MAX];
    topic_faults[1] = fault;
    Roster {
        clock: RunClock {
            mode: mode.code(),
            ..RunClock::default()
        },
        control: RunControl {
            topic_faults,
            ..RunControl::default()
        },
        seats: Role::SERVICES.map(seat).to_vec(),
        own: Some((Role::CollisionGuard, 1)),
        woken_ns: 1_000,
    }
}

fn fault<T: Topic>(kind: TopicFaultKind, share: u32, delay_us: u32) -> TopicFault {
    TopicFault {
        topic: u16::try_from(T::ROW.number).expect("a small number"),
        kind: kind.code(),
        share,
        delay_us,
        seed: 5,
    }
}

fn request(v_mps: f64) -> VelocityRequest {
    VelocityRequest {
        v_mps,
        validity: Validity::Drive.code(),
        ..VelocityRequest::default()
    }
}

#[test]
fn a_share_of_the_messages_is_lost_in_real_time_and_none_in_lockstep() {
    let house = House::new();
    let (robot, guard) = (
        house.join(Role::Robot, 1),
        house.join(Role::CollisionGuard, 1),
    );
    for (mode, range) in [
        (RunMode::RealTime, 150..=250),
        (RunMode::Lockstep, 400..=400),
    ] {
        let mut writer = robot.writer::<RobotOdometry>(1).expect("a writer");
        let mut reader = guard.stream::<RobotOdometry>().expect("a reader");
        let roster = roster(
            fault::<RobotOdometry>(TopicFaultKind::Drop, SHARE_ALL / 2, 0),
            mode,
        );
        let mut heard = 0;
        for tick in 1..=400 {
            let draft = Draft {
                tick,
                ..Draft::default()
            };
            writer
                .publish(&draft, Odometry::default(), &[])
                .expect("sent");
            reader.drain(&roster, |_| heard += 1);
        }
        assert!(range.contains(&heard), "{mode}: {heard} of 400");
        assert_eq!(reader.refused(), 0, "what is lost is not rejected");
    }
}

#[test]
fn late_messages_arrive_in_order_after_the_delay_and_at_once_when_it_ends() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 1);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut writer = planner.writer::<ControlRequest>(1).expect("a writer");
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    let late = fault::<ControlRequest>(TopicFaultKind::Delay, 0, 50);
    let mut roster = roster(late, RunMode::RealTime);
    let mut send = |v_mps| {
        let sent = writer.publish(&Draft::default(), request(v_mps), &[]);
        sent.expect("sent");
    };
    // The copies wait outside the two places that a reader has.
    for n in 0..5 {
        send(0.1 * f64::from(n));
        roster.woken_ns += 10_000;
        assert!(!reader.poll(&roster), "after {n} messages");
    }
    roster.woken_ns += 10_000;
    assert!(reader.poll(&roster));
    let v_mps = |reader: &zeronav_shell::Latest<ControlRequest>| {
        reader.get().expect("a request").meta.v_mps
    };
    assert!(v_mps(&reader).abs() < 1e-12, "the oldest first");
    roster.woken_ns += 30_000;
    assert!(reader.poll(&roster));
    assert!((v_mps(&reader) - 0.3).abs() < 1e-12, "{}", v_mps(&reader));
    roster.control.topic_faults = [TopicFault::default(); TOPIC_FAULTS_MAX];
    assert!(reader.poll(&roster));
    assert!((v_mps(&reader) - 0.4).abs() < 1e-12);
    send(0.7);
    assert!(reader.poll(&roster));
    assert!((v_mps(&reader) - 0.7).abs() < 1e-12);
}

#[test]
fn every_flipped_bit_is_rejected_and_the_memory_is_as_it_was() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 1);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut writer = planner.writer::<ControlRequest>(1).expect("a writer");
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    let mut other = guard.latest::<ControlRequest>().expect("another reader");
    let roster_of = |fault| roster(fault, RunMode::RealTime);
    let corrupt = roster_of(fault::<ControlRequest>(
        TopicFaultKind::Corrupt,
        SHARE_ALL,
        0,
    ));
    let earnest = roster_of(TopicFault::default());
    for _ in 0..500 {
        writer
            .publish(&Draft::default(), request(0.5), &[])
            .expect("sent");
        assert!(!reader.poll(&corrupt));
        assert!(other.poll(&earnest));
        assert_eq!(*other.get().expect("a request").meta, request(0.5));
    }
    assert_eq!((reader.refused(), other.refused()), (500, 0));
    assert_eq!(reader.spoken_tick(), 0, "a broken header names no tick");
}
