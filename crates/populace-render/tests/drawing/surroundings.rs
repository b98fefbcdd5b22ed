//! Surroundings: ground, sky, shadows and haze.

use std::sync::Arc;

use populace_character::{Character, Level, Mesh, Part};
use populace_model::Affine;
use populace_render::{Ambient, Camera, Ground, Highlights, Sky};

use crate::fixture::{at, box_mesh, part, person, plain, source, transform};
use crate::rig::{Rig, instance, srgb};

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn ground_is_at_the_feet_and_sky_above() {
    let mut rig = Rig::new();
    rig.scene.ground =
        Some(Ground { color: [0.0, 1.0, 0.0], line_color: [0.0, 1.0, 0.0], height_m: 0.0 });
    rig.scene.sky = Sky::uniform([0.0, 0.0, 1.0]);
    // One metre up, so that the feet are one metre below the centre of the picture.
    rig.camera.eye = [0.0, 1.0, 10.0];
    rig.camera.target = [0.0, 1.0, 0.0];
    let red = Arc::new(person([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    rig.upload(&[Affine::IDENTITY; 2]);
    let drawn = rig.draw(&[instance(&red, Affine::IDENTITY, 0)]);
    drawn.expect(0.13, -0.9, [255, 0, 0]);
    drawn.expect(0.13, -1.15, [0, 255, 0]);
    drawn.expect(0.6, -0.9, [0, 255, 0]);
    drawn.expect(0.6, 0.1, [0, 0, 255]);
    drawn.expect(0.6, 1.9, [0, 0, 255]);
    rig.scene.ground = None;
    rig.draw(&[instance(&red, Affine::IDENTITY, 0)]).expect(0.6, -0.9, [0, 0, 255]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn ground_hides_what_lies_beyond_it() {
    let mut rig = Rig::new();
    rig.scene.ground =
        Some(Ground { color: [0.0, 1.0, 0.0], line_color: [0.0, 1.0, 0.0], height_m: 0.0 });
    rig.camera.eye = [0.0, 1.0, 10.0];
    rig.camera.target = [0.0, 1.0, 0.0];
    let red = Arc::new(person([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    rig.upload(&[Affine::IDENTITY; 2]);
    // Half a metre deep in the ground, which is one metre below the centre of the picture.
    let list = [instance(&red, at(0.0, -0.5, 0.0), 0)];
    let above = rig.draw(&list);
    above.expect(0.13, -0.9, [255, 0, 0]);
    above.expect(0.13, -1.15, [0, 255, 0]);
    // From below, the ground is one metre above the centre and hides what stands on it.
    rig.camera.eye = [0.0, -1.0, 10.0];
    rig.camera.target = [0.0, -1.0, 0.0];
    let below = rig.draw(&list);
    below.expect(0.13, 0.85, [255, 0, 0]);
    below.expect(0.13, 1.15, [0, 255, 0]);
    rig.scene.ground = None;
    rig.draw(&list).expect(0.13, 1.15, [255, 0, 0]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn the_sky_is_seen_from_below_the_ground() {
    let mut rig = Rig::new();
    rig.scene.ground =
        Some(Ground { color: [0.0, 1.0, 0.0], line_color: [0.0, 1.0, 0.0], height_m: 0.0 });
    rig.scene.sky = Sky::uniform([0.0, 0.0, 1.0]);
    (rig.camera.eye, rig.camera.target) = ([0.0, -1.0, 10.0], [0.0, -1.0, 0.0]);
    let drawn = rig.draw(&[]);
    drawn.expect(0.0, -1.0, [0, 0, 255]);
    drawn.expect(0.0, -0.1, [0, 0, 255]);
    drawn.expect(0.0, 1.15, [0, 255, 0]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn horizon_continues_below_the_sky() {
    let mut rig = Rig::new();
    rig.scene.highlights = Highlights::Filmic;
    // The sky has one colour, part of which is above the knee of the tone mapping curve.
    rig.scene.sky = Sky::uniform([1.0, 0.8, 0.3]);
    let drawn = rig.draw(&[]);
    let above = drawn.at(0.5, 1.0);
    assert!(above[0] < 250 && above[0] > above[1], "{above:?}");
    drawn.expect(0.5, -1.0, above);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn haze_hides_the_distance() {
    let mut rig = Rig::new();
    rig.scene.ground =
        Some(Ground { color: [0.0, 1.0, 0.0], line_color: [0.0, 1.0, 0.0], height_m: 0.0 });
    rig.scene.sky = Sky::uniform([0.0, 0.0, 1.0]);
    rig.camera.eye = [0.0, 1.0, 10.0];
    rig.camera.target = [0.0, 1.0, 0.0];
    rig.camera.far = 30.0;
    let drawn = rig.draw(&[]);
    // The distances of the ground are 6, 20 and 28 m.
    let [near, middle, far] = [-1.7, -0.5, -0.36].map(|y| drawn.at(0.0, y));
    assert!(near[1] > 240 && near[2] < 80, "{near:?}");
    assert!((100..200).contains(&middle[1]) && (150..250).contains(&middle[2]), "{middle:?}");
    assert!(far[1] < 60 && far[2] > 240, "{far:?}");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn paving_has_lines_every_metre() {
    let mut rig = Rig::new();
    rig.scene.ground = Some(Ground { color: [0.5; 3], line_color: [0.0; 3], height_m: 0.0 });
    // From vertically above; up in the picture is -Z.
    rig.camera = Camera {
        eye: [0.5, 10.0, 0.5],
        target: [0.5, 0.0, 0.5],
        up: [0.0, 0.0, -1.0],
        ..rig.camera
    };
    let drawn = rig.draw(&[]);
    drawn.expect(0.0, 0.0, [srgb(0.5); 3]);
    drawn.expect(0.9, 0.9, [srgb(0.5); 3]);
    let darkest =
        |x: f32| (0..5).map(|i| drawn.at(x + 0.02 * (i as f32 - 2.0), 0.0)[0]).min().unwrap();
    assert!(darkest(0.5) < srgb(0.4), "a line at x = 1");
    assert!(darkest(-0.5) < darkest(0.5), "a wider one at x = 0");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn members_cast_shadows_on_the_ground_and_on_each_other() {
    let mut rig = Rig::new();
    rig.scene.ground = Some(Ground { color: [1.0; 3], line_color: [1.0; 3], height_m: 0.0 });
    rig.scene.ambient = Ambient::uniform([0.1; 3]);
    rig.scene.sun.color = [0.5; 3];
    rig.camera =
        Camera { eye: [0.0, 10.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, -1.0], ..rig.camera };
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY; 2]);
    // The sun is at 45 degrees on the left, so that the shadow extends 1.75 m to the right.
    rig.scene.sun.to_sun = [-1.0, 1.0, 0.0];
    let list = [instance(&white, Affine::IDENTITY, 0)];
    let sunny = [srgb(0.1 + 0.5 * f64::sqrt(0.5)); 3];
    let shady = [srgb(0.1); 3];
    rig.scene.sun.casts_shadows = true;
    let drawn = rig.draw(&list);
    drawn.expect(1.2, 0.0, shady);
    drawn.expect(-1.2, 0.0, sunny);
    drawn.expect(1.2, 0.5, sunny);
    drawn.expect(0.0, 0.0, sunny);
    // A second person stands in the first one's shadow from the chest down.
    let both = rig.draw(&[list[0], instance(&white, at(0.5, 0.0, 0.0), 0)]);
    both.expect(0.53, 0.0, sunny);
    rig.scene.sun.casts_shadows = false;
    rig.draw(&list).expect(1.2, 0.0, sunny);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn lit_surfaces_do_not_shadow_themselves() {
    let mut rig = Rig::new();
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.sun.color = [0.9; 3];
    rig.scene.sun.to_sun = [0.0, 1.0, 1.0];
    rig.scene.sun.casts_shadows = true;
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY; 2]);
    // The crowd is wide, so that shadow texels are coarse. One member is in front of the camera.
    let list: Vec<_> =
        (0..41).map(|i| instance(&white, at((i as f32 - 20.0) * 1.5, 0.0, 0.0), 0)).collect();
    let drawn = rig.draw(&list);
    let lit = [srgb(0.9 * f64::sqrt(0.5)); 3];
    for y in [0.1, 0.3, 0.5, 0.9, 1.0, 1.1, 1.2, 1.3] {
        drawn.expect(0.13, y, lit);
    }
}

/// The coarser level stands out by 0.1 m. Its shadow is to be 0.125 m off at most.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn coarser_levels_throw_no_shadows_on_the_surface_that_is_seen() {
    let mut rig = Rig::new();
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.sun.color = [0.9; 3];
    rig.scene.sun.casts_shadows = true;
    rig.scene.sun.error_px = 4.0;
    let white = person([1.0; 3], [1.0; 3]);
    let thick = |part: &Part| {
        let out = |(p, n): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|i| p[i] + 0.1 * n[i]);
        let positions = part.mesh.positions.iter().zip(&part.mesh.normals).map(out).collect();
        Mesh { positions, ..part.mesh.clone() }
    };
    let meshes = white.parts.iter().map(thick).collect();
    let level = Level { error_m: 0.1, meshes, joint_count: 2 };
    let white = Arc::new(white.with_levels(vec![level]).unwrap());
    rig.upload(&[Affine::IDENTITY; 2]);
    rig.draw(&[instance(&white, Affine::IDENTITY, 0)]).expect(0.0, 1.1, [srgb(0.9); 3]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn haze_leaves_a_twentieth_of_the_contrast_at_the_distance_of_visibility() {
    let mut rig = Rig::new();
    rig.scene.ground = Some(Ground { color: [1.0; 3], line_color: [1.0; 3], height_m: 0.0 });
    rig.scene.sky = Sky { visibility_m: 20.0, ..Sky::uniform([0.0; 3]) };
    (rig.camera.eye, rig.camera.target) = ([0.0, 1.0, 10.0], [0.0, 1.0, 0.0]);
    (rig.camera.far, rig.scene.sun.to_sun) = (2000.0, [0.0, 1.0, 0.0]);
    // The ground 20 m away is half a metre below the centre.
    let seen = rig.draw(&[]).at(0.0, -0.5)[0];
    assert!(seen.abs_diff(srgb(0.05)) <= 5, "{seen}, not {}", srgb(0.05));
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn sky_and_surfaces_are_brighter_towards_the_sun() {
    let mut rig = Rig::new();
    rig.scene.sky.glow = [0.5; 3];
    rig.scene.ambient = Ambient { glow: [0.2; 3], ..Ambient::uniform([0.4; 3]) };
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY; 2]);
    let list = [instance(&white, Affine::IDENTITY, 0)];
    for (to_sun, sky, surface) in [([0.0, 0.0, 1.0], 0.0, 0.6), ([0.0, 0.0, -1.0], 0.5, 0.2)] {
        rig.scene.sun.to_sun = to_sun;
        let drawn = rig.draw(&list);
        drawn.expect(0.13, 0.5, [srgb(surface); 3]);
        assert!(drawn.at(0.8, 0.0)[0].abs_diff(srgb(sky)) <= 6, "{:?}", drawn.at(0.8, 0.0));
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn upright_surfaces_have_light_of_their_own() {
    let mut rig = Rig::new();
    rig.scene.ambient.side = [0.3; 3];
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY; 2]);
    let list = [instance(&white, Affine::IDENTITY, 0)];
    rig.draw(&list).expect(0.13, 0.5, [srgb(0.3); 3]);
    rig.camera.eye = [0.0, 10.0, 0.0];
    rig.camera.up = [0.0, 0.0, -1.0];
    rig.draw(&list).expect(0.2, 0.0, [255; 3]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn bodies_near_the_ground_darken_it_and_are_darkened() {
    let mut rig = Rig::new();
    rig.scene.ground = Some(Ground { color: [0.8; 3], line_color: [0.8; 3], height_m: 0.0 });
    rig.scene.sky = Sky::uniform([0.8; 3]);
    rig.camera =
        Camera { eye: [0.0, 10.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, -1.0], ..rig.camera };
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY; 2]);
    let plain = srgb(0.8);
    let mut ground = |place: Affine, contact_shadows: f32, x: f32| {
        rig.scene.contact_shadows = contact_shadows;
        rig.draw(&[instance(&white, place, 0)]).at(x, 0.3)[0]
    };
    let standing = Affine::IDENTITY;
    assert!(ground(standing, 1.0, 0.0) < plain - 20);
    assert!(ground(standing, 0.5, 0.0) > ground(standing, 1.0, 0.0));
    assert_eq!(ground(standing, 0.0, 0.0), plain);
    assert_eq!(ground(at(0.0, 3.0, 0.0), 1.0, 0.0), plain, "too high");
    // On its back, with the head to the left: the shadow is as long as the body.
    let lying = transform([0.0, 0.14, 0.0], std::f32::consts::FRAC_PI_2, [1.0; 3]);
    assert!(ground(lying, 1.0, -1.2) < ground(standing, 1.0, -1.2) - 10);
    // Its side, 5 cm above the ground, has lost light to the ground; its upper edge has not.
    (rig.camera.eye, rig.camera.target) = ([0.0, 1.0, 10.0], [0.0, 1.0, 0.0]);
    rig.camera.up = [0.0, 1.0, 0.0];
    let drawn = rig.draw(&[instance(&white, standing, 0)]);
    let [low, high] = [-0.95, 0.3].map(|y| drawn.at(0.13, y)[0]);
    assert!(low < high - 20, "{low} {high}");
}

/// Returns a floor of 3.2 by 3.2 m whose top is at y = 0, moved by palette entry 0.
fn floor() -> Character {
    let slab = part("floor", 0, box_mesh([-1.6, -0.15, -1.6], [1.6, 0.0, 1.6], 0));
    Character::new(source(vec![slab], vec![plain([0.8, 0.8, 0.8, 1.0])], 1)).unwrap()
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn bodies_darken_the_floor_over_lower_ground() {
    let mut rig = Rig::new();
    rig.scene.ground = Some(Ground { color: [0.3; 3], line_color: [0.3; 3], height_m: -0.15 });
    rig.scene.sky = Sky::uniform([0.8; 3]);
    rig.camera =
        Camera { eye: [0.0, 10.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, -1.0], ..rig.camera };
    let (white, floor) = (Arc::new(person([1.0; 3], [1.0; 3])), Arc::new(floor()));
    rig.upload(&[Affine::IDENTITY; 3]);
    let mut seen = |contact_shadows: f32, person: Affine, x: f32| {
        rig.scene.contact_shadows = contact_shadows;
        let list = [instance(&floor, Affine::IDENTITY, 0), instance(&white, person, 1)];
        rig.draw(&list).at(x, 0.3)[0]
    };
    let (standing, plain) = (Affine::IDENTITY, srgb(0.8));
    assert!(seen(1.0, standing, 0.0) < plain - 20);
    assert_eq!(seen(0.0, standing, 0.0), plain);
    assert_eq!(seen(1.0, at(0.0, 3.0, 0.0), 0.0), plain, "too high");
    assert_eq!(seen(1.0, at(-0.6, 0.0, 0.0), 1.5), plain, "the floor is no body");
    // Beside the edge, where nobody is at y = 0, the ground has no shadow of the floor's height.
    assert_eq!(seen(1.0, at(1.4, 0.0, 0.0), 1.85), srgb(0.3));
    assert!(seen(1.0, at(1.4, 0.0, 0.0), 1.4) < plain - 20);
}

/// Beneath a blue sky and a red sun, whose light it does not take, a contact shadow is no stain.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn contact_shadows_keep_the_hue_of_ground_and_floor() {
    let mut rig = Rig::new();
    rig.scene.ground = Some(Ground { color: [0.8; 3], line_color: [0.8; 3], height_m: 0.0 });
    rig.scene.ambient = Ambient::uniform([0.15, 0.2, 0.4]);
    (rig.scene.sun.color, rig.scene.sun.to_sun) = ([0.5, 0.35, 0.15], [0.0, 1.0, 0.0]);
    rig.camera =
        Camera { eye: [0.0, 10.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, -1.0], ..rig.camera };
    let (white, floor) = (Arc::new(person([1.0; 3], [1.0; 3])), Arc::new(floor()));
    rig.upload(&[Affine::IDENTITY; 3]);
    let list = [instance(&white, Affine::IDENTITY, 1), instance(&floor, Affine::IDENTITY, 0)];
    for (list, lowered_m) in [(&list[..1], 0.0), (&list[..], 0.15)] {
        rig.scene.ground = rig.scene.ground.map(|ground| Ground { height_m: -lowered_m, ..ground });
        let [open, shaded] = [0.0, 1.0].map(|contact_shadows| {
            rig.scene.contact_shadows = contact_shadows;
            rig.draw(list).at(0.0, 0.3).map(|value| (f32::from(value) / 255.0).powf(2.2))
        });
        let shares = [0, 1, 2].map(|channel| shaded[channel] / open[channel]);
        assert!(shares[1] < 0.9, "{shares:?}");
        let [least, most] = [f32::min, f32::max].map(|of| shares.into_iter().reduce(of).unwrap());
        assert!(most - least < 0.04, "{shares:?} on {lowered_m} m");
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn ground_may_lie_lower() {
    let mut rig = Rig::new();
    rig.scene.ground =
        Some(Ground { color: [0.0, 1.0, 0.0], line_color: [0.0, 1.0, 0.0], height_m: -1.0 });
    (rig.camera.eye, rig.camera.target) = ([0.0, 1.0, 10.0], [0.0, 1.0, 0.0]);
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY; 2]);
    // A person who stands on y = -0.5 is seen down to the feet: half a metre is over the ground.
    let list = [instance(&white, at(0.0, -0.5, 0.0), 0)];
    let drawn = rig.draw(&list);
    assert!(drawn.at(0.13, -1.4)[0] > 100, "{:?}", drawn.at(0.13, -1.4));
    rig.scene.ground = rig.scene.ground.map(|ground| Ground { height_m: 0.0, ..ground });
    assert!(rig.draw(&list).at(0.13, -1.4)[0] < 50);
    rig.scene.ground = rig.scene.ground.map(|ground| Ground { height_m: f32::NAN, ..ground });
    assert!(rig.try_draw(&list).is_err());
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn pictures_are_the_same_at_any_height_of_the_floor() {
    let (white, floor) = (Arc::new(person([1.0; 3], [1.0; 3])), Arc::new(floor()));
    let drawn = |floor_m: f32, slab_m: f32| {
        let mut rig = Rig::new();
        rig.upload(&[Affine::IDENTITY; 3]);
        let height_m = floor_m - slab_m;
        rig.scene.ground = Some(Ground { color: [0.5; 3], line_color: [0.2; 3], height_m });
        (rig.scene.contact_shadows, rig.scene.floor_m) = (1.0, floor_m);
        (rig.camera.eye, rig.camera.target) = ([0.0, floor_m + 3.0, 8.0], [0.0, floor_m, 0.0]);
        let place = at(0.0, floor_m, 0.0);
        let list = [instance(&white, place, 0), instance(&floor, place, 1)];
        rig.draw(if slab_m > 0.0 { &list } else { &list[..1] })
    };
    for slab_m in [0.0, 0.15] {
        let wanted = drawn(0.0, slab_m);
        for floor_m in [-2.0, 5.0] {
            let found = drawn(floor_m, slab_m);
            let pairs = wanted.0.rgba.iter().zip(&found.0.rgba);
            let off = pairs.filter(|(a, b)| a.abs_diff(**b) > 2).count();
            assert!(off < 40, "floor at {floor_m} m, slab of {slab_m} m: {off} values differ");
        }
    }
}
