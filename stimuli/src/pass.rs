//! Small helpers for passes that cover a target with one triangle: pipelines, uniforms, bind groups, textures.

use crate::contract::LINEAR_FORMAT;
use crate::geometry::{GEOMETRY_WGSL, PixelBox};
use crate::gpu::Gpu;
use wgpu::util::DeviceExt;

/// A pipeline whose fragment shader `entry` runs on every pixel of a target of `format`.
pub(crate) fn pipeline(
    gpu: &Gpu,
    label: &str,
    wgsl: &str,
    entry: &str,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    pipeline_with(gpu, label, wgsl, entry, format, &[])
}

/// As [`pipeline`], with values for the shader's `override` constants.
pub(crate) fn pipeline_with(
    gpu: &Gpu,
    label: &str,
    wgsl: &str,
    entry: &str,
    format: wgpu::TextureFormat,
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(format!("{GEOMETRY_WGSL}\n{wgsl}").into()),
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cover"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A uniform buffer that holds `value`. Small and made anew for each use, so that draws of one frame never share it.
pub(crate) fn uniform<T: bytemuck::Pod>(gpu: &Gpu, value: &T) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::bytes_of(value),
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// Bind group 0 of `pipeline`: a uniform at binding 0, then the views from binding 1 on.
pub(crate) fn bind(
    gpu: &Gpu,
    pipeline: &wgpu::RenderPipeline,
    uniform: &wgpu::Buffer,
    views: &[&wgpu::TextureView],
) -> wgpu::BindGroup {
    let textures = views.iter().map(|&view| wgpu::BindingResource::TextureView(view));
    let entries: Vec<_> = std::iter::once(uniform.as_entire_binding())
        .chain(textures)
        .zip(0..)
        .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

/// Which pixels of a target a draw touches.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Extent<'a> {
    /// The whole target.
    All,
    /// The top left corner, `[width, height]`.
    Corner([u32; 2]),
    /// These boxes; the rest keeps what it holds.
    Boxes(&'a [PixelBox]),
}

/// Records one draw of `pipeline` over `extent` of `target`.
pub(crate) fn draw(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    bind_group: &wgpu::BindGroup,
    target: &wgpu::TextureView,
    extent: Extent<'_>,
) {
    draw_with(encoder, pipeline, &[bind_group], target, extent);
}

/// As [`draw`], with bind groups 0, 1, ….
pub(crate) fn draw_with(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    bind_groups: &[&wgpu::BindGroup],
    target: &wgpu::TextureView,
    extent: Extent<'_>,
) {
    let keep = matches!(extent, Extent::Boxes(_));
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: if keep { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(wgpu::Color::BLACK) },
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    for (&bind_group, index) in bind_groups.iter().zip(0..) {
        pass.set_bind_group(index, bind_group, &[]);
    }
    match extent {
        Extent::All => pass.draw(0..3, 0..1),
        Extent::Corner([width, height]) => {
            pass.set_scissor_rect(0, 0, width, height);
            pass.draw(0..3, 0..1);
        }
        Extent::Boxes(boxes) => {
            for area in boxes {
                let [width, height] = area.size();
                pass.set_scissor_rect(area.left, area.top, width, height);
                pass.draw(0..3, 0..1);
            }
        }
    }
}

/// Records the filling of `target` with one value.
pub(crate) fn clear(encoder: &mut wgpu::CommandEncoder, target: &wgpu::TextureView, colour: wgpu::Color) {
    let _ = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("clear"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(colour), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
}

/// A texture that passes can draw, read and copy.
pub(crate) fn texture(gpu: &Gpu, label: &str, size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0].max(1), height: size[1].max(1), depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// The texture in `slot`, made anew when it is smaller than `size` on an axis.
pub(crate) fn at_least<'a>(
    gpu: &Gpu,
    slot: &'a mut Option<wgpu::Texture>,
    label: &str,
    size: [u32; 2],
    format: wgpu::TextureFormat,
) -> &'a wgpu::Texture {
    let held = slot.as_ref().map_or([0; 2], |texture| [texture.width(), texture.height()]);
    if held[0] < size[0] || held[1] < size[1] {
        *slot = None;
    }
    slot.get_or_insert_with(|| texture(gpu, label, [size[0].max(held[0]), size[1].max(held[1])], format))
}

/// A linear-light picture of `size` pixels.
pub(crate) fn linear_texture(gpu: &Gpu, label: &str, size: [u32; 2]) -> wgpu::Texture {
    texture(gpu, label, size, LINEAR_FORMAT)
}

/// The whole of a texture.
pub(crate) fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A texture of half floats from RGBA values, row by row from the top.
pub(crate) fn half_texture(gpu: &Gpu, label: &str, size: [u32; 2], rgba: &[[f32; 4]]) -> wgpu::Texture {
    let halves: Vec<u16> = rgba.iter().flatten().map(|&x| half::f16::from_f32(x).to_bits()).collect();
    filled_texture(gpu, label, size, LINEAR_FORMAT, bytemuck::cast_slice(&halves))
}

/// A texture of full floats from RGBA values, row by row from the top; it is read by texel, never filtered.
pub(crate) fn float_texture(gpu: &Gpu, label: &str, size: [u32; 2], rgba: &[[f32; 4]]) -> wgpu::Texture {
    filled_texture(gpu, label, size, wgpu::TextureFormat::Rgba32Float, bytemuck::cast_slice(rgba))
}

fn filled_texture(gpu: &Gpu, label: &str, size: [u32; 2], format: wgpu::TextureFormat, texels: &[u8]) -> wgpu::Texture {
    gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        texels,
    )
}

/// Copies all of `from` over `to`, which has its size and format.
pub(crate) fn copy(encoder: &mut wgpu::CommandEncoder, from: &wgpu::Texture, to: &wgpu::Texture) {
    encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
}

/// Copies the same boxes of `from` over `to`, which has its size and format.
pub(crate) fn copy_boxes(
    encoder: &mut wgpu::CommandEncoder,
    from: &wgpu::Texture,
    to: &wgpu::Texture,
    boxes: &[PixelBox],
) {
    for area in boxes {
        let origin = wgpu::Origin3d { x: area.left, y: area.top, z: 0 };
        let [width, height] = area.size();
        encoder.copy_texture_to_texture(
            wgpu::TexelCopyTextureInfo { origin, ..from.as_image_copy() },
            wgpu::TexelCopyTextureInfo { origin, ..to.as_image_copy() },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::GEOMETRY_WGSL;
    use wgpu::naga;

    /// Every shader of the crate, as it is handed to the device.
    #[test]
    fn every_shader_is_valid() {
        let shaders = [
            ("display_pass", crate::display_pass::WGSL),
            ("mesh scene", crate::mesh_scene::raster::WGSL),
            ("mesh scene, counted", crate::mesh_scene::raster::COUNTED_WGSL),
            ("mesh scene's shadow", crate::mesh_scene::shadow::WGSL),
            ("campbell_robson", crate::scenes::campbell_robson::WGSL),
            ("noise", crate::scenes::noise::WGSL),
            ("orbit", crate::scenes::orbit::WGSL),
            ("photo", crate::scenes::photo::WGSL),
            ("zone_plate", crate::scenes::zone_plate::WGSL),
            ("falloff", crate::renderers::falloff::WGSL),
            ("low_passed", crate::renderers::low_passed::WGSL),
            ("ring", crate::renderers::ring::WGSL),
            ("tally", crate::tally::WGSL),
        ];
        let capabilities = naga::valid::Capabilities::default() | naga::valid::Capabilities::EARLY_DEPTH_TEST;
        let complete = [
            ("shading of surfaces", crate::surfaces::SHADING_WGSL.to_owned()),
            ("rays", crate::surfaces::RAYS_WGSL.to_owned()),
        ];
        let shaders = shaders.into_iter().chain(crate::renderers::layers::SHADERS);
        let with_geometry = shaders.map(|(name, wgsl)| (name, format!("{GEOMETRY_WGSL}\n{wgsl}")));
        for (name, source) in with_geometry.chain(complete) {
            let module = naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
            let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities);
            if let Err(error) = validator.validate(&module) {
                panic!("{name}: {}", error.emit_to_string(&source));
            }
        }
    }
}
