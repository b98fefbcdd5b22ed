//! Pictures of a crowd.

use populace::character::{Image, Part};
use populace::hand_over::PaletteTransport;
use populace::{Crowd, CrowdBuilder};
use populace_render::{Camera, CharacterHandle, HandOver, Instance, Renderer, Scene};

use crate::cast::Role;
use crate::failure::Failure;

/// A renderer that knows a crowd's characters.
pub(crate) struct Studio {
    renderer: Renderer,
    handles: Vec<CharacterHandle>,
    /// Of each character, as it is drawn.
    triangles: Vec<usize>,
    scene: Scene,
    hand_over: HandOver,
    drawn: Drawn,
}

/// What a picture shows.
#[derive(Clone, Copy, Default)]
pub(crate) struct Drawn {
    pub(crate) members: usize,
    pub(crate) triangles: usize,
}

impl Studio {
    /// Links the crowd's palettes to the renderer; `crowd` should have been built for its OpenGL.
    pub(crate) fn new(
        mut renderer: Renderer,
        crowd: &mut Crowd,
        roles: &[Role],
        hide: &[String],
        camera: Camera,
    ) -> Result<Self, Failure> {
        let hand_over = renderer.link_palettes(crowd)?;
        let hidden = |part: &Part| hide.contains(&part.node_name);
        let handles = roles.iter().map(|role| renderer.add_character(&role.character, &hidden));
        let handles = handles.collect::<Result<_, _>>()?;
        let triangles = |role: &Role| {
            let shown = role.character.parts.iter().filter(|part| !hidden(part));
            shown.map(|part| part.mesh.indices.len() / 3).sum()
        };
        let triangles = roles.iter().map(triangles).collect();
        let scene = Scene { camera, ..Scene::default() };
        Ok(Self { renderer, handles, triangles, scene, hand_over, drawn: Drawn::default() })
    }

    /// What draws, for people.
    pub(crate) fn driver(&self) -> &str {
        self.renderer.driver()
    }

    /// How palettes get there, for people.
    pub(crate) fn palettes(&self) -> PaletteTransport {
        self.hand_over.way
    }

    /// What the last picture shows.
    pub(crate) fn drawn(&self) -> Drawn {
        self.drawn
    }

    /// Draws the crowd as of its last update.
    pub(crate) fn picture(&mut self, crowd: &mut Crowd) -> Result<Image, Failure> {
        self.renderer.take_palettes(crowd)?;
        let instances: Vec<_> = crowd
            .instances()
            .map(|i| Instance {
                character: self.handles[i.character.index()],
                world_from_model: i.world_from_model,
                moved: i.moved,
                palette_first: i.palette_first,
                tint: [1.0; 3],
            })
            .collect();
        let triangles = crowd.instances().map(|i| self.triangles[i.character.index()]).sum();
        self.drawn = Drawn { members: instances.len(), triangles };
        self.renderer.draw(&self.scene, &instances)?;
        Ok(self.renderer.read_image()?)
    }
}

/// A crowd to be built for the OpenGL of a renderer, where there is one.
pub(crate) fn drawn_with(
    builder: CrowdBuilder,
    renderer: &Result<Renderer, populace_render::Error>,
) -> CrowdBuilder {
    match renderer {
        Ok(renderer) => builder.for_gl(renderer.gl_context()),
        Err(_) => builder,
    }
}

/// The devices of a crowd by name, and the share of each where there are several.
pub(crate) fn devices_and_shares(crowd: &Crowd) -> String {
    let (devices, shares) = (crowd.devices().as_slice(), crowd.shares());
    match devices {
        [only] => only.to_string(),
        _ => {
            let part = |(device, share)| format!("{device} ({:.0} %)", share * 100.0);
            devices.iter().zip(shares).map(part).collect::<Vec<_>>().join(" + ")
        }
    }
}
