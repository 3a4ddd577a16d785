//! Pixels of a map image: PGM (P2, P5) or PNG, also packed as `IMAGE.gz`.

use crate::map_file_error::MapFileError;
use image::{DynamicImage, ImageDecoder, ImageReader};
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use zeronav_msgs::grid::SIDE_CELLS_MAX;

/// Largest image file, unpacked: the largest map as ASCII PGM. [bytes]
const IMAGE_BYTES_MAX: u64 = 4 * (SIDE_CELLS_MAX as u64) * (SIDE_CELLS_MAX as u64) + 1_000_000;

/// An image as map servers see it: the mean of the colours, and what is transparent. Row-major
/// from the upper left.
pub(crate) struct Pixels {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// 0 = black.
    pub(crate) grey: Vec<u8>,
    /// 255 = opaque; empty = all opaque.
    pub(crate) alpha: Vec<u8>,
}

impl Pixels {
    /// Opacity of a pixel, 255 = opaque.
    pub(crate) fn alpha_at(&self, index: usize) -> u8 {
        self.alpha.get(index).copied().unwrap_or(u8::MAX)
    }
}

/// Reads `file`, or `file.gz` when only that exists.
pub(crate) fn read(file: &Path) -> Result<Pixels, MapFileError> {
    let (file, bytes) = bytes_of(file)?;
    let refused = |why: String| MapFileError::Image {
        file: file.clone(),
        why,
    };
    let image_error = |error: image::ImageError| refused(error.to_string());
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| refused(error.to_string()))?;
    // The size is checked below, with words that help.
    reader.no_limits();
    let decoder = reader.into_decoder().map_err(image_error)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width.max(height) > SIDE_CELLS_MAX {
        return Err(refused(format!(
            "{width} x {height} pixels, a map has 1 to {SIDE_CELLS_MAX} along each side"
        )));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(image_error)?;
    let (grey, alpha) = channels(image);
    Ok(Pixels {
        width,
        height,
        grey,
        alpha,
    })
}

fn channels(image: DynamicImage) -> (Vec<u8>, Vec<u8>) {
    match image {
        DynamicImage::ImageLuma8(grey) => (grey.into_raw(), Vec::new()),
        other => {
            let has_alpha = other.color().has_alpha();
            let colours = other.into_rgba8();
            let mean = |[r, g, b, _]: [u8; 4]| {
                let sum = u16::from(r) + u16::from(g) + u16::from(b);
                u8::try_from((sum + 1) / 3).unwrap_or(u8::MAX)
            };
            let grey = colours.pixels().map(|pixel| mean(pixel.0)).collect();
            let alpha = if has_alpha {
                colours.pixels().map(|pixel| pixel.0[3]).collect()
            } else {
                Vec::new()
            };
            (grey, alpha)
        }
    }
}

fn bytes_of(file: &Path) -> Result<(PathBuf, Vec<u8>), MapFileError> {
    let read = |file: &Path, packed: bool| {
        let failed = |source: io::Error| MapFileError::Read {
            file: file.to_path_buf(),
            source,
        };
        let opened = File::open(file).map_err(failed)?;
        let mut bytes = Vec::new();
        // One byte more than allowed tells too large from just large enough.
        let limit = IMAGE_BYTES_MAX + 1;
        if packed {
            let mut unpacked = flate2::read::MultiGzDecoder::new(opened).take(limit);
            unpacked.read_to_end(&mut bytes).map_err(failed)?;
        } else {
            let mut plain = opened.take(limit);
            plain.read_to_end(&mut bytes).map_err(failed)?;
        }
        if bytes.len() as u64 > IMAGE_BYTES_MAX {
            return Err(MapFileError::Image {
                file: file.to_path_buf(),
                why: format!("more than {IMAGE_BYTES_MAX} bytes"),
            });
        }
        Ok((file.to_path_buf(), bytes))
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
