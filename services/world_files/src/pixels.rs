//! What is read of a map image.

use zeronav_msgs::grid::SIDE_CELLS_MAX;

/// An image as map servers see it: the mean of the colours, and what is transparent. Row-major
/// from the upper left.
#[derive(Debug, Clone, PartialEq, Eq)]
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

/// Accepts the size of a map.
pub(crate) fn check_size(width: u32, height: u32) -> Result<usize, String> {
    if width == 0 || height == 0 || width.max(height) > SIDE_CELLS_MAX {
        return Err(format!(
            "{width} x {height} pixels, a map has 1 to {SIDE_CELLS_MAX} along each side"
        ));
    }
    Ok(width as usize * height as usize)
}

/// A 16-bit value as one of 8 bits.
pub(crate) fn narrow(value: u16) -> u8 {
    u8::try_from((u32::from(value) + 128) / 257).unwrap_or(u8::MAX)
}
