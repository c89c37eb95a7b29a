//! Pictures as PNG files.

use std::io::Write;

use estimand::render::Image;
use png::{BitDepth, ColorType, Encoder, EncodingError};

/// Bytes of an image's size, as grey or as red, green, blue.
pub fn write_png(
    out: impl Write,
    image: &Image,
    bytes: &[u8],
    colour: ColorType,
) -> Result<(), EncodingError> {
    let mut encoder = Encoder::new(out, image.width, image.height);
    encoder.set_color(colour);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}
