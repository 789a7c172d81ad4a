//! The lab's errors: what went wrong, in words for the user, and the exit code that goes with it.

use std::path::Path;

/// Why a command did not do its work.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// What was given cannot be used: exit code 2.
    #[error("{0}")]
    BadInput(String),
    /// A study or display file has mistakes: exit code 2. Shown with the lines at fault.
    #[error(transparent)]
    Mistakes(#[from] Box<experiments::study::Mistakes>),
    /// Several files have mistakes, a study and what it brings along: exit code 2.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    ManyFiles(Vec<experiments::study::Mistakes>),
    /// What was asked could not be done: exit code 1.
    #[error("{0}")]
    Failed(String),
}

impl LabError {
    /// A file system problem, with the path.
    #[must_use]
    pub fn io(action: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::Failed(format!("cannot {action} {}: {error}", path.display()))
    }

    /// The program's exit code.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::BadInput(_) | Self::Mistakes(_) | Self::ManyFiles(_) => 2,
            Self::Failed(_) => 1,
        }
    }
}

impl From<experiments::study::Mistakes> for LabError {
    fn from(mistakes: experiments::study::Mistakes) -> Self {
        Self::Mistakes(Box::new(mistakes))
    }
}

impl From<stimuli::AddError> for LabError {
    fn from(error: stimuli::AddError) -> Self {
        match error {
            stimuli::AddError::Mistakes(mistakes) => Self::Mistakes(mistakes),
            other => Self::BadInput(other.to_string()),
        }
    }
}

impl From<stimuli::gpu::GpuError> for LabError {
    fn from(error: stimuli::gpu::GpuError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<stimuli::contract::MakeError> for LabError {
    fn from(error: stimuli::contract::MakeError) -> Self {
        Self::BadInput(error.to_string())
    }
}

impl From<stimuli::contract::RenderError> for LabError {
    fn from(error: stimuli::contract::RenderError) -> Self {
        Self::Failed(error.to_string())
    }
}
