//! Random bytes at every decoder: no panic, and what is accepted is in range.

use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use std::cell::RefCell;
use std::collections::BTreeMap;
use zeronav_msgs::message::Wire;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Envelope, Topic, TopicRow, TopicVisitor, decode, seal, visit_topics};

/// Fixed fields that are plausible numbers as often as not, so that the deeper checks are met.
fn plausible(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed | 1;
    bytes
        .chunks(8)
        .flat_map(|chunk| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let word = match state >> 61 {
                0 => 0_u64.to_le_bytes(),
                1 => 1_u64.to_le_bytes(),
                2 => 1.0_f64.to_le_bytes(),
                3 => f64::NAN.to_le_bytes(),
                4 => 0x0001_0001_0001_0001_u64.to_le_bytes(),
                5 => 0x3d4c_cccd_3d4c_cccd_u64.to_le_bytes(), // twice 0.05 as f32
                _ => {
                    let mut word = [0; 8];
                    word[..chunk.len()].copy_from_slice(chunk);
                    word
                }
            };
            word[..chunk.len()].to_vec()
        })
        .collect()
}

struct Thrower<'a> {
    bytes: &'a [u8],
    len: usize,
    seed: u64,
    /// What was accepted, by topic.
    accepted: BTreeMap<&'static str, u64>,
}

impl TopicVisitor for Thrower<'_> {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        let take = |bytes: usize, skip: usize| -> Vec<u8> {
            self.bytes
                .iter()
                .cycle()
                .skip(skip)
                .take(bytes)
                .copied()
                .collect()
        };
        let raw = plausible(&take(row.envelope_bytes, 0), self.seed);
        let mut envelope: T::Envelope = bytemuck::pod_read_unaligned(&raw);
        let len = self.len.min(row.len_max + 1);
        let items: Vec<T::Item> = (0..len)
            .map(|n| {
                let raw = plausible(&take(row.item_bytes, 7 * n + 1), self.seed ^ n as u64);
                bytemuck::pod_read_unaligned(&raw)
            })
            .collect();
        // As it came: almost surely refused by its header.
        let _ = decode::<T>(row, &envelope, &items);
        // With a true header, so that the fixed fields and the slice are looked at.
        let mut header = *envelope.header();
        header.schema = u32::try_from(row.schema & 0xffff_ffff).expect("32 bits");
        (header.robot, header.clock) = (0, 0);
        header.role = row.writers.first().map_or(0, |role| role.code());
        header.id = 1 << 40 | 1;
        envelope = seal::<T>(header, *envelope.meta(), &items);
        if decode::<T>(row, &envelope, &items).is_ok() {
            *self.accepted.entry(row.name).or_default() += 1;
            // Whatever is accepted has the length it says, and no item count beyond the contract.
            if items.len() > row.len_max {
                return Err(format!("{}: {} items accepted", row.name, items.len()));
            }
        }
        Ok(())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), String> {
        let raw: Vec<u8> = self
            .bytes
            .iter()
            .cycle()
            .take(row.item_bytes)
            .copied()
            .collect();
        let span: zeronav_msgs::span::Span = bytemuck::pod_read_unaligned(&raw);
        if span.check().is_ok() && (span.role().is_none() || span.kind().is_none()) {
            return Err("a span without role or kind is accepted".to_owned());
        }
        Ok(())
    }
}

/// Throws random bytes at every decoder; what was accepted, by topic.
fn thrown(cases: u32) -> BTreeMap<&'static str, u64> {
    let bytes = prop::collection::vec(any::<u8>(), 1..600);
    // The same bytes every time, so that what is accepted can be asserted.
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(cases)
    };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, rng);
    let accepted = RefCell::new(BTreeMap::new());
    let thrown = runner.run(&(bytes, 0_usize..40, any::<u64>()), |(bytes, len, seed)| {
        let mut thrower = Thrower {
            bytes: &bytes,
            len,
            seed,
            accepted: accepted.take(),
        };
        let result = visit_topics(&mut thrower);
        accepted.replace(thrower.accepted);
        prop_assert_eq!(result, Ok(()));
        Ok(())
    });
    thrown.unwrap_or_else(|failure| panic!("{failure}"));
    accepted.take()
}

#[test]
fn no_decoder_panics_and_some_bytes_are_accepted() {
    let accepted = thrown(2000);
    let sum: u64 = accepted.values().sum();
    assert!(sum >= 100 && accepted.len() >= 10, "{accepted:?}");
}

/// One wrong number at a time in a message that is right otherwise.
#[test]
fn one_bad_field_is_enough() {
    use zeronav_msgs::command::VelocityRequest;
    use zeronav_msgs::message::Refusal;
    use zeronav_msgs::path::{Path, Waypoint};
    use zeronav_msgs::scan::Scan;

    let request = VelocityRequest {
        v_mps: 0.5,
        validity: 1,
        ..VelocityRequest::default()
    };
    assert_eq!(request.check(), Ok(()));
    let nan = VelocityRequest {
        v_mps: f64::NAN,
        ..request
    };
    assert_eq!(nan.check(), Err(Refusal::NotFinite("v_mps")));
    let code = VelocityRequest {
        validity: 77,
        ..request
    };
    assert_eq!(code.check(), Err(Refusal::Code("validity")));

    let scan = Scan {
        n_beams: 2,
        angle_increment_rad: 0.1,
        range_m_min: 0.1,
        range_m_max: 10.0,
        ..Scan::default()
    };
    assert_eq!(scan.check(&[f32::NAN, f32::INFINITY]), Ok(()));
    assert_eq!(scan.check(&[1.0]), Err(Refusal::Length("beams")));
    assert_eq!(scan.check(&[-1.0, 2.0]), Err(Refusal::OutOfRange("ranges")));

    let path = Path {
        status: 1,
        n_waypoints: 1,
        ..Path::default()
    };
    let waypoint = Waypoint::default();
    assert_eq!(path.check(&[waypoint]), Ok(()));
    assert_eq!(path.check(&[]), Err(Refusal::Length("waypoints")));
    let block = Path { block: 9, ..path };
    assert_eq!(block.check(&[waypoint]), Err(Refusal::Code("block")));
    let infinite = Waypoint {
        x_m: f64::INFINITY,
        ..waypoint
    };
    assert_eq!(path.check(&[infinite]), Err(Refusal::NotFinite("x_m")));
}

#[test]
fn headers_of_strangers_are_refused() {
    use zeronav_msgs::header::Header;
    use zeronav_msgs::message::Refusal;
    let schema = 0x1234_5678_9abc_def0;
    let header = Header {
        role: Role::Robot.code(),
        schema: 0x9abc_def0,
        id: 1 << 40 | 1,
        ..Header::default()
    };
    let check = |header: Header| header.check(schema, &[Role::Robot]);
    assert_eq!(check(header), Ok(()));
    assert_eq!(
        check(Header {
            schema: 1,
            ..header
        }),
        Err(Refusal::Schema)
    );
    assert_eq!(
        check(Header { robot: 1, ..header }),
        Err(Refusal::Foreign("robot"))
    );
    assert_eq!(
        check(Header { clock: 1, ..header }),
        Err(Refusal::Foreign("clock"))
    );
    assert_eq!(
        check(Header { role: 99, ..header }),
        Err(Refusal::Code("role"))
    );
    assert_eq!(
        check(Header {
            role: Role::Mapping.code(),
            ..header
        }),
        Err(Refusal::Writer)
    );
    // Without an epoch, and without a count.
    for id in [0, 5, 1 << 40] {
        assert_eq!(check(Header { id, ..header }), Err(Refusal::Identity));
    }
}

#[test]
fn swapped_fields_of_equal_size_change_the_schema() {
    mod swapped {
        use zeronav_msgs::message;
        use zeronav_msgs::message::ZeroCopySend;
        message! {
            /// The pose with its first two fields swapped.
            pub struct Pose = "zeronav.Pose.v1" {
                /// [m]
                pub y_m: f64,
                /// [m]
                pub x_m: f64,
                /// [rad]
                pub yaw_rad: f64,
            }
        }
    }
    assert_eq!(size_of::<swapped::Pose>(), size_of::<zeronav_msgs::Pose>());
    assert_ne!(swapped::Pose::SCHEMA, zeronav_msgs::Pose::SCHEMA);
}

#[test]
fn reasons_are_checked_like_everything_else() {
    use zeronav_msgs::command::{VelocityCommand, VelocityRequest};
    use zeronav_msgs::message::Refusal;
    let request = VelocityRequest::default();
    assert_eq!(request.check(), Ok(()), "who tells no reason is legal");
    for (wrong, field) in [
        (
            VelocityRequest {
                cause: 99,
                ..request
            },
            "cause",
        ),
        (
            VelocityRequest {
                input: 99,
                ..request
            },
            "input",
        ),
        (
            VelocityRequest {
                recovery: 99,
                ..request
            },
            "recovery",
        ),
    ] {
        assert_eq!(wrong.check(), Err(Refusal::Code(field)));
    }
    let negative = VelocityRequest {
        blocked_arc_m: -0.1,
        ..request
    };
    assert_eq!(negative.check(), Err(Refusal::OutOfRange("blocked_arc_m")));
    let command = VelocityCommand {
        beam: 3,
        point_m: [0.5, -0.1],
        point_clearance_m: -0.01,
        ..VelocityCommand::default()
    };
    assert_eq!(command.check(), Ok(()));
    let nan = VelocityCommand {
        point_m: [0.5, f64::NAN],
        ..command
    };
    assert_eq!(nan.check(), Err(Refusal::NotFinite("point_m")));
    let beam = VelocityCommand {
        beam: 5000,
        ..command
    };
    assert_eq!(beam.check(), Err(Refusal::OutOfRange("beam")));
}
