//! What the procedural scenes share: the camera's parameters and paths, noise, painted skies, and forms that several of
//! them are put together from. None of it needs a GPU.

pub(crate) mod batch;
pub(crate) mod camera;
pub(crate) mod forms;
pub(crate) mod noise;
pub(crate) mod openness;
pub(crate) mod sky;

pub(crate) use batch::Batch;
