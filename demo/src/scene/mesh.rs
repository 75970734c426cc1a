//! Triangle meshes, what their vertices lack, and simple shapes.

use glam::{Affine3A, Vec2, Vec3, Vec4};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
    /// Direction of growing u; w is the sign of the bitangent `cross(normal, tangent) * w`.
    pub tangent: Vec4,
}

/// Triangles of one material. Counter-clockwise from the front.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    pub name: String,
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<[u32; 3]>,
    pub material: usize,
}

impl Mesh {
    /// Gives every corner its own vertex with the triangle's normal.
    pub fn make_flat(&mut self) {
        let corners = self.triangles.iter().flatten().map(|&i| self.vertices[i as usize]);
        self.vertices = corners.collect();
        self.triangles = (0..self.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        for corners in self.vertices.chunks_exact_mut(3) {
            let [a, b, c] = [corners[0].position, corners[1].position, corners[2].position];
            let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
            corners.iter_mut().for_each(|v| v.normal = normal);
        }
    }

    /// Tangents from positions and uv, averaged over the triangles at a vertex.
    pub fn make_tangents(&mut self) {
        let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|i| self.vertices[i as usize]);
            let (e1, e2) = (b.position - a.position, c.position - a.position);
            let (d1, d2) = (b.uv - a.uv, c.uv - a.uv);
            // The sign is all that matters of the determinant: the length weights a triangle by its area.
            let sign = d1.perp_dot(d2).signum();
            let (u, v) = ((e1 * d2.y - e2 * d1.y) * sign, (e2 * d1.x - e1 * d2.x) * sign);
            for &i in triangle {
                sums[i as usize].0 += u;
                sums[i as usize].1 += v;
            }
        }
        for (vertex, (u, v)) in self.vertices.iter_mut().zip(sums) {
            let n = vertex.normal;
            let across = (u - n * n.dot(u)).normalize_or(n.any_orthonormal_vector());
            // glTF's bitangent points to smaller v, as images grow downwards.
            let sign = if n.cross(across).dot(-v) < 0.0 { -1.0 } else { 1.0 };
            vertex.tangent = across.extend(sign);
        }
    }
}

/// Builds a mesh of one material from simple shapes.
#[derive(Debug, Clone)]
pub struct MeshBuilder {
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    /// Texture repeats per unit of length, for shapes that lay out uv by size.
    uv_scale: f32,
}

impl Default for MeshBuilder {
    fn default() -> Self {
        Self { vertices: Vec::new(), triangles: Vec::new(), uv_scale: 1.0 }
    }
}

impl MeshBuilder {
    pub fn new(uv_scale: f32) -> Self {
        Self { uv_scale, ..Default::default() }
    }

    pub fn build(self, name: &str, material: usize) -> Mesh {
        let Self { vertices, triangles, .. } = self;
        let mut mesh = Mesh { name: name.to_owned(), vertices, triangles, material };
        mesh.make_tangents();
        mesh
    }

    fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.vertices.push(Vertex { position, normal, uv, tangent: Vec4::X });
        self.vertices.len() as u32 - 1
    }

    /// Parallelogram from `corner` along `u` and `v`, facing `cross(u, v)`; uv 0 to 1 with v down along `-v`.
    pub fn picture(mut self, corner: Vec3, u: Vec3, v: Vec3) -> Self {
        self.parallelogram(corner, u, v, Vec2::ONE);
        self
    }

    /// As [`Self::picture`], with uv laid out by size.
    pub fn quad(mut self, corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let repeats = Vec2::new(u.length(), v.length()) * self.uv_scale;
        self.parallelogram(corner, u, v, repeats);
        self
    }

    fn parallelogram(&mut self, corner: Vec3, u: Vec3, v: Vec3, repeats: Vec2) {
        let normal = u.cross(v).normalize_or(Vec3::Y);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let [a, b, c, d] = corners
            .map(|(s, t)| self.vertex(corner + u * s + v * t, normal, Vec2::new(s, 1.0 - t) * repeats));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Axis-aligned box, facing outwards.
    pub fn cuboid(mut self, low: Vec3, high: Vec3) -> Self {
        let d = high - low;
        let (x, y, z) = (Vec3::X * d.x, Vec3::Y * d.y, Vec3::Z * d.z);
        self = self.quad(low + z, x, y).quad(high - y, -z, y).quad(low + x, -x, y);
        self.quad(low, z, y).quad(low + y + z, x, -z).quad(low, x, z)
    }

    /// Solid of revolution about +y through `base`. The profile is (radius, height) from the bottom up; normals
    /// are smooth within a run and sharp where a profile point is repeated.
    pub fn lathe(mut self, base: Vec3, profile: &[(f32, f32)], segments: u32) -> Self {
        let circumference =
            (std::f32::consts::TAU * profile.iter().map(|p| p.0).fold(0.0, f32::max) * self.uv_scale)
                .round()
                .max(1.0);
        let points: Vec<Vec2> = profile.iter().map(|&p| p.into()).collect();
        for (i, point) in points.iter().enumerate() {
            let edge = |a: usize, b: usize| (points[b] - points[a]).normalize_or_zero();
            let before = if i > 0 { edge(i - 1, i) } else { Vec2::ZERO };
            let after = if i + 1 < points.len() { edge(i, i + 1) } else { Vec2::ZERO };
            let along = (before + after).normalize_or(Vec2::Y);
            for s in 0..=segments {
                let turn = s as f32 / segments as f32;
                let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
                let around = Vec3::new(cos, 0.0, -sin);
                let normal = around * along.y - Vec3::Y * along.x;
                let uv = Vec2::new(turn * circumference, -point.y * self.uv_scale);
                self.vertex(base + around * point.x + Vec3::Y * point.y, normal, uv);
            }
        }
        let row = segments + 1;
        let first = self.vertices.len() as u32 - row * points.len() as u32;
        for i in 0..points.len() as u32 - 1 {
            if points[i as usize] == points[i as usize + 1] {
                continue;
            }
            for s in 0..segments {
                let [a, b] = [first + i * row + s, first + (i + 1) * row + s];
                self.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
        self
    }

    pub fn sphere(self, centre: Vec3, radius: f32, rings: u32) -> Self {
        let point = |i: u32| {
            let (sin, cos) = (std::f32::consts::PI * i as f32 / rings as f32).sin_cos();
            (radius * sin, -radius * cos)
        };
        let profile: Vec<_> = (0..=rings).map(point).collect();
        self.lathe(centre, &profile, 2 * rings)
    }

    /// Ring of `major` radius about +y through `centre`.
    pub fn torus(mut self, centre: Vec3, major: f32, minor: f32, segments: u32) -> Self {
        let sides = (segments / 3).max(8);
        let repeats = (major / minor).round();
        let first = self.vertices.len() as u32;
        for i in 0..=segments {
            for j in 0..=sides {
                let (s, t) = (i as f32 / segments as f32, j as f32 / sides as f32);
                let (sin, cos) = (s * std::f32::consts::TAU).sin_cos();
                let around = Vec3::new(cos, 0.0, -sin);
                let (sin, cos) = (t * std::f32::consts::TAU).sin_cos();
                let normal = around * cos + Vec3::Y * sin;
                let uv = Vec2::new(s * repeats, -t);
                self.vertex(centre + around * major + normal * minor, normal, uv);
            }
        }
        for i in 0..segments {
            for j in 0..sides {
                let [a, b] = [first + i * (sides + 1) + j, first + (i + 1) * (sides + 1) + j];
                self.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        self
    }

    /// Tube along a trefoil, a knot of three leaves about the y axis, 1 across.
    pub fn trefoil(self) -> Self {
        const POINTS: usize = 400;
        let point = |i: usize| {
            let t = i as f32 / POINTS as f32 * std::f32::consts::TAU;
            let around = 0.34 + 0.15 * (3.0 * t).cos();
            Vec3::new(around * (2.0 * t).cos(), 0.15 * (3.0 * t).sin(), around * (2.0 * t).sin())
        };
        let curve: Vec<Vec3> = (0..POINTS).map(point).collect();
        self.tube(&curve, 0.085, 24)
    }

    /// Round tube along a closed curve that is nowhere vertical.
    pub fn tube(mut self, curve: &[Vec3], radius: f32, sides: u32) -> Self {
        let count = curve.len();
        let first = self.vertices.len() as u32;
        for i in 0..=count {
            let [before, here, after] = [count + i - 1, i, i + 1].map(|k| curve[k % count]);
            let along = (after - before).normalize_or(Vec3::X);
            let across = Vec3::Y.cross(along).normalize_or(Vec3::X);
            let up = along.cross(across);
            for j in 0..=sides {
                let t = j as f32 / sides as f32;
                let (sin, cos) = (t * std::f32::consts::TAU).sin_cos();
                let normal = across * cos + up * sin;
                self.vertex(here + normal * radius, normal, Vec2::new(i as f32 / count as f32, t));
            }
        }
        for i in 0..count as u32 {
            for j in 0..sides {
                let [a, b] = [first + i * (sides + 1) + j, first + (i + 1) * (sides + 1) + j];
                self.triangles.extend([[a, b + 1, b], [a, a + 1, b + 1]]);
            }
        }
        self
    }

    /// Moves all that was built so far.
    pub fn transformed(mut self, transform: Affine3A) -> Self {
        let normal_from_object = transform.matrix3.inverse().transpose();
        for vertex in &mut self.vertices {
            vertex.position = transform.transform_point3(vertex.position);
            vertex.normal = (normal_from_object * vertex.normal).normalize_or(Vec3::Y);
        }
        self
    }
}
