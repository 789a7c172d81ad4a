//! A file as a scene of studies: which of its cameras and animations, under which sky, how bright.

use super::GltfFile;
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::parameters::{number, text};
use crate::world::camera::CameraMotion;
use crate::world::{CameraPath, Environment, Light, Motion, Sky, World};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo, complete_parameters};
use experiments::display::Display;
use glam::{DVec3, Vec3};

/// Mean radiance of the sky, the scale to which the file's own lights are brought.
const SKY_MEAN: f32 = 0.62;
/// Name of the panorama that a file brings with it.
const OWN: &str = "own";

/// Around what it circles: places of the camera without a camera in the file.
const ORBIT_PLACES: u32 = 24;
const ORBIT_S: f64 = 60.0;
/// How much of the view's half height or width, whichever is less, the sphere around everything may take.
const ORBIT_SHARE: f64 = 1.15;
/// How far above the middle, degrees.
const ORBIT_HEIGHT_DEG: f64 = 18.0;
/// How fast a camera pans at the speed 1, degrees per second in the middle of the sweep.
const PAN_DEG_S: f64 = 6.0;

/// How a file is shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choices {
    /// Which of the scene's cameras; nothing for a circle around everything.
    pub(crate) camera: Option<usize>,
    pub(crate) motion: CameraMotion,
    /// Which animation; nothing for the nodes at rest.
    pub(crate) animation: Option<usize>,
    /// Which shipped panorama; nothing for the one that was given with the file.
    pub(crate) sky: Option<Sky>,
    /// Brighter by so many factors of two.
    pub(crate) exposure_ev: f64,
}

impl Choices {
    fn read(parameters: &Parameters) -> Result<Self, MakeError> {
        // −1 stands for none.
        let index = |name| number(parameters, name).map(|value| (value >= 0.0).then(|| value.round() as usize));
        let speed = number(parameters, "camera_speed")?;
        Ok(Self {
            camera: index("camera_index")?,
            motion: match text(parameters, "camera")? {
                "static" => CameraMotion::Still,
                "pan" => CameraMotion::Pan(PAN_DEG_S * speed),
                _ => CameraMotion::Fly(speed),
            },
            animation: index("animation_index")?,
            sky: Sky::named(text(parameters, "environment")?),
            exposure_ev: number(parameters, "exposure_ev")?,
        })
    }
}

impl GltfFile {
    /// What may be set when it is shown as the scene `id`. Its version changes with the file's content.
    #[must_use]
    pub fn info(&self, id: &str) -> SceneInfo {
        let first_or_none = |count: usize| if count > 0 { 0.0 } else { -1.0 };
        let last = |count: usize| count as f64 - 1.0;
        let (cameras, animations) = (self.cameras(), self.animations());
        let own = self.panorama.is_some().then_some(OWN);
        let skies: Vec<&str> = own.into_iter().chain(Sky::ALL.map(Sky::name)).collect();
        let parameters = vec![
            ParameterSchema::choice(
                "camera",
                &["fly", "pan", "static"],
                "The camera's motion: it goes as the file's camera does, or circles where the file has none; or stops and looks left and right; or stands still.",
            ),
            ParameterSchema::number(
                "camera_speed",
                "×",
                -8.0..=8.0,
                1.0,
                "How many times as fast as in the file the camera moves; without a camera in the file, 1 is a circle in a minute. A panning camera sweeps at 6°/s times this.",
            ),
            ParameterSchema::number(
                "camera_index",
                "",
                -1.0..=last(cameras),
                first_or_none(cameras),
                "Which of the file's cameras tells where the viewer stands and looks; -1 circles around everything. How wide the view is follows from the display.",
            ),
            ParameterSchema::number(
                "animation_index",
                "",
                -1.0..=last(animations),
                first_or_none(animations),
                "Which of the file's animations moves the nodes; -1 leaves them at rest.",
            ),
            ParameterSchema::choice(
                "environment",
                &skies,
                "The panorama that lights everything and is seen behind it.",
            ),
            ParameterSchema::number(
                "exposure_ev",
                "EV",
                -8.0..=8.0,
                0.0,
                "Brighter by so many factors of two; at 0 a white surface that faces the sun comes out at the display's peak.",
            ),
        ];
        let name = self.file.file_name().map_or_else(|| id.into(), |name| name.to_string_lossy());
        let about = format!("The glTF file {name} with {} triangles.", self.triangles());
        SceneInfo { id: id.to_owned(), version: self.version, about, parameters, animated: true }
    }

    /// Makes the scene for `display`; parameters that are not given take their defaults.
    ///
    /// # Errors
    /// When a parameter is refused, the device cannot hold the scene, or the device fails.
    pub fn make(&self, gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
        let parameters = complete_parameters(&self.info("").parameters, parameters)?;
        mesh_scene::make(gpu, display, self.world(display, &parameters)?)
    }

    /// The world that parameters ask for, as seen on `display`; they must be complete.
    ///
    /// # Errors
    /// When a parameter is missing or a shipped panorama is damaged.
    pub(crate) fn world(&self, display: &Display, parameters: &Parameters) -> Result<World, MakeError> {
        let [across, up] = display.half_field_deg();
        self.chosen(&Choices::read(parameters)?, across.min(up))
    }

    /// The world under some choices, on a display that spans `half_view_deg` from its middle to its nearer edge.
    pub(crate) fn chosen(&self, choices: &Choices, half_view_deg: f64) -> Result<World, MakeError> {
        let motions = self.motions(choices.animation.and_then(|index| self.clips.get(index)));
        let mut world = self.assembled(&motions);
        world.environment = Environment::of(match (choices.sky, &self.panorama) {
            (None, Some(panorama)) => panorama.clone().with_mean(SKY_MEAN),
            (sky, _) => sky.unwrap_or_default().panorama(SKY_MEAN)?,
        });
        let position = choices.camera.and_then(|index| self.cameras.get(index));
        let path = match position.and_then(|&position| motions.get(position)) {
            Some(carrier) => CameraPath { carrier: Some(Motion::clone(carrier)), ..CameraPath::default() },
            None => orbit(world.bounds(0.0).unwrap_or([Vec3::NEG_ONE, Vec3::ONE]), half_view_deg),
        };
        world.camera = CameraPath { motion: choices.motion, ..path };
        // White in full light comes out at 1; what shines by itself whatever the light keeps its own values.
        let full = f64::from(full_light(&world).max(1e-3));
        for &material in &self.unlit {
            world.materials[material].emission *= full as f32;
        }
        world.light = SceneLight { exposure: choices.exposure_ev.exp2() / full, tone_map: ToneMap::Filmic };
        Ok(world)
    }
}

/// What a white surface sends out that faces the sun, or up where there is none: the mean of its channels.
fn full_light(world: &World) -> f32 {
    let lamp = world.lights.iter().find_map(|light| match *light {
        Light::Directional { towards, colour } => Some((towards, colour)),
        _ => None,
    });
    let sun = lamp.or(world.environment.sun.map(|sun| (sun.towards, sun.colour)));
    let (towards, colour) = sun.unwrap_or((Vec3::Y, Vec3::ZERO));
    (colour + world.environment.on_white(towards)).element_sum() / 3.0
}

/// A slow circle around everything, as near as shows it whole.
fn orbit([low, high]: [Vec3; 2], half_view_deg: f64) -> CameraPath {
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let middle = 0.5 * (low + high);
    let share = (ORBIT_SHARE * half_view_deg).clamp(1.0, 60.0).to_radians().sin();
    let distance_m = (0.5 * low.distance(high)).max(1e-3) / share;
    let (sin, cos) = ORBIT_HEIGHT_DEG.to_radians().sin_cos();
    let place = |i: u32| {
        // From the front right, as pictures of things are taken.
        let around = (f64::from(i) / f64::from(ORBIT_PLACES)) * std::f64::consts::TAU + 0.6;
        (middle + distance_m * DVec3::new(cos * around.sin(), sin, cos * around.cos()), middle)
    };
    let places: Vec<_> = (0..ORBIT_PLACES).map(place).collect();
    CameraPath::round(&places, ORBIT_S / f64::from(ORBIT_PLACES))
}
