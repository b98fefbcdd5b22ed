//! Renders pictures of a crowd.

use populace::character::{Image, Part};
use populace::interop::PaletteTransport;
use populace::{Crowd, CrowdBuilder};
use populace_render::{Camera, CharacterHandle, Instance, PaletteInterop, Renderer, Scene};

use crate::failure::Failure;
use crate::roles::CrowdRole;

/// A renderer with a crowd's characters loaded.
pub(crate) struct CrowdRenderer {
    renderer: Renderer,
    handles: Vec<CharacterHandle>,
    /// Number of visible triangles of each character.
    triangles: Vec<usize>,
    scene: Scene,
    interop: PaletteInterop,
    stats: DrawStats,
}

/// Statistics of a picture.
#[derive(Clone, Copy, Default)]
pub(crate) struct DrawStats {
    pub(crate) members: usize,
    pub(crate) triangles: usize,
}

impl CrowdRenderer {
    /// Links the crowd's palettes to the renderer. `crowd` should be built by [`builder_for`] with
    /// the same renderer.
    pub(crate) fn new(
        mut renderer: Renderer,
        crowd: &mut Crowd,
        roles: &[CrowdRole],
        hide: &[String],
        camera: Camera,
    ) -> Result<Self, Failure> {
        let interop = renderer.connect_palettes(crowd)?;
        let hidden = |part: &Part| hide.contains(&part.node_name);
        let handles = roles.iter().map(|role| renderer.add_character(&role.character, &hidden));
        let handles = handles.collect::<Result<_, _>>()?;
        let triangles = |role: &CrowdRole| {
            let shown = role.character.parts.iter().filter(|part| !hidden(part));
            shown.map(|part| part.mesh.indices.len() / 3).sum()
        };
        let triangles = roles.iter().map(triangles).collect();
        let scene = Scene { camera, ..Scene::default() };
        Ok(Self { renderer, handles, triangles, scene, interop, stats: DrawStats::default() })
    }

    /// Returns the name of the OpenGL driver.
    pub(crate) fn driver(&self) -> &str {
        self.renderer.driver()
    }

    /// Returns the transport of palettes to OpenGL.
    pub(crate) fn palette_transport(&self) -> PaletteTransport {
        self.interop.transport
    }

    /// Returns statistics of the last picture.
    pub(crate) fn stats(&self) -> DrawStats {
        self.stats
    }

    /// Draws the crowd in the state of its last update.
    pub(crate) fn picture(&mut self, crowd: &mut Crowd) -> Result<Image, Failure> {
        self.renderer.acquire_palettes(crowd)?;
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
        self.stats = DrawStats { members: instances.len(), triangles };
        self.renderer.draw(&self.scene, &instances)?;
        Ok(self.renderer.read_image()?)
    }
}

/// Prepares a crowd builder for the OpenGL context of a renderer, if there is one.
pub(crate) fn builder_for(
    builder: CrowdBuilder,
    renderer: &Result<Renderer, populace_render::Error>,
) -> CrowdBuilder {
    match renderer {
        Ok(renderer) => builder.for_gl(renderer.gl_context()),
        Err(_) => builder,
    }
}

/// Names the devices of a crowd, with the load share of each if there are several.
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
