//! What every procedural world owes: sound triangles in a bounded number, quickly built, the same each time, and a camera
//! that never comes too near to anything.

use super::{atrium, engine_room, grid_world, tunnel, voxel_town};
use crate::contract::MakeError;
use crate::world::{Mesh, World};
use experiments::catalogue::{Parameters, SceneInfo, complete_parameters};
use glam::Vec3;
use std::time::Instant;

type Build = fn(&Parameters) -> Result<World, MakeError>;
/// A world's description, how it is built, and its bounds.
type Case = (fn() -> SceneInfo, Build, [usize; 2]);

/// Every world with the least and the most triangles of its finest levels, in thousands; objects count as often as they
/// stand in the world.
const WORLDS: [Case; 6] = [
    (grid_world::info, grid_world::world, [8_000, 8_030]),
    (atrium::info, atrium::world, [150, 450]),
    (tunnel::geom::info, tunnel::geom::world, [200, 320]),
    (tunnel::maps::info, tunnel::maps::world, [60, 300]),
    (voxel_town::info, voxel_town::world, [150, 750]),
    (engine_room::info, engine_room::world, [200, 600]),
];

fn built(info: fn() -> SceneInfo, build: Build) -> World {
    let parameters = complete_parameters(&info().parameters, &Parameters::new()).expect("defaults are accepted");
    build(&parameters).expect("it can be built")
}

fn triangles(world: &World) -> usize {
    let finest = |mesh: &Mesh| mesh.levels.first().map_or(0, |level| level.triangles());
    world.objects.iter().map(|object| finest(&world.meshes[object.mesh])).sum()
}

#[test]
fn worlds_are_sound() {
    for (info, build, [fewest, most]) in WORLDS {
        let name = info().id;
        let begin = Instant::now();
        let world = built(info, build);
        let ms = begin.elapsed().as_secs_f64() * 1e3;
        let thousands = triangles(&world) / 1000;
        let [low, high] = world.bounds(0.0).expect("there is something");
        println!(
            "{name}: {thousands}k triangles, {} objects, {} meshes, {} materials, {} lights, {:.0} × {:.0} × {:.0} m, \
             round of {:.0} s, built in {ms:.0} ms",
            world.objects.len(),
            world.meshes.len(),
            world.materials.len(),
            world.lights.len(),
            high.x - low.x,
            high.y - low.y,
            high.z - low.z,
            world.camera.span_s(),
        );
        assert!((fewest..=most).contains(&thousands), "{name}: {thousands}k triangles");
        assert!((60.0..400.0).contains(&world.camera.span_s()), "{name}: {} s", world.camera.span_s());
        for object in &world.objects {
            assert!(object.material < world.materials.len() && object.mesh < world.meshes.len(), "{name}");
        }
        for material in &world.materials {
            let colours = [material.albedo, material.pattern.colour];
            assert!(colours.iter().all(|c| c.min_element() >= 0.0 && c.max_element() <= 1.0), "{name}: {colours:?}");
        }
        for level in world.meshes.iter().flat_map(|mesh| &mesh.levels) {
            let count = level.vertices.len() as u32;
            assert!(level.indices.iter().all(|&index| index < count), "{name}");
            for vertex in &level.vertices {
                let (normal, [x, y, z, open]) = (Vec3::from(vertex.normal), vertex.tangent);
                assert!(Vec3::from(vertex.position).is_finite() && vertex.uv[0].is_finite(), "{name}");
                assert!((normal.length() - 1.0).abs() < 1e-3, "{name}: a normal of {normal}");
                assert!(
                    Vec3::new(x, y, z).length() > 0.9 && (0.0..=1.0).contains(&open.abs()),
                    "{name}: {x} {y} {z} {open}"
                );
            }
        }
    }
}

/// Normals look to the side from which a triangle is counter-clockwise, but for a few slivers at
/// cusps, at most one in three hundred.
#[test]
fn triangles_face_their_normals() {
    for (info, build, _) in WORLDS {
        let world = built(info, build);
        let (mut wrong, mut all) = (0, 0);
        for level in world.meshes.iter().filter_map(|mesh| mesh.levels.first()) {
            for triangle in level.indices.chunks_exact(3) {
                let corner = |i: usize| &level.vertices[triangle[i] as usize];
                let place = |i: usize| Vec3::from(corner(i).position);
                let facing = (place(1) - place(0)).cross(place(2) - place(0)).normalize_or_zero();
                let normal: Vec3 = (0..3).map(|i| Vec3::from(corner(i).normal)).sum();
                all += 1;
                wrong += usize::from(facing.dot(normal) < -0.1);
            }
        }
        println!("{}: {wrong} of {all} triangles face away from their normals", info().id);
        assert!(wrong * 300 <= all, "{}", info().id);
    }
}

#[test]
fn worlds_are_the_same_each_time() {
    for (info, build, _) in WORLDS {
        let [a, b] = [0, 1].map(|_| built(info, build));
        assert!(a.meshes == b.meshes && a.objects == b.objects && a.materials == b.materials, "{}", info().id);
    }
}

/// Distance from a point to a triangle (Ericson, "Real-Time Collision Detection", 2005, §5.1.5, by clamped barycentrics and
/// edges).
fn distance(at: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let normal = (b - a).cross(c - a);
    let inside = |p: Vec3, q: Vec3| normal.cross(q - p).dot(at - p) >= 0.0;
    if normal.length_squared() > 1e-12 && inside(a, b) && inside(b, c) && inside(c, a) {
        return (at - a).dot(normal.normalize()).abs();
    }
    let to_edge = |p: Vec3, q: Vec3| {
        let t = ((at - p).dot(q - p) / (q - p).length_squared().max(1e-12)).clamp(0.0, 1.0);
        at.distance(p.lerp(q, t))
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// On its whole round the eye keeps at least a third of a metre from every triangle of the finest levels.
#[test]
fn cameras_keep_their_distance() {
    const FREE_M: f32 = 0.33;
    for (info, build, _) in WORLDS {
        let world = built(info, build);
        let span_s = world.camera.span_s();
        let samples = 500;
        let eyes: Vec<Vec3> =
            (0..samples).map(|i| world.camera.pose(span_s * f64::from(i) / f64::from(samples)).eye.as_vec3()).collect();
        let (mut nearest, mut when) = (f32::MAX, 0.0);
        for object in &world.objects {
            let at = object.motion.at(0.0);
            let Some(level) = world.meshes[object.mesh].levels.first() else { continue };
            let [low, high] = world.meshes[object.mesh].bounds().expect("it has vertices");
            let reach = 0.5 * (high - low).length() * at.matrix3.x_axis.length() + 1.0;
            let middle = at.transform_point3(0.5 * (low + high));
            let near: Vec<usize> = (0..eyes.len()).filter(|&i| eyes[i].distance(middle) < reach).collect();
            if near.is_empty() {
                continue;
            }
            let places: Vec<Vec3> = level.vertices.iter().map(|v| at.transform_point3(v.position.into())).collect();
            for triangle in level.indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|i| places[triangle[i] as usize]);
                let low = corners[0].min(corners[1]).min(corners[2]) - 1.0;
                let high = corners[0].max(corners[1]).max(corners[2]) + 1.0;
                for &i in &near {
                    let eye = eyes[i];
                    if eye.cmpge(low).all() && eye.cmple(high).all() {
                        let away = distance(eye, corners);
                        if away < nearest {
                            (nearest, when) = (away, span_s * i as f64 / f64::from(samples));
                        }
                    }
                }
            }
        }
        // Farther away than a metre was not looked for.
        println!("{}: at least {:.2} m free (after {when:.1} s)", info().id, nearest.min(1.0));
        assert!(nearest > FREE_M, "{}: {nearest:.2} m after {when:.1} s", info().id);
    }
}
