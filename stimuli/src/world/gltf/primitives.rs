//! A primitive's vertices and triangles: lists, strips and fans; normals and tangents that a file leaves out.

use super::accessors::{Accessors, Allowed, Component, FLOATS};
use super::document::{self, Document};
use super::errors::Findings;
use super::materials::Surface;
use crate::world::{MeshLevel, Vertex};
use glam::{Vec2, Vec3, Vec4};

/// How far from its origin a vertex may lie, metres: beyond, squares of lengths would leave the range of floats.
const MOST_METRES: f32 = 1e9;

const SMALL: fn(Component) -> bool = |c| matches!(c, Component::I8 | Component::U8 | Component::I16 | Component::U16);

/// What attributes may be made of (glTF 2.0, §3.7.2.1; the second of each pair with KHR_mesh_quantization).
const POSITIONS: [Allowed; 2] = [
    FLOATS,
    Allowed { components: |c, _| c == Component::F32 || SMALL(c), said: "floats or whole numbers of 8 or 16 bits" },
];
const DIRECTIONS: [Allowed; 2] = [
    FLOATS,
    Allowed {
        components: |c, normalised| c == Component::F32 || (normalised && matches!(c, Component::I8 | Component::I16)),
        said: "floats or normalised signed numbers of 8 or 16 bits",
    },
];
const COORDINATES: [Allowed; 2] = [
    Allowed {
        components: |c, normalised| c == Component::F32 || (normalised && matches!(c, Component::U8 | Component::U16)),
        said: "floats or normalised unsigned numbers of 8 or 16 bits",
    },
    Allowed { components: |c, _| c == Component::F32 || SMALL(c), said: "floats or whole numbers of 8 or 16 bits" },
];

/// The triangles of the primitive at `place`; nothing where it has none or is wrong.
pub(crate) fn level(
    primitive: &document::Primitive,
    surface: &Surface,
    place: &str,
    document: &Document,
    accessors: &Accessors<'_>,
    findings: &mut Findings,
) -> Option<MeshLevel> {
    let mode = primitive.mode.unwrap_or(4);
    match mode {
        4..=6 => {}
        0..=3 => {
            findings.note(place, "points and lines are left out");
            return None;
        }
        _ => {
            findings.wrong(format!("{place}.mode"), format!("there is no mode {mode}; 4, 5 and 6 are triangles"));
            return None;
        }
    }
    if primitive.targets.is_some() {
        findings.note(place, "morph targets are left out, the unmorphed shape is shown");
    }
    if primitive.attributes.contains_key("COLOR_0") {
        findings.note(place, "colours of vertices are left out");
    }
    for name in primitive.extensions.keys() {
        findings.note(place, format!("{} is left out", super::accessors::shown(name)));
    }
    let Some(&positions) = primitive.attributes.get("POSITION") else {
        findings.note(place, "it has no positions and is left out");
        return None;
    };

    let at = |name: &str| format!("{place}.attributes.{name}");
    let quantised = usize::from(document.uses("KHR_mesh_quantization"));
    let positions = accessors.read::<3>(positions, "VEC3", POSITIONS[quantised], &at("POSITION"), findings)?;
    if let Some(far) = positions.iter().position(|p| p.iter().any(|x| x.abs() > MOST_METRES)) {
        let message = format!("item {far} is {:?}; expected at most {MOST_METRES} metres", positions[far]);
        findings.wrong(at("POSITION"), message);
        return None;
    }
    let count = positions.len();
    let same_count = |name: &str, found: usize, findings: &mut Findings| {
        if found != count {
            findings.wrong(at(name), format!("it has {found} items, POSITION has {count}; expected the same"));
        }
        found == count
    };
    let mut normals = None;
    if let Some(&index) = primitive.attributes.get("NORMAL") {
        let read = accessors.read::<3>(index, "VEC3", DIRECTIONS[quantised], &at("NORMAL"), findings)?;
        normals = same_count("NORMAL", read.len(), findings).then_some(read);
    }
    let mut tangents = None;
    if let Some(&index) = primitive.attributes.get("TANGENT").filter(|_| normals.is_some()) {
        let read = accessors.read::<4>(index, "VEC4", DIRECTIONS[quantised], &at("TANGENT"), findings)?;
        tangents = same_count("TANGENT", read.len(), findings).then_some(read);
    }
    let mut coordinates = None;
    if let Some(set) = surface.uv_set {
        let name = format!("TEXCOORD_{set}");
        match primitive.attributes.get(&name) {
            Some(&index) => {
                let read = accessors.read::<2>(index, "VEC2", COORDINATES[quantised], &at(&name), findings)?;
                coordinates = same_count(&name, read.len(), findings).then_some(read);
            }
            None => findings.note(place, "its material has maps, but it has no coordinates for them"),
        }
    }
    let order = match primitive.indices {
        Some(index) => accessors.read_indices(index, count, &format!("{place}.indices"), findings)?,
        None => (0..u32::try_from(count).ok()?).collect(),
    };
    let indices = triangles(mode, &order);
    if indices.is_empty() {
        findings.note(place, "it has no whole triangle and is left out");
        return None;
    }
    if !surface.repeats
        && coordinates.as_ref().is_some_and(|all| all.iter().flatten().any(|x| !(-0.01..=1.01).contains(x)))
    {
        findings.note(place, "its maps end at their borders in the file; here they repeat");
    }

    let vertex = |i: usize| {
        let uv = coordinates.as_ref().map_or(Vec2::ZERO, |all| surface.transformed(Vec2::from(all[i])));
        let normal = normals.as_ref().map_or(Vec3::ZERO, |all| unit(Vec3::from(all[i])).unwrap_or(Vec3::ZERO));
        let mut vertex = Vertex { normal: normal.into(), ..Vertex::new(positions[i].into(), Vec3::Y, uv) };
        vertex.tangent = tangents.as_ref().map_or([0.0; 4], |all| all[i]);
        vertex
    };
    let mut level = MeshLevel { vertices: (0..count).map(vertex).collect(), indices };
    if normals.is_none() {
        flatten(&mut level);
    } else if mend_normals(&mut level) {
        findings.note(at("NORMAL"), "normals of length zero are replaced by those of the triangles");
    }
    complete_tangents(&mut level, surface.material.normal_map.is_some() && coordinates.is_some());
    Some(level)
}

/// Corners of triangles out of a list (mode 4), strip (5) or fan (6) (glTF 2.0, §3.7.2.1); triangles that repeat a
/// corner are left out, and so is what is left over.
fn triangles(mode: u32, order: &[u32]) -> Vec<u32> {
    let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    let triangles: Vec<[u32; 3]> = match mode {
        5 => order
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        6 => order.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], order[0]]).collect(),
        _ => order.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    };
    triangles.into_iter().filter(whole).flatten().collect()
}

/// Gives every triangle corners of its own, with its own normal (glTF 2.0, §3.7.2.1: without normals, flat ones).
fn flatten(level: &mut MeshLevel) {
    level.vertices = level.indices.iter().map(|&i| level.vertices[i as usize]).collect();
    level.indices = (0..level.vertices.len() as u32).collect();
    for triangle in level.vertices.chunks_exact_mut(3) {
        let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(triangle[i].position));
        let normal = facing([a, b, c]).unwrap_or(Vec3::Y);
        triangle.iter_mut().for_each(|vertex| vertex.normal = normal.into());
    }
}

/// A vector's direction, also where its squared length is too small or too large for a float.
fn unit(vector: Vec3) -> Option<Vec3> {
    let most = vector.abs().max_element();
    (most > f32::MIN_POSITIVE).then(|| vector / most).and_then(Vec3::try_normalize)
}

/// The direction in which a triangle faces; nothing where it has no area.
fn facing([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    unit(unit(b - a)?.cross(unit(c - a)?))
}

/// Replaces normals of length zero by the mean of their triangles', weighted by area; whether there were any.
fn mend_normals(level: &mut MeshLevel) -> bool {
    let missing = |vertex: &Vertex| vertex.normal == [0.0; 3];
    if !level.vertices.iter().any(missing) {
        return false;
    }
    let mut sums = vec![Vec3::ZERO; level.vertices.len()];
    for t in level.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(level.vertices[t[i] as usize].position));
        let area = (b - a).cross(c - a);
        t.iter().for_each(|&i| sums[i as usize] += area);
    }
    for (vertex, sum) in level.vertices.iter_mut().zip(sums).filter(|(vertex, _)| missing(vertex)) {
        vertex.normal = unit(sum).unwrap_or(Vec3::Y).into();
    }
    true
}

/// Makes every tangent a unit vector in the surface. Where a normal map needs them and the file has none, they follow the
/// map: the mean of the triangles' directions of growing u (Lengyel's method), with the sign of the direction in which
/// the picture's up lies, as glTF has it.
fn complete_tangents(level: &mut MeshLevel, needed: bool) {
    let missing = level.vertices.iter().any(|vertex| Vec4::from(vertex.tangent).truncate() == Vec3::ZERO);
    let mut across = vec![Vec3::ZERO; if needed && missing { level.vertices.len() } else { 0 }];
    let mut upwards = across.clone();
    if !across.is_empty() {
        for t in level.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| level.vertices[t[i] as usize]);
            let edge = |v: Vertex| Vec3::from(v.position) - Vec3::from(a.position);
            let step = |v: Vertex| Vec2::from(v.uv) - Vec2::from(a.uv);
            let (e1, e2, s1, s2) = (edge(b), edge(c), step(b), step(c));
            let turned = s1.perp_dot(s2);
            if turned == 0.0 {
                continue;
            }
            let along_u = (e1 * s2.y - e2 * s1.y) * turned.signum();
            let along_v = (e2 * s1.x - e1 * s2.x) * turned.signum();
            for &i in t {
                across[i as usize] += unit(along_u).unwrap_or(Vec3::ZERO);
                upwards[i as usize] -= unit(along_v).unwrap_or(Vec3::ZERO);
            }
        }
    }
    for (i, vertex) in level.vertices.iter_mut().enumerate() {
        let normal = Vec3::from(vertex.normal);
        let given = Vec4::from(vertex.tangent);
        let (direction, sign) = match across.get(i) {
            Some(&across) if given.truncate() == Vec3::ZERO => {
                (across, if normal.cross(across).dot(upwards[i]) < 0.0 { -1.0 } else { 1.0 })
            }
            _ => (given.truncate(), if given.w < 0.0 { -1.0 } else { 1.0 }),
        };
        let direction = unit(direction).unwrap_or(Vec3::ZERO);
        let tangent = direction - normal * direction.dot(normal);
        let tangent = (tangent.length_squared() > 1e-8).then(|| tangent.normalize());
        vertex.tangent = tangent.unwrap_or_else(|| normal.any_orthonormal_vector()).extend(sign).into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The order of corners as the specification writes it out.
    #[test]
    fn strips_and_fans_become_triangles() {
        assert_eq!(triangles(4, &[0, 1, 2, 3, 4, 5, 6]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(triangles(5, &[0, 1, 2, 3, 4]), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
        assert_eq!(triangles(6, &[0, 1, 2, 3]), [1, 2, 0, 2, 3, 0]);
        assert_eq!(triangles(5, &[0, 1, 2, 2, 3, 4]), [0, 1, 2, 2, 4, 3]);
        for mode in [4, 5, 6] {
            assert_eq!(triangles(mode, &[0, 1]), [0_u32; 0]);
            assert_eq!(triangles(mode, &[]), [0_u32; 0]);
        }
    }

    fn square(u: Vec2, v: Vec2) -> MeshLevel {
        let corner = |x: f32, y: f32| {
            let uv = x * u + y * v;
            Vertex { tangent: [0.0; 4], ..Vertex::new(Vec3::new(x, y, 0.0), Vec3::Z, uv) }
        };
        MeshLevel {
            vertices: vec![corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 1.)],
            indices: vec![0, 1, 2, 0, 2, 3],
        }
    }

    /// A square that faces +z, with maps laid on it in four ways: the tangent is where u grows, and normal × tangent ·
    /// sign points where the picture's up is (v falls).
    #[test]
    fn tangents_follow_the_map() {
        let cases = [
            (Vec2::X, Vec2::NEG_Y, Vec3::X, Vec3::Y),
            (Vec2::NEG_X, Vec2::NEG_Y, Vec3::NEG_X, Vec3::Y),
            (Vec2::X, Vec2::Y, Vec3::X, Vec3::NEG_Y),
            (Vec2::new(0.0, -3.0), Vec2::new(2.0, 0.0), Vec3::Y, Vec3::X),
        ];
        for (u, v, across, up) in cases {
            let mut level = square(u, v);
            complete_tangents(&mut level, true);
            for vertex in level.vertices {
                let [x, y, z, sign] = vertex.tangent;
                let tangent = Vec3::new(x, y, z);
                assert!(tangent.distance(across) < 1e-6, "{tangent} is not {across}");
                assert!((Vec3::Z.cross(tangent) * sign).distance(up) < 1e-6, "up is not {up}");
            }
        }
    }

    #[test]
    fn flat_normals_stand_on_their_triangles() {
        let mut level = square(Vec2::X, Vec2::Y);
        level.vertices[3].position = [0.0, 1.0, 1.0];
        flatten(&mut level);
        assert_eq!((level.vertices.len(), level.triangles()), (6, 2));
        assert_eq!(level.vertices[0].normal, [0.0, 0.0, 1.0]);
        // (1, 1, 0) × (0, 1, 1) = (1, −1, 1).
        let expected = Vec3::new(1.0, -1.0, 1.0).normalize();
        assert!(Vec3::from(level.vertices[4].normal).distance(expected) < 1e-6);
    }
}
