//! Pixels of a map image: PGM (P2, P5) or PNG, also packed as `IMAGE.gz`.

use crate::map_file_error::MapFileError;
use crate::pgm;
use crate::pixels::{Pixels, check_size, narrow};
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use zeronav_files::read;
use zeronav_msgs::grid::SIDE_CELLS_MAX;

/// Largest image file, unpacked: the largest map as ASCII PGM. [bytes]
const IMAGE_BYTES_MAX: u64 = 4 * (SIDE_CELLS_MAX as u64) * (SIDE_CELLS_MAX as u64) + 1_000_000;

/// Most memory that a PNG may take beside its pixels: palettes and the like. [bytes]
const PNG_BYTES_MAX: usize = 16 << 20;

/// How a PNG begins.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Reads `file`, or `file.gz` when only that exists.
pub(crate) fn read(file: &Path) -> Result<Pixels, MapFileError> {
    let (file, bytes) = bytes_of(file)?;
    let pixels = match bytes.get(..2) {
        Some(b"P2" | b"P5") => pgm::decode(&bytes),
        _ if bytes.starts_with(PNG_SIGNATURE) => png(&bytes),
        _ => Err("neither a PGM (P2, P5) nor a PNG image".to_owned()),
    };
    pixels.map_err(|why| MapFileError::Image { file, why })
}

/// Reads the pixels; colour profiles, texts and whatever else a PNG may carry are not unpacked.
fn png(bytes: &[u8]) -> Result<Pixels, String> {
    let limits = png::Limits {
        bytes: PNG_BYTES_MAX,
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::EXPAND);
    let broken = |error: png::DecodingError| match error {
        png::DecodingError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            "the file is truncated".to_owned()
        }
        error => error.to_string(),
    };
    let (width, height) = {
        let header = decoder.read_header_info().map_err(broken)?;
        (header.width, header.height)
    };
    let n_pixels = check_size(width, height)?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let (colours, depth) = reader.output_color_type();
    let has_alpha = matches!(
        colours,
        png::ColorType::GrayscaleAlpha | png::ColorType::Rgba
    );
    let mut grey = vec![0; n_pixels];
    let mut alpha = vec![0; if has_alpha { n_pixels } else { 0 }];
    // Row by row: eight bytes a pixel, as of colours with 16 bits, are never there for the whole image.
    let (mut line, mut row) = (0, Row::default());
    while let Some(read) = reader.next_interlaced_row().map_err(broken)? {
        row.take(read.data(), colours, depth)?;
        for (pixels, of_row) in [(&mut grey, &row.grey), (&mut alpha, &row.alpha)] {
            match read.interlace() {
                png::InterlaceInfo::Adam7(_) if of_row.is_empty() => {}
                png::InterlaceInfo::Adam7(pass) => {
                    png::expand_interlaced_row(pixels, width as usize, of_row, pass, 8);
                }
                png::InterlaceInfo::Null(_) => {
                    let there = pixels.iter_mut().skip(line * width as usize);
                    there.zip(of_row).for_each(|(pixel, value)| *pixel = *value);
                }
            }
        }
        line += 1;
    }
    Ok(Pixels {
        width,
        height,
        grey,
        alpha,
    })
}

/// One row of a PNG, or of a pass over it.
#[derive(Default)]
struct Row {
    samples: Vec<u8>,
    grey: Vec<u8>,
    /// Empty when everything is opaque.
    alpha: Vec<u8>,
}

impl Row {
    /// Takes in samples of 8 or 16 bits.
    fn take(
        &mut self,
        data: &[u8],
        colours: png::ColorType,
        depth: png::BitDepth,
    ) -> Result<(), String> {
        let Self {
            samples,
            grey,
            alpha,
        } = self;
        for buffer in [&mut *samples, &mut *grey, &mut *alpha] {
            buffer.clear();
        }
        if depth == png::BitDepth::Sixteen {
            let wide = data.chunks_exact(2);
            samples.extend(wide.map(|pair| narrow(u16::from_be_bytes([pair[0], pair[1]]))));
        } else {
            samples.extend_from_slice(data);
        }
        let mean = |pixel: &[u8]| {
            let sum: u16 = pixel[..3].iter().copied().map(u16::from).sum();
            u8::try_from((sum + 1) / 3).unwrap_or(u8::MAX)
        };
        match colours {
            png::ColorType::Grayscale => grey.extend_from_slice(samples),
            png::ColorType::GrayscaleAlpha => {
                grey.extend(samples.chunks_exact(2).map(|pixel| pixel[0]));
                alpha.extend(samples.chunks_exact(2).map(|pixel| pixel[1]));
            }
            png::ColorType::Rgb => grey.extend(samples.chunks_exact(3).map(mean)),
            png::ColorType::Rgba => {
                grey.extend(samples.chunks_exact(4).map(mean));
                alpha.extend(samples.chunks_exact(4).map(|pixel| pixel[3]));
            }
            png::ColorType::Indexed => return Err("its palette is missing".to_owned()),
        }
        Ok(())
    }
}

fn bytes_of(file: &Path) -> Result<(PathBuf, Vec<u8>), MapFileError> {
    let read = |file: &Path, packed: bool| {
        let bytes = read::open(file).and_then(|opened| {
            if packed {
                let unpacked = flate2::read::MultiGzDecoder::new(opened);
                read::bounded(unpacked, IMAGE_BYTES_MAX)
            } else {
                read::bounded(opened, IMAGE_BYTES_MAX)
            }
        });
        let failed = |source: io::Error| MapFileError::Read {
            file: file.to_path_buf(),
            source,
        };
        Ok((file.to_path_buf(), bytes.map_err(failed)?))
    };
    if !file.exists() {
        let mut name = file.as_os_str().to_owned();
        name.push(".gz");
        let packed = PathBuf::from(name);
        if packed.exists() {
            return read(&packed, true);
        }
    }
    read(file, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn encoded(colours: png::ColorType, depth: png::BitDepth, samples: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colours);
        encoder.set_depth(depth);
        if colours == png::ColorType::Indexed {
            encoder.set_palette(vec![0, 0, 0, 255, 255, 255]);
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(samples).unwrap();
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn every_kind_of_png_is_read_as_grey() {
        use png::{BitDepth, ColorType};
        let is = |colours, depth, samples: &[u8], grey: [u8; 2], alpha: &[u8]| {
            let pixels = png(&encoded(colours, depth, samples)).unwrap();
            assert_eq!((&pixels.grey[..], &pixels.alpha[..]), (&grey[..], alpha));
        };
        is(ColorType::Grayscale, BitDepth::Eight, &[7, 9], [7, 9], &[]);
        is(
            ColorType::Grayscale,
            BitDepth::One,
            &[0b0100_0000],
            [0, 255],
            &[],
        );
        let wide = [0x80, 0x80, 0xff, 0x00];
        is(
            ColorType::Grayscale,
            BitDepth::Sixteen,
            &wide,
            [128, 254],
            &[],
        );
        is(
            ColorType::GrayscaleAlpha,
            BitDepth::Eight,
            &[1, 2, 3, 4],
            [1, 3],
            &[2, 4],
        );
        is(
            ColorType::Rgb,
            BitDepth::Eight,
            &[255, 0, 0, 1, 1, 2],
            [85, 1],
            &[],
        );
        let rgba = [255, 0, 0, 9, 1, 1, 2, 8];
        is(ColorType::Rgba, BitDepth::Eight, &rgba, [85, 1], &[9, 8]);
        is(ColorType::Indexed, BitDepth::Eight, &[1, 0], [255, 0], &[]);
    }

    /// A chunk of a PNG.
    fn chunk(name: [u8; 4], data: &[u8]) -> Vec<u8> {
        let body = [&name[..], data].concat();
        let mut crc = flate2::Crc::new();
        crc.update(&body);
        let length = u32::try_from(data.len()).unwrap();
        [&length.to_be_bytes()[..], &body, &crc.sum().to_be_bytes()].concat()
    }

    /// The passes over an interlaced image: first column and row, and the steps between them.
    const PASSES: [[usize; 4]; 7] = [
        [0, 0, 8, 8],
        [4, 0, 8, 8],
        [0, 4, 4, 8],
        [2, 0, 4, 4],
        [0, 2, 2, 4],
        [1, 0, 2, 2],
        [0, 1, 1, 2],
    ];

    /// A square image of colours and opacity with 16 bits each, 8 bytes a pixel, as a file.
    fn wide(side: u16, interlaced: bool, pixel: impl Fn(usize, usize) -> [u16; 4]) -> Vec<u8> {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        let whole = [[0, 0, 1, 1]];
        let passes = if interlaced { &PASSES[..] } else { &whole[..] };
        let side_usize = usize::from(side);
        for [x0, y0, dx, dy] in passes {
            for y in (*y0..side_usize).step_by(*dy) {
                let mut row = vec![0];
                for x in (*x0..side_usize).step_by(*dx) {
                    row.extend(pixel(x, y).iter().flat_map(|sample| sample.to_be_bytes()));
                }
                if row.len() > 1 {
                    packer.write_all(&row).unwrap();
                }
            }
        }
        let [high, low] = side.to_be_bytes();
        let header = [
            0,
            0,
            high,
            low,
            0,
            0,
            high,
            low,
            16,
            6,
            0,
            0,
            interlaced.into(),
        ];
        let data = packer.finish().unwrap();
        let chunks = [
            chunk(*b"IHDR", &header),
            chunk(*b"IDAT", &data),
            chunk(*b"IEND", &[]),
        ];
        [PNG_SIGNATURE, &chunks.concat()].concat()
    }

    #[test]
    fn an_interlaced_image_is_the_same_as_a_plain_one() {
        let pixel = |x: usize, y: usize| {
            let value = |it: usize| u16::try_from(257 * (it % 256)).unwrap();
            [
                value(x + 19 * y),
                value(x + 19 * y),
                value(x + 19 * y),
                value(7 * x + y),
            ]
        };
        for side in [1, 2, 3, 5, 8, 9, 19] {
            let plain = png(&wide(side, false, pixel)).unwrap();
            assert_eq!(png(&wide(side, true, pixel)), Ok(plain.clone()), "{side}");
            let side = usize::from(side);
            for (at, (grey, alpha)) in plain.grey.iter().zip(&plain.alpha).enumerate() {
                let (x, y) = (at % side, at / side);
                let expected = ((x + 19 * y) % 256, (7 * x + y) % 256);
                assert_eq!((usize::from(*grey), usize::from(*alpha)), expected);
            }
        }
    }

    /// The largest map would take half a gigabyte with eight bytes a pixel.
    #[test]
    fn an_image_with_sixteen_bits_takes_no_more_memory_than_its_map() {
        for interlaced in [false, true] {
            let bytes = wide(1024, interlaced, |_, _| [0xffff; 4]);
            let used = allocation_counter::measure(|| {
                let pixels = png(&bytes).unwrap();
                assert!(pixels.grey.iter().chain(&pixels.alpha).all(|it| *it == 255));
            });
            // A byte of grey and one of opacity for each pixel, and what unpacks them.
            assert!(used.bytes_max < 3 << 20, "{used:?}");
        }
    }

    #[test]
    fn a_profile_that_unpacks_to_gigabytes_is_not_unpacked() {
        let plain = encoded(png::ColorType::Grayscale, png::BitDepth::Eight, &[7, 9]);
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        let zeros = vec![0; 1 << 20];
        for _ in 0..64 {
            packer.write_all(&zeros).unwrap();
        }
        let packed = packer.finish().unwrap();
        for (name, data) in [
            (b"iCCP", [&b"it\0\0"[..], &packed].concat()),
            (b"zTXt", [&b"it\0\0"[..], &packed].concat()),
            (b"iTXt", [&b"it\0\x01\0\0\0"[..], &packed].concat()),
        ] {
            // After the header, whose chunk has 25 bytes.
            let mut bytes = plain[..33].to_vec();
            bytes.extend(chunk(*name, &data));
            bytes.extend(&plain[33..]);
            assert_eq!(png(&bytes).unwrap().grey, [7, 9]);
        }
    }

    #[test]
    fn an_image_that_ends_before_its_pixels_is_called_truncated() {
        let whole = encoded(png::ColorType::Grayscale, png::BitDepth::Eight, &[7, 9]);
        // In its header, before and in the chunk of its pixels.
        for n_bytes in [20, 33, 45] {
            let why = png(&whole[..n_bytes]).unwrap_err();
            assert!(why.contains("truncated"), "{n_bytes}: {why}");
        }
    }

    #[test]
    fn sizes_that_no_map_has_are_refused_before_the_pixels() {
        let mut header = [0, 0, 0x40, 0, 0, 0, 0x40, 0, 8, 0, 0, 0, 0].to_vec();
        let image = |header: &[u8]| [PNG_SIGNATURE, &chunk(*b"IHDR", header)].concat();
        assert!(png(&image(&header)).unwrap_err().contains("16384 x 16384"));
        header[3] = 0;
        header[2] = 0;
        assert!(png(&image(&header)).is_err());
    }
}
