//! Pictures on surfaces: decoded within limits, made smaller where they are larger than is drawn, and each kept once for
//! colours and once for numbers if it is used as both.

use super::accessors::Buffers;
use super::container::fetch;
use super::document::Document;
use super::errors::Findings;
use crate::world::Map;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// The longest side of a map that is kept, pixels.
const MOST_SIDE: u32 = 2048;
/// The longest side that is decoded at all.
const MOST_DECODED_SIDE: u32 = 16_384;
/// Bytes that a decoder may take.
const MOST_DECODER_BYTES: u64 = 1 << 30;
/// Pixels of all maps of a file together.
const MOST_PIXELS: u64 = 1 << 27;

/// Whether a map's values are colours (sRGB) or numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Meaning {
    Colours,
    Numbers,
}

/// Reads the images that materials use.
#[derive(Debug)]
pub(crate) struct Images<'a> {
    document: &'a Document,
    buffers: &'a Buffers,
    folder: &'a Path,
    pixels_left: u64,
    /// Decoded images by index; nothing for those that are wrong.
    decoded: HashMap<usize, Option<Map>>,
    /// Where an image is among the maps.
    placed: HashMap<(usize, Meaning), usize>,
    pub(crate) colour_maps: Vec<Map>,
    pub(crate) data_maps: Vec<Map>,
}

impl<'a> Images<'a> {
    pub(crate) fn new(document: &'a Document, buffers: &'a Buffers, folder: &'a Path) -> Self {
        Self {
            document,
            buffers,
            folder,
            pixels_left: MOST_PIXELS,
            decoded: HashMap::new(),
            placed: HashMap::new(),
            colour_maps: Vec::new(),
            data_maps: Vec::new(),
        }
    }

    /// The index among the maps of the texture `texture`, which the element at `place` uses.
    pub(crate) fn map(
        &mut self,
        texture: usize,
        meaning: Meaning,
        place: &str,
        findings: &mut Findings,
    ) -> Option<usize> {
        let Some(found) = self.document.textures.get(texture) else {
            let count = self.document.textures.len();
            findings.wrong(format!("{place}.index"), format!("there is no texture {texture}; the file has {count}"));
            return None;
        };
        let Some(image) = found.source else {
            findings.note(place, "its texture has no image that can be read (PNG and JPEG can); it is left out");
            return None;
        };
        if let Some(&index) = self.placed.get(&(image, meaning)) {
            return Some(index);
        }
        let (document, buffers, folder) = (self.document, self.buffers, self.folder);
        let pixels_left = &mut self.pixels_left;
        let decoded = self.decoded.entry(image).or_insert_with(|| {
            let place = format!("images[{image}]");
            if *pixels_left == 0 {
                return None;
            }
            let bytes = bytes_of(image, document, buffers, folder);
            let map = bytes.and_then(|bytes| decoded(&bytes)).and_then(|(map, shrunk)| {
                let pixels = u64::from(map.size[0]) * u64::from(map.size[1]);
                *pixels_left = pixels_left.checked_sub(pixels).unwrap_or_default();
                if *pixels_left == 0 {
                    return Err(format!("the images up to this one have more than {MOST_PIXELS} pixels in all"));
                }
                if shrunk {
                    findings.note(&*place, format!("it is made smaller, to at most {MOST_SIDE} pixels a side"));
                }
                Ok(map)
            });
            map.map_err(|message| findings.wrong(place, message)).ok()
        });
        let map = decoded.clone()?;
        let maps = match meaning {
            Meaning::Colours => &mut self.colour_maps,
            Meaning::Numbers => &mut self.data_maps,
        };
        maps.push(map);
        self.placed.insert((image, meaning), maps.len() - 1);
        Some(maps.len() - 1)
    }
}

fn bytes_of(index: usize, document: &Document, buffers: &Buffers, folder: &Path) -> Result<Vec<u8>, String> {
    let count = document.images.len();
    let image = document.images.get(index).ok_or_else(|| format!("there is no image {index}; the file has {count}"))?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), None) => fetch(uri, folder),
        (None, Some(view)) => buffers.view(document, view).map(<[u8]>::to_vec),
        _ => Err("expected either a uri or a bufferView".to_owned()),
    }
}

/// Decodes a picture, and whether it had to be made smaller.
fn decoded(bytes: &[u8]) -> Result<(Map, bool), String> {
    let mut reader = image::ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| format!("the picture cannot be read: {error}"))?;
    if !matches!(reader.format(), Some(image::ImageFormat::Png | image::ImageFormat::Jpeg)) {
        return Err("the picture is neither PNG nor JPEG".to_owned());
    }
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MOST_DECODED_SIDE);
    limits.max_image_height = Some(MOST_DECODED_SIDE);
    limits.max_alloc = Some(MOST_DECODER_BYTES);
    reader.limits(limits);
    let mut picture = reader.decode().map_err(|error| format!("the picture cannot be read: {error}"))?;
    let shrunk = picture.width().max(picture.height()) > MOST_SIDE;
    if shrunk {
        picture = picture.resize(MOST_SIDE, MOST_SIDE, image::imageops::FilterType::Triangle);
    }
    let rgba = picture.into_rgba8();
    Ok((Map { size: [rgba.width(), rgba.height()], rgba: rgba.into_raw() }, shrunk))
}
