//! A file's buffers and accessors, every range checked.

use super::error::fail;
use super::limits::Budget;
use super::{Result, element, source};
use gltf::accessor::{DataType, Dimensions};
use std::path::{Path, PathBuf};

/// A parsed file and its buffers.
pub(super) struct File {
    pub path: PathBuf,
    pub document: gltf::Document,
    buffers: Vec<Vec<u8>>,
    pub budget: Budget,
}

impl File {
    pub fn open(path: &Path) -> Result<Self> {
        let budget = Budget::new();
        let whole = source::read_whole(path, &budget)?;
        let parsed = source::parse(path, &whole)?;
        drop(whole);
        let document = parsed.document;
        let mut file = Self { path: path.to_owned(), document, buffers: Vec::new(), budget };
        let mut blob = parsed.blob;
        let mut buffers = Vec::new();
        for buffer in file.document.buffers() {
            let what = element("buffer", buffer.index(), buffer.name());
            let bytes = match buffer.source() {
                gltf::buffer::Source::Uri(uri) => file.fetch(uri, &what)?,
                gltf::buffer::Source::Bin => match blob.take() {
                    Some(blob) => blob,
                    None => return fail(path, &what, "the file has no binary chunk"),
                },
            };
            if bytes.len() < buffer.length() {
                let reason =
                    format!("has {} bytes, {} are declared (truncated?)", bytes.len(), buffer.length());
                return fail(path, &what, reason);
            }
            buffers.push(bytes);
        }
        file.buffers = buffers;
        Ok(file)
    }

    /// What a URI stands for: data in itself or a file in this one's folder.
    pub fn fetch(&self, uri: &str, what: &str) -> Result<Vec<u8>> {
        source::fetch(&self.path, &self.budget, uri, what)
    }

    pub fn view_bytes(&self, view: &gltf::buffer::View<'_>, what: &str) -> Result<&[u8]> {
        let buffer = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        match end.and_then(|end| buffer.get(view.offset()..end)) {
            Some(bytes) => Ok(bytes),
            None => {
                let reason = format!(
                    "buffer view {} ends past the {} bytes of its buffer",
                    view.index(),
                    buffer.len()
                );
                fail(&self.path, what, reason)
            }
        }
    }

    /// The elements of an accessor as floats, normalised integers scaled to 0 to 1 or -1 to 1.
    pub fn floats<const N: usize>(&self, accessor: &gltf::Accessor<'_>, what: &str) -> Result<Vec<[f32; N]>> {
        if accessor.dimensions().multiplicity() != N || is_matrix(accessor.dimensions()) {
            let reason =
                format!("{} has {:?} elements, expected {N} numbers", label(accessor), accessor.dimensions());
            return fail(&self.path, what, reason);
        }
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        self.elements(accessor, what, |bytes| {
            let mut chunks = bytes.chunks_exact(kind.size());
            [(); N].map(|()| chunks.next().map_or(0.0, |b| number(kind, normalized, b)))
        })
    }

    /// The elements of an index accessor.
    pub fn indices(&self, accessor: &gltf::Accessor<'_>, what: &str) -> Result<Vec<u32>> {
        let kind = accessor.data_type();
        if accessor.dimensions() != Dimensions::Scalar
            || !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32)
        {
            let reason = format!("{} is no list of unsigned integers", label(accessor));
            return fail(&self.path, what, reason);
        }
        self.elements(accessor, what, unsigned)
    }

    fn elements<T: Clone>(
        &self,
        accessor: &gltf::Accessor<'_>,
        what: &str,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let (size, count) = (accessor.size(), accessor.count());
        self.budget.elements(count, &self.path, what)?;
        let zero = vec![0; size];
        let mut elements = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(size);
                let bytes = self.view_bytes(&view, what)?;
                let elements = strided(bytes, accessor.offset(), stride, size, count);
                match elements {
                    Some(elements) => elements.map(&convert).collect(),
                    None => return self.too_long(accessor, count, what),
                }
            }
            // Without a view all is zero. Whatever else there is of as many elements has a byte for each.
            None if accessor.sparse().is_some() => match self.buffers.iter().map(Vec::len).sum() {
                bytes if count > bytes => {
                    let reason = format!("{} has {count} elements, the file {bytes} bytes", label(accessor));
                    return fail(&self.path, what, reason);
                }
                _ => vec![convert(&zero); count],
            },
            None => return fail(&self.path, what, format!("{} has no buffer view", label(accessor))),
        };
        if let Some(sparse) = accessor.sparse() {
            let places = sparse.indices();
            let place_size = places.index_type().size();
            let place_bytes = self.view_bytes(&places.view(), what)?;
            let values = sparse.values();
            let value_bytes = self.view_bytes(&values.view(), what)?;
            let places = strided(place_bytes, places.offset(), place_size, place_size, sparse.count());
            let values = strided(value_bytes, values.offset(), size, size, sparse.count());
            let (Some(places), Some(values)) = (places, values) else {
                return self.too_long(accessor, sparse.count(), what);
            };
            for (place, value) in places.zip(values) {
                match elements.get_mut(unsigned(place) as usize) {
                    Some(element) => *element = convert(value),
                    None => {
                        return fail(
                            &self.path,
                            what,
                            format!("{}: sparse index out of range", label(accessor)),
                        );
                    }
                }
            }
        }
        Ok(elements)
    }

    fn too_long<T>(&self, accessor: &gltf::Accessor<'_>, count: usize, what: &str) -> Result<T> {
        fail(&self.path, what, format!("{}: {count} elements do not fit its buffer view", label(accessor)))
    }
}

fn label(accessor: &gltf::Accessor<'_>) -> String {
    element("accessor", accessor.index(), accessor.name())
}

fn is_matrix(dimensions: Dimensions) -> bool {
    matches!(dimensions, Dimensions::Mat2 | Dimensions::Mat3 | Dimensions::Mat4)
}

/// `count` runs of `size` bytes, `None` where they do not fit.
fn strided(
    bytes: &[u8],
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
) -> Option<impl Iterator<Item = &[u8]>> {
    let last = count.saturating_sub(1).checked_mul(stride)?.checked_add(offset)?;
    let end = last.checked_add(if count > 0 { size } else { 0 })?;
    (end <= bytes.len()).then(|| (0..count).map(move |i| &bytes[offset + i * stride..][..size]))
}

fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &b| value << 8 | u32::from(b))
}

fn number(kind: DataType, normalized: bool, bytes: &[u8]) -> f32 {
    let (value, largest) = match (kind, bytes) {
        (DataType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        (DataType::I8, &[a]) => (f32::from(a as i8), 127.0),
        (DataType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (DataType::U8, _) => (unsigned(bytes) as f32, 255.0),
        (DataType::U16, _) => (unsigned(bytes) as f32, 65535.0),
        _ => (unsigned(bytes) as f32, 4_294_967_295.0),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
