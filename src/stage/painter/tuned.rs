//! A renderer with what it is set to and where in a presentation it stands, so that nothing of one presentation is carried
//! into another.

use super::View;
use crate::error::LabError;
use experiments::catalogue::Parameters;
use stimuli::Renderer;

/// A renderer and what it is set to.
pub(super) struct Tuned {
    pub(super) renderer: Box<dyn Renderer>,
    pub(super) parameters: Parameters,
    /// Presentation and frame that it drew last.
    drawn: Option<(u64, u64)>,
}

impl Tuned {
    pub(super) fn new(renderer: Box<dyn Renderer>, parameters: Parameters) -> Self {
        Self { renderer, parameters, drawn: None }
    }

    /// Begins a presentation, unless the frame follows one of the same.
    pub(super) fn follow(&mut self, view: &View<'_>) {
        let follows = self.drawn.is_some_and(|(seq, frame)| seq == view.presentation_seq && frame < view.frame_index);
        if !follows {
            self.renderer.begin();
        }
        self.drawn = Some((view.presentation_seq, view.frame_index));
    }

    pub(super) fn tune(&mut self, parameters: Parameters) -> Result<(), LabError> {
        if self.parameters != parameters {
            self.renderer.set_parameters(&parameters).map_err(|errors| {
                let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
                LabError::BadInput(all.join("; "))
            })?;
            self.parameters = parameters;
        }
        Ok(())
    }

    /// What was drawn was shown to nobody and is no part of any presentation.
    pub(super) fn forget(&mut self) {
        self.drawn = None;
    }
}
