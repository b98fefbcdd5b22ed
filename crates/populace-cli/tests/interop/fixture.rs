//! A crowd and its renderer, connected by the best transport or by copies.

use std::sync::{Arc, OnceLock};

use populace::BackendError;
use populace::character::{Character, Image};
use populace::interop::{
    DrawSource, Float4, GlContext, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, TargetMark, Visibility,
};
use populace::{Affine, CharacterId, ClipPlayback, Crowd, Devices, Instance, Placement};
use populace_render::{Camera, PaletteInterop, Renderer, Scene};

pub(crate) const FRAME_SECS: f32 = 0.11;

/// A palette source that only allows copies.
pub(crate) struct ByCopy<'a>(pub(crate) &'a mut Crowd);

impl PaletteSource for ByCopy<'_> {
    fn page_lengths(&self) -> Vec<usize> {
        self.0.page_lengths()
    }

    fn refuses(&self, transport: PaletteTransport, _context: &dyn GlContext) -> Option<String> {
        (transport != PaletteTransport::Copied).then(|| "this test uses copies".into())
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.0.set_target(target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        self.0.release_palettes()
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        PaletteSource::with_page(self.0, page, reader)
    }
}

impl DrawSource for ByCopy<'_> {
    fn instances(&self) -> Vec<Instance<'_>> {
        self.0.instances().collect()
    }
}

fn people() -> Vec<Arc<Character>> {
    static PEOPLE: OnceLock<Vec<Arc<Character>>> = OnceLock::new();
    PEOPLE
        .get_or_init(|| populace_cast::cast().unwrap().into_iter().map(Arc::new).collect())
        .clone()
}

/// A crowd of people in rows, each running at its own phase.
pub(crate) struct PeopleCrowd {
    pub(crate) crowd: Crowd,
    roles: Vec<CharacterId>,
    spawned: u16,
}

impl PeopleCrowd {
    /// Creates the crowd for the OpenGL context of a renderer, so that devices can share memory
    /// with it.
    pub(crate) fn new(device: &Devices, members: u16, session: &RenderSession) -> Self {
        let builder =
            Crowd::builder().devices(device.clone()).for_gl(session.renderer.gl_context());
        let mut crowd = builder.capacity(100_000).build().unwrap();
        let roles =
            people().into_iter().map(|person| crowd.add_character(person).unwrap()).collect();
        let mut people = Self { crowd, roles, spawned: 0 };
        people.spawn(members);
        people
    }

    pub(crate) fn spawn(&mut self, members: u16) {
        for index in self.spawned..self.spawned + members {
            let role = self.roles[usize::from(index) % self.roles.len()];
            let at = [f32::from(index % 12) * 0.7 - 3.85, 0.0, -1.2 * f32::from(index / 12)];
            let member = self.crowd.spawn(role, Placement::at(at)).unwrap();
            let clip = self.crowd.clip(role, "Run").unwrap();
            self.crowd
                .member_mut(member)
                .unwrap()
                .play(clip, ClipPlayback::looping().phase(f32::from(index) * 0.37 % 1.0))
                .unwrap();
        }
        self.spawned += members;
    }

    pub(crate) fn update(&mut self) {
        self.crowd.update(FRAME_SECS).unwrap();
    }

    pub(crate) fn by_copy(&mut self) -> ByCopy<'_> {
        ByCopy(&mut self.crowd)
    }
}

/// A renderer and its camera.
pub(crate) struct RenderSession {
    pub(crate) renderer: Renderer,
    camera: Camera,
}

impl RenderSession {
    pub(crate) fn new() -> Self {
        let renderer = Renderer::headless([160, 90]).unwrap();
        let corners = [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.9, 0.0], [0.0, 0.0, -6.0]];
        Self { renderer, camera: Camera::framing(corners, 160.0 / 90.0) }
    }

    /// Connects a crowd's palettes. Fails if they would be copied.
    pub(crate) fn link(&mut self, crowd: &mut Crowd) -> PaletteInterop {
        let interop = self.renderer.connect_palettes(crowd).unwrap();
        assert_ne!(interop.transport, PaletteTransport::Copied, "{interop}");
        interop
    }

    pub(crate) fn draw(&mut self, instances: &[Instance<'_>]) {
        self.renderer.draw_instances(instances, &self.camera, &Scene::default()).unwrap();
    }

    pub(crate) fn picture(&mut self, instances: &[Instance<'_>]) -> Image {
        self.draw(instances);
        self.renderer.read_image().unwrap()
    }

    pub(crate) fn draw_crowd(&mut self, crowd: &mut dyn DrawSource) -> Image {
        self.renderer.draw(crowd, &self.camera, &Scene::default()).unwrap();
        self.renderer.read_image().unwrap()
    }
}

/// The instances of a crowd at one time. They can be drawn while the crowd changes, and once it is
/// gone.
pub(crate) struct Kept {
    characters: Vec<Arc<Character>>,
    placements: Vec<(Affine, u32)>,
}

impl Kept {
    pub(crate) fn of(crowd: &Crowd) -> Self {
        let instances: Vec<_> = crowd.instances().collect();
        Self {
            characters: instances.iter().map(|i| Arc::clone(i.character)).collect(),
            placements: instances.iter().map(|i| (i.world_from_model, i.palette_first)).collect(),
        }
    }

    pub(crate) fn instances(&self) -> Vec<Instance<'_>> {
        let kept = self.characters.iter().zip(self.placements.iter().copied());
        let instance = |(character, (world_from_model, palette_first))| Instance {
            character,
            world_from_model,
            moved: [0.0; 3],
            palette_first,
            look: populace::MemberLook::PLAIN,
            level: 0,
            visibility: Visibility::InView,
        };
        kept.map(instance).collect()
    }
}

/// Draws frames by copies. Asserts that successive pictures differ.
pub(crate) fn pictures_by_copy(device: &Devices, members: u16, frames: usize) -> Vec<Image> {
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, members, &session);
    let draw_crowd = |_| {
        people.update();
        session.draw_crowd(&mut people.by_copy())
    };
    let pictures: Vec<_> = (0..frames).map(draw_crowd).collect();
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]), "the crowd must move");
    pictures
}
