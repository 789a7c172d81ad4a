//! What surfaces are made of: metal or not, rough or smooth (Burley's parameters, as glTF 2.0 has them), with maps or with
//! patterns that are computed where they are seen.

use glam::Vec3;

/// A surface's material. Where there is a map, its values multiply the numbers here.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Material {
    /// Linear reflectance, 0–1.
    pub(crate) albedo: Vec3,
    /// 0 is a mirror, 1 is chalk.
    pub(crate) roughness: f32,
    /// 0 for insulators, 1 for metals.
    pub(crate) metalness: f32,
    /// Light of its own, linear.
    pub(crate) emission: Vec3,
    /// Index into [`super::World::colour_maps`].
    pub(crate) albedo_map: Option<usize>,
    /// Index into [`super::World::colour_maps`].
    pub(crate) emission_map: Option<usize>,
    /// Index into [`super::World::data_maps`]: tangent-space normals.
    pub(crate) normal_map: Option<usize>,
    /// Index into [`super::World::data_maps`]: roughness in green, metalness in blue.
    pub(crate) roughness_map: Option<usize>,
    /// How strongly the normal map tilts.
    pub(crate) normal_scale: f32,
    /// Where the albedo map's alpha is below this, there is nothing.
    pub(crate) cutout: Option<f32>,
    /// Whether it is seen from behind, too.
    pub(crate) two_sided: bool,
    /// A pattern that is computed where it is seen.
    pub(crate) pattern: Pattern,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            albedo: Vec3::splat(0.8),
            roughness: 0.6,
            metalness: 0.0,
            emission: Vec3::ZERO,
            albedo_map: None,
            emission_map: None,
            normal_map: None,
            roughness_map: None,
            normal_scale: 1.0,
            cutout: None,
            two_sided: false,
            pattern: Pattern::default(),
        }
    }
}

impl Material {
    /// A plain insulator.
    pub(crate) fn matt(albedo: [f32; 3], roughness: f32) -> Self {
        Self { albedo: albedo.into(), roughness, ..Self::default() }
    }

    /// A plain metal.
    pub(crate) fn metal(albedo: [f32; 3], roughness: f32) -> Self {
        Self { metalness: 1.0, ..Self::matt(albedo, roughness) }
    }

    /// The same with a pattern.
    #[must_use]
    pub(crate) fn with(self, pattern: Pattern) -> Self {
        Self { pattern, ..self }
    }
}

/// A procedural pattern between the material's albedo and a second colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pattern {
    pub(crate) kind: PatternKind,
    /// The second colour, linear.
    pub(crate) colour: Vec3,
    /// Repeats per metre.
    pub(crate) scale: f32,
    /// How much of the second colour there is, 0–1.
    pub(crate) strength: f32,
    /// How much the roughness changes with the pattern, −1–1.
    pub(crate) roughness: f32,
    /// Depth of its relief, as a share of a repeat.
    pub(crate) relief: f32,
}

impl Default for Pattern {
    fn default() -> Self {
        Self { kind: PatternKind::None, colour: Vec3::ZERO, scale: 1.0, strength: 1.0, roughness: 0.0, relief: 0.0 }
    }
}

impl Pattern {
    /// A pattern without relief and of even roughness.
    pub(crate) fn new(kind: PatternKind, colour: [f32; 3], scale: f32) -> Self {
        Self { kind, colour: colour.into(), scale, ..Self::default() }
    }
}

/// The patterns of `patterns.wgsl`, by their numbers there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub(crate) enum PatternKind {
    /// The albedo alone.
    #[default]
    None = 0,
    /// Cubes of alternating colour in the mesh's space.
    Checker = 1,
    /// Cloudy noise of several octaves.
    Clouds = 2,
    /// Veins.
    Marble = 3,
    /// Year rings around the mesh's y axis.
    Wood = 4,
    /// Courses of bricks on the surface's map coordinates; the second colour is the mortar.
    Bricks = 5,
    /// Square tiles on the map coordinates; the second colour is the joints.
    Tiles = 6,
    /// Warp and weft on the map coordinates.
    Weave = 7,
    /// Meadow, rock and snow by height and slope in the world's space.
    Terrain = 8,
    /// Scratches and stains, for metal.
    Worn = 9,
    /// Rows of windows on the map coordinates; the second colour is the glass.
    Windows = 10,
    /// Stripes along the map's x.
    Stripes = 11,
    /// Dots.
    Dots = 12,
}

/// A picture on surfaces: four bytes a pixel, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Map {
    pub(crate) size: [u32; 2],
    pub(crate) rgba: Vec<u8>,
}
