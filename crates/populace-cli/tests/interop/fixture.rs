//! A crowd and its renderer, connected by the best transport or by copies.

use std::sync::{Arc, OnceLock};

use populace::BackendError;
use populace::character::{Character, Image};
use populace::interop::Float4;
use populace::interop::{
    GlContext, PaletteSource, PaletteTarget, PaletteTransport, ReleasedPalettes, TargetMark,
};
use populace::{CharacterId, ClipPlayback, Crowd, Devices, Placement};
use populace_render::{Camera, CharacterHandle, Instance, PaletteInterop, Renderer, Scene};

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

/// A renderer with the people loaded.
pub(crate) struct RenderSession {
    pub(crate) renderer: Renderer,
    handles: Vec<CharacterHandle>,
    scene: Scene,
}

impl RenderSession {
    pub(crate) fn new() -> Self {
        Self::with(&people())
    }

    pub(crate) fn with(characters: &[Arc<Character>]) -> Self {
        let mut renderer = Renderer::headless([160, 90]).unwrap();
        let handles =
            characters.iter().map(|c| renderer.add_character(c, &|_| false).unwrap()).collect();
        let corners = [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.9, 0.0], [0.0, 0.0, -6.0]];
        let camera = Camera::framing(corners, 160.0 / 90.0);
        Self { renderer, handles, scene: Scene { camera, ..Scene::default() } }
    }

    /// Connects a crowd's palettes. Fails if they would be copied.
    pub(crate) fn link(&mut self, crowd: &mut Crowd) -> PaletteInterop {
        let interop = self.renderer.connect_palettes(crowd).unwrap();
        assert_ne!(interop.transport, PaletteTransport::Copied, "{interop}");
        interop
    }

    /// Returns the instances of a crowd.
    pub(crate) fn instances(&self, crowd: &Crowd) -> Vec<Instance> {
        let instance = |i: populace::Instance| Instance {
            character: self.handles[i.character.index()],
            world_from_model: i.world_from_model,
            moved: i.moved,
            palette_first: i.palette_first,
            tint: [1.0; 3],
        };
        crowd.instances().map(instance).collect()
    }

    pub(crate) fn draw(&mut self, instances: &[Instance]) {
        self.renderer.draw(&self.scene, instances).unwrap();
    }

    pub(crate) fn picture(&mut self, instances: &[Instance]) -> Image {
        self.draw(instances);
        self.renderer.read_image().unwrap()
    }

    /// Acquires a crowd's palettes and draws it.
    pub(crate) fn draw_crowd(&mut self, crowd: &mut Crowd) -> Image {
        self.renderer.acquire_palettes(crowd).unwrap();
        let instances = self.instances(crowd);
        self.picture(&instances)
    }

    pub(crate) fn draw_crowd_by_copy(&mut self, people: &mut PeopleCrowd) -> Image {
        self.renderer.acquire_palettes(&mut people.by_copy()).unwrap();
        let instances = self.instances(&people.crowd);
        self.picture(&instances)
    }
}

/// Draws frames by copies. Asserts that successive pictures differ.
pub(crate) fn pictures_by_copy(device: &Devices, members: u16, frames: usize) -> Vec<Image> {
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, members, &session);
    let draw_crowd = |_| {
        people.update();
        session.draw_crowd_by_copy(&mut people)
    };
    let pictures: Vec<_> = (0..frames).map(draw_crowd).collect();
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]), "the crowd must move");
    pictures
}
