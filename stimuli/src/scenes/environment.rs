//! A panorama alone: the sky all around, from an HDR or EXR file, seen by a camera that turns or stands still.

use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use crate::world::camera::{CameraKey, CameraMotion};
use crate::world::{CameraPath, Environment, Panorama, World};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;
use glam::DVec3;

/// What the mean of all directions is shown as, in units of the display's peak.
const MEAN_SHOWN: f64 = 0.3;

pub(crate) fn info(id: &str) -> SceneInfo {
    SceneInfo {
        id: id.to_owned(),
        version: 1,
        about: "A panorama from a file.".to_owned(),
        parameters: vec![
            ParameterSchema::choice(
                "camera",
                &["pan", "static"],
                "Whether the camera looks left and right or stands still.",
            ),
            ParameterSchema::number(
                "camera_speed",
                "°/s",
                0.1..=90.0,
                10.0,
                "How fast a panning camera turns at most.",
            ),
            ParameterSchema::number(
                "heading_deg",
                "°",
                -180.0..=180.0,
                0.0,
                "Where the camera looks: degrees to the right of the panorama's middle.",
            ),
            ParameterSchema::number(
                "exposure_ev",
                "EV",
                -8.0..=8.0,
                0.0,
                "Brighter by so many factors of two; at 0 the mean of all directions is 0.3 of the display's peak.",
            ),
        ],
        animated: true,
    }
}

pub(crate) fn make(
    gpu: &Gpu,
    display: &Display,
    panorama: &Panorama,
    parameters: &Parameters,
) -> Result<Box<dyn Scene>, MakeError> {
    let heading = number(parameters, "heading_deg")?.to_radians();
    let ahead = DVec3::new(heading.cos(), 0.0, heading.sin());
    let motion = match text(parameters, "camera")? {
        "static" => CameraMotion::Still,
        _ => CameraMotion::Pan(number(parameters, "camera_speed")?),
    };
    let exposure = MEAN_SHOWN * number(parameters, "exposure_ev")?.exp2();
    let world = World {
        environment: Environment::of(panorama.clone().with_mean(1.0)),
        camera: CameraPath {
            keys: vec![CameraKey { time_s: 0.0, eye: DVec3::ZERO, target: ahead }],
            motion,
            ..CameraPath::default()
        },
        light: SceneLight { exposure, tone_map: ToneMap::Filmic },
        ..World::default()
    };
    crate::mesh_scene::make(gpu, display, world)
}
