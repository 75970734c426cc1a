//! How much a file may ask for. Beyond what is shown, or held in memory, it is a mistake or an attack.

use super::Result;
use super::error::fail;
use std::cell::Cell;
use std::path::Path;

/// Triangles on screen, each instance counted: what the path tracer's 24-bit indices tell apart.
pub(super) const MOST_TRIANGLES: usize = 1 << 24;
/// Vertices, in meshes and once more where these are placed: three of its own for each triangle.
pub(super) const MOST_VERTICES: usize = 3 * MOST_TRIANGLES;
/// Elements read from accessors: four attributes and an index for each of these vertices.
const MOST_ELEMENTS: usize = 5 * MOST_VERTICES;
/// Largest coordinate: up to here the square of a triangle's area is finite in 32 bits.
pub(super) const MOST_DISTANCE: f32 = 1e9;
/// Largest light intensity or emitted radiance, so that sums over lights stay finite in 32 bits.
pub(super) const MOST_LIGHT: f32 = 1e15;
/// Bytes of one file: 16 million triangles with their own vertices come to this.
pub(super) const MOST_FILE_BYTES: u64 = 3 << 30;
/// Bytes of all files and data URIs together.
pub(super) const MOST_SOURCE_BYTES: u64 = 6 << 30;
/// JSON objects in a file, which take up to a kilobyte each once parsed.
pub(super) const MOST_JSON_OBJECTS: usize = 1 << 20;
/// Commas and brackets in the JSON text; extensions keep a value of 32 bytes for each.
pub(super) const MOST_JSON_VALUES: usize = 1 << 24;
/// Longest side of an image: what every WebGPU device can hold in a texture.
pub(super) const MOST_IMAGE_SIDE: u32 = 8192;
/// Bytes of all decoded images: a hundred and more of 4096 x 4096.
const MOST_IMAGE_BYTES: u64 = 8 << 30;
/// Bytes that a byte of an image file can decode to: a little more than deflate's 1032. (A JPEG's flat blocks come to 1024.)
pub(super) const MOST_IMAGE_EXPANSION: u64 = 1100;

/// What a file has used of what it may.
pub(super) struct Budget {
    elements: Cell<usize>,
    vertices: Cell<usize>,
    image_bytes: Cell<u64>,
    source_bytes: Cell<u64>,
}

impl Budget {
    pub fn new() -> Self {
        Self {
            elements: Cell::new(MOST_ELEMENTS),
            vertices: Cell::new(MOST_VERTICES),
            image_bytes: Cell::new(MOST_IMAGE_BYTES),
            source_bytes: Cell::new(MOST_SOURCE_BYTES),
        }
    }

    pub fn elements(&self, count: usize, path: &Path, what: &str) -> Result<()> {
        if let Some(left) = self.elements.get().checked_sub(count) {
            self.elements.set(left);
            return Ok(());
        }
        let reason =
            format!("with it more than {MOST_ELEMENTS} elements would be read from the file's accessors");
        fail(path, what, reason)
    }

    pub fn vertices(&self, count: usize, path: &Path, what: &str) -> Result<()> {
        if let Some(left) = self.vertices.get().checked_sub(count) {
            self.vertices.set(left);
            return Ok(());
        }
        fail(
            path,
            what,
            format!("with its {count} the file's meshes have more than {MOST_VERTICES} vertices"),
        )
    }

    pub fn image_bytes(&self, count: u64, path: &Path, what: &str) -> Result<()> {
        if let Some(left) = self.image_bytes.get().checked_sub(count) {
            self.image_bytes.set(left);
            return Ok(());
        }
        fail(
            path,
            what,
            format!("with its {count} bytes the file's images take more than {MOST_IMAGE_BYTES}"),
        )
    }

    /// Bytes that may still come from files.
    pub fn source_bytes_left(&self) -> u64 {
        self.source_bytes.get()
    }

    pub fn take_source_bytes(&self, count: usize) {
        self.source_bytes.set(self.source_bytes.get().saturating_sub(count as u64));
    }
}
