//! Triangles: vertices, meshes at several levels of detail, and which level is drawn at a distance.

use glam::{Vec2, Vec3};

/// A corner of triangles.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Vertex {
    /// Metres, in the mesh's own space.
    pub(crate) position: [f32; 3],
    /// Unit vector outwards.
    pub(crate) normal: [f32; 3],
    /// Unit vector in which `uv.x` grows; in the fourth number the sign of the direction in which `uv.y` grows, times the
    /// share of the surroundings that is seen from here (1 where nothing is in the way).
    pub(crate) tangent: [f32; 4],
    /// Coordinates on maps, which repeat; y downwards.
    pub(crate) uv: [f32; 2],
}

impl Vertex {
    /// A vertex whose tangent lies in the surface, in whatever direction.
    pub(crate) fn new(position: Vec3, normal: Vec3, uv: Vec2) -> Self {
        let tangent = normal.any_orthonormal_vector();
        Self { position: position.into(), normal: normal.into(), tangent: tangent.extend(1.0).into(), uv: uv.into() }
    }
}

/// One level of detail.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MeshLevel {
    pub(crate) vertices: Vec<Vertex>,
    /// Three for each triangle, counter-clockwise from outside.
    pub(crate) indices: Vec<u32>,
}

impl MeshLevel {
    pub(crate) fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Adds everything of `other`.
    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        self.indices.extend(other.indices.iter().map(|index| index + first));
    }

    /// The same, moved by `by`.
    #[must_use]
    pub(crate) fn transformed(mut self, by: glam::Affine3A) -> Self {
        let normals = glam::Mat3::from(by.matrix3).inverse().transpose();
        for vertex in &mut self.vertices {
            vertex.position = by.transform_point3(Vec3::from(vertex.position)).into();
            vertex.normal = (normals * Vec3::from(vertex.normal)).normalize_or_zero().into();
            let [x, y, z, sign] = vertex.tangent;
            vertex.tangent = by.transform_vector3(Vec3::new(x, y, z)).normalize_or_zero().extend(sign).into();
        }
        if by.matrix3.determinant() < 0.0 {
            self.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
        }
        self
    }

    /// Adds a quadrilateral `a b c d`, counter-clockwise from outside, whose map runs from `a` to `c`.
    pub(crate) fn quad(&mut self, [a, b, c, d]: [Vec3; 4], uv: [Vec2; 2]) {
        let normal = (b - a).cross(d - a).normalize_or_zero();
        let tangent = (b - a).normalize_or_zero().extend(1.0).into();
        let [low, high] = uv;
        let corners = [(a, low), (b, Vec2::new(high.x, low.y)), (c, high), (d, Vec2::new(low.x, high.y))];
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners.map(|(at, uv)| Vertex { tangent, ..Vertex::new(at, normal, uv) }));
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
    }
}

/// A surface at one or more levels of detail.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mesh {
    /// Finest first.
    pub(crate) levels: Vec<MeshLevel>,
}

impl From<MeshLevel> for Mesh {
    fn from(level: MeshLevel) -> Self {
        Self { levels: vec![level] }
    }
}

impl Mesh {
    /// Lowest and highest corner of the finest level; nothing without vertices.
    pub(crate) fn bounds(&self) -> Option<[Vec3; 2]> {
        let places =
            || self.levels.first().into_iter().flat_map(|level| &level.vertices).map(|v| Vec3::from(v.position));
        let first = places().next()?;
        Some(places().fold([first; 2], |[low, high], at| [low.min(at), high.max(at)]))
    }

    /// The level whose number of triangles is nearest to `triangles`, by ratio.
    pub(crate) fn level_of(&self, triangles: f64) -> usize {
        let away = |level: &MeshLevel| (level.triangles().max(1) as f64 / triangles.max(1.0)).ln().abs();
        let nearest = self.levels.iter().enumerate().min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)));
        nearest.map_or(0, |(index, _)| index)
    }
}

/// How many triangles an object is drawn with: a straight line in the squared distance between its centre and the camera
/// (Guenter et al. 2012, §6, "Geometric Complexity").
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Detail {
    /// Distance up to which it has most triangles, metres.
    pub(crate) near_m: f64,
    /// Distance from which on it has fewest.
    pub(crate) far_m: f64,
    /// Triangles when near.
    pub(crate) most: f64,
    /// Triangles when far.
    pub(crate) fewest: f64,
}

impl Detail {
    /// Triangles at `distance_m`, of which a layer takes the share `share`; never fewer than the fewest.
    pub(crate) fn triangles(&self, distance_m: f64, share: f64) -> f64 {
        let [near, far] = [self.near_m, self.far_m].map(|m| m * m);
        let along = ((distance_m * distance_m - near) / (far - near).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (share * (self.most + along * (self.fewest - self.most))).max(self.fewest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guenter 2012, §6: linear in the squared distance, 20,000 triangles at most, 8,000 in the outer layer.
    #[test]
    fn triangles_fall_linearly_with_squared_distance() {
        let detail = Detail { near_m: 2.0, far_m: 10.0, most: 20_000.0, fewest: 200.0 };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
        close(detail.triangles(1.0, 1.0), 20_000.0);
        close(detail.triangles(0.0, 0.4), 8_000.0);
        close(detail.triangles(52.0_f64.sqrt(), 1.0), 10_100.0);
        close(detail.triangles(50.0, 1.0), 200.0);
        close(detail.triangles(50.0, 0.1), 200.0);
    }

    #[test]
    fn a_mirrored_mesh_still_faces_outwards() {
        let mut level = MeshLevel::default();
        level.quad([Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], [Vec2::ZERO, Vec2::ONE]);
        for scale in [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0), Vec3::new(2.0, 3.0, -0.5)] {
            let moved = level.clone().transformed(glam::Affine3A::from_scale(scale));
            let corner = |i: usize| Vec3::from(moved.vertices[moved.indices[i] as usize].position);
            let facing = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalize();
            assert!(facing.dot(Vec3::from(moved.vertices[0].normal)) > 0.999, "{scale}");
        }
    }
}
