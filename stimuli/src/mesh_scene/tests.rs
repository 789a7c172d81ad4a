//! What a drawn world must look like: by closed forms, and by three views of it that must agree.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::contract::{LINEAR_FORMAT, MotionRequest, View};
use crate::pass;
use crate::readback::linear_rgba;
use crate::surfaces::{RAYS_WGSL, SHADING_WGSL};
use crate::tally::{Tallied, Tally};
use crate::world::camera::CameraMotion;
use crate::world::{
    CameraPath, Detail, Environment, Light, Material, Motion, Object, Panorama, Pattern, PatternKind, shapes,
};
use glam::{Affine3A, DVec3, Vec3};
use std::sync::OnceLock;

const SIZE: [u32; 2] = [160, 90];

fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::headless().unwrap_or_else(|error| panic!("{error}")))
}

fn display() -> Display {
    Display::new("test", SIZE, [520.0, 292.5], 600.0).unwrap()
}

fn looking(eye: [f64; 3], target: [f64; 3]) -> CameraPath {
    let places = [(DVec3::from(eye), DVec3::from(target))];
    CameraPath { motion: CameraMotion::Still, ..CameraPath::round(&places, 1.0) }
}

fn draw(scene: &mut dyn Scene, request: &DrawRequest<'_>) -> (Vec<[f32; 4]>, DrawCost) {
    let target = pass::linear_texture(gpu(), "test", request.view.target_px);
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let cost = scene.draw(gpu(), &mut encoder, request, &pass::view(&target)).unwrap();
    gpu().queue.submit([encoder.finish()]);
    gpu().check().unwrap();
    (pixels(&target), cost)
}

fn pixels(texture: &wgpu::Texture) -> Vec<[f32; 4]> {
    linear_rgba(gpu(), texture).unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

fn single_sampled() -> DrawRequest<'static> {
    DrawRequest { multisampled: false, ..DrawRequest::of(View::full(SIZE), 0.0) }
}

fn difference(a: [f32; 4], b: [f32; 4]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max)
}

/// A floor, things on it of every kind of material, and every kind of light.
fn everything() -> World {
    let mut world = World {
        environment: Environment::of(Panorama::painted(64, |d| Vec3::new(0.5, 0.6, 0.8) * (0.6 + 0.4 * d.y))),
        camera: looking([0.5, 1.8, 5.0], [0.0, 0.6, 0.0]),
        ..World::default()
    };
    let floor = world.mesh(shapes::block(Vec3::new(-6.0, -0.2, -6.0), Vec3::new(6.0, 0.0, 6.0)));
    let ball = world.mesh(shapes::sphere(0.5, 24));
    let block = world.mesh(shapes::block(Vec3::splat(-0.4), Vec3::splat(0.4)));
    let relief = Pattern { relief: 0.08, roughness: 0.2, ..Pattern::new(PatternKind::Tiles, [0.2, 0.2, 0.2], 1.0) };
    world.colour_maps.push(crate::world::Map {
        size: [4, 4],
        rgba: (0..16)
            .flat_map(|i| if (i + i / 4) % 2 == 0 { [220, 60, 40, 255] } else { [240, 230, 210, 255] })
            .collect(),
    });
    let materials = [
        Material::matt([0.7, 0.7, 0.6], 0.6).with(relief),
        Material::metal([0.9, 0.7, 0.3], 0.2),
        Material::matt([0.2, 0.4, 0.7], 0.3).with(Pattern::new(PatternKind::Checker, [0.8, 0.8, 0.8], 3.0)),
        Material { albedo_map: Some(0), ..Material::matt([1.0, 1.0, 1.0], 0.5) },
    ]
    .map(|material| world.material(material));
    world.place(floor, materials[0], Affine3A::IDENTITY);
    world.place(ball, materials[1], Affine3A::from_translation(Vec3::new(-1.1, 0.5, 0.3)));
    world.place(ball, materials[2], Affine3A::from_translation(Vec3::new(1.2, 0.5, -0.4)));
    let turned = Affine3A::from_rotation_translation(glam::Quat::from_rotation_y(0.6), Vec3::new(0.1, 0.4, 0.2));
    world.place(block, materials[3], turned);
    world.lights.extend([
        Light::Directional { towards: Vec3::new(0.5, 0.8, 0.4).normalize(), colour: Vec3::splat(1.5) },
        Light::Point { at: Vec3::new(0.0, 2.0, 1.5), colour: Vec3::new(1.0, 0.5, 0.2), reach_m: 6.0 },
        Light::Area {
            at: Vec3::new(-3.0, 1.5, 0.0),
            half_right: Vec3::new(0.0, 0.0, -0.5),
            half_up: Vec3::new(0.0, 0.5, 0.0),
            colour: Vec3::new(0.5, 1.0, 2.0),
        },
    ]);
    world
}

/// A white furnace: whatever is white and matt under an even sky cannot be told from it.
#[test]
fn a_white_world_under_an_even_sky_cannot_be_seen() {
    let mut world = World {
        environment: Environment::of(Panorama::uniform(Vec3::splat(0.5))),
        camera: looking([0.0, 0.0, 3.0], [0.0; 3]),
        ..World::default()
    };
    let ball = world.mesh(shapes::sphere(1.0, 32));
    let white = world.material(Material::matt([1.0; 3], 1.0));
    world.place(ball, white, Affine3A::IDENTITY);
    let mut scene = make(gpu(), &display(), world).unwrap();
    for request in [single_sampled(), DrawRequest::of(View::full(SIZE), 0.0)] {
        let (picture, cost) = draw(scene.as_mut(), &request);
        let worst = picture.iter().map(|&p| difference(p, [0.5; 4])).fold(0.0, f32::max);
        println!("largest departure from the sky's 0.5: {worst:.1e}; {} triangles", cost.triangles);
        assert!(worst < 2e-3 && cost.triangles > 1000);
    }
}

/// A point light over a white floor: albedo · colour · cos / d², at the foot and aside (the mirrored part is below 4 %).
#[test]
fn light_falls_off_by_the_cosine_and_the_square() {
    let mut world = World {
        environment: Environment::of(Panorama::uniform(Vec3::ZERO)),
        camera: looking([0.0, 4.0, 0.001], [0.0; 3]),
        ..World::default()
    };
    let floor = world.mesh(shapes::block(Vec3::new(-9.0, -1.0, -9.0), Vec3::new(9.0, 0.0, 9.0)));
    let white = world.material(Material::matt([1.0; 3], 1.0));
    world.place(floor, white, Affine3A::IDENTITY);
    world.lights.push(Light::Point { at: Vec3::new(0.0, 1.0, 0.0), colour: Vec3::ONE, reach_m: 1000.0 });
    let display = display();
    let mut scene = make(gpu(), &display, world).unwrap();
    let (picture, _) = draw(scene.as_mut(), &single_sampled());
    for px in [[80_u32, 45], [100, 45], [80, 70], [150, 80]] {
        let d = display.direction_from_mm(display.mm_from_px(px.map(|x| f64::from(x) + 0.5)));
        // The floor is four metres in front of the eye.
        let r2 = 16.0 * (d[0] * d[0] + d[1] * d[1]) / (d[2] * d[2]);
        let expected = (1.0 + r2).powf(-1.5);
        let found = f64::from(picture[(px[1] * SIZE[0] + px[0]) as usize][1]);
        println!("{px:?}: {found:.4}, closed form {expected:.4}");
        assert!((found / expected - 1.0).abs() < 0.04);
    }
}

/// The shadow of a block that floats over a floor in oblique light lies where the light's direction says.
#[test]
fn shadows_lie_where_the_light_says() {
    let mut world = World {
        environment: Environment::of(Panorama::uniform(Vec3::ZERO)),
        camera: looking([0.0, 8.0, 0.001], [0.0; 3]),
        ..World::default()
    };
    let floor = world.mesh(shapes::block(Vec3::new(-4.0, -0.5, -4.0), Vec3::new(4.0, 0.0, 4.0)));
    let block = world.mesh(shapes::block(Vec3::new(-0.5, 1.0, -0.5), Vec3::new(0.5, 1.2, 0.5)));
    let white = world.material(Material::matt([0.9; 3], 1.0));
    world.place(floor, white, Affine3A::IDENTITY);
    world.place(block, white, Affine3A::IDENTITY);
    // 45° from the right: the shadow of the lower face is moved one metre to the left.
    world.lights.push(Light::Directional { towards: Vec3::new(1.0, 1.0, 0.0).normalize(), colour: Vec3::ONE });
    let display = display();
    let mut scene = make(gpu(), &display, world).unwrap();
    let (picture, _) = draw(scene.as_mut(), &single_sampled());
    let mut checked = [0, 0];
    for (i, pixel) in picture.iter().enumerate() {
        let px = [(i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5];
        let d = display.direction_from_mm(display.mm_from_px(px));
        let at = [8.0 * d[0] / d[2], -8.0 * d[1] / d[2]];
        // The camera's up is −z. Well inside the shadow and not under the block; well outside everything.
        let inside = (-1.55..-0.85).contains(&at[0]) && at[1].abs() < 0.35;
        let outside = at[0].abs().max(at[1].abs()) < 1.6 && (at[0] > 0.75 || at[1].abs() > 0.75);
        if inside {
            assert!(pixel[1] < 0.01, "light at {at:?}: {}", pixel[1]);
            checked[0] += 1;
        } else if outside {
            assert!((pixel[1] - 0.9 * std::f32::consts::FRAC_1_SQRT_2).abs() < 0.05, "at {at:?}: {}", pixel[1]);
            checked[1] += 1;
        }
    }
    println!("pixels in the shadow and in the light: {checked:?}");
    assert!(checked[0] > 50 && checked[1] > 200);
}

/// Rasterised, shaded from a G-buffer, and traced: one picture. What differs are pixels at edges, and the joints of a
/// relief, whose depth depends on the directions of a pixel's footprint.
#[test]
fn three_views_of_a_world_agree() {
    let mut scene = make(gpu(), &display(), everything()).unwrap();
    let (rasterised, _) = draw(scene.as_mut(), &single_sampled());
    let shaded = own_pass(scene.as_mut(), SHADING_WGSL, DEFERRED_TEST_WGSL, true);
    let traced = own_pass(scene.as_mut(), RAYS_WGSL, TRACED_TEST_WGSL, false);
    let brightness = rasterised.iter().map(|p| p[1]).sum::<f32>() / rasterised.len() as f32;
    for (name, picture, most_share) in [("deferred", shaded, 0.001), ("traced", traced, 0.04)] {
        let off = rasterised.iter().zip(&picture).map(|(&a, &b)| difference(a, b));
        let differing = off.clone().filter(|&d| d > 0.03).count() as f32 / rasterised.len() as f32;
        let mean = off.sum::<f32>() / rasterised.len() as f32;
        println!(
            "{name}: mean difference {mean:.1e} of {brightness:.2}, {:.2} % differ by more than 0.03",
            100.0 * differing
        );
        assert!(differing <= most_share && mean < 5e-3, "{name}");
    }
}

const DEFERRED_TEST_WGSL: &str = "
@group(1) @binding(0) var normals: texture_2d<f32>;
@group(1) @binding(1) var albedo: texture_2d<f32>;
@group(1) @binding(2) var emission: texture_2d<f32>;
@group(1) @binding(3) var depth: texture_2d<f32>;
@fragment fn test_colour(@builtin(position) p: vec4f) -> @location(0) vec4f {
    let at = vec2i(p.xy);
    let n = textureLoad(normals, at, 0);
    let colour = shade_texels(n, textureLoad(albedo, at, 0), textureLoad(emission, at, 0), textureLoad(depth, at, 0).r, p.xy);
    return half_colour(colour);
}";

const TRACED_TEST_WGSL: &str = "
@fragment fn test_colour(@builtin(position) p: vec4f) -> @location(0) vec4f {
    let d = ray_through(p.xy);
    let pixel_rad = length(frame.geometry.pitch_per_distance) * 0.7071 / length(d);
    return half_colour(radiance_along(frame.eye.xyz, d, pixel_rad));
}";

/// A picture by a shader of a renderer's own.
fn own_pass(scene: &mut dyn Scene, preamble: &str, wgsl: &str, deferred: bool) -> Vec<[f32; 4]> {
    let gpu = gpu();
    let request = single_sampled();
    let surfaces = scene.surfaces().unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let rays_layout = (!deferred).then(|| surfaces.rays_layout(gpu).clone());
    let groups = surfaces.groups(gpu, &mut encoder, &request);
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(format!("{preamble}\n{wgsl}").into()),
    });
    let texture_layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[0, 1, 2, 3].map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }),
    });
    let second = rays_layout.as_ref().unwrap_or(&texture_layout);
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(surfaces.world_layout()), Some(second)],
        immediate_size: 0,
    });
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
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
            entry_point: Some("test_colour"),
            compilation_options: Default::default(),
            targets: &[Some(LINEAR_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let group = match groups.rays {
        Some(rays) => rays,
        None => {
            let targets = GBuffer::new(gpu, SIZE);
            surfaces.draw_g_buffer(gpu, &mut encoder, &request, &targets).unwrap();
            let entries: Vec<_> = targets
                .targets()
                .iter()
                .zip(0..)
                .map(|((view, _), binding)| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(view),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &texture_layout,
                entries: &entries,
            })
        }
    };
    let target = pass::linear_texture(gpu, "test", SIZE);
    pass::draw_with(&mut encoder, &pipeline, &[&groups.world, &group], &pass::view(&target), pass::Extent::All);
    gpu.queue.submit([encoder.finish()]);
    gpu.check().unwrap();
    pixels(&target)
}

/// The motion of a floor under a moving camera and of the sky, against the same projection in f64.
#[test]
fn motion_is_that_of_the_two_cameras() {
    let display = display();
    let mut world = World { environment: Environment::default(), ..World::default() };
    let floor = world.mesh(shapes::block(Vec3::new(-50.0, -1.0, -50.0), Vec3::new(50.0, 0.0, 50.0)));
    let grey = world.material(Material::default());
    world.place(floor, grey, Affine3A::IDENTITY);
    world.camera = CameraPath::round(
        &[
            (DVec3::new(0.0, 1.5, 4.0), DVec3::new(0.0, 1.0, 0.0)),
            (DVec3::new(1.0, 1.7, 3.5), DVec3::new(0.5, 1.0, 0.0)),
            (DVec3::new(-1.0, 2.0, 3.0), DVec3::new(0.0, 1.3, 0.0)),
        ],
        2.0,
    );
    let path = world.camera.clone();
    let mut scene = make(gpu(), &display, world).unwrap();
    let (now_s, since_s) = (0.70, 0.65);
    let motion = pass::linear_texture(gpu(), "motion", SIZE);
    let view = pass::view(&motion);
    let request =
        DrawRequest { animation_s: now_s, motion: Some(MotionRequest { since_s, target: &view }), ..single_sampled() };
    draw(scene.as_mut(), &request);
    let (now, then) = (path.pose(now_s), path.pose(since_s));
    let mut worst = [0.0_f64; 2];
    let mut kinds = [0, 0];
    for (i, texel) in pixels(&motion).iter().enumerate() {
        let px = [(i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5];
        let d = display.direction_from_mm(display.mm_from_px(px)).map(|x| x / display.distance_mm());
        let direction = now.right * d[0] + now.up * d[1] + now.forward * d[2];
        // The floor, or the sky; near the horizon a pixel may be either.
        if direction.y.abs() < 0.05 {
            continue;
        }
        let (to_then, expected_inverse) = if direction.y < 0.0 {
            let depth = -now.eye.y / direction.y;
            let to = now.eye + direction * depth - then.eye;
            (to, [1.0 / to.dot(then.forward), 1.0 / depth])
        } else {
            (direction, [0.0; 2])
        };
        kinds[usize::from(direction.y < 0.0)] += 1;
        let depth = to_then.dot(then.forward);
        let mm = [to_then.dot(then.right), to_then.dot(then.up)].map(|x| x / depth * display.distance_mm());
        let px_then = display.px_from_mm(mm);
        for axis in 0..2 {
            worst[0] = worst[0].max((f64::from(texel[axis]) - (px_then[axis] - px[axis])).abs());
            let inverse = f64::from(texel[2 + axis]);
            worst[1] = worst[1].max((inverse - expected_inverse[axis]).abs() / expected_inverse[axis].max(1e-3));
        }
    }
    println!(
        "floor and sky {kinds:?} pixels; largest error {:.1e} px, inverse depth {:.1e} of itself",
        worst[0], worst[1]
    );
    assert!(kinds[0] > 1000 && kinds[1] > 1000 && worst[0] < 0.02 && worst[1] < 2e-3);
}

/// An object that spins under a still camera moves by its own rotation.
#[test]
fn objects_move_by_themselves() {
    let mut world = World { camera: looking([0.0, 0.0, 5.0], [0.0; 3]), ..World::default() };
    let card = world.mesh(shapes::block(Vec3::new(-1.0, -1.0, -0.01), Vec3::new(1.0, 1.0, 0.0)));
    let grey = world.material(Material::default());
    let motion = Motion::Spin { at: Affine3A::IDENTITY, axis: Vec3::Z, speed_deg_s: 90.0 };
    world.objects.push(Object { motion, ..Object::still(card, grey) });
    let display = display();
    let mut scene = make(gpu(), &display, world).unwrap();
    assert!(scene.picture_changes(0.0, 0.1));
    let texture = pass::linear_texture(gpu(), "motion", SIZE);
    let view = pass::view(&texture);
    let request = DrawRequest {
        animation_s: 0.1,
        motion: Some(MotionRequest { since_s: 0.0, target: &view }),
        ..single_sampled()
    };
    draw(scene.as_mut(), &request);
    // A place r from the axis was 9° further back.
    let (x, y) = (92.5 - 80.0, 35.5 - 45.0);
    let angle = 9.0_f64.to_radians();
    let expected = [x * angle.cos() - y * angle.sin() - x, x * angle.sin() + y * angle.cos() - y];
    let found = pixels(&texture)[35 * 160 + 92];
    println!("moved {found:?}, closed form {expected:?}");
    assert!((f64::from(found[0]) - expected[0]).abs() < 0.02 && (f64::from(found[1]) - expected[1]).abs() < 0.02);
}

/// Multisampling changes the pixels at edges only, and what is counted holds with and without.
#[test]
fn edges_are_smooth_and_counts_hold() {
    let mut scene = make(gpu(), &display(), everything()).unwrap();
    let (hard, _) = draw(scene.as_mut(), &single_sampled());
    let (smooth, _) = draw(scene.as_mut(), &DrawRequest::of(View::full(SIZE), 0.0));
    let changed = hard.iter().zip(&smooth).filter(|&(&a, &b)| difference(a, b) > 0.02).count();
    println!("{changed} of {} pixels have an edge", hard.len());
    assert!(changed > 50 && changed < hard.len() / 8);
    for request in [single_sampled(), DrawRequest::of(View::full(SIZE), 0.0)] {
        let tally = Tally::new(gpu(), SIZE);
        let (counted, cost) = draw(&mut Tallied::new(scene.as_mut(), &tally), &request);
        let plain = if request.multisampled { &smooth } else { &hard };
        assert_eq!(&counted, plain, "counting changes nothing");
        let counts = tally.counts(gpu()).unwrap();
        let runs: u64 = counts.runs.iter().map(|&r| u64::from(r)).sum();
        println!("{counts:?}", counts = counts.draws);
        assert_eq!(counts.draws.len(), 1);
        assert_eq!(u64::from(counts.draws[0].pixels), cost.pixels_shaded);
        assert_eq!(u64::from(counts.draws[0].runs), runs);
        // Every pixel shows something, and few are shaded twice.
        assert!(counts.runs.iter().all(|&r| r >= 1));
        assert!(runs < 3 * cost.pixels_shaded);
    }
}

/// A part of the display in a finer grid is the same picture, and less detail means fewer triangles.
#[test]
fn views_and_levels_of_detail() {
    let mut world = everything();
    let shape = world.mesh(shapes::graded_surface(4, 40, |uv| {
        let (theta, phi) = ((1.0 - uv.y) * std::f32::consts::PI, uv.x * std::f32::consts::TAU);
        0.5 * Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
    }));
    let detail = Detail { near_m: 1.0, far_m: 20.0, most: 3200.0, fewest: 32.0 };
    world.objects.push(Object { detail: Some(detail), ..Object::still(shape, 1) });
    let mut scene = make(gpu(), &display(), world).unwrap();
    let (whole, full) = draw(scene.as_mut(), &single_sampled());
    let part = View { origin_px: [40.0, 20.0], size_px: [80.0, 50.0], target_px: [80, 50] };
    let (cut, fewer) = draw(scene.as_mut(), &DrawRequest { view: part, ..single_sampled() });
    let off = cut.iter().enumerate().map(|(i, &p)| {
        let (x, y) = (i as u32 % 80 + 40, i as u32 / 80 + 20);
        difference(p, whole[(y * SIZE[0] + x) as usize])
    });
    let differing = off.filter(|&d| d > 0.01).count();
    println!("{differing} of {} pixels differ; triangles {} and {}", cut.len(), full.triangles, fewer.triangles);
    assert!(differing < 20 && fewer.triangles <= full.triangles);
    let (_, coarse) = draw(scene.as_mut(), &DrawRequest { detail: 0.4, ..single_sampled() });
    println!("detail 0.4: {} triangles of {}", coarse.triangles, full.triangles);
    assert!(coarse.triangles < full.triangles);
}

#[test]
fn an_empty_world_shows_the_sky() {
    let world = World { environment: Environment::of(Panorama::uniform(Vec3::new(0.2, 0.3, 0.4))), ..World::default() };
    let mut scene = make(gpu(), &display(), world).unwrap();
    let (picture, cost) = draw(scene.as_mut(), &DrawRequest::of(View::full(SIZE), 0.0));
    assert_eq!(cost.triangles, 0);
    assert!(picture.iter().all(|&p| difference(p, [0.2, 0.3, 0.4, 1.0]) < 1e-3 && p[3] > 0.999));
    let traced = own_pass(scene.as_mut(), RAYS_WGSL, TRACED_TEST_WGSL, false);
    assert!(traced.iter().all(|&p| difference(p, [0.2, 0.3, 0.4, 1.0]) < 1e-3));
}
