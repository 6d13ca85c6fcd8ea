use thiserror::Error;

use super::resample::resample;
use crate::model::CROP;
use crate::scene::{ObjectFault, location_fault};

/// An image of bytes, red, green and blue for each pixel, row by row from the top.
#[derive(Debug, Clone, Copy)]
pub struct RgbImage<'a> {
    pixels: &'a [u8],
    width: u32,
    height: u32,
    stride: usize,
}

/// Why bytes are not a valid image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Width or height is zero or more than 65,535 pixels.
    #[error("image: {width}×{height} pixels; each side must be from 1 to 65535")]
    Size {
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
    },
    /// Rows overlap: the stride is less than three bytes per pixel.
    #[error("image: a stride of {got} bytes, but a row takes {expected}")]
    Stride {
        /// The smallest valid stride, in bytes.
        expected: usize,
        /// Bytes from one row to the next.
        got: usize,
    },
    /// Fewer bytes than the size needs.
    #[error("image: {got} bytes, but its size takes {expected}")]
    Length {
        /// The number needed.
        expected: usize,
        /// Bytes given.
        got: usize,
    },
}

impl<'a> RgbImage<'a> {
    /// An image in `pixels`.
    ///
    /// * `stride`: bytes from the start of one row to the next, at least `3·width`
    ///
    /// ```
    /// use nsrm_core::vision::{ImageError, RgbImage};
    ///
    /// let pixels = [0; 3 * 4 * 2];
    /// assert!(RgbImage::new(&pixels, 4, 2, 3 * 4).is_ok());
    /// let short = RgbImage::new(&pixels, 4, 3, 3 * 4).unwrap_err();
    /// assert_eq!(short, ImageError::Length { expected: 36, got: 24 });
    /// ```
    pub fn new(
        pixels: &'a [u8],
        width: u32,
        height: u32,
        stride: usize,
    ) -> Result<Self, ImageError> {
        let size = ImageError::Size { width, height };
        let side = |pixels: u32| match u16::try_from(pixels) {
            Ok(side) if side > 0 => Ok(usize::from(side)),
            _ => Err(size),
        };
        let row = 3 * side(width)?;
        let rows_before_last = side(height)?.saturating_sub(1);
        if stride < row {
            return Err(ImageError::Stride {
                expected: row,
                got: stride,
            });
        }
        let length = stride
            .checked_mul(rows_before_last)
            .and_then(|bytes| bytes.checked_add(row))
            .ok_or(size)?;
        if pixels.len() < length {
            return Err(ImageError::Length {
                expected: length,
                got: pixels.len(),
            });
        }
        Ok(Self {
            pixels,
            width,
            height,
            stride,
        })
    }

    /// Width in pixels.
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The bytes of a row and of all behind it.
    #[inline(always)]
    pub(super) fn bytes_from(&self, row: usize) -> &'a [u8] {
        let begin = row.wrapping_mul(self.stride);
        self.pixels.get(begin..).unwrap_or_default()
    }
}

/// The encoder's input for an object: its box resampled to 32×32 pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Crop {
    /// Red, green and blue from 0 to 1, by channel, row, column.
    pub channels: [[[f32; CROP]; CROP]; 3],
}

impl Crop {
    /// All black.
    pub const BLACK: Self = Self {
        channels: [[[0.0; CROP]; CROP]; 3],
    };

    /// Cuts a box out of an image.
    ///
    /// Each pixel is the mean of 2×2 samples at ¼ and ¾ of its width and height;
    /// each sample is bilinear between the image's pixel centres (at + ½) and held
    /// at the image's edge.
    ///
    /// * `bounds`: corners x1, y1, x2, y2 as fractions of the image's width and height
    ///
    /// Cost: at most 128 rows with 128 pixels each, and `128²` multiply-adds, for any size of box and
    /// image.
    ///
    /// ```
    /// use nsrm_core::vision::{Crop, RgbImage};
    ///
    /// let pixels = [255; 3 * 40 * 40];
    /// let image = RgbImage::new(&pixels, 40, 40, 3 * 40)?;
    /// let crop = Crop::from_rgb(&image, &[0.25, 0.25, 0.75, 0.75])?;
    /// assert_eq!(crop.channels[0][0][0], 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_rgb(image: &RgbImage<'_>, bounds: &[f32; 4]) -> Result<Self, ObjectFault> {
        let mut crop = Self::BLACK;
        crop.fill(image, bounds)?;
        Ok(crop)
    }

    /// [`Crop::from_rgb`] into existing memory.
    pub fn fill(&mut self, image: &RgbImage<'_>, bounds: &[f32; 4]) -> Result<(), ObjectFault> {
        let [x1, y1, x2, y2] = *bounds;
        if let Some(fault) = location_fault(&[x1, y1, x2, y2, 1.0]) {
            return Err(fault);
        }
        resample(image, bounds, &mut self.channels);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red rises by 2 a column, green by 3 a row, blue is 60 everywhere.
    fn ramp(width: usize, height: usize, stride: usize) -> std::vec::Vec<u8> {
        let mut pixels = std::vec![255; stride * height];
        for (row, line) in pixels.chunks_mut(stride).enumerate() {
            for (column, pixel) in line.chunks_mut(3).take(width).enumerate() {
                pixel.copy_from_slice(&[2 * column as u8, 3 * row as u8, 60]);
            }
        }
        pixels
    }

    #[test]
    fn a_ramp_is_sampled_at_pixel_centres() {
        let pixels = ramp(100, 50, 301);
        let image = RgbImage::new(&pixels, 100, 50, 301).unwrap();
        let crop = Crop::from_rgb(&image, &[0.25, 0.2, 0.57, 0.84]).unwrap();
        let [red, green, blue] = &crop.channels;
        for row in 0..CROP {
            for column in 0..CROP {
                // The box's 32 × 32 image pixels are the crop's.
                let expected = [2 * (25 + column), 3 * (10 + row), 60];
                let got = [red[row][column], green[row][column], blue[row][column]];
                for (got, expected) in got.iter().zip(expected) {
                    let expected = expected as f32 / 255.0;
                    assert!((got - expected).abs() < 1e-4, "{row} {column}: {got}");
                }
            }
        }
    }

    #[test]
    fn of_a_wide_box_two_samples_make_a_pixel() {
        let mut pixels = std::vec![0; 3 * 128 * 96];
        for (index, pixel) in pixels.chunks_mut(3).enumerate() {
            pixel.copy_from_slice(&[(index % 128) as u8, (index / 128) as u8, 0]);
        }
        let image = RgbImage::new(&pixels, 128, 96, 3 * 128).unwrap();
        let crop = Crop::from_rgb(&image, &[0.0, 0.0, 1.0, 1.0]).unwrap();
        let [red, green, _] = &crop.channels;
        for index in 0..CROP {
            // Samples at ¼ and ¾ of 4 columns, or 3 rows: as far as the middle.
            let (column, row) = (4.0 * index as f32 + 1.5, 3.0 * index as f32 + 1.0);
            assert!((red[7][index] - column / 255.0).abs() < 1e-6, "{index}");
            assert!((green[index][7] - row / 255.0).abs() < 1e-6, "{index}");
        }
    }

    #[test]
    fn a_box_at_the_edge_holds_the_outermost_pixels() {
        let pixels = [0, 10, 20, 100, 110, 120];
        let image = RgbImage::new(&pixels, 2, 1, 6).unwrap();
        let crop = Crop::from_rgb(&image, &[0.0, 0.0, 1.0, 1.0]).unwrap();
        let red = &crop.channels[0];
        // Samples up to the first centre, at column 8, are held; then they rise by
        // 100/16 a column.
        assert_eq!((red[0][0], red[31][7]), (0.0, 0.0));
        assert!((red[5][8] - 3.125 / 255.0).abs() < 1e-6);
        assert!((red[5][23] - 96.875 / 255.0).abs() < 1e-6);
        assert!((red[5][31] - 100.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn bytes_that_are_no_image_are_refused() {
        let pixels = [0; 11];
        let error = |width, height, stride| RgbImage::new(&pixels, width, height, stride).err();
        let size = |width, height| Some(ImageError::Size { width, height });
        assert_eq!(error(0, 1, 3), size(0, 1));
        assert_eq!(error(1, 70_000, 3), size(1, 70_000));
        let (expected, got) = (6, 5);
        assert_eq!(error(2, 1, 5), Some(ImageError::Stride { expected, got }));
        let (expected, got) = (12, 11);
        assert_eq!(error(2, 2, 6), Some(ImageError::Length { expected, got }));
        assert_eq!(
            error(1, 2, usize::MAX),
            Some(ImageError::Size {
                width: 1,
                height: 2
            })
        );
        // The last row needs no padding.
        assert_eq!(error(1, 2, 8), None);
    }

    #[test]
    fn a_box_that_is_none_is_refused() {
        let pixels = [0; 3];
        let image = RgbImage::new(&pixels, 1, 1, 3).unwrap();
        let fault = |bounds| Crop::from_rgb(&image, &bounds).err();
        assert_eq!(
            fault([0.5, 0.0, 0.5, 1.0]),
            Some(ObjectFault::BoxNotOrdered)
        );
        assert_eq!(
            fault([0.0, 0.0, 1.1, 1.0]),
            Some(ObjectFault::BoxOutsideImage)
        );
        assert_eq!(
            fault([0.0, f32::NAN, 1.0, 1.0]),
            Some(ObjectFault::LocationNotFinite)
        );
    }
}
