//! The end of a file that could not be written any further, so that it says so itself.
//!
//! The middle of a file on a full disk is some part of a chunk. It is cut off behind the last chunk that was handed to
//! the system as a whole, and the end is put there. For its few bytes a little room is kept free from the beginning.

use crate::verdict::VERDICT;
use mcap::MAGIC;
use mcap::records::op;
use std::collections::BTreeMap;

/// Room that is enough for [`ending`] with a line that says why. [bytes]
pub const RESERVE_BYTES: u64 = 64 << 10;

/// What stands behind the last chunk of a file with this verdict: the verdict, then the end of a file without an index.
#[must_use]
pub fn ending(verdict: &BTreeMap<String, String>) -> Vec<u8> {
    let mut map = Vec::new();
    for (key, value) in verdict {
        text(&mut map, key);
        text(&mut map, value);
    }
    let mut metadata = Vec::new();
    text(&mut metadata, VERDICT);
    metadata.extend(length(map.len()).to_le_bytes());
    metadata.extend(map);
    let mut bytes = Vec::new();
    record(&mut bytes, op::METADATA, &metadata);
    // No checksum of the data.
    record(&mut bytes, op::DATA_END, &[0; 4]);
    // No summary, no offsets of one, no checksum.
    record(&mut bytes, op::FOOTER, &[0; 20]);
    bytes.extend_from_slice(MAGIC);
    bytes
}

fn record(to: &mut Vec<u8>, opcode: u8, content: &[u8]) {
    to.push(opcode);
    to.extend((content.len() as u64).to_le_bytes());
    to.extend_from_slice(content);
}

fn text(to: &mut Vec<u8>, text: &str) {
    to.extend(length(text.len()).to_le_bytes());
    to.extend_from_slice(text.as_bytes());
}

fn length(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::tests::a_channel;
    use crate::file::{RecordingFile, Stamped};
    use crate::read::summary;
    use std::fs::File;
    use std::io::{Read, Seek, SeekFrom};

    #[test]
    fn a_file_that_was_cut_between_chunks_is_whole_with_its_end() {
        let mut kept: File = tempfile::tempfile().expect("a file");
        let mut file = RecordingFile::new(kept.try_clone().expect("it")).expect("a file");
        let channel = file.channel(&a_channel()).expect("a channel");
        let when = Stamped {
            sequence: 1,
            log_ns: 1,
            publish_ns: 1,
        };
        file.write(channel, when, &[7]).expect("written");
        file.flush().expect("flushed");
        let mut bytes = Vec::new();
        kept.seek(SeekFrom::Start(0)).expect("sought");
        kept.read_to_end(&mut bytes).expect("read");
        let (before, damage) = summary(&bytes[..]);
        assert!(damage.is_some() && before.messages() == 1, "{before:?}");
        let verdict: BTreeMap<String, String> = [
            ("valid".to_owned(), "false".to_owned()),
            ("why".to_owned(), "full".to_owned()),
        ]
        .into();
        let end = ending(&verdict);
        assert!((end.len() as u64) < RESERVE_BYTES);
        bytes.extend(end);
        let (after, damage) = summary(&bytes[..]);
        assert!(damage.is_none() && after.has_end, "{damage:?}");
        assert_eq!((after.messages(), &after.metadata[VERDICT]), (1, &verdict));
    }
}
