//! The surfaces of a scene, for renderers that shade or trace by themselves instead of asking for whole pictures: a
//! G-buffer of what a view shows, and the triangles as rays meet them. Shading is the scene's one WGSL function either way.
//!
//! A renderer's shader is the text [`SHADING_WGSL`] or [`RAYS_WGSL`] with its own behind it. Group 0 is then the world
//! (camera, materials, lights, sky, shadow), group 1 the rays; its own things begin at the next group.

use crate::contract::{DrawCost, DrawRequest, LINEAR_FORMAT, RenderError};
use crate::gpu::Gpu;
use crate::pass;

/// WGSL of group 0. Its functions: `ray_through(px) -> vec3f` (direction through a display pixel, one unit deep),
/// `surface_at(Place) -> Surface`, `shade(Surface) -> vec3f`, `sky_in_direction(direction, level) -> vec3f`, and
/// `shade_texels(…) -> vec3f` for a pixel of a [`GBuffer`].
pub const SHADING_WGSL: &str = crate::mesh_scene::pipelines::SHADING_WGSL;

/// [`SHADING_WGSL`] and group 1: `trace(origin, direction, farthest, any) -> Hit`, `place_of_hit(…) -> Place`, and
/// `radiance_along(origin, direction, pixel_rad) -> vec3f`, the light along a ray as the rasterised picture shows it.
pub const RAYS_WGSL: &str = crate::mesh_scene::pipelines::RAYS_WGSL;

/// A scene whose surfaces can be had; see [`crate::contract::Scene::surfaces`].
pub trait Surfaces {
    /// Layout of group 0, the world.
    fn world_layout(&self) -> &wgpu::BindGroupLayout;

    /// Layout of group 1, the rays. Builds the hierarchies when it is first asked for, which takes a moment.
    fn rays_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout;

    /// Groups 0 and 1 for a view: camera, places of objects, shadow. Records what must be drawn for it.
    fn groups(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, request: &DrawRequest<'_>) -> SurfaceGroups;

    /// Records the drawing of a view's surfaces, one sample a pixel, into the top left corner of `targets`, and their
    /// motion where it is asked for.
    ///
    /// # Errors
    /// When they cannot be drawn.
    fn draw_g_buffer(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        targets: &GBuffer,
    ) -> Result<DrawCost, RenderError>;
}

/// Bind groups of one view.
#[derive(Debug, Clone)]
pub struct SurfaceGroups {
    /// Group 0.
    pub world: wgpu::BindGroup,
    /// Group 1; where no one has asked for [`Surfaces::rays_layout`] there is none.
    pub rays: Option<wgpu::BindGroup>,
}

/// What a view shows, unshaded, in linear numbers.
#[derive(Debug)]
pub struct GBuffer {
    /// World normal, and roughness in alpha. Half floats.
    pub normal_roughness: wgpu::TextureView,
    /// Albedo, and metalness in alpha. Half floats.
    pub albedo_metalness: wgpu::TextureView,
    /// Light of the surface's own; alpha is 0 where the colour is that of the sky, and ½ and half of the surface's openness
    /// to its surroundings elsewhere. Half floats.
    pub emission: wgpu::TextureView,
    /// One over the distance along the viewing axis, per metre; 0 for the sky. Full floats.
    pub inverse_depth: wgpu::TextureView,
}

impl GBuffer {
    /// Format of [`GBuffer::inverse_depth`].
    pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

    /// Targets of `size_px` pixels.
    #[must_use]
    pub fn new(gpu: &Gpu, size_px: [u32; 2]) -> Self {
        let target = |label, format| pass::view(&pass::texture(gpu, label, size_px, format));
        Self {
            normal_roughness: target("normals", LINEAR_FORMAT),
            albedo_metalness: target("albedo", LINEAR_FORMAT),
            emission: target("emission", LINEAR_FORMAT),
            inverse_depth: target("depth", Self::DEPTH_FORMAT),
        }
    }

    /// The targets in the order in which shaders write them, with their formats.
    pub(crate) fn targets(&self) -> [(&wgpu::TextureView, wgpu::TextureFormat); 4] {
        [
            (&self.normal_roughness, LINEAR_FORMAT),
            (&self.albedo_metalness, LINEAR_FORMAT),
            (&self.emission, LINEAR_FORMAT),
            (&self.inverse_depth, Self::DEPTH_FORMAT),
        ]
    }
}
