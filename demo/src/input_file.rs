//! Opening files that strangers wrote: only regular ones, of a bounded size, and only inside the folder they belong to.

use std::borrow::Cow;
use std::fs::{File, Metadata};
use std::io::{Read, Seek};
use std::path::{Component, Path, PathBuf};
use thiserror::Error;

/// Why a file is not read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum InputFileError {
    #[error(transparent)]
    Io(#[from] std::io::Error),
    #[error("is a {found}, expected a regular file")]
    Kind { found: &'static str },
    #[error("has {found} bytes, expected at most {most}")]
    TooLarge { found: u64, most: u64 },
    #[error("leaves the folder {}, expected a file in it", folder.display())]
    Outside { folder: PathBuf },
    #[error("is no relative path, expected the path of a file in the same folder")]
    NotRelative,
}

type Result<T> = std::result::Result<T, InputFileError>;

fn check(metadata: &Metadata, most: u64) -> Result<()> {
    if !metadata.is_file() {
        return Err(InputFileError::Kind { found: kind(metadata) });
    }
    match metadata.len() {
        found if found > most => Err(InputFileError::TooLarge { found, most }),
        _ => Ok(()),
    }
}

fn kind(metadata: &Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_fifo() {
            return "named pipe";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "device";
        }
        if kind.is_socket() {
            return "socket";
        }
    }
    if metadata.is_dir() { "folder" } else { "special file" }
}

/// Opens a regular file of at most `most` bytes.
pub fn open(path: &Path, most: u64) -> Result<File> {
    // Before opening: that would wait for a named pipe's writer for ever.
    check(&std::fs::metadata(path)?, most)?;
    let file = File::open(path)?;
    check(&file.metadata()?, most)?;
    Ok(file)
}

/// The bytes of a regular file of at most `most` bytes.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut file = open(path, most)?;
    let mut bytes = Vec::new();
    // It may grow while it is read, and files of /proc do not say how long they are.
    (&mut file).take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let found = file.seek(std::io::SeekFrom::End(0)).unwrap_or(0).max(bytes.len() as u64);
        return Err(InputFileError::TooLarge { found, most });
    }
    Ok(bytes)
}

/// Text from a file, for a message: it may be megabytes long, or steer a terminal.
pub fn printable(text: &str, most_letters: usize) -> Cow<'_, str> {
    let text = text.trim_end();
    let is_long = text.chars().nth(most_letters).is_some();
    if !is_long && !text.contains(is_unprintable) {
        return text.into();
    }
    let plain = |c: char| if is_unprintable(c) { '?' } else { c };
    let end = if is_long { "..." } else { "" };
    text.chars().take(most_letters).map(plain).chain(end.chars()).collect::<String>().into()
}

/// Control characters, and those that turn the direction of what follows.
fn is_unprintable(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A folder that what is read must lie in.
#[derive(Debug, Clone)]
pub struct Folder {
    /// Without symbolic links.
    canonical: PathBuf,
}

impl Folder {
    pub fn new(path: &Path) -> std::io::Result<Self> {
        // The parent of a bare file name is empty, and means here.
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        Ok(Self { canonical: path.canonicalize()? })
    }

    /// The folder that a file lies in.
    pub fn of(file: &Path) -> std::io::Result<Self> {
        Self::new(file.parent().unwrap_or(Path::new("")))
    }

    /// Where `relative` leads, links included, if that is inside.
    pub fn resolve(&self, relative: &Path) -> Result<PathBuf> {
        let outside = || InputFileError::Outside { folder: self.canonical.clone() };
        // By its spelling first, so that an error does not tell what exists outside.
        let mut depth = 0_usize;
        for component in relative.components() {
            match component {
                Component::Normal(_) => depth += 1,
                Component::CurDir => {}
                Component::ParentDir => depth = depth.checked_sub(1).ok_or_else(outside)?,
                Component::RootDir | Component::Prefix(_) => return Err(InputFileError::NotRelative),
            }
        }
        let place = self.canonical.join(relative).canonicalize()?;
        if place.starts_with(&self.canonical) { Ok(place) } else { Err(outside()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_lies_inside_is_resolved() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("folder");
        std::fs::create_dir_all(folder.join("sub")).unwrap();
        std::fs::write(folder.join("sub/inside"), "in").unwrap();
        std::fs::write(root.path().join("outside"), "out").unwrap();
        let folder = Folder::new(&folder).unwrap();
        assert!(folder.resolve(Path::new("sub/../sub/./inside")).is_ok());
        let refused = |path: &str| folder.resolve(Path::new(path)).unwrap_err().to_string();
        for path in ["../outside", "sub/../../outside", "../folder/sub/inside", "../no such file"] {
            assert!(refused(path).contains("leaves the folder"), "{path}: {}", refused(path));
        }
        assert!(refused("/etc/passwd").contains("no relative path"));
        assert!(refused("missing").contains("No such file"));
    }

    #[test]
    fn messages_stay_short_and_printable() {
        assert_eq!(printable("a name", 6), "a name");
        assert_eq!(printable("a longer name", 8), "a longer...");
        assert_eq!(printable("red\u{1b}[31m\u{202e}\n", 80), "red?[31m?");
    }

    #[test]
    fn only_regular_files_within_the_limit_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ten");
        std::fs::write(&path, [0; 10]).unwrap();
        assert_eq!(read(&path, 10).unwrap().len(), 10);
        assert_eq!(read(&path, 9).unwrap_err().to_string(), "has 10 bytes, expected at most 9");
        let folder = read(folder.path(), 9).unwrap_err().to_string();
        assert_eq!(folder, "is a folder, expected a regular file");
        #[cfg(unix)]
        assert_eq!(
            read(Path::new("/dev/zero"), 9).unwrap_err().to_string(),
            "is a device, expected a regular file"
        );
    }
}
