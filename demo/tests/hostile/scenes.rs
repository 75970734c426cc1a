//! Hostile scenes, each with the error that a user sees.

use crate::files::{load_scene, temporary};
use crate::oracle::check_scene;
use crate::seeds;
use image::ImageFormat;

#[test]
fn the_seed_is_whole() {
    let temporary = temporary();
    let place = &temporary.place;
    let buffer = seeds::buffer(1.0);
    let picture = seeds::picture(ImageFormat::Png, [1, 2, 3]);
    place.write_scene(&seeds::scene_json(buffer.len()), &buffer, &picture);
    let scene = load_scene(&place.inside.join("scene.gltf")).unwrap();
    check_scene(&scene).unwrap();
    assert_eq!((scene.images.len(), scene.instances.len(), scene.punctual_lights.len()), (3, 2, 2));
}
