//! The messages of a recording that were obeyed, as readers of the stack accept them.

use crate::bag::input::open;
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_msgs::header::Header;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{
    Envelope, RobotOdometry, RunControlTopic, SPANS, Topic, TopicRow, TopicVisitor, topics,
    visit_topics,
};
use zeronav_msgs::user::{Form, UserTopic, name_in, row};
use zeronav_recorder::accepted::{Check, accepted};
use zeronav_recorder::holders::Holders;
use zeronav_recorder::messages::native_messages;
use zeronav_recorder::native::PREFIX;
use zeronav_recorder::read::Summary;
use zeronav_shell::View;

/// Most topics of users of a recording.
const USERS_MAX: usize = 64;

/// A message of a topic.
#[derive(Debug, Clone)]
pub(crate) struct Note {
    pub row: &'static TopicRow,
    /// Who sent it; launch, too.
    pub role: Role,
    pub epoch: u32,
    pub tick: u64,
    /// When. [ns] by the clock of the machine that recorded it
    pub sent_ns: u64,
    /// Header and fixed fields, then items.
    pub bytes: Vec<u8>,
}

impl Note {
    /// Header with fixed fields, and items.
    pub(crate) fn parts(&self) -> (&[u8], &[u8]) {
        self.bytes
            .split_at(self.row.envelope_bytes.min(self.bytes.len()))
    }

    /// Its header.
    pub(crate) fn header(&self) -> Header {
        let bytes = self.bytes.get(..size_of::<Header>());
        bytes.map_or_else(Header::default, bytemuck::pod_read_unaligned)
    }

    /// Shows it to `see` when it is of topic `T`.
    pub(crate) fn show<T: Topic>(&self, see: impl FnOnce(View<'_, T>)) {
        if self.row.number != T::ROW.number {
            return;
        }
        let (envelope, items) = self.parts();
        let Ok(envelope) = bytemuck::try_pod_read_unaligned::<T::Envelope>(envelope) else {
            return;
        };
        // Only items that do not lie as in shared memory are copied.
        let copied: Vec<T::Item>;
        let items: &[T::Item] = if let Ok(items) = bytemuck::try_cast_slice(items) {
            items
        } else {
            copied = bytemuck::pod_collect_to_vec(items);
            &copied
        };
        see(View {
            header: envelope.header(),
            meta: envelope.meta(),
            items,
        });
    }

    /// What it says when it is odometry.
    pub(crate) fn odometry(&self) -> Option<Odometry> {
        let mut said = None;
        self.show::<RobotOdometry>(|view| said = Some(*view.meta));
        said
    }
}

/// Something in a recording.
#[derive(Debug)]
pub(crate) enum Heard {
    /// A message.
    Note(Note),
    /// Records of cycles.
    Spans(Vec<Span>),
}

/// Shows what was obeyed of the wanted topics of the recording in `file`, summed up as `found`, in the order in which it
/// was recorded: messages that readers of the stack accept, of launch and of the processes that were obeyed, and on the
/// topics in `users` also of companions.
///
/// # Errors
/// One line naming the file; what was read before has been shown.
pub(crate) fn obeyed(
    file: &Path,
    (found, users): (&Summary, &[(&'static TopicRow, Form)]),
    wants: impl Fn(&str) -> bool,
    see: impl FnMut(Heard),
) -> Result<(), String> {
    let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
    same_contract(found).map_err(|why| wrong(&why))?;
    let mut checks = Checks::default();
    match visit_topics(&mut checks) {
        Ok(()) => {}
    }
    let of_users = users.iter().map(|(row, _)| {
        let check: Check = accepted::<UserTopic>;
        (row.name, (*row, check))
    });
    checks.0.extend(of_users);
    let mut reading = Reading {
        see,
        holders: Holders::default(),
        checks: checks.0,
    };
    native_messages(open(file)?, wants, |name, layout, parts| {
        if name == RunControlTopic::ROW.name {
            reading.holders.see(layout, parts[1]);
        } else if name == SPANS.name {
            reading.spans(parts[1]);
        } else {
            reading.take(name, parts);
        }
    })
    .map_err(|error| wrong(&error))?;
    Ok(())
}

/// Topics of users in a recording, each with the form of its messages.
///
/// # Errors
/// One line that names the first whose form this build does not read, or has another layout for.
pub(crate) fn user_topics(found: &Summary) -> Result<Vec<(&'static TopicRow, Form)>, String> {
    let mut all = Vec::new();
    for channel in found.channels.values() {
        let name = channel.topic.strip_prefix(PREFIX).and_then(name_in);
        let Some(name) = name else { continue };
        let text = channel.metadata.get("form").map_or("", String::as_str);
        let form = Form::new(text).map_err(|error| format!("{}: {error}", channel.topic))?;
        let row = row(name, &form).map_err(|error| format!("{}: {error}", channel.topic))?;
        same_layout(found, row)?;
        all.push((row, form));
        if all.len() > USERS_MAX {
            return Err(format!("it has more than {USERS_MAX} topics of users"));
        }
    }
    Ok(all)
}

/// Accepts a recording whose topics have the layout of this build.
fn same_contract(found: &Summary) -> Result<(), String> {
    topics().iter().try_for_each(|row| same_layout(found, row))
}

/// Accepts a recording in which this topic has the layout of this build, if it is there.
fn same_layout(found: &Summary, row: &TopicRow) -> Result<(), String> {
    let name = format!("{PREFIX}{}", row.name);
    let mut channels = found.channels.values();
    let channel = channels.find(|channel| channel.topic == name);
    let expected = format!("{:016x}", row.schema);
    let schema = channel.and_then(|channel| channel.metadata.get("schema_hash"));
    if channel.is_some() && schema != Some(&expected) {
        let library = &found.library;
        return Err(format!(
            "{} has another layout than in this build: use the version that recorded it ({library})",
            row.name
        ));
    }
    Ok(())
}

/// How each topic is checked.
#[derive(Default)]
struct Checks(BTreeMap<&'static str, (&'static TopicRow, Check)>);

impl TopicVisitor for Checks {
    type Error = core::convert::Infallible;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Self::Error> {
        self.0.insert(row.name, (row, accepted::<T>));
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// A recording while it is read.
struct Reading<F> {
    see: F,
    holders: Holders,
    checks: BTreeMap<&'static str, (&'static TopicRow, Check)>,
}

impl<F: FnMut(Heard)> Reading<F> {
    fn take(&mut self, name: &str, [envelope, items]: [&[u8]; 2]) {
        let Some((row, check)) = self.checks.get(name).copied() else {
            return;
        };
        let Some(header) = check(row, envelope, items) else {
            return;
        };
        let epoch = header.id().epoch();
        let is_users = name_in(row.name).is_some();
        let Some(role) = header.role().filter(|role| {
            let is_seat = Role::SERVICES.contains(role);
            *role == Role::Launch
                || (is_users && !is_seat)
                || self.is_obeyed(role.code(), epoch, header.tick)
        }) else {
            return;
        };
        (self.see)(Heard::Note(Note {
            row,
            role,
            epoch,
            tick: header.tick,
            sent_ns: header.stamps.published_ns,
            bytes: [envelope, items].concat(),
        }));
    }

    fn spans(&mut self, items: &[u8]) {
        let whole = items.chunks_exact(size_of::<Span>());
        let spans = whole.filter_map(|span| bytemuck::try_pod_read_unaligned::<Span>(span).ok());
        let spans = spans.filter(|span| self.is_obeyed(span.role, span.epoch, span.tick));
        let spans = spans.collect();
        (self.see)(Heard::Spans(spans));
    }

    fn is_obeyed(&self, role: u16, epoch: u32, tick: u64) -> bool {
        let author = [Some(role.into()), Some(epoch.into()), Some(tick)];
        self.holders.obey(author)
    }
}
