//! Where a file's parts come from: itself, data URIs and files in its folder.

use super::error::{LoadError, MOST_REASON_LETTERS, fail};
use super::limits::{Budget, MOST_FILE_BYTES, MOST_JSON_OBJECTS, MOST_JSON_VALUES, MOST_SOURCE_BYTES};
use super::{MOST_NAME_LETTERS, Result, element};
use crate::input_file::{self, Folder, InputFileError, printable};
use std::path::{Path, PathBuf};

/// The bytes of a `.gltf` or `.glb` file.
pub(super) fn read_whole(path: &Path, budget: &Budget) -> Result<Vec<u8>> {
    let bytes = input_file::read(path, MOST_FILE_BYTES)
        .map_err(|source| LoadError::Read { path: path.to_owned(), source })?;
    budget.take_source_bytes(bytes.len());
    Ok(bytes)
}

/// Parses, and refuses what the parser would stumble over or multiply in memory.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<gltf::Gltf> {
    let syntax = |reason: String| LoadError::Syntax {
        path: path.to_owned(),
        reason: printable(&reason, MOST_REASON_LETTERS).into_owned(),
    };
    if bytes.starts_with(b"glTF") && bytes.get(8..12).is_none_or(|length| number(length) < 12) {
        return Err(syntax("its header is shorter than 12 bytes".to_owned()));
    }
    check_json_size(json_chunk(bytes)).map_err(syntax)?;
    let parsed =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(|error| syntax(error.to_string()))?;
    let json = parsed.document.into_json();
    check_positions(path, &json)?;
    let document = gltf::Document::from_json(json).map_err(|error| match error {
        gltf::Error::Validation(problems) => {
            let first = problems.first().map(|(at, what)| format!("{at}: {what}"));
            syntax(first.unwrap_or_default())
        }
        other => syntax(other.to_string()),
    })?;
    let parsed = gltf::Gltf { document, blob: parsed.blob };
    check_choices(path, &parsed.document)?;
    Ok(parsed)
}

fn number(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |value, &b| value << 8 | usize::from(b))
}

/// The JSON of a file, as far as it is there.
fn json_chunk(bytes: &[u8]) -> &[u8] {
    if !bytes.starts_with(b"glTF") {
        return bytes;
    }
    let (length, rest) = (bytes.get(12..16).map_or(0, number), bytes.get(20..).unwrap_or_default());
    &rest[..length.min(rest.len())]
}

fn check_json_size(json: &[u8]) -> std::result::Result<(), String> {
    // Some of them stand in names, which does not matter at these numbers; base64 has none.
    let count = |wanted: &[u8]| json.iter().filter(|byte| wanted.contains(byte)).count();
    let (objects, values) = (count(b"{"), count(b",[{"));
    if objects > MOST_JSON_OBJECTS {
        return Err(format!("has {objects} objects, expected at most {MOST_JSON_OBJECTS}"));
    }
    if values > MOST_JSON_VALUES {
        return Err(format!("has {values} values, expected at most {MOST_JSON_VALUES}"));
    }
    Ok(())
}

/// Accessors that the gltf crate looks at while it checks whether there are any: it panics where not.
fn check_positions(path: &Path, json: &gltf::json::Root) -> Result<()> {
    for (m, mesh) in json.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let accessors = json.accessors.len();
            let beyond = primitive.attributes.values().find(|index| index.value() >= accessors);
            if let Some(index) = beyond {
                let what = format!("{}, primitive {p}", element("mesh", m, mesh.name.as_deref()));
                return fail(path, &what, format!("uses accessor {index}, the file has {accessors}"));
            }
        }
    }
    Ok(())
}

/// Alternatives that the gltf crate takes for decided: it panics where the one it expects is missing.
fn check_choices(path: &Path, document: &gltf::Document) -> Result<()> {
    let json = document.as_json();
    for (i, camera) in json.cameras.iter().enumerate() {
        let wanted = match &camera.type_ {
            gltf::json::validation::Checked::Valid(gltf::json::camera::Type::Perspective) => {
                camera.perspective.is_none().then_some("perspective")
            }
            _ => camera.orthographic.is_none().then_some("orthographic"),
        };
        if let Some(wanted) = wanted {
            let what = element("camera", i, camera.name.as_deref());
            return fail(path, &what, format!("is of the type {wanted} but has no `{wanted}`"));
        }
    }
    for (i, image) in json.images.iter().enumerate() {
        let problem = match (&image.buffer_view, &image.uri, &image.mime_type) {
            (None, None, _) => "has neither `uri` nor `bufferView`, expected one",
            (Some(_), _, None) => "has a `bufferView` but no `mimeType`, expected image/png or image/jpeg",
            _ => continue,
        };
        return fail(path, &element("image", i, image.name.as_deref()), problem);
    }
    check_channels(path, json)
}

/// The gltf crate does not check where an animation's channels lead.
fn check_channels(path: &Path, json: &gltf::json::Root) -> Result<()> {
    use gltf::json::validation::Checked;
    for (a, animation) in json.animations.iter().enumerate() {
        for (i, channel) in animation.channels.iter().enumerate() {
            let what = || format!("{}, channel {i}", element("animation", a, animation.name.as_deref()));
            let (node, nodes) = (channel.target.node.value(), json.nodes.len());
            if node >= nodes {
                return fail(path, &what(), format!("moves node {node}, the file has {nodes}"));
            }
            if matches!(channel.target.path, Checked::Invalid) {
                let reason = "its `path` is unknown, expected translation, rotation, scale or weights";
                return fail(path, &what(), reason);
            }
        }
    }
    Ok(())
}

/// What a URI stands for: data in itself, or a file in the folder of the file at `path`.
pub(super) fn fetch(path: &Path, budget: &Budget, uri: &str, what: &str) -> Result<Vec<u8>> {
    let left = budget.source_bytes_left();
    let bytes = match uri.strip_prefix("data:") {
        Some(data) => from_data(data).or_else(|error| fail(path, what, format!("bad data URI: {error}")))?,
        None => from_file(path, uri, left).or_else(|error| fail(path, what, error))?,
    };
    if bytes.len() as u64 > left {
        return fail(path, what, format!("with it the file's data is more than {MOST_SOURCE_BYTES} bytes"));
    }
    budget.take_source_bytes(bytes.len());
    Ok(bytes)
}

fn from_data(data: &str) -> std::result::Result<Vec<u8>, String> {
    let (kind, data) = data.split_once(',').ok_or("it has no comma before its data")?;
    if !kind.ends_with(";base64") {
        return Err("it is not base64".to_owned());
    }
    base64::decode(data).map_err(|error| error.to_string())
}

fn from_file(path: &Path, uri: &str, left: u64) -> std::result::Result<Vec<u8>, String> {
    if let Some(scheme) = scheme(uri) {
        return Err(format!(
            "cannot read {}: its scheme is {scheme}, expected a relative path or data",
            printable(uri, MOST_NAME_LETTERS)
        ));
    }
    let relative = percent_decoded(uri);
    let read = || -> std::result::Result<Vec<u8>, InputFileError> {
        input_file::read(&Folder::of(path)?.resolve(&relative)?, MOST_FILE_BYTES.min(left))
    };
    read().map_err(|error| {
        format!("cannot read {}: {error}", printable(&relative.to_string_lossy(), MOST_NAME_LETTERS))
    })
}

/// `http` of `http://example.com`; a file's name may hold a colon, but not before two slashes.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_once(':')?;
    let is_name = scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    (is_name && (rest.starts_with("//") || scheme.eq_ignore_ascii_case("file"))).then_some(scheme)
}

fn percent_decoded(uri: &str) -> PathBuf {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let hex = tail.get(..2).filter(|hex| hex.iter().all(u8::is_ascii_hexdigit));
        let hex = hex.and_then(|h| std::str::from_utf8(h).ok()).filter(|_| first == b'%');
        match hex.and_then(|h| u8::from_str_radix(h, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned().into()
}
