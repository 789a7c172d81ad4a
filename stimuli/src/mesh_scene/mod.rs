//! Draws a [`World`] on the GPU: a scene of meshes under lights and a sky, as [`crate::contract::Scene`].
//!
//! `gpu_world` holds what does not change (triangles, materials, maps, sky), `frame` what a view needs (camera,
//! objects' places), `raster` draws, `shadow` looks from the sun. Shading is the one function of `shading.wgsl`.

mod draw_list;
mod frame;
mod gpu_world;
mod intermediates;
mod projection;
pub(crate) mod raster;
pub(crate) mod shadow;

use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity, SceneLight};
use crate::gpu::Gpu;
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
    Ok(Box::new(MeshScene { identity: SceneIdentity::new(), display: display.clone(), world, on_gpu, raster, shadow }))
}

impl Scene for MeshScene {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let frame = frame::Frame::new(gpu, &self.display, &self.world, &self.on_gpu, &self.shadow, request);
        self.shadow.update(gpu, encoder, &self.world, &self.on_gpu, &frame, request.animation_s);
        let group = self.on_gpu.bind(gpu, &frame, &self.shadow);
        let list = draw_list::DrawList::new(&self.world, &self.on_gpu, &frame, request);
        self.raster.draw(gpu, encoder, &self.on_gpu, &group, &list, request, target);
        if let Some(tally) = request.tally {
            tally.count_pixels(gpu, encoder, &request.view);
        }
        Ok(DrawCost { triangles: list.triangles, ..DrawCost::of_pixels(&request.view) })
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
