//! A message as it was read: a copy, because one that stays in shared memory takes its place from
//! the next, and the reader of the output may be slow.

use zeronav_msgs::fields::Shape;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::message::Wire;
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{SPANS, Topic, TopicRow};
use zeronav_msgs::user::{Form, UserMessage};
use zeronav_shell::View;

/// A copy of one message. Its memory is used again for the next.
#[derive(Debug)]
pub(super) struct Message {
    /// The topic.
    pub row: &'static TopicRow,
    /// Author, identity, times; `None` for a record.
    pub header: Option<Header>,
    /// What the fixed fields are; `None` for a record.
    pub fields: Option<&'static Shape>,
    /// The fixed fields.
    pub field_bytes: Vec<u8>,
    /// What an item of the slice is; a record is one item.
    pub item: &'static Shape,
    /// The items.
    pub item_bytes: Vec<u8>,
    /// When it was sent, monotonic. [ns]
    pub published_ns: u64,
    /// Messages between the one before and this one that were overwritten before they were read.
    pub missed: u64,
}

impl Message {
    /// No message of topic `T` yet.
    pub(super) fn of_topic<T: Topic>(row: &'static TopicRow) -> Self {
        Self::empty(row, Some(T::Meta::SHAPE), T::Item::SHAPE)
    }

    /// No message of a user's own topic with this form yet.
    pub(super) fn of_user(row: &'static TopicRow, form: &Form) -> Self {
        Self::empty(row, Some(UserMessage::SHAPE), form.shape())
    }

    /// No record yet.
    pub(super) fn of_records() -> Self {
        Self::empty(&SPANS, None, Span::SHAPE)
    }

    fn empty(row: &'static TopicRow, fields: Option<&'static Shape>, item: &'static Shape) -> Self {
        Self {
            row,
            header: None,
            fields,
            field_bytes: Vec::new(),
            item,
            item_bytes: Vec::new(),
            published_ns: 0,
            missed: 0,
        }
    }

    /// Copies a message.
    pub(super) fn copy<T: Topic>(&mut self, view: &View<'_, T>) {
        self.header = Some(*view.header);
        self.published_ns = view.header.stamps.published_ns;
        overwrite(&mut self.field_bytes, bytemuck::bytes_of(view.meta));
        overwrite(&mut self.item_bytes, bytemuck::cast_slice(view.items));
    }

    /// Copies a record.
    pub(super) fn copy_record(&mut self, span: &Span) {
        // A command that was applied is recorded when it is, not when it was sent.
        self.published_ns = span.published_ns.max(span.started_ns);
        overwrite(&mut self.item_bytes, bytemuck::bytes_of(span));
    }

    /// Its identity; `None` for a record.
    pub(super) fn id(&self) -> Option<Id> {
        self.header.as_ref().map(Header::id)
    }

    /// Unit of items that are plain numbers.
    pub(super) fn item_unit(&self) -> &'static str {
        self.fields.and_then(Shape::item_unit).unwrap_or("")
    }

    /// Its size with header and slice. [bytes]
    pub(super) fn bytes(&self) -> usize {
        self.row.envelope_bytes + self.item_bytes.len()
    }
}

fn overwrite(to: &mut Vec<u8>, from: &[u8]) {
    to.clear();
    to.extend_from_slice(from);
}
