//! A mapping service built from another contract: two fields of equal size are swapped in
//! its scan. Names and sizes agree, so only the schema hash differs.

use zeronav_msgs::header::Header;
use zeronav_msgs::message;
use zeronav_msgs::message::{FNV_OFFSET, Refusal, Wire, ZeroCopySend, fnv1a};
use zeronav_msgs::role::Role;
use zeronav_msgs::scan::BEAMS_MAX;
use zeronav_msgs::topics::{Discipline, Envelope, RobotScan, Topic, TopicRow};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Latest, Service, Shell, StartError};
use zeronav_tests::seats::AnyConfig;

message! {
    /// The scan with `range_m_min` and `range_m_max` in each other's place.
    pub struct Scan = "zeronav.Scan.v1" {
        /// As in the contract.
        pub sensor: u32,
        /// As in the contract.
        pub n_beams: u32,
        /// As in the contract.
        pub angle_min_rad: f32,
        /// As in the contract.
        pub angle_increment_rad: f32,
        /// As in the contract.
        pub time_increment_s: f32,
        /// Where the contract has the closest range.
        pub range_m_max: f32,
        /// Where the contract has the farthest range.
        pub range_m_min: f32,
        /// As in the contract.
        pub spare: u32,
    }
}

message! {
    /// Named and sized as in the contract.
    pub struct ScanEnvelope = "zeronav.robot.scan.v1" {
        /// The header.
        pub header: Header,
        /// The fixed fields.
        pub meta: Scan,
    }
}

impl Envelope for ScanEnvelope {
    type Meta = Scan;
    fn new(header: Header, meta: Scan) -> Self {
        Self { header, meta }
    }
    fn header(&self) -> &Header {
        &self.header
    }
    fn meta(&self) -> &Scan {
        &self.meta
    }
}

#[derive(Debug)]
enum SwappedScan {}

impl Topic for SwappedScan {
    type Envelope = ScanEnvelope;
    type Meta = Scan;
    type Item = f32;
    const ROW: &'static TopicRow = &TopicRow {
        number: RobotScan::ROW.number,
        name: RobotScan::ROW.name,
        discipline: Discipline::Latest,
        writers: &[Role::Robot],
        rings: &[],
        rings_in_lockstep: &[],
        len_max: BEAMS_MAX,
        envelope_bytes: size_of::<ScanEnvelope>(),
        item_bytes: 4,
        schema: fnv1a(FNV_OFFSET, &<ScanEnvelope as Wire>::SCHEMA.to_le_bytes()),
    };

    fn check(_meta: &Scan, _items: &[f32]) -> Result<(), Refusal> {
        Ok(())
    }
}

pub(crate) struct SwappedFields {
    _scan: Latest<SwappedScan>,
}

impl Service for SwappedFields {
    const ROLE: Role = Role::Mapping;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            _scan: shell.peer().latest()?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        shell.ready();
        Ok(())
    }
}
