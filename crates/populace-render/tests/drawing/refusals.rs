//! Invalid input is rejected with an error, and the renderer stays usable.

use std::sync::Arc;

use populace_character::{Character, Image, Material, Texture, TextureFilter, Wrap};
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_model::Affine;
use populace_render::{Camera, Error, Renderer, Scene};

use crate::fixture::{part, person, quad_mesh, source};
use crate::rig::{Rig, instance};

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn picture_size_is_between_one_pixel_and_the_drivers_limit() {
    for size in [[0, 5], [5, 0]] {
        let error = Renderer::headless(size).err().unwrap();
        assert!(matches!(error, Error::EmptyPicture { .. }), "{error}");
    }
    for size in [[1 << 20, 4], [4, u32::MAX]] {
        let error = Renderer::headless(size).err().unwrap();
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    }
    for size in [[1, 1], [1, 7], [33, 1]] {
        let mut renderer = Renderer::headless(size).unwrap();
        renderer.draw_instances(&[], &Camera::default(), &Scene::default()).unwrap();
        let Image { width, height, rgba } = renderer.read_image().unwrap();
        assert_eq!(([width, height], rgba.len()), (size, 4 * (width * height) as usize));
        assert!(rgba.iter().skip(3).step_by(4).all(|alpha| *alpha == 255));
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn pages_are_complete_matrices_within_the_limits() {
    let mut rig = Rig::new();
    let page = |rig: &mut Rig, len| rig.upload_pages(vec![vec![Float4::default(); len]]);
    let error = page(&mut rig, 4).unwrap_err();
    assert!(matches!(error, Error::PartialMatrix { len: 4 }), "{error}");
    let error = rig.upload_pages(vec![Vec::new(); 4097]).unwrap_err();
    assert!(matches!(error, Error::TooLarge { size: 4097, limit: 4096, .. }), "{error}");
    let error = page(&mut rig, 3 * (PAGE_ENTRIES as usize + 1)).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    page(&mut rig, 0).unwrap();
    rig.upload_pages(vec![Vec::new(); 4096]).unwrap();
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn members_need_a_palette() {
    let mut rig = Rig::new();
    let character = person([1.0; 3], [1.0; 3]);
    let here = Arc::new(character);
    let one = instance(&here, Affine::IDENTITY, 0);
    let error = rig.try_draw(&[one]).err().unwrap();
    assert!(matches!(error, Error::NoPalette { available: 0, count: 2, .. }), "{error}");
    rig.upload(&[Affine::IDENTITY; 3]);
    let error = rig.try_draw(&[one, instance(&here, Affine::IDENTITY, 2)]).err().unwrap();
    assert!(
        matches!(error, Error::NoPalette { instance: 1, first: 2, available: 3, .. }),
        "{error}"
    );
    rig.draw(&[one]).expect(0.0, 1.1, [255; 3]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn textures_above_the_drivers_limit_are_rejected() {
    let texture = Texture {
        image: 0,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: TextureFilter::Linear,
    };
    let material = Material { base_color_texture: Some(texture), ..Material::default() };
    let mut pieces = source(vec![part("quad", 0, quad_mesh(0))], vec![material], 1);
    pieces.images = vec![Image { width: 1 << 20, height: 1, rgba: vec![255; 4 << 20] }];
    let mut rig = Rig::new();
    let long = Arc::new(Character::new(pieces).unwrap());
    let error = rig.renderer.upload_character(&long, &|_| false).unwrap_err();
    assert!(matches!(error, Error::TooLarge { what: "the side of a texture", .. }), "{error}");
    rig.renderer.upload_character(&long, &|_| true).unwrap();
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn invalid_cameras_and_scenes_are_rejected() {
    type Spoiler<'a> = (&'a dyn Fn(&mut Scene), &'a str);
    let mut rig = Rig::new();
    let (good_camera, good) = (rig.camera, rig.scene);
    let spoilers: [&dyn Fn(&mut Camera); 6] = [
        &|c| c.eye[0] = f32::NAN,
        &|c| c.target = c.eye,
        &|c| c.up = [0.0, 0.0, 3.0],
        &|c| c.fov_y_rad = 3.2,
        &|c| c.near = 0.0,
        &|c| c.far = c.near,
    ];
    for spoil in spoilers {
        rig.camera = good_camera;
        spoil(&mut rig.camera);
        let error = rig.try_draw(&[]).err().unwrap();
        assert!(matches!(error, Error::BadCamera { .. }), "{error}");
    }
    rig.camera = good_camera;
    let spoilers: [Spoiler<'_>; 6] = [
        (&|s| s.sun.to_sun = [0.0; 3], "direction to the sun must be finite and not zero"),
        (&|s| s.sun.color[1] = f32::INFINITY, "sun colour must be finite"),
        (&|s| s.sky.horizon[2] = f32::NAN, "horizon colour must be finite"),
        (&|s| s.reflections = 1.5, "fraction of reflections must be 0 to 1"),
        (&|s| s.sky.visibility_m = 0.0, "visibility must be above 0"),
        (&|s| s.floor_m = f32::NAN, "height of the floor must be -1000000 to 1000000"),
    ];
    for (spoil, words) in spoilers {
        rig.scene = good;
        spoil(&mut rig.scene);
        let error = rig.try_draw(&[]).err().unwrap();
        assert!(matches!(error, Error::BadScene { .. }), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
}
