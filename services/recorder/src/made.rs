//! A recording that is made of something else than a running stack: of the log of another robot, or of a recording that
//! is brought into another form. It has both layers, as the recorder writes them.

use crate::channels::Channels;
use crate::file::{RecordingFile, SCENARIO_TYPE, START, Stamped, low32};
use crate::native::{self, NativeTopic};
use crate::verdict::{END_TICK, Tally, VERDICT, verdict};
use mcap::McapError;
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use zeronav_msgs::header::{Header, Id, Stamps};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Topic, TopicRow, seal};
use zeronav_msgs::user::name_in;
use zeronav_ros_messages::times::TimeBase;
use zeronav_ros_messages::{Bytes, Ros};

/// Why a recording could not be made.
#[derive(Debug, thiserror::Error)]
pub enum MadeError {
    /// The output, or the file's format.
    #[error("{0}")]
    File(#[from] McapError),
    /// A message that has no form in CDR.
    #[error("a message has no form in CDR: {0}")]
    Cdr(#[from] zeronav_ros_messages::CdrError),
    /// A topic that is not in the contract.
    #[error("{0} is no topic of the contract")]
    Topic(&'static str),
}

/// When a message was, and who sent it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// Its author.
    pub role: Role,
    /// The tick that it answers.
    pub tick: u64,
    /// The run time that it is about. [ns]
    pub run_ns: u64,
}

/// A recording while it is made, of a lockstep run.
pub struct Made<W: Write + Seek> {
    file: RecordingFile<W>,
    topics: Vec<NativeTopic>,
    channels: Channels,
    ros: Ros,
    tallies: BTreeMap<&'static str, Tally>,
    counts: BTreeMap<(Role, &'static str), u64>,
    sent_ns: u64,
}

impl<W: Write + Seek> core::fmt::Debug for Made<W> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Made").finish_non_exhaustive()
    }
}

impl<W: Write + Seek> Made<W> {
    /// Begins one with these fields of [`START`], and the name and text of the scenario that configures its seats.
    ///
    /// # Errors
    /// What the output says.
    pub fn begin(
        output: W,
        start: BTreeMap<String, String>,
        scenario: Option<(&str, &str)>,
    ) -> Result<Self, MadeError> {
        let mut file = RecordingFile::new(output)?;
        file.metadata(START, start)?;
        if let Some((name, text)) = scenario {
            file.attach(name, SCENARIO_TYPE, text.as_bytes())?;
        }
        Ok(Self {
            file,
            topics: native::topics(),
            channels: Channels::default(),
            ros: Ros::new(TimeBase::default()),
            tallies: BTreeMap::new(),
            counts: BTreeMap::new(),
            sent_ns: 0,
        })
    }

    /// Writes a metadata record.
    ///
    /// # Errors
    /// What the output says.
    pub fn metadata(
        &mut self,
        name: &str,
        fields: BTreeMap<String, String>,
    ) -> Result<(), MadeError> {
        Ok(self.file.metadata(name, fields)?)
    }

    /// Messages of a user's own topic will come, too.
    pub fn add(&mut self, topic: NativeTopic) {
        self.topics.push(topic);
    }

    /// Writes a message of topic `T`, the next of its author; its identity.
    ///
    /// # Errors
    /// [`MadeError`].
    pub fn write<T: Topic>(
        &mut self,
        at: Moment,
        meta: T::Meta,
        items: &[T::Item],
    ) -> Result<Id, MadeError> {
        let count = self.counts.entry((at.role, T::ROW.name)).or_default();
        *count += 1;
        let id = Id::new(1, *count);
        // Each is sent after the one before, and not before the moment that it is about.
        self.sent_ns = (self.sent_ns + 1).max(at.run_ns);
        let header = Header {
            role: at.role.code(),
            schema: u32::try_from(T::ROW.schema & 0xffff_ffff).unwrap_or(0),
            id: id.0,
            tick: at.tick,
            run_ns: at.run_ns,
            capture_ns: at.run_ns,
            stamps: Stamps {
                woken_ns: self.sent_ns,
                started_ns: self.sent_ns,
                published_ns: self.sent_ns,
            },
            ..Header::default()
        };
        let envelope = seal::<T>(header, meta, items);
        let parts = [bytemuck::bytes_of(&envelope), bytemuck::cast_slice(items)];
        self.put(T::ROW, &header, parts)?;
        Ok(id)
    }

    /// Writes a message as it is: header with fixed fields, and items.
    ///
    /// # Errors
    /// [`MadeError`].
    pub fn put(
        &mut self,
        row: &'static TopicRow,
        header: &Header,
        [envelope, items]: [&[u8]; 2],
    ) -> Result<(), MadeError> {
        let tally = self.tallies.entry(row.name).or_default();
        if name_in(row.name).is_some() {
            tally.see_of_any(header.id());
        } else {
            tally.see(header.id());
        }
        let log_ns = header.run_ns;
        let when = Stamped {
            sequence: low32(header.id().count()),
            log_ns,
            publish_ns: log_ns,
        };
        let mut topics = self.topics.iter();
        let topic = topics.find(|topic| topic.row.name == row.name);
        let topic = topic.ok_or(MadeError::Topic(row.name))?;
        let channel = self.channels.native(&mut self.file, topic)?;
        self.file
            .write(channel, when, &[envelope, items].concat())?;
        let bytes = Bytes {
            row,
            log_ns,
            envelope,
            items,
        };
        for made in self.ros.see(&bytes)? {
            let channel = self.channels.world(&mut self.file, made.topic)?;
            let when = Stamped {
                log_ns: made.log_ns,
                ..when
            };
            self.file.write(channel, when, &made.bytes)?;
        }
        Ok(())
    }

    /// Ends it: the run ended with `end_tick`, and `why` is what is missing, if something is.
    ///
    /// # Errors
    /// What the output says.
    pub fn finish(mut self, end_tick: u64, why: Option<&str>) -> Result<W, MadeError> {
        let tallies = self.topics.iter().filter_map(|topic| {
            let tally = self.tallies.get(topic.row.name)?;
            Some((topic.row, tally))
        });
        let mut fields = verdict(tallies, why);
        fields.insert(END_TICK.to_owned(), end_tick.to_string());
        self.file.metadata(VERDICT, fields)?;
        Ok(self.file.finish()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::native_messages;
    use crate::read::summary;
    use std::io::Cursor;
    use zeronav_msgs::odometry::Odometry;
    use zeronav_msgs::topics::RobotOdometry;

    #[test]
    fn what_is_made_reads_as_a_recording() {
        let mut made = Made::begin(Cursor::new(Vec::new()), BTreeMap::new(), None).expect("begun");
        for tick in 1..=3 {
            let at = Moment {
                role: Role::Robot,
                tick,
                run_ns: tick * 50,
            };
            let id = made.write::<RobotOdometry>(at, Odometry::default(), &[]);
            assert_eq!(id.expect("written"), Id::new(1, tick));
        }
        let bytes = made.finish(4, None).expect("finished").into_inner();
        let (found, damage) = summary(&bytes[..]);
        assert!(
            damage.is_none() && found.metadata[VERDICT]["valid"] == "true",
            "{found:?}"
        );
        let mut ticks = Vec::new();
        let end = native_messages(
            &bytes[..],
            |_| true,
            |_, layout, [envelope, items]| {
                let check = crate::accepted::accepted::<RobotOdometry>;
                assert!(check(RobotOdometry::ROW, envelope, items).is_some());
                ticks.extend(layout.number(envelope, "header.tick"));
            },
        );
        assert_eq!(ticks, [1, 2, 3]);
        assert_eq!(end.expect("read").incomplete, None);
    }
}
