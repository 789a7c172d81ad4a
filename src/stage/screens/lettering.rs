//! Setting type: widths, line breaks and glyphs, in pixels. One light face, and a second one for the characters that the
//! first lacks, such as arrows.

use super::{LEADING, cover};
use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use image::RgbaImage;

/// The second face's arrows are small beside the first one's letters.
const OTHER_SIZE: f32 = 1.4;

/// The faces that screens are set in.
#[derive(Debug)]
pub(crate) struct Lettering<'a> {
    main: FontRef<'a>,
    other: FontRef<'a>,
}

/// Where a line stands, px from the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Place {
    /// It begins here.
    Left(f64),
    /// Its middle is here.
    Middle(f64),
    /// It ends here.
    Right(f64),
}

impl Lettering<'static> {
    /// The faces that ship with the program; nothing if they cannot be read.
    pub(crate) fn load() -> Option<Self> {
        let face = |bytes: &'static [u8]| FontRef::try_from_slice(bytes).ok();
        Some(Self { main: face(epaint_default_fonts::UBUNTU_LIGHT)?, other: face(epaint_default_fonts::HACK_REGULAR)? })
    }
}

impl Lettering<'_> {
    /// The heavier face, for a letter that stands alone.
    pub(crate) fn heavy(&self) -> &impl Font {
        &self.other
    }

    /// The width of a line, px.
    pub(crate) fn width(&self, line: &str, line_px: f64) -> f64 {
        self.set(line, line_px, |_, _| {})
    }

    /// The width of the widest line, px.
    pub(crate) fn widest(&self, lines: &[String], line_px: f64) -> f64 {
        lines.iter().map(|line| self.width(line, line_px)).fold(0.0, f64::max)
    }

    /// Draws a line whose upper edge is at `top`.
    pub(crate) fn line(&self, picture: &mut RgbaImage, line: &str, line_px: f64, place: Place, top: f64, ink: [u8; 3]) {
        let left = match place {
            Place::Left(x) => x,
            Place::Middle(x) => x - 0.5 * self.width(line, line_px),
            Place::Right(x) => x - self.width(line, line_px),
        };
        let baseline = top + f64::from(self.main.as_scaled(PxScale::from(line_px as f32)).ascent());
        self.set(line, line_px, |font, mut glyph| {
            glyph.position.x += left as f32;
            glyph.position.y = baseline as f32;
            if let Some(outlined) = font.outline_glyph(glyph) {
                let bounds = outlined.px_bounds();
                outlined.draw(|x, y, coverage| {
                    let at = (bounds.min.x as i64 + i64::from(x), bounds.min.y as i64 + i64::from(y));
                    cover(picture, at, ink, f64::from(coverage));
                });
            }
        });
    }

    /// Draws lines below each other, the first one's upper edge at `top`.
    pub(crate) fn block(
        &self,
        picture: &mut RgbaImage,
        lines: &[String],
        line_px: f64,
        place: Place,
        top: f64,
        ink: [u8; 3],
    ) {
        for (index, line) in lines.iter().enumerate() {
            self.line(picture, line, line_px, place, top + index as f64 * line_px * LEADING, ink);
        }
    }

    /// Hands over each glyph of a line that begins at 0, and returns where the line ends.
    fn set(&self, line: &str, line_px: f64, mut each: impl FnMut(&FontRef<'_>, Glyph)) -> f64 {
        let scale = PxScale::from(line_px as f32);
        let mut x = 0.0_f32;
        let mut before = None;
        for character in line.chars() {
            let other = self.main.glyph_id(character).0 == 0 && self.other.glyph_id(character).0 != 0;
            let font = if other { &self.other } else { &self.main };
            let scale = if other { PxScale::from(OTHER_SIZE * line_px as f32) } else { scale };
            let scaled = font.as_scaled(scale);
            let id = scaled.glyph_id(character);
            x += before
                .filter(|(_, from_other)| *from_other == other)
                .map_or(0.0, |(before, _)| scaled.kern(before, id));
            each(font, id.with_scale_and_position(scale, point(x, 0.0)));
            x += scaled.h_advance(id);
            before = Some((id, other));
        }
        f64::from(x)
    }

    /// Breaks text into lines no wider than `room_px` where words allow; its own line breaks stay.
    pub(crate) fn wrap(&self, text: &str, line_px: f64, room_px: f64) -> Vec<String> {
        let mut lines = Vec::new();
        for paragraph in text.split('\n') {
            let mut line = String::new();
            for word in paragraph.split_whitespace() {
                let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
                if line.is_empty() || self.width(&longer, line_px) <= room_px {
                    line = longer;
                } else {
                    lines.push(std::mem::replace(&mut line, word.to_owned()));
                }
            }
            lines.push(line);
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_hints_use_can_be_set() {
        let lettering = Lettering::load().expect("ships");
        for character in "←→↑↓–−°ΔéÄ09Az".chars() {
            let known = lettering.main.glyph_id(character).0 != 0 || lettering.other.glyph_id(character).0 != 0;
            assert!(known, "{character}");
        }
    }

    #[test]
    fn lines_are_no_wider_than_the_room_and_lose_no_word() {
        let lettering = Lettering::load().expect("ships");
        let text = "Which of the two was better: the first, the second, or neither of them?";
        let lines = lettering.wrap(text, 20.0, 180.0);
        assert!(lines.len() > 2 && lettering.widest(&lines, 20.0) <= 180.0);
        assert_eq!(lines.join(" "), text);
    }
}
