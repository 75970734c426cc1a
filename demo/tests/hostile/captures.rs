//! Hostile captures, each with the error that a user sees.

use crate::files::{read_capture, temporary};
use crate::seeds;

/// The reader's own hook for panics is in place after this.
pub fn read_one_frame() {
    let folder = tempfile::tempdir().unwrap();
    seeds::write_capture(folder.path(), 1.0);
    read_capture(folder.path()).unwrap();
}

#[test]
fn the_seed_is_whole() {
    let temporary = temporary();
    assert_eq!(read_capture(&temporary.place.inside).unwrap().len(), 2);
}
