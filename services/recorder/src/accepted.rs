//! Which messages of the contract a reader of the stack accepts.

use zeronav_msgs::header::Header;
use zeronav_msgs::topics::{Envelope, Topic, TopicRow, decode};

/// The header of a message of a topic's row, if its two parts are accepted.
pub type Check = fn(&'static TopicRow, &[u8], &[u8]) -> Option<Header>;

/// [`Check`] of topic `T`. The parts may lie anywhere in memory.
#[must_use]
pub fn accepted<T: Topic>(row: &'static TopicRow, envelope: &[u8], items: &[u8]) -> Option<Header> {
    let envelope: T::Envelope = bytemuck::try_pod_read_unaligned(envelope).ok()?;
    let copied: Vec<T::Item>;
    let items: &[T::Item] = if let Ok(items) = bytemuck::try_cast_slice(items) {
        items
    } else {
        if !items.len().is_multiple_of(size_of::<T::Item>().max(1)) {
            return None;
        }
        copied = bytemuck::pod_collect_to_vec(items);
        &copied
    };
    decode::<T>(row, &envelope, items).ok()?;
    Some(*envelope.header())
}
