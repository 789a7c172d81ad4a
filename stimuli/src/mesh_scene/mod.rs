//! Draws a [`World`] on the GPU: a scene of meshes under lights and a sky, as [`crate::contract::Scene`].
//!
//! `gpu_world` holds what does not change (triangles, materials, maps, sky), `frame` what a view needs (camera,
//! objects' places), `raster` draws, `shadow` looks from the sun, `rays` holds the triangles for tracing. Shading is the one function of `shading.wgsl`.

mod draw_list;
mod frame;
mod gpu_world;
mod intermediates;
mod projection;
pub(crate) mod raster;
mod rays;
pub(crate) mod shadow;
#[cfg(test)]
mod tests;

use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity, SceneLight};
use crate::gpu::Gpu;
use crate::surfaces::{GBuffer, SurfaceGroups, Surfaces};
use crate::world::World;
use experiments::display::Display;

/// A world on the GPU, seen on one display.
struct MeshScene {
    identity: SceneIdentity,
    display: Display,
    world: World,
    on_gpu: gpu_world::GpuWorld,
    raster: raster::Raster,
    shadow: shadow::Shadow,
    /// Built when rays are first asked for.
    rays: Option<rays::Rays>,
}

/// Brings `world` to the GPU.
///
/// # Errors
/// When it has more than the device can hold.
pub(crate) fn make(gpu: &Gpu, display: &Display, world: World) -> Result<Box<dyn Scene>, MakeError> {
    let on_gpu = gpu_world::GpuWorld::new(gpu, &world)?;
    let shadow = shadow::Shadow::new(gpu, &world);
    let raster = raster::Raster::new(gpu, &on_gpu, shadow.texel_m() > 0.0);
    gpu.check()?;
    Ok(Box::new(MeshScene {
        identity: SceneIdentity::new(),
        display: display.clone(),
        world,
        on_gpu,
        raster,
        shadow,
        rays: None,
    }))
}

impl MeshScene {
    /// A view readied: the camera and objects at their places, the shadow drawn, and group 0 of both.
    fn frame(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
    ) -> (frame::Frame, wgpu::BindGroup) {
        let frame = frame::Frame::new(gpu, &self.display, &self.world, &self.on_gpu, &self.shadow, request);
        self.shadow.update(gpu, encoder, &self.world, &self.on_gpu, &frame, request.animation_s);
        let group = self.on_gpu.bind(gpu, &frame, &self.shadow);
        (frame, group)
    }
}

impl Scene for MeshScene {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let (frame, group) = self.frame(gpu, encoder, request);
        let list = draw_list::DrawList::new(&self.world, &self.on_gpu, &frame, request);
        self.raster.draw(gpu, encoder, &self.on_gpu, &group, &list, request, target);
        if let Some(tally) = request.tally {
            tally.count_pixels(gpu, encoder, &request.view);
        }
        Ok(DrawCost { triangles: list.triangles, ..DrawCost::of_pixels(&request.view) })
    }

    fn surfaces(&mut self) -> Option<&mut dyn Surfaces> {
        Some(self)
    }

    fn light(&self) -> SceneLight {
        self.world.light
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        from_s != to_s && (self.world.camera.moves() || self.world.has_moving_objects())
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}

impl Surfaces for MeshScene {
    fn world_layout(&self) -> &wgpu::BindGroupLayout {
        &self.on_gpu.layouts.world
    }

    fn rays_layout(&mut self, gpu: &Gpu) -> &wgpu::BindGroupLayout {
        &self.rays.get_or_insert_with(|| rays::Rays::new(gpu, &self.world)).layout
    }

    fn groups(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, request: &DrawRequest<'_>) -> SurfaceGroups {
        let (frame, world) = self.frame(gpu, encoder, request);
        let rays = self.rays.as_ref().map(|rays| rays.bind(gpu, &self.world, &frame.places));
        SurfaceGroups { world, rays }
    }

    fn draw_g_buffer(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        targets: &GBuffer,
    ) -> Result<DrawCost, RenderError> {
        let (frame, group) = self.frame(gpu, encoder, request);
        let list = draw_list::DrawList::new(&self.world, &self.on_gpu, &frame, request);
        self.raster.draw_surfaces(gpu, encoder, &self.on_gpu, &group, &list, request, targets);
        Ok(DrawCost { triangles: list.triangles, ..DrawCost::default() })
    }
}
