//! Logged frames as a video: shown for as long as they were, resampled to the display's own rate, and handed to ffmpeg
//! through a pipe. Without ffmpeg the same frames become numbered pictures in a folder.

use super::export::{Look, Partial, PictureFolder};
use super::{Drawer, Replay, ink};
use crate::error::LabError;
use crate::session::tables::FrameRow;
use image::RgbaImage;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::thread::JoinHandle;

/// A frame is shown no longer than this, seconds: what follows a pause of hours comes after a second.
const LONGEST_S: f64 = 1.0;

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Written {
    /// A video of so many frames.
    Video(usize),
    /// Numbered pictures in a folder, since there is no ffmpeg.
    Pictures(PathBuf, usize),
}

/// Which of the chosen frames each frame of a video shows: at a rate, in hertz, and a speed, times real time.
#[must_use]
pub fn schedule(durations_s: &[f64], rate_hz: f64, speed: f64) -> Vec<usize> {
    let mut chosen = Vec::new();
    let mut ends_s = 0.0;
    for (index, duration_s) in durations_s.iter().enumerate() {
        ends_s += duration_s / speed;
        // Half a frame of slack, so that a rate which is the log's own takes every frame once.
        while (chosen.len() as f64 + 0.5) / rate_hz < ends_s - 1e-9 {
            chosen.push(index);
        }
    }
    chosen
}

/// How long each frame was on the display, seconds.
fn durations_s(replay: &Replay, frames: &[&FrameRow]) -> Vec<f64> {
    let all = replay.frames();
    let duration_s = |frame: &&FrameRow| {
        let next = all.get(all.partition_point(|other| other.index <= frame.index));
        let shown_s = next.map(|next| next.presented_s - frame.presented_s);
        shown_s.filter(|s| *s >= 0.0).unwrap_or(1.0 / replay.display(frame).refresh_hz()).min(LONGEST_S)
    };
    frames.iter().map(duration_s).collect()
}

/// Writes frames as a video file, whole or not at all. `progress` is told how many of its frames are done, of how many.
///
/// # Errors
/// When there is nothing to show, the file's ending is neither `.mp4` nor `.webm`, a frame cannot be drawn, or the file
/// cannot be written.
pub fn write(
    drawer: &mut Drawer,
    frames: &[&FrameRow],
    file: &Path,
    look: Look,
    speed: f64,
    mut progress: impl FnMut(usize, usize),
) -> Result<Written, LabError> {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if !["mp4", "webm"].contains(&ending.as_str()) {
        return Err(LabError::BadInput(format!("{}: expected a file that ends in .mp4 or .webm", file.display())));
    }
    if file.is_dir() {
        return Err(LabError::BadInput(format!("{}: expected a file, found a folder", file.display())));
    }
    let replay = Arc::clone(drawer.replay());
    let Some(first) = frames.first() else {
        return Err(LabError::BadInput("there is no frame to make a video of".to_owned()));
    };
    let rate_hz = replay.display(first).refresh_hz();
    let chosen = schedule(&durations_s(&replay, frames), rate_hz, speed);
    let mut output = None;
    let mut last: Option<(usize, Arc<RgbaImage>)> = None;
    for (done, &index) in chosen.iter().enumerate() {
        let picture = match last.take().filter(|(before, _)| *before == index) {
            Some((_, picture)) => picture,
            None => {
                let seen = drawer.seen(frames[index])?;
                look.picture(drawer, frames[index], &seen)?
            }
        };
        let output = match &mut output {
            Some(output) => output,
            None => output.insert(Output::begin(file, &ending, largest(&replay, look), rate_hz)?),
        };
        output.add(&picture)?;
        last = Some((index, picture));
        progress(done + 1, chosen.len());
    }
    match output {
        Some(output) => output.finish(file),
        None => Err(LabError::BadInput(format!("at speed {speed} not one frame of the video is filled"))),
    }
}

/// The size of a video's frames: a session may have been gone on with on another display.
fn largest(replay: &Replay, look: Look) -> [u32; 2] {
    let sizes = replay.displays().map(|display| {
        let [width, height] = display.resolution_px();
        if look.reference {
            let blank = RgbaImage::new(width, 1);
            [ink::side_by_side(&blank, &blank).width(), height]
        } else {
            [width, height]
        }
    });
    sizes.fold([1, 1], |most, size| [most[0].max(size[0]), most[1].max(size[1])])
}

/// Where a video's frames go.
struct Output {
    size: [u32; 2],
    frames: usize,
    to: To,
}

enum To {
    Ffmpeg(Box<Ffmpeg>),
    Folder(PictureFolder, PathBuf),
}

impl Output {
    fn begin(file: &Path, ending: &str, size: [u32; 2], rate_hz: f64) -> Result<Self, LabError> {
        let to = match Ffmpeg::begin(file, ending, size, rate_hz)? {
            Some(ffmpeg) => To::Ffmpeg(Box::new(ffmpeg)),
            None => {
                let folder = file.with_extension("");
                To::Folder(PictureFolder::begin(&folder)?, folder)
            }
        };
        Ok(Self { size, frames: 0, to })
    }

    fn add(&mut self, picture: &RgbaImage) -> Result<(), LabError> {
        let larger;
        let picture = if [picture.width(), picture.height()] == self.size {
            picture
        } else {
            larger = ink::centred(picture, self.size);
            &larger
        };
        match &mut self.to {
            To::Ffmpeg(ffmpeg) => ffmpeg.add(picture)?,
            To::Folder(folder, _) => folder.add(format!("{:06}.png", self.frames), picture)?,
        }
        self.frames += 1;
        Ok(())
    }

    fn finish(self, file: &Path) -> Result<Written, LabError> {
        match self.to {
            To::Ffmpeg(ffmpeg) => ffmpeg.finish(file).map(|()| Written::Video(self.frames)),
            To::Folder(folder, place) => Ok(Written::Pictures(place, folder.finish()?)),
        }
    }
}

/// A running ffmpeg.
struct Ffmpeg {
    child: Child,
    frames: Option<ChildStdin>,
    messages: Option<JoinHandle<String>>,
    partial: Partial,
}

impl Ffmpeg {
    /// Starts it; nothing where it is not installed.
    fn begin(file: &Path, ending: &str, [width, height]: [u32; 2], rate_hz: f64) -> Result<Option<Self>, LabError> {
        let partial = Partial::beside(file, &format!(".{ending}"))?;
        let (size, rate) = (format!("{width}x{height}"), rate_hz.to_string());
        // Both kinds of file hold a quarter of the colours and even sizes only. Without the matrix, colours would be those
        // of standard definition.
        let filter = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";
        let codec: &[&str] = match ending {
            "webm" => &["-c:v", "libvpx-vp9", "-crf", "18", "-b:v", "0", "-row-mt", "1", "-cpu-used", "4"],
            _ => &["-c:v", "libx264", "-crf", "12", "-preset", "medium", "-movflags", "+faststart"],
        };
        let mut command = Command::new("ffmpeg");
        command
            .args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"])
            .args(["-f", "rawvideo", "-pix_fmt", "rgba", "-s", &size, "-framerate", &rate, "-i", "pipe:0"])
            .args(["-vf", filter, "-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace", "bt709"])
            .args(["-color_range", "tv"])
            .args(codec)
            .arg(&partial.path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = match command.spawn() {
            Ok(child) => child,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(LabError::Failed(format!("cannot start ffmpeg: {error}"))),
        };
        let (frames, errors) = (child.stdin.take(), child.stderr.take());
        // Read all the while: a full pipe would stop it.
        let listen = move || {
            let mut text = String::new();
            if let Some(mut errors) = errors {
                let _ = errors.read_to_string(&mut text);
            }
            text
        };
        let messages = std::thread::Builder::new().name("ffmpeg-messages".to_owned()).spawn(listen);
        let messages = messages.map_err(|error| LabError::Failed(format!("cannot listen to ffmpeg: {error}")))?;
        Ok(Some(Self { child, frames, messages: Some(messages), partial }))
    }

    fn add(&mut self, picture: &RgbaImage) -> Result<(), LabError> {
        let written = self.frames.as_mut().map_or(Ok(()), |frames| frames.write_all(picture.as_raw()));
        // It has ended before its time; its own words say why.
        written.map_err(|error| self.ended(&error.to_string()))
    }

    fn finish(mut self, file: &Path) -> Result<(), LabError> {
        drop(self.frames.take());
        let status = self.child.wait().map_err(|error| LabError::Failed(format!("ffmpeg: {error}")))?;
        if !status.success() {
            return Err(self.ended(&status.to_string()));
        }
        std::fs::rename(&self.partial.path, file).map_err(|error| LabError::io("name", file, &error))
    }

    fn ended(&mut self, why: &str) -> LabError {
        drop(self.frames.take());
        let said = self.messages.take().and_then(|messages| messages.join().ok()).unwrap_or_default();
        LabError::Failed(format!("ffmpeg failed ({why}): {}", said.trim()))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // Only what did not finish is still running; its half file goes with `partial`.
        drop(self.frames.take());
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logs_own_rate_takes_every_frame_once() {
        let even = [1.0 / 60.0; 90];
        assert_eq!(schedule(&even, 60.0, 1.0), (0..90).collect::<Vec<_>>());
        // Times as a real window has them: early and late by a quarter of a frame.
        let uneven: Vec<f64> = (0..90).map(|i| (1.0 + if i % 2 == 0 { 0.25 } else { -0.25 }) / 60.0).collect();
        assert_eq!(schedule(&uneven, 60.0, 1.0), (0..90).collect::<Vec<_>>());
    }

    #[test]
    fn a_late_frame_leaves_the_one_before_it_standing() {
        let durations_s = [0.1, 0.2, 0.1];
        assert_eq!(schedule(&durations_s, 10.0, 1.0), [0, 1, 1, 2]);
        assert_eq!(schedule(&durations_s, 10.0, 0.5), [0, 0, 1, 1, 1, 1, 2, 2]);
        assert_eq!(schedule(&durations_s, 10.0, 2.0), [1, 2]);
        assert_eq!(schedule(&[], 10.0, 1.0), [0_usize; 0]);
        assert_eq!(schedule(&[0.0, 0.1], 10.0, 1.0), [1]);
    }
}
