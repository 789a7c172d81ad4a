//! The files that `render` writes: checked before anything is drawn, and put in their place only when they are whole.

use crate::error::LabError;
use image::{Rgb32FImage, RgbaImage};
use std::path::{Path, PathBuf};

/// What a picture's file holds, by its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PictureFormat {
    /// 8-bit values as they are sent to the display.
    Png,
    /// The renderer's linear light in full floats, before exposure and tone map.
    Exr,
}

impl PictureFormat {
    /// The format of `--out`.
    pub(super) fn of(path: &Path) -> Result<Self, LabError> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(LabError::BadInput(format!(
                "--out {}: expected a file that ends in .png, or in .exr for linear light",
                path.display()
            ))),
        }
    }
}

fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |extension| extension.to_string_lossy().to_ascii_lowercase())
}

/// Refuses a heat map that is no PNG file.
pub(super) fn check_heat_map(path: &Path) -> Result<(), LabError> {
    if extension(path) == "png" {
        return Ok(());
    }
    Err(LabError::BadInput(format!("--heatmap {}: expected a file that ends in .png", path.display())))
}

/// Refuses a file whose folder is not there, and a folder.
pub(super) fn check_place(option: &str, path: &Path) -> Result<(), LabError> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(LabError::BadInput(format!(
            "{option} {}: expected a folder that exists, found no {}",
            path.display(),
            folder.display()
        )));
    }
    if path.is_dir() {
        return Err(LabError::BadInput(format!("{option} {}: expected a file, found a folder", path.display())));
    }
    Ok(())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Writes an 8-bit picture.
pub(super) fn write_png(path: &Path, picture: &RgbaImage) -> Result<(), LabError> {
    whole(path, |unfinished| picture.save_with_format(unfinished, image::ImageFormat::Png))
}

/// Writes the linear light of RGBA values, row by row from the top.
pub(super) fn write_exr(path: &Path, size_px: [u32; 2], rgba: &[f32]) -> Result<(), LabError> {
    let rgb: Vec<f32> = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let picture = Rgb32FImage::from_raw(size_px[0], size_px[1], rgb)
        .ok_or_else(|| LabError::Failed("the picture came back with pixels missing".to_owned()))?;
    whole(path, |unfinished| picture.save_with_format(unfinished, image::ImageFormat::OpenExr))
}

/// Writes beside the place and moves the file there when it is whole; what was there until then stays otherwise.
fn whole(path: &Path, write: impl FnOnce(&Path) -> image::ImageResult<()>) -> Result<(), LabError> {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let unfinished = folder_of(path).join(format!(".{name}.{}.part", std::process::id()));
    let written = write(&unfinished).map_err(|error| error.to_string());
    let moved = written.and_then(|()| std::fs::rename(&unfinished, path).map_err(|error| error.to_string()));
    moved.map_err(|error| {
        // It may not even have been begun.
        let _ = std::fs::remove_file(&unfinished);
        LabError::Failed(format!("cannot write {}: {error}", path.display()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides() {
        assert_eq!(PictureFormat::of(Path::new("a/b.PNG")).ok(), Some(PictureFormat::Png));
        assert_eq!(PictureFormat::of(Path::new("b.exr")).ok(), Some(PictureFormat::Exr));
        for other in ["b.jpg", "b", "exr", ".png", ""] {
            assert!(PictureFormat::of(Path::new(other)).is_err(), "{other}");
        }
    }
}
