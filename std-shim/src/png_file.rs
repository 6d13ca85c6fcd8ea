//! Decodes PNG images.

use std::io::{BufRead, Seek};

use png::{ColorType, Decoder, DecodingError, Transformations};

/// The largest decoded image, bytes: a header of a few bytes must not take all memory.
const MAX_BYTES: usize = 512 << 20;

/// A decoded image.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// `[height][width][3]`
    pub(crate) rgb: Vec<u8>,
}

/// Decodes a PNG image of any colour type and depth; transparency is dropped.
pub(crate) fn decode(file: impl BufRead + Seek) -> Result<Picture, DecodingError> {
    let mut decoder = Decoder::new(file);
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info()?;
    let size = reader.output_buffer_size();
    let size = size.filter(|size| *size <= MAX_BYTES);
    let mut pixels = vec![0; size.ok_or(DecodingError::LimitsExceeded)?];
    let frame = reader.next_frame(&mut pixels)?;
    pixels.truncate(frame.buffer_size());
    let rgb = match frame.color_type {
        // Indices are expanded to colours.
        ColorType::Rgb | ColorType::Indexed => pixels,
        ColorType::Rgba => of_each(&pixels, 4, |pixel| [pixel[0], pixel[1], pixel[2]]),
        ColorType::Grayscale => of_each(&pixels, 1, |pixel| [pixel[0]; 3]),
        ColorType::GrayscaleAlpha => of_each(&pixels, 2, |pixel| [pixel[0]; 3]),
    };
    Ok(Picture {
        width: frame.width,
        height: frame.height,
        rgb,
    })
}

/// The colours of pixels with this many channels.
fn of_each(pixels: &[u8], channels: usize, color: impl Fn(&[u8]) -> [u8; 3]) -> Vec<u8> {
    pixels.chunks_exact(channels).flat_map(color).collect()
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use png::{BitDepth, ColorType, DecodingError, Encoder};

    use super::decode;

    /// Bytes of the signature and the header.
    const HEADER: usize = 8 + 25;

    fn encoded(color: ColorType, depth: BitDepth, size: (u32, u32), pixels: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, size.0, size.1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_palette([0, 0, 0, 10, 20, 30].as_slice());
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(pixels).unwrap();
        drop(writer);
        bytes
    }

    #[test]
    fn every_colour_type_becomes_red_green_and_blue() {
        let (eight, sixteen) = (BitDepth::Eight, BitDepth::Sixteen);
        for (color, depth, pixels, rgb) in [
            (
                ColorType::Rgb,
                eight,
                &[1, 2, 3, 4, 5, 6][..],
                [1, 2, 3, 4, 5, 6],
            ),
            (
                ColorType::Rgba,
                eight,
                &[1, 2, 3, 0, 4, 5, 6, 255],
                [1, 2, 3, 4, 5, 6],
            ),
            (ColorType::Grayscale, eight, &[7, 8], [7, 7, 7, 8, 8, 8]),
            (
                ColorType::GrayscaleAlpha,
                eight,
                &[7, 0, 8, 9],
                [7, 7, 7, 8, 8, 8],
            ),
            (ColorType::Indexed, eight, &[1, 0], [10, 20, 30, 0, 0, 0]),
            (
                ColorType::Grayscale,
                sixteen,
                &[7, 99, 8, 99],
                [7, 7, 7, 8, 8, 8],
            ),
            (
                ColorType::Grayscale,
                BitDepth::One,
                &[0b0100_0000],
                [0, 0, 0, 255, 255, 255],
            ),
        ] {
            let picture = decode(Cursor::new(encoded(color, depth, (2, 1), pixels))).unwrap();
            assert_eq!((picture.width, picture.height), (2, 1));
            assert_eq!(picture.rgb, rgb, "{color:?} {depth:?}");
        }
    }

    #[test]
    fn a_header_that_promises_too_much_is_refused_before_memory_is_taken() {
        let mut bytes = Vec::new();
        drop(
            Encoder::new(&mut bytes, 1 << 20, 1 << 20)
                .write_header()
                .unwrap(),
        );
        let small = encoded(ColorType::Grayscale, BitDepth::Eight, (1, 1), &[7]);
        bytes.splice(HEADER.., small.into_iter().skip(HEADER));
        let refused = decode(Cursor::new(bytes)).unwrap_err();
        assert!(
            matches!(refused, DecodingError::LimitsExceeded),
            "{refused}"
        );
    }

    #[test]
    fn what_is_no_png_or_half_of_one_is_refused() {
        let bytes = encoded(ColorType::Grayscale, BitDepth::Eight, (2, 1), &[7, 8]);
        assert!(decode(Cursor::new(b"GIF89a")).is_err());
        assert!(decode(Cursor::new(&bytes[..bytes.len() / 2])).is_err());
    }
}
