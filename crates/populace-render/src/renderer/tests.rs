use std::time::Duration;

use populace_character::{AlphaMode, CharacterSource, Influences, Material, Mesh, PaletteEntry};
use populace_device::layout::Float4;
use populace_device::{
    BackendError, PaletteTarget, PaletteTransport, ReleasedPalettes, TargetMark,
};
use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};

use super::*;
use crate::gl::Fence;

/// A device with one member that never moves. Frames alternate between the two sets.
#[derive(Default)]
struct Still {
    mark: TargetMark,
    target: PaletteTarget,
    set: usize,
    /// True if the member is gone.
    is_empty: bool,
}

impl PaletteSource for Still {
    fn page_lengths(&self) -> Vec<usize> {
        if self.is_empty { Vec::new() } else { vec![1] }
    }

    fn refuses(&self, transport: PaletteTransport, _context: &dyn GlContext) -> Option<String> {
        (transport != PaletteTransport::Mapped).then(|| "this test uses mapped buffers".into())
    }

    fn set_target(
        &mut self,
        mut target: PaletteTarget,
        mark: &TargetMark,
    ) -> Result<(), BackendError> {
        if let PaletteTarget::Mapped(sets) = &mut target {
            let pages = sets.iter_mut().flatten();
            pages.for_each(|page| {
                page.elements()[..3].copy_from_slice(&Affine::IDENTITY.rows.map(Float4))
            });
        }
        (self.mark, self.target) = (mark.clone(), target);
        Ok(())
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        Ok(Some(ReleasedPalettes { mark: self.mark.clone(), set: Some(self.set) }))
    }

    fn with_page(&mut self, _: usize, _: &mut dyn FnMut(&[Float4])) -> Result<(), BackendError> {
        Ok(())
    }
}

/// A blended quad that fills the picture.
fn glass() -> Character {
    with_alpha(AlphaMode::Blend)
}

fn with_alpha(alpha: AlphaMode) -> Character {
    let joint = JointSource { name: "pane".into(), parent: None, rest: Trs::IDENTITY };
    let mesh = Mesh {
        positions: vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences {
            per_vertex: 4,
            entries: vec![0; 16],
            weights: [1.0, 0.0, 0.0, 0.0].repeat(4),
        },
        indices: vec![0, 1, 2, 0, 2, 3],
    };
    Character::new(CharacterSource {
        name: "glass".into(),
        skeleton: Skeleton::new(&[joint]).unwrap(),
        palette: vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }],
        parts: vec![Part {
            node: 0,
            node_name: "pane".into(),
            primitive: 0,
            material: Some(0),
            mesh,
        }],
        materials: vec![Material { alpha, ..Material::default() }],
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    })
    .unwrap()
}

/// Drawing many panes on top of each other takes OpenGL far longer than the draw call.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn acquire_waits_for_draws_from_the_set_written_next() {
    let mut renderer = Renderer::headless([1024, 1024]).unwrap();
    let character = Arc::new(glass());
    let mut device = Still::default();
    renderer.connect_palettes(&mut device).unwrap();
    let instance = pane(&character, 0.0, 0.0);
    let camera = Camera::framing([[-1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], 1.0);
    renderer.acquire_palettes(&mut device).unwrap();
    renderer.draw_instances(&[instance; 30], &camera, &Scene::default()).unwrap();
    let drawn = Fence::new(&renderer.gl).unwrap();
    device.set = 1;
    renderer.acquire_palettes(&mut device).unwrap();
    // This test's fence comes just after the renderer's and may be signalled a little later.
    std::thread::sleep(Duration::from_millis(2));
    assert!(drawn.is_reached(), "set 0 is written next but is still being drawn from");
}

/// A pane that reaches 9 m up and down from a height, at z metres.
fn pane(character: &Arc<Character>, z: f32, height: f32) -> Instance<'_> {
    let mut world_from_model = Affine::IDENTITY;
    world_from_model.rows[1][3] = height;
    world_from_model.rows[2][3] = z;
    Instance {
        character,
        world_from_model,
        moved: [0.0; 3],
        palette_first: 0,
        look: populace_device::MemberLook::PLAIN,
        level: 0,
        visibility: populace_device::Visibility::InView,
    }
}

/// Returns a renderer of 64 by 64 pixels with one palette entry, and a camera 2 m above the ground.
fn watched() -> (Renderer, Camera) {
    let mut renderer = Renderer::headless([64, 64]).unwrap();
    let mut device = Still::default();
    renderer.connect_palettes(&mut device).unwrap();
    renderer.acquire_palettes(&mut device).unwrap();
    let camera = Camera {
        eye: [0.0, 2.0, 10.0],
        target: [0.0, 2.0, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y_rad: 1.0,
        near: 0.1,
        far: 500.0,
    };
    (renderer, camera)
}

const MIDDLE: usize = 32;

/// A pane in front of the camera and one behind it, and the ground around them.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn marks_say_what_each_pixel_shows() {
    let (mut renderer, camera) = watched();
    let character = Arc::new(glass());
    let scene = Scene::default();
    // The first is out of view. Both others end at the height of the eye.
    let instances = [(30.0, 0.0), (-10.0, 11.0), (4.0, 11.0)].map(|(z, y)| pane(&character, z, y));
    renderer.draw_instances(&instances, &camera, &scene).unwrap();
    // Windows have another viewport.
    MarkTarget::new(&renderer.gl, [8, 8]).unwrap().begin();
    let marks = renderer.read_marks(&camera, &scene, &|_| true).unwrap();
    for (row, instance, depth_m) in [(0, Some(2), 6.0), (30, Some(2), 6.0), (33, None, 78.1)] {
        assert_eq!(marks.instances[64 * row + MIDDLE], instance, "row {row}");
        let covered = if instance.is_some() { 255 } else { 0 };
        assert_eq!(marks.coverage[64 * row + MIDDLE], covered, "row {row}");
        let found = marks.depths_m[64 * row + MIDDLE];
        assert!((found - depth_m).abs() < 0.05 * depth_m, "row {row}: {found}");
    }
    let lowest = marks.depths_m[64 * 63 + MIDDLE];
    let slope = (0.5f32).tan() * 31.5 / 32.0;
    assert!((lowest - 2.0 / slope).abs() < 1e-3, "{lowest}");
    renderer.draw_instances(&[], &camera, &Scene { ground: None, ..scene }).unwrap();
    let marks = renderer.read_marks(&camera, &Scene { ground: None, ..scene }, &|_| true).unwrap();
    assert!(marks.depths_m.iter().all(|depth| depth.is_infinite()));
    assert!(marks.coverage.iter().all(|share| *share == 0));
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn marks_leave_out_as_much_as_fading_leaves_out() {
    let (mut renderer, camera) = watched();
    let character = Arc::new(glass());
    let scene = Scene { ground: None, ..Scene::default() };
    for opacity in [0.0, 0.3, 1.0] {
        let mut instance = pane(&character, 0.0, 0.0);
        instance.look = instance.look.with_opacity(opacity);
        renderer.draw_instances(&[instance], &camera, &scene).unwrap();
        let marks = renderer.read_marks(&camera, &scene, &|_| true).unwrap();
        let named: Vec<_> = marks.instances.iter().map(Option::is_some).collect();
        let near: Vec<_> = marks.depths_m.iter().map(|depth| depth.is_finite()).collect();
        assert_eq!(near, named, "{opacity}");
        let share = named.iter().filter(|is_named| **is_named).count() as f32 / 4096.0;
        assert!((share - opacity).abs() < 0.05, "{opacity}: {share}");
        let covered = marks.coverage.iter().map(|share| f32::from(*share) / 255.0).sum::<f32>();
        assert!((covered / 4096.0 - opacity).abs() < 0.05, "{opacity}: {covered}");
    }
}

/// A place covers nothing, and hides whoever is behind it.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn instances_that_do_not_count_cover_nothing() {
    let (mut renderer, camera) = watched();
    let person = Arc::new(glass());
    let place = Arc::new(with_alpha(AlphaMode::Opaque));
    let scene = Scene::default();
    // The place hides the lower half of what the first shows, and is behind the last.
    let instances = [pane(&person, -10.0, 2.0), pane(&place, 0.0, -7.0), pane(&person, 4.0, 11.5)];
    let covered = |renderer: &mut Renderer, row: usize| {
        renderer.draw_instances(&instances, &camera, &scene).unwrap();
        let marks = renderer.read_marks(&camera, &scene, &|index| index != 1).unwrap();
        (marks.instances[64 * row + MIDDLE], marks.coverage[64 * row + MIDDLE])
    };
    assert_eq!(covered(&mut renderer, 0), (Some(2), 255));
    assert_eq!(covered(&mut renderer, 30), (Some(0), 255));
    assert_eq!(covered(&mut renderer, 40), (Some(1), 0));
}

/// Marks show a body between y = 0 and a lower ground.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn marks_are_those_of_a_ground_that_lies_lower() {
    let (mut renderer, camera) = watched();
    let character = Arc::new(glass());
    let mut scene = Scene::default();
    scene.ground.as_mut().unwrap().height_m = -1.0;
    // It ends 0.5 m below y = 0, at a depth of 10 m, and begins far below the ground.
    renderer.draw_instances(&[pane(&character, 0.0, -9.5)], &camera, &scene).unwrap();
    let marks = renderer.read_marks(&camera, &scene, &|_| true).unwrap();
    let pixels_per_m = 32.0 / (0.5f32).tan() / 10.0;
    let row_of = |height: f32| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a row")]
        let row = (32.0 + (2.0 - height) * pixels_per_m) as usize;
        row
    };
    for (height, instance) in [(-0.3, None), (-0.7, Some(0)), (-1.3, None)] {
        let pixel = 64 * row_of(height) + MIDDLE;
        assert_eq!(marks.instances[pixel], instance, "{height}");
        assert_eq!(marks.coverage[pixel], if instance.is_some() { 255 } else { 0 }, "{height}");
    }
    let lowest = marks.depths_m[64 * 63 + MIDDLE];
    let slope = (0.5f32).tan() * 31.5 / 32.0;
    assert!((lowest - 3.0 / slope).abs() < 1e-3, "{lowest}");
}

/// A failed draw may have released the models of the picture before.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn marks_show_nothing_after_a_draw_that_failed() {
    let (mut renderer, camera) = watched();
    let (first, other) = (Arc::new(glass()), Arc::new(glass()));
    let scene = Scene::default();
    let instances = [pane(&other, 0.0, 0.0), pane(&first, 0.0, 0.0)];
    renderer.draw_instances(&instances, &camera, &scene).unwrap();
    drop(other);
    let astray = Instance { palette_first: 1, ..pane(&first, 0.0, 0.0) };
    assert!(renderer.draw_instances(&[astray], &camera, &scene).is_err());
    let marks = renderer.read_marks(&camera, &scene, &|_| true).unwrap();
    assert!(marks.instances.iter().all(Option::is_none));
}

/// The runs of a picture name pages that are gone.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn marks_show_nothing_without_the_palettes_or_the_picture() {
    let (mut renderer, camera) = watched();
    let character = Arc::new(glass());
    let scene = Scene::default();
    renderer.draw_instances(&[pane(&character, 0.0, 0.0)], &camera, &scene).unwrap();
    renderer.resize([64, 64]).unwrap();
    let marks = renderer.read_marks(&camera, &scene, &|_| true).unwrap();
    assert!(marks.instances.iter().all(Option::is_none), "after a change of size");
    renderer.draw_instances(&[pane(&character, 0.0, 0.0)], &camera, &scene).unwrap();
    renderer.acquire_palettes(&mut Still { is_empty: true, ..Still::default() }).unwrap();
    let marks = renderer.read_marks(&camera, &scene, &|_| true).unwrap();
    assert!(marks.instances.iter().all(Option::is_none), "after other palettes");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn pictures_change_their_size_and_windows_are_asked_for() {
    let mut renderer = Renderer::headless([16, 8]).unwrap();
    let camera = Camera::default();
    for size in [[16, 8], [40, 24], [5, 9]] {
        renderer.resize(size).unwrap();
        renderer.draw_instances(&[], &camera, &Scene::default()).unwrap();
        let image = renderer.read_image().unwrap();
        assert_eq!(([image.width, image.height], renderer.size()), (size, size));
    }
    assert!(matches!(renderer.resize([0, 4]), Err(Error::EmptyPicture { .. })));
    assert_eq!(renderer.size(), [5, 9]);
    for error in [
        renderer.compose([4, 4], [0, 0], [0.0; 3], &[]).err(),
        renderer.read_window([4, 4]).err(),
        renderer.present().err(),
    ] {
        assert!(matches!(error, Some(Error::NoWindow)), "{error:?}");
    }
}
