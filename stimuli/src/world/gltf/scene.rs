//! A file as a scene of studies: which of its cameras and animations, under which sky, how bright.

use super::GltfFile;
use crate::contract::{MakeError, SceneLight, ToneMap};
use crate::parameters::{number, text};
use crate::world::camera::CameraMotion;
use crate::world::{CameraPath, Environment, Motion, Sky, World};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use glam::{DVec3, Vec3};

/// Mean radiance of the sky: a white surface in the open then comes out a little above half the display's peak.
const SKY_MEAN: f32 = 0.62;
/// Name of the panorama that a file brings with it.
const OWN: &str = "own";

/// Around what it circles: places of the camera without a camera in the file.
const ORBIT_PLACES: u32 = 24;
const ORBIT_S: f64 = 60.0;
/// Distance from the middle, in radii of the sphere around everything.
const ORBIT_RADII: f64 = 2.6;
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
                "Brighter by so many factors of two; at 0 white under the sky is a little above half the display's peak.",
            ),
        ];
        let name = self.file.file_name().map_or_else(|| id.into(), |name| name.to_string_lossy());
        let about = format!("The glTF file {name} with {} triangles.", self.triangles());
        SceneInfo { id: id.to_owned(), version: self.version, about, parameters, animated: true }
    }

    /// The world that parameters ask for; they must be complete.
    ///
    /// # Errors
    /// When a parameter is missing or a shipped panorama is damaged.
    pub(crate) fn world(&self, parameters: &Parameters) -> Result<World, MakeError> {
        self.chosen(&Choices::read(parameters)?)
    }

    /// The world under some choices.
    pub(crate) fn chosen(&self, choices: &Choices) -> Result<World, MakeError> {
        let motions = self.motions(choices.animation.and_then(|index| self.clips.get(index)));
        let mut world = self.assembled(&motions);
        world.environment = Environment::of(match (choices.sky, &self.panorama) {
            (None, Some(panorama)) => panorama.clone().with_mean(SKY_MEAN),
            (sky, _) => sky.unwrap_or_default().panorama(SKY_MEAN)?,
        });
        let position = choices.camera.and_then(|index| self.cameras.get(index));
        let path = match position.and_then(|&position| motions.get(position)) {
            Some(carrier) => CameraPath { carrier: Some(Motion::clone(carrier)), ..CameraPath::default() },
            None => orbit(world.bounds(0.0).unwrap_or([Vec3::NEG_ONE, Vec3::ONE])),
        };
        world.camera = CameraPath { motion: choices.motion, ..path };
        world.light = SceneLight { exposure: choices.exposure_ev.exp2(), tone_map: ToneMap::Filmic };
        Ok(world)
    }
}

/// A slow circle around everything.
fn orbit([low, high]: [Vec3; 2]) -> CameraPath {
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let middle = 0.5 * (low + high);
    let distance_m = ORBIT_RADII * (0.5 * low.distance(high)).max(1e-3);
    let (sin, cos) = ORBIT_HEIGHT_DEG.to_radians().sin_cos();
    let place = |i: u32| {
        // From the front right, as pictures of things are taken.
        let around = (f64::from(i) / f64::from(ORBIT_PLACES)) * std::f64::consts::TAU + 0.6;
        (middle + distance_m * DVec3::new(cos * around.sin(), sin, cos * around.cos()), middle)
    };
    let places: Vec<_> = (0..ORBIT_PLACES).map(place).collect();
    CameraPath::round(&places, ORBIT_S / f64::from(ORBIT_PLACES))
}
