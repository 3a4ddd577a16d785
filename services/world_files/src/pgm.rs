//! Grey images in the format PGM, as text (P2) or in bytes (P5).

use crate::pixels::{Pixels, check_size, narrow};
use zeronav_casts::Cast;

/// Largest value that a sample may have.
const WHITE_MAX: u32 = 65_535;

/// What is wrong with an image that ends before its last pixel.
const TRUNCATED: &str = "the file is truncated";

/// What is left to be read.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// The next number; space and comments before it and one byte after it are passed over.
    fn number(&mut self) -> Result<u32, String> {
        let mut digit = self.byte();
        loop {
            match digit {
                Some(b'#') => while !matches!(self.byte(), Some(b'\n' | b'\r') | None) {},
                Some(space) if is_space(space) => {}
                _ => break,
            }
            digit = self.byte();
        }
        let mut value = None;
        loop {
            match digit {
                Some(letter @ b'0'..=b'9') => {
                    let more = value.unwrap_or(0) * 10 + u32::from(letter - b'0');
                    if more > WHITE_MAX {
                        return Err(format!("a number above {WHITE_MAX}"));
                    }
                    value = Some(more);
                }
                None => return value.ok_or_else(|| TRUNCATED.to_owned()),
                Some(space) if is_space(space) && value.is_some() => break,
                Some(_) => return Err("something that is no number".to_owned()),
            }
            digit = self.byte();
        }
        value.ok_or_else(|| TRUNCATED.to_owned())
    }
}

fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

/// The pixels of an image that begins with `P2` or `P5`.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let is_text = bytes.get(1) == Some(&b'2');
    let mut rest = Rest(bytes.get(2..).unwrap_or_default());
    if !rest
        .0
        .first()
        .copied()
        .is_some_and(|next| is_space(next) || next == b'#')
    {
        return Err("its header is broken".to_owned());
    }
    let mut field = |name: &str| {
        let number = rest.number();
        number.map_err(|why| format!("its {name}: {why}"))
    };
    let (width, height) = (field("width")?, field("height")?);
    let white = field("largest value")?;
    let n = check_size(width, height)?;
    if white == 0 {
        return Err("its largest value is 0".to_owned());
    }
    let grey = if is_text {
        let mut grey = Vec::with_capacity(n.min(bytes.len()));
        for _ in 0..n {
            let value = rest.number().map_err(|why| {
                let n_read = grey.len();
                format!("its pixels: {why}, {n_read} of {n} pixels are there")
            })?;
            grey.push(shade(value, white));
        }
        grey
    } else {
        let width_bytes = if white > 255 { 2 } else { 1 };
        let short = || {
            format!(
                "its pixels: {TRUNCATED}, {} of {} bytes are there",
                rest.0.len(),
                n * width_bytes
            )
        };
        let samples = rest.0.get(..n * width_bytes).ok_or_else(short)?;
        let value = |sample: &[u8]| {
            let big_endian = |value, byte: &u8| (value << 8) | u32::from(*byte);
            sample.iter().fold(0, big_endian)
        };
        let samples = samples.chunks_exact(width_bytes);
        samples.map(|sample| shade(value(sample), white)).collect()
    };
    Ok(Pixels {
        width,
        height,
        grey,
        alpha: Vec::new(),
    })
}

/// A value as its part of 255.
fn shade(value: u32, white: u32) -> u8 {
    let of = |most: f32| (value.to_f32() * (most / white.to_f32())).round();
    match white {
        0..=254 => of(255.0).to_u8(),
        255 => value.min(255) as u8,
        _ => narrow(of(65_535.0).to_u16()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_bytes_are_read_alike() {
        for image in [
            &b"P2\n# a comment\n3 1\n255\n0 128\n255"[..],
            b"P2 3 1 #c\n255 0 128 255 and more",
            b"P5\n3 1\n255\n\x00\x80\xff",
            b"P5 3 1 65535\n\x00\x00\x80\x80\xff\xff",
        ] {
            let pixels = decode(image).unwrap();
            assert_eq!((pixels.width, pixels.height), (3, 1));
            assert_eq!(pixels.grey, [0, 128, 255]);
        }
        assert_eq!(decode(b"P2 3 1 100 0 50 100").unwrap().grey, [0, 128, 255]);
    }

    #[test]
    fn broken_images_are_refused() {
        for (image, word) in [
            (&b"P5"[..], "header"),
            (b"P5x", "header"),
            (b"P5 2", "height: the file is truncated"),
            (b"P5 2 2 0\n", "largest value is 0"),
            (b"P5 99999 2 255\n", "width"),
            (b"P5 9000 2 255\n", "9000 x 2"),
            (b"P5 2 2 255\n123", "truncated, 3 of 4 bytes"),
            (b"P5 2 2 65535\n1234567", "truncated, 7 of 8 bytes"),
            (b"P2 2 2 255 1 2 3", "truncated, 3 of 4 pixels"),
            (b"P2 2 2 255 1 2 3 -4", "no number"),
        ] {
            let why = decode(image).unwrap_err();
            assert!(why.contains(word), "{why}");
        }
    }
}
