//! The checksum that protects a message from end to end: whatever flips a bit of it between its writer
//! and a reader, the reader rejects it.

use crate::header::Header;

/// Factor of the first word, and from each to the next: odd plus even stays odd.
const FIRST: u64 = 0x9e37_79b9_7f4a_7c15;
const STEP: u64 = 0x3c6e_f372_fe94_f82a;

/// Bytes of the header in front of its checksum, which is its last field.
pub const HEADER_BYTES: usize = size_of::<Header>() - size_of::<u64>();

/// Checksum of a message: of its header in front of the checksum, its fixed fields, and its slice.
///
/// The sum of all words of 8 bytes (the last of each part filled up with zeros) and of the length of the
/// slice, each times an odd factor of its place, modulo 2^64. An odd factor has an inverse, so that any
/// change within one word, and with it every single flipped bit, changes the sum.
///
/// Source: multilinear hashing; Lemire, Kaser, "Strongly universal string hashing is fast", 2014.
#[must_use]
pub fn checksum(header: &[u8], meta: &[u8], items: &[u8]) -> u64 {
    let mut sum = Sum {
        factor: FIRST,
        sum: 0,
    };
    sum.word(items.len() as u64);
    for part in [header, meta, items] {
        sum.part(part);
    }
    sum.sum
}

struct Sum {
    factor: u64,
    sum: u64,
}

impl Sum {
    fn part(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        for word in words {
            self.word(u64::from_le_bytes(*word));
        }
        if !rest.is_empty() {
            let mut word = [0; 8];
            word[..rest.len()].copy_from_slice(rest);
            self.word(u64::from_le_bytes(word));
        }
    }

    fn word(&mut self, word: u64) {
        self.sum = self.sum.wrapping_add(word.wrapping_mul(self.factor));
        self.factor = self.factor.wrapping_add(STEP);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_and_every_cut_changes_it() {
        let header: Vec<u8> = (0..120_u8).map(|n| n.wrapping_mul(3)).collect();
        let (meta, items) = ([7_u8; 24], [255_u8; 13]);
        let right = checksum(&header, &meta, &items);
        let parts = [header.clone(), meta.to_vec(), items.to_vec()];
        for (at, part) in parts.iter().enumerate() {
            for bit in 0..8 * part.len() {
                let mut other = parts.clone();
                other[at][bit / 8] ^= 1 << (bit % 8);
                let found = checksum(&other[0], &other[1], &other[2]);
                assert_ne!(found, right, "bit {bit} of part {at}");
            }
        }
        assert_ne!(checksum(&header, &meta, &[255; 12]), right);
        let mut longer = items.to_vec();
        longer.push(0);
        assert_ne!(checksum(&header, &meta, &longer), right, "a zero more");
        let mut swapped = header.clone();
        swapped.swap(0, 8);
        assert_ne!(checksum(&swapped, &meta, &items), right);
    }

    /// A reader in another language has the same.
    #[test]
    fn it_does_not_change_by_accident() {
        assert_eq!(checksum(&[1; 8], &[2; 8], &[3]), 0xa9cc_acf9_8d8d_07df);
    }
}
