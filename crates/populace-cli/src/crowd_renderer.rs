//! Renders pictures of a crowd.

use populace::character::{Image, Part};
use populace::interop::PaletteTransport;
use populace::{Crowd, CrowdBuilder, MemberId};
use populace_render::{Camera, Drawn, PassTimes, Renderer, Scene};

use crate::failure::Failure;
use crate::image_files::PixelFacts;
use crate::roles::CrowdRole;

/// A renderer that is connected to a crowd.
pub(crate) struct CrowdRenderer {
    renderer: Renderer,
    transport: PaletteTransport,
    drawn: Drawn,
}

impl CrowdRenderer {
    /// Links the crowd's palettes to the renderer. `crowd` should be built by [`builder_for`] with
    /// the same renderer.
    pub(crate) fn new(
        mut renderer: Renderer,
        crowd: &mut Crowd,
        roles: &[CrowdRole],
        hide: &[String],
    ) -> Result<Self, Failure> {
        let transport = connect(&mut renderer, crowd, roles, hide)?;
        Ok(Self { renderer, transport, drawn: Drawn::default() })
    }

    /// Returns the name of the OpenGL driver.
    pub(crate) fn driver(&self) -> &str {
        self.renderer.driver()
    }

    /// Returns the transport of palettes to OpenGL.
    pub(crate) fn palette_transport(&self) -> PaletteTransport {
        self.transport
    }

    /// Returns what the last picture shows.
    pub(crate) fn drawn(&self) -> Drawn {
        self.drawn
    }

    /// Returns how long the passes of the last picture took.
    pub(crate) fn pass_times(&self) -> Result<PassTimes, Failure> {
        Ok(self.renderer.pass_times()?)
    }

    /// Draws the crowd in the state of its last update.
    pub(crate) fn picture(
        &mut self,
        crowd: &mut Crowd,
        camera: &Camera,
        scene: &Scene,
    ) -> Result<Image, Failure> {
        self.drawn = self.renderer.draw(crowd, camera, scene)?;
        Ok(self.renderer.read_image()?)
    }
}

impl CrowdRenderer {
    /// Returns what the pixels of the last picture show. `person` returns the number of the person
    /// that a member is.
    pub(crate) fn pixel_facts(
        &mut self,
        crowd: &Crowd,
        camera: &Camera,
        scene: &Scene,
        person: &dyn Fn(MemberId) -> Option<u64>,
    ) -> Result<PixelFacts, Failure> {
        // Things in hands belong to the person who holds them.
        let holder = |of: &MemberId| Some(crowd.member(*of).ok()?.attached_to()?.0);
        let whose = |member| std::iter::successors(Some(member), holder).find_map(person);
        // Instances are in the order of members.
        let people: Vec<_> = crowd.members().map(|member| whose(member.id())).collect();
        let covers = |index: u32| people.get(index as usize).is_some_and(Option::is_some);
        let marks = self.renderer.read_marks(camera, scene, &covers)?;
        Ok(PixelFacts { marks, people })
    }
}

/// Links a crowd's palettes to a renderer, and uploads its characters without the parts of nodes in
/// `hide`. Returns the transport of palettes.
pub(crate) fn connect(
    renderer: &mut Renderer,
    crowd: &mut Crowd,
    roles: &[CrowdRole],
    hide: &[String],
) -> Result<PaletteTransport, Failure> {
    let transport = renderer.connect_palettes(crowd)?.transport;
    let hidden = |part: &Part| hide.contains(&part.node_name);
    for role in roles {
        renderer.upload_character(&role.character, &hidden)?;
    }
    Ok(transport)
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
    let info = crowd.device_info();
    let (devices, shares) = (info.devices.as_slice(), info.shares);
    match devices {
        [only] => only.to_string(),
        _ => {
            let part = |(device, share)| format!("{device} ({:.0} %)", share * 100.0);
            devices.iter().zip(shares).map(part).collect::<Vec<_>>().join(" + ")
        }
    }
}
