//! Logged frames as picture files. A folder is whole or not there: it is filled under another name first.

use super::overlay::{Overlay, Parts};
use super::{Drawer, Drawn, ink};
use crate::error::LabError;
use crate::session::tables::FrameRow;
use image::RgbaImage;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What exported pictures show besides what was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Look {
    /// What is painted over.
    pub parts: Parts,
    /// Whether the full-resolution reference stands beside it.
    pub reference: bool,
}

impl Look {
    /// A frame as it is exported. `seen` is what the drawer has drawn of it.
    ///
    /// # Errors
    /// When the reference cannot be drawn.
    pub fn picture(self, drawer: &mut Drawer, frame: &FrameRow, seen: &Drawn) -> Result<Arc<RgbaImage>, LabError> {
        if self.parts.is_empty() && !self.reference {
            return Ok(Arc::clone(&seen.picture));
        }
        let overlay = Overlay::of(drawer.replay(), frame, self.parts);
        let painted = |picture: &RgbaImage| {
            let mut picture = picture.clone();
            ink::paint(&mut picture, &overlay);
            picture
        };
        let left = painted(&seen.picture);
        if !self.reference {
            return Ok(Arc::new(left));
        }
        let right = painted(&drawer.reference(frame)?.picture);
        Ok(Arc::new(ink::side_by_side(&left, &right)))
    }
}

/// A folder of pictures in the making.
#[derive(Debug)]
pub struct PictureFolder {
    folder: PathBuf,
    /// Where pictures go until all are there; removed if they never are.
    partial: Partial,
    names: Vec<String>,
}

impl PictureFolder {
    /// Begins a folder.
    ///
    /// # Errors
    /// When the place cannot be written to.
    pub fn begin(folder: &Path) -> Result<Self, LabError> {
        if folder.exists() && !folder.is_dir() {
            return Err(LabError::BadInput(format!("{}: expected a folder, found a file", folder.display())));
        }
        let partial = Partial::beside(folder, "")?;
        std::fs::create_dir_all(&partial.path).map_err(|error| LabError::io("make", &partial.path, &error))?;
        Ok(Self { folder: folder.to_owned(), partial, names: Vec::new() })
    }

    /// Adds a picture as a PNG file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, name: String, picture: &RgbaImage) -> Result<(), LabError> {
        let path = self.partial.path.join(&name);
        picture.save(&path).map_err(|error| LabError::Failed(format!("cannot write {}: {error}", path.display())))?;
        self.names.push(name);
        Ok(())
    }

    /// Puts the folder in its place, and returns how many pictures it holds. Other files that were there stay.
    ///
    /// # Errors
    /// When it cannot be put there.
    pub fn finish(self) -> Result<usize, LabError> {
        let (from, to) = (&self.partial.path, &self.folder);
        if !to.exists() {
            std::fs::rename(from, to).map_err(|error| LabError::io("name", to, &error))?;
            return Ok(self.names.len());
        }
        for name in &self.names {
            let place = to.join(name);
            std::fs::rename(from.join(name), &place).map_err(|error| LabError::io("name", &place, &error))?;
        }
        Ok(self.names.len())
    }
}

/// A file or folder under a name of its own, removed when it is dropped; one that was renamed is gone already.
#[derive(Debug)]
pub(super) struct Partial {
    pub(super) path: PathBuf,
}

impl Partial {
    /// A name beside `target`, with an ending such as `.mp4`; the folder around it is made.
    pub(super) fn beside(target: &Path, ending: &str) -> Result<Self, LabError> {
        let Some(name) = target.file_name().filter(|name| !name.is_empty()) else {
            return Err(LabError::BadInput(format!("{}: expected a name for what is written", target.display())));
        };
        let around = target.parent().filter(|around| !around.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(around).map_err(|error| LabError::io("make", around, &error))?;
        let name = format!(".{}.partial-{}{ending}", name.to_string_lossy(), std::process::id());
        Ok(Self { path: around.join(name) })
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // Nothing can be done about what cannot be removed, and an earlier error matters more.
        let _ = if self.path.is_dir() { std::fs::remove_dir_all(&self.path) } else { std::fs::remove_file(&self.path) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_is_whole_or_not_there() {
        let around = tempfile::tempdir().expect("a folder");
        let folder = around.path().join("new/pictures");
        let picture = RgbaImage::new(2, 2);

        let mut dropped = PictureFolder::begin(&folder).expect("begins");
        dropped.add("a.png".to_owned(), &picture).expect("written");
        assert!(!folder.exists());
        drop(dropped);
        assert_eq!(names(&around.path().join("new")), [""; 0]);

        let mut kept = PictureFolder::begin(&folder).expect("begins");
        kept.add("a.png".to_owned(), &picture).expect("written");
        assert_eq!(kept.finish().expect("named"), 1);
        assert_eq!(names(&around.path().join("new")), ["pictures"]);

        // A second time: what is there stays, and nothing is left beside it.
        std::fs::write(folder.join("notes.txt"), "mine").expect("written");
        let mut again = PictureFolder::begin(&folder).expect("begins");
        again.add("b.png".to_owned(), &picture).expect("written");
        again.finish().expect("named");
        assert_eq!(names(&folder), ["a.png", "b.png", "notes.txt"]);
        assert_eq!(names(&around.path().join("new")), ["pictures"]);
        assert!(PictureFolder::begin(&folder.join("notes.txt")).is_err());
    }
}
