//! Folders that hold a scene and a capture, what should not be read, and ways out.

use crate::seeds::{self, SECRET, SECRET_COLOR};
use image::ImageFormat;
use quell_demo::capture::CaptureReader;
use quell_demo::scene::{Scene, gltf};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// `inside/` holds the seeds (the capture from the start, a scene once written), and links and a pipe that lead out; `outside/` what must not be read.
#[derive(Debug, Clone)]
pub struct Place {
    pub inside: PathBuf,
    pub outside: PathBuf,
}

impl Place {
    pub fn new(root: &Path) -> Self {
        let (inside, outside) = (root.join("inside"), root.join("outside"));
        seeds::write_capture(&inside, 1.0);
        std::fs::create_dir(inside.join("folder.bin")).unwrap();
        seeds::write_capture(&outside, SECRET);
        let place = Self { inside, outside };
        std::fs::write(place.outside.join("tri.bin"), seeds::buffer(SECRET)).unwrap();
        std::fs::write(place.outside.join("image.png"), seeds::picture(ImageFormat::Png, SECRET_COLOR))
            .unwrap();
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            for name in ["tri.bin", "image.png", "frame_0000.exr"] {
                symlink(place.outside.join(name), place.inside.join(format!("link_{name}"))).unwrap();
            }
            symlink("../outside", place.inside.join("link")).unwrap();
            symlink("/dev/zero", place.inside.join("zero")).unwrap();
            symlink("loop", place.inside.join("loop")).unwrap();
            let pipe = std::process::Command::new("mkfifo").arg(place.inside.join("pipe")).status();
            assert!(pipe.unwrap().success(), "mkfifo makes the pipe");
        }
        place
    }

    /// Strings that name, or may name, something outside or something that is no file.
    pub fn hostile_paths(&self) -> Vec<String> {
        let mut paths: Vec<String> =
            ["pipe", "zero", "loop", "folder.bin", ".", "", "/dev/zero", "/dev/stdin", "/"]
                .into_iter()
                .map(String::from)
                .collect();
        for name in ["tri.bin", "image.png", "frame_0000.exr"] {
            let outside = self.outside.join(name);
            let outside = outside.display();
            paths.extend([
                format!("../outside/{name}"),
                format!("folder.bin/../../outside/{name}"),
                format!("..%2foutside%2F{name}"),
                format!("%2e%2e/outside/{name}"),
                format!("..\\outside\\{name}"),
                format!("./.././outside/./{name}"),
                format!("link_{name}"),
                format!("link/{name}"),
                format!("{outside}"),
                format!("file://{outside}"),
                format!("http://127.0.0.1:9/{name}"),
                format!("//{outside}"),
                format!("{name}\0.png"),
                format!("/proc/self/cwd/{name}"),
                name.to_owned(),
            ]);
        }
        paths.push("data:,".to_owned());
        paths.push("data:;base64,####".to_owned());
        paths.push(format!("data:;base64,{}", "A".repeat(1 << 16)));
        paths.push("a/".repeat(5000));
        paths.push("\u{202e}%00%ff%zz%".to_owned());
        paths
    }

    pub fn write_scene(&self, json: &Value, buffer: &[u8], picture: &[u8]) {
        self.write("scene.gltf", json.to_string().as_bytes());
        self.write("tri.bin", buffer);
        self.write("image.png", picture);
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.inside.join(name), bytes).unwrap();
    }
}

/// A place of its own for a test, removed at its end.
pub struct Temporary {
    pub place: Place,
    root: tempfile::TempDir,
}

impl Temporary {
    pub fn keep(self) -> PathBuf {
        self.root.keep()
    }
}

pub fn temporary() -> Temporary {
    let root = tempfile::tempdir().unwrap();
    Temporary { place: Place::new(root.path()), root }
}

pub fn load_scene(path: &Path) -> Result<Scene, String> {
    gltf::load(path).map_err(|error| format!("{:#}", anyhow::Error::from(error)))
}

/// Reads all frames of a capture, or tells the first error.
pub fn read_capture(folder: &Path) -> Result<Vec<quell_demo::capture::Frame>, String> {
    let frames = CaptureReader::open(folder)
        .and_then(|capture| (0..capture.len().min(4)).map(|i| capture.read(i)).collect());
    frames.map_err(|error| format!("{:#}", anyhow::Error::from(error)))
}
