//! A crowd and what draws it, by the best way or by copies.

use std::sync::{Arc, OnceLock};

use populace::BackendError;
use populace::character::{Character, Image};
use populace::hand_over::Float4;
use populace::hand_over::{
    GlContext, HandedOver, PaletteSource, PaletteTarget, PaletteTransport, TargetMark,
};
use populace::{CharacterId, Crowd, Devices, Placement, Play};
use populace_render::{Camera, CharacterHandle, HandOver, Instance, Renderer, Scene};

pub(crate) const FRAME_SECS: f32 = 0.11;

/// A crowd whose palettes go by copies only.
pub(crate) struct ByCopy<'a>(pub(crate) &'a mut Crowd);

impl PaletteSource for ByCopy<'_> {
    fn page_lengths(&self) -> Vec<usize> {
        self.0.page_lengths()
    }

    fn refuses(&self, way: PaletteTransport, _context: &dyn GlContext) -> Option<String> {
        (way != PaletteTransport::Copied).then(|| "copies are wanted".into())
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.0.set_target(target, mark)
    }

    fn hand_over(&mut self) -> Result<Option<HandedOver>, BackendError> {
        self.0.hand_over()
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

/// A crowd of people in rows, each running from a moment of its own.
pub(crate) struct Troupe {
    pub(crate) crowd: Crowd,
    roles: Vec<CharacterId>,
    spawned: u16,
}

impl Troupe {
    /// For the OpenGL of a stage, so that a device that can share with it does.
    pub(crate) fn new(device: &Devices, members: u16, stage: &Stage) -> Self {
        let builder = Crowd::builder().devices(device.clone()).for_gl(stage.renderer.gl_context());
        let mut crowd = builder.capacity(100_000).build().unwrap();
        let roles =
            people().into_iter().map(|person| crowd.add_character(person).unwrap()).collect();
        let mut troupe = Self { crowd, roles, spawned: 0 };
        troupe.spawn(members);
        troupe
    }

    pub(crate) fn spawn(&mut self, members: u16) {
        for index in self.spawned..self.spawned + members {
            let role = self.roles[usize::from(index) % self.roles.len()];
            let at = [f32::from(index % 12) * 0.7 - 3.85, 0.0, -1.2 * f32::from(index / 12)];
            let member = self.crowd.spawn(role, Placement::at(at)).unwrap();
            let clip = self.crowd.clip(role, "Run").unwrap();
            self.crowd
                .play(member, clip, Play::looping().phase(f32::from(index) * 0.37 % 1.0))
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

/// A renderer that knows the people.
pub(crate) struct Stage {
    pub(crate) renderer: Renderer,
    handles: Vec<CharacterHandle>,
    scene: Scene,
}

impl Stage {
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

    /// Links a crowd, which must go without copies.
    pub(crate) fn link(&mut self, crowd: &mut Crowd) -> HandOver {
        let hand_over = self.renderer.link_palettes(crowd).unwrap();
        assert_ne!(hand_over.way, PaletteTransport::Copied, "{hand_over}");
        hand_over
    }

    /// What of a crowd is to be drawn.
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

    /// Takes a crowd's palettes and draws it.
    pub(crate) fn shoot(&mut self, crowd: &mut Crowd) -> Image {
        self.renderer.take_palettes(crowd).unwrap();
        let instances = self.instances(crowd);
        self.picture(&instances)
    }

    pub(crate) fn shoot_by_copy(&mut self, troupe: &mut Troupe) -> Image {
        self.renderer.take_palettes(&mut troupe.by_copy()).unwrap();
        let instances = self.instances(&troupe.crowd);
        self.picture(&instances)
    }
}

/// The pictures of so many frames, by copies.
pub(crate) fn film_by_copy(device: &Devices, members: u16, frames: usize) -> Vec<Image> {
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, members, &stage);
    let shoot = |_| {
        troupe.update();
        stage.shoot_by_copy(&mut troupe)
    };
    let film: Vec<_> = (0..frames).map(shoot).collect();
    assert!(film.windows(2).all(|pair| pair[0] != pair[1]), "the crowd moves");
    film
}
