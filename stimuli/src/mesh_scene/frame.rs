//! What one view of a world needs: the camera now and at an earlier picture, and where every object is.

use super::gpu_world::GpuWorld;
use super::projection::{Frustum, clip_from_world};
use super::shadow::Shadow;
use crate::contract::DrawRequest;
use crate::geometry::GeometryUniform;
use crate::gpu::Gpu;
use crate::pass;
use crate::world::{Pose, World};
use experiments::display::Display;
use glam::{Affine3A, DVec3, Mat4, Vec3, Vec4};
use wgpu::util::DeviceExt;

/// `Frame` of `world.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FrameUniform {
    geometry: GeometryUniform,
    clip: Mat4,
    now: [Vec4; 4],
    then: [Vec4; 4],
    sun: Vec4,
    sun_colour: Vec4,
    ambient: [Vec4; 9],
    shadow: Mat4,
    origin_px: [f32; 2],
    step_px: [f32; 2],
    light_counts: [u32; 4],
    shadow_texel_m: f32,
    pattern_samples: u32,
    sky_levels: u32,
    four: u32,
    white: f32,
    reserved: [f32; 3],
}

/// `Object` of `world.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct ObjectRecord {
    now: [Vec4; 3],
    then: [Vec4; 3],
    normal: [Vec4; 3],
    material: u32,
    reserved: [u32; 3],
}

/// One view of the world at one time, on the GPU.
pub(super) struct Frame {
    pub(super) uniform: wgpu::Buffer,
    pub(super) objects: wgpu::Buffer,
    /// Where each object is now.
    pub(super) places: Vec<Affine3A>,
    pub(super) eye: DVec3,
    pub(super) frustum: Frustum,
}

impl Frame {
    pub(super) fn new(
        gpu: &Gpu,
        display: &Display,
        world: &World,
        on_gpu: &GpuWorld,
        shadow: &Shadow,
        request: &DrawRequest<'_>,
    ) -> Self {
        let view = &request.view;
        let then_s = request.motion.map_or(request.animation_s, |motion| motion.since_s);
        let [pose, then] = [request.animation_s, then_s].map(|time_s| world.camera.pose(time_s));
        let clip = clip_from_world(display, view, &pose);
        let sun = shadow.sun();
        let uniform = FrameUniform {
            geometry: GeometryUniform::new(display, [0.0; 2]),
            clip: clip.as_mat4(),
            now: pose_rows(&pose),
            then: pose_rows(&then),
            sun: sun.towards.extend(0.0),
            sun_colour: sun.colour.extend(0.0),
            ambient: world.environment.ambient.map(|c| c.extend(0.0)),
            shadow: shadow.matrix(),
            origin_px: view.origin_px.map(|x| x as f32),
            step_px: view.step_px().map(|x| x as f32),
            light_counts: on_gpu.light_counts,
            shadow_texel_m: shadow.texel_m(),
            pattern_samples: world.pattern_samples,
            sky_levels: on_gpu.sky_levels,
            four: 4,
            white: world.light.white() as f32,
            reserved: [0.0; 3],
        };
        let places: Vec<Affine3A> = world.objects.iter().map(|object| object.motion.at(request.animation_s)).collect();
        let records = object_records(world, &places, request.animation_s, then_s);
        Self {
            uniform: pass::uniform(gpu, &uniform),
            objects: gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("objects"),
                contents: bytemuck::cast_slice(&records),
                usage: wgpu::BufferUsages::STORAGE,
            }),
            places,
            eye: pose.eye,
            frustum: Frustum::of(&clip),
        }
    }
}

fn pose_rows(pose: &Pose) -> [Vec4; 4] {
    [pose.eye, pose.right, pose.up, pose.forward].map(|v| v.as_vec3().extend(0.0))
}

fn object_records(world: &World, places: &[Affine3A], now_s: f64, then_s: f64) -> Vec<ObjectRecord> {
    let rows = |m: &Affine3A| {
        let t = Mat4::from(*m);
        [t.row(0), t.row(1), t.row(2)]
    };
    let record = |(object, place): (&crate::world::Object, &Affine3A)| {
        let moved = object.motion.moves() && now_s != then_s;
        let then = if moved { object.motion.at(then_s) } else { *place };
        // The transposed inverse up to a factor, which also serves matrices that flatten.
        let [x, y, z] = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis].map(Vec3::from);
        let (yz, zx, xy) = (y.cross(z), z.cross(x), x.cross(y));
        let sign = if x.dot(yz) < 0.0 { -1.0 } else { 1.0 };
        let normal = [0, 1, 2].map(|i| (sign * Vec3::new(yz[i], zx[i], xy[i])).extend(0.0));
        ObjectRecord { now: rows(place), then: rows(&then), normal, material: object.material as u32, reserved: [0; 3] }
    };
    let mut records: Vec<ObjectRecord> = world.objects.iter().zip(places).map(record).collect();
    if records.is_empty() {
        // Storage buffers are never empty.
        records.push(bytemuck::Zeroable::zeroed());
    }
    records
}
