//! Primitives as meshes.

use super::error::fail;
use super::limits::MOST_DISTANCE;
use super::material::uv_set;
use super::read::File;
use super::{Result, element};
use crate::scene::{Mesh, Vertex};
use glam::{Vec2, Vec3, Vec4};
use gltf::Semantic;
use gltf::mesh::Mode;

/// A primitive; `None` for points and lines, which have no surface to show.
pub(super) fn load(
    file: &File,
    mesh: &gltf::Mesh<'_>,
    primitive: &gltf::Primitive<'_>,
    default_material: usize,
) -> Result<Option<Mesh>> {
    let what = format!("{}, primitive {}", element("mesh", mesh.index(), mesh.name()), primitive.index());
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(None);
    }
    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        return fail(&file.path, &what, "it has no POSITION attribute");
    };
    let positions = file.floats::<3>(&accessor, &format!("{what}, POSITION"))?;
    let count = positions.len();
    let normals = attribute::<3>(file, primitive, &Semantic::Normals, count, &what)?;
    let tangents = attribute::<4>(file, primitive, &Semantic::Tangents, count, &what)?;
    let uv_semantic = Semantic::TexCoords(uv_set(&primitive.material()));
    let uvs = attribute::<2>(file, primitive, &uv_semantic, count, &what)?;
    let is_far = |p: &[f32; 3]| p.iter().any(|v| v.is_nan() || v.abs() > MOST_DISTANCE);
    if let Some(i) = positions.iter().position(is_far) {
        let reason = if positions[i].iter().all(|v| v.is_finite()) {
            format!("vertex {i} lies at {:?}, expected at most {MOST_DISTANCE:e}", positions[i])
        } else {
            format!("the position of vertex {i} is not finite")
        };
        return fail(&file.path, &what, reason);
    }

    let indices = match primitive.indices() {
        Some(accessor) => file.indices(&accessor, &format!("{what}, indices"))?,
        None => (0..count as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|&&i| i as usize >= count) {
        return fail(&file.path, &what, format!("index {index} is out of range, it has {count} vertices"));
    }

    let mut triangles = triangles(primitive.mode(), &indices);
    let used = compacted(&mut triangles, count);
    file.budget.vertices(used.len().max(3 * triangles.len()), &file.path, &what)?;
    let vertex = |i: usize| Vertex {
        position: positions[i].into(),
        normal: normals.as_ref().map_or(Vec3::Y, |n| sane(Vec3::from(n[i])).normalize_or(Vec3::Y)),
        uv: uvs.as_ref().map_or(Vec2::ZERO, |uv| Vec2::from(uv[i].map(sane_number))),
        tangent: tangents.as_ref().map_or(Vec4::X, |t| Vec4::from(t[i].map(sane_number))),
    };
    let mut mesh = Mesh {
        name: mesh.name().unwrap_or_default().to_owned(),
        vertices: used.into_iter().map(vertex).collect(),
        triangles,
        material: primitive.material().index().unwrap_or(default_material),
    };
    if mesh.triangles.is_empty() {
        return Ok(None);
    }
    if normals.is_none() {
        // As the format asks for.
        mesh.make_flat();
    }
    if normals.is_none() || tangents.is_none() {
        mesh.make_tangents();
    }
    Ok(Some(mesh))
}

fn attribute<const N: usize>(
    file: &File,
    primitive: &gltf::Primitive<'_>,
    semantic: &Semantic,
    count: usize,
    what: &str,
) -> Result<Option<Vec<[f32; N]>>> {
    let Some(accessor) = primitive.get(semantic) else {
        return Ok(None);
    };
    let what = format!("{what}, {}", semantic.to_string());
    let values = file.floats::<N>(&accessor, &what)?;
    if values.len() == count {
        return Ok(Some(values));
    }
    fail(&file.path, &what, format!("has {} values for {count} vertices", values.len()))
}

fn sane(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}

/// Far values in textures and frames of reference are as good as none.
fn sane_number(v: f32) -> f32 {
    if v.abs() <= MOST_DISTANCE { v } else { 0.0 }
}

/// The vertices to keep: all, unless most belong to other primitives, as where these share one large array.
fn compacted(triangles: &mut [[u32; 3]], count: usize) -> Vec<usize> {
    if count <= 3 * triangles.len() {
        return (0..count).collect();
    }
    let mut used: Vec<usize> = triangles.iter().flatten().map(|&i| i as usize).collect();
    used.sort_unstable();
    used.dedup();
    for index in triangles.iter_mut().flatten() {
        // Every one is in the list.
        *index = used.partition_point(|&kept| kept < *index as usize) as u32;
    }
    used
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let windows = || indices.windows(3).enumerate();
    match mode {
        Mode::TriangleStrip => {
            windows().map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] }).collect()
        }
        Mode::TriangleFan => windows().map(|(i, _)| [indices[0], indices[i + 1], indices[i + 2]]).collect(),
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
