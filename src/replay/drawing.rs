//! Drawing logged frames again, one after the other or in any order.
//!
//! A picture that depends on those before it is drawn with all frames since its presentation began. A picture that is the
//! same as the one before is not drawn twice.

use super::Replay;
use crate::error::LabError;
use crate::session::tables::FrameRow;
use crate::stage::painter::FrameKey;
use crate::stage::{Painter, View};
use experiments::trial::{Alternative, Presentation};
use image::RgbaImage;
use std::sync::Arc;
use stimuli::Registry;
use stimuli::gpu::Gpu;

/// A frame's picture.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// 8-bit RGBA, as large as the display.
    pub picture: Arc<RgbaImage>,
    /// Tells pictures apart: the same number is the same picture.
    pub serial: u64,
}

/// Draws the frames of a replay.
#[derive(Debug)]
pub struct Drawer {
    replay: Arc<Replay>,
    registry: Arc<Registry>,
    /// One for each of the session's displays, made when it is needed.
    painters: Vec<Option<Painter>>,
    adapter: Option<String>,
    /// The phase and number of the frame whose test picture was drawn last.
    drawn: Option<(u64, u64)>,
    seen: Option<Kept>,
    reference: Option<Kept>,
    serial: u64,
}

/// A picture with what decides it.
#[derive(Debug)]
struct Kept {
    segment: usize,
    key: FrameKey,
    drawn: Drawn,
}

impl Drawer {
    /// A drawer; the graphics device is opened with the first frame.
    #[must_use]
    pub fn new(replay: Arc<Replay>, registry: Arc<Registry>) -> Self {
        let painters = replay.displays().map(|_| None).collect();
        Self { replay, registry, painters, adapter: None, drawn: None, seen: None, reference: None, serial: 0 }
    }

    /// What is drawn.
    #[must_use]
    pub fn replay(&self) -> &Arc<Replay> {
        &self.replay
    }

    /// The graphics adapter and driver, in the words of session headers.
    ///
    /// # Errors
    /// When there is none.
    pub fn adapter(&mut self) -> Result<&str, LabError> {
        let replay = Arc::clone(&self.replay);
        if self.adapter.is_none()
            && let Some(frame) = replay.frames().first()
        {
            self.painter(frame)?;
        }
        Ok(self.adapter.as_deref().unwrap_or_default())
    }

    fn painter(&mut self, frame: &FrameRow) -> Result<&mut Painter, LabError> {
        let slot = &mut self.painters[self.replay.segment(frame)];
        let painter = match slot.take() {
            Some(painter) => painter,
            None => {
                let gpu = Gpu::headless()?;
                let info = &gpu.adapter_info;
                self.adapter =
                    Some(format!("{} ({:?}, {} {})", info.name, info.backend, info.driver, info.driver_info));
                let plan = self.replay.plan(frame);
                let format = wgpu::TextureFormat::Rgba8Unorm;
                Painter::new(gpu, &self.registry, &plan.display, plan.gaze.fixation_deg, format)
            }
        };
        Ok(slot.insert(painter))
    }

    /// What a frame showed.
    ///
    /// # Errors
    /// When the log does not hold what the frame names, or the device fails.
    pub fn seen(&mut self, frame: &FrameRow) -> Result<Drawn, LabError> {
        let replay = Arc::clone(&self.replay);
        let view = replay.view(frame)?;
        let drawn = self.drawn;
        let painter = self.painter(frame)?;
        if painter.remembers(&view)? {
            // Frames that were drawn already, if the last one drawn is one of those before.
            let known = drawn.filter(|&(phase, index)| phase == frame.phase_seq && index < frame.index);
            let before = replay.presentation(frame).iter().filter(|earlier| earlier.index < frame.index);
            for earlier in before.filter(|earlier| known.is_none_or(|(_, index)| earlier.index > index)) {
                painter.pass_over(&replay.view(earlier)?)?;
            }
        }
        self.drawn = Some((frame.phase_seq, frame.index));
        let kept = self.seen.take();
        let kept = self.picture(frame, &view, kept)?;
        let drawn = kept.drawn.clone();
        self.seen = Some(kept);
        Ok(drawn)
    }

    /// What the full-resolution reference would have looked like at a frame's moment; where no stimulus is shown, what was
    /// shown.
    ///
    /// # Errors
    /// As [`Drawer::seen`].
    pub fn reference(&mut self, frame: &FrameRow) -> Result<Drawn, LabError> {
        let replay = Arc::clone(&self.replay);
        let view = replay.view(frame)?;
        let presentation = match view.presentation {
            Presentation::Stimulus(stimulus) => {
                let mut reference = stimulus.clone();
                reference.alternative = Alternative::Reference;
                Presentation::Stimulus(reference)
            }
            other => other.clone(),
        };
        let kept = self.reference.take();
        let kept = self.picture(frame, &View { presentation: &presentation, ..view }, kept)?;
        let drawn = kept.drawn.clone();
        self.reference = Some(kept);
        Ok(drawn)
    }

    /// The kept picture if it is the same, or a new one.
    fn picture(&mut self, frame: &FrameRow, view: &View<'_>, kept: Option<Kept>) -> Result<Kept, LabError> {
        let (segment, key) = (self.replay.segment(frame), FrameKey::from(view));
        let painter = self.painter(frame)?;
        let same = |kept: &Kept| kept.segment == segment && painter.same_picture(&kept.key, &key);
        let drawn = match kept.filter(same) {
            Some(kept) => kept.drawn,
            None => {
                let (picture, _) = painter.picture(view)?;
                self.serial += 1;
                Drawn { picture: Arc::new(picture), serial: self.serial }
            }
        };
        Ok(Kept { segment, key, drawn })
    }
}
