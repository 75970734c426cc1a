//! The gallery's materials.

use super::textures;
use crate::scene::{Material, Scene, TextureRef};
use glam::Vec2;

/// Indices of materials.
pub(super) struct Looks {
    pub checker: usize,
    pub wood: usize,
    pub bricks: usize,
    pub plaster: usize,
    pub terracotta: usize,
    pub teal: usize,
    pub stone: usize,
    pub ground: usize,
    pub leaves: usize,
    pub gold: usize,
    pub steel: usize,
    pub copper: usize,
    pub chrome: usize,
    pub red: usize,
    pub iron: usize,
    pub oak: usize,
    pub paintings: [usize; 4],
}

impl Looks {
    pub fn new(scene: &mut Scene) -> Self {
        let plaster_normal = scene.add_image(textures::plaster_normal());
        let plain = |name: &str, color: [f32; 3], roughness| Material {
            name: name.to_owned(),
            base_color: [color[0], color[1], color[2], 1.0],
            roughness,
            ..Default::default()
        };
        let metal =
            |name: &str, color, roughness| Material { metallic: 1.0, ..plain(name, color, roughness) };
        let plaster = |name: &str, color| Material {
            normal_texture: Some(TextureRef::new(plaster_normal)),
            ..plain(name, color, 0.9)
        };
        let (checker, checker_roughness) =
            (scene.add_image(textures::checker()), scene.add_image(textures::checker_roughness()));
        let (wood, wood_normal) =
            (scene.add_image(textures::wood()), scene.add_image(textures::wood_normal()));
        let (bricks, brick_normal) =
            (scene.add_image(textures::bricks()), scene.add_image(textures::brick_normal()));
        let white = [1.0; 3];
        let pictures = [
            textures::painting_sea(),
            textures::painting_fields(),
            textures::painting_waves(),
            textures::painting_rings(),
        ];
        let paintings = pictures.map(|picture| {
            let name = picture.name.clone();
            let image = scene.add_image(picture);
            let base_color_texture = Some(TextureRef::new(image));
            scene.add_material(Material { base_color_texture, ..plain(&name, white, 0.55) })
        });
        Self {
            checker: scene.add_material(Material {
                base_color_texture: Some(TextureRef::new(checker)),
                metallic_roughness_texture: Some(TextureRef::new(checker_roughness)),
                ..plain("checker", white, 1.0)
            }),
            wood: scene.add_material(Material {
                base_color_texture: Some(TextureRef::new(wood)),
                normal_texture: Some(TextureRef::new(wood_normal)),
                ..plain("planks", white, 0.38)
            }),
            bricks: scene.add_material(Material {
                base_color_texture: Some(TextureRef::new(bricks)),
                normal_texture: Some(TextureRef::new(brick_normal)),
                ..plain("bricks", white, 0.85)
            }),
            plaster: scene.add_material(plaster("plaster", [0.80, 0.77, 0.71])),
            terracotta: scene.add_material(plaster("terracotta", [0.72, 0.30, 0.17])),
            teal: scene.add_material(plaster("teal", [0.13, 0.42, 0.45])),
            stone: scene.add_material(plaster("stone", [0.74, 0.69, 0.60])),
            ground: scene.add_material(plain("ground", [0.24, 0.30, 0.13], 0.95)),
            leaves: scene.add_material(plain("leaves", [0.075, 0.13, 0.05], 0.9)),
            gold: scene.add_material(metal("gold", [0.95, 0.70, 0.32], 0.28)),
            steel: scene.add_material(metal("steel", [0.62, 0.63, 0.65], 0.42)),
            copper: scene.add_material(metal("copper", [0.93, 0.55, 0.42], 0.35)),
            chrome: scene.add_material(metal("chrome", [0.80, 0.81, 0.83], 0.06)),
            red: scene.add_material(plain("lacquer", [0.62, 0.045, 0.035], 0.12)),
            iron: scene.add_material(metal("iron", [0.20, 0.20, 0.21], 0.5)),
            oak: scene.add_material(Material {
                base_color_texture: Some(TextureRef::scaled(wood, Vec2::splat(0.5))),
                ..plain("oak", [0.75, 0.72, 0.7], 0.45)
            }),
            paintings,
        }
    }
}
