//! The passes of a picture: members in the shadow map and in the picture, and what surrounds them.

use std::ops::Range;

use super::Renderer;
use super::calls::{Call, Pass, calls, contact_calls};
use crate::batch::{Batches, Drawn, PassCounts, Run};
use crate::gl::{ContactTarget, Cull, DrawState, ShadowTarget};
use crate::programs::Kind;
use crate::{Error, Scene};

const TEXTURE_UNIT: u32 = 0;
const SHADOW_UNIT: u32 = 1;
pub(super) const MEMBER_UNIT: u32 = 2;
const PALETTE_UNIT: u32 = 7;
const CONTACT_UNIT: u32 = 8;

/// Milliseconds that the graphics device took for the passes of a picture, by its own timers.
///
/// llvmpipe draws into a target once the target is no longer bound, so it counts the last map of
/// shadows with the members.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// Members in the shadow map, and contact shadows; 0 without either.
    pub shadow_ms: f64,
    /// Members in the picture.
    pub members_ms: f64,
    /// Ground and sky, and the members' samples brought over them.
    pub surroundings_ms: f64,
}

/// Index of a pass among the timers.
const SHADOW_PASS: usize = 0;
const MEMBER_PASS: usize = 1;
const SURROUNDINGS_PASS: usize = 2;

impl Renderer {
    /// Returns how long the passes of the last picture took. Waits until it is drawn.
    ///
    /// # Errors
    ///
    /// Errors of the driver.
    pub fn pass_times(&self) -> Result<PassTimes, Error> {
        self.gl.make_current()?;
        let ms = self.timers.ms();
        self.gl.check("read the timers")?;
        Ok(PassTimes {
            shadow_ms: ms[SHADOW_PASS],
            members_ms: ms[MEMBER_PASS],
            surroundings_ms: ms[SURROUNDINGS_PASS],
        })
    }

    /// Draws shadows, if there are any, then the members into the picture, and then what surrounds
    /// them.
    pub(super) fn draw_passes(
        &mut self,
        batches: &Batches,
        shadows: bool,
        scene: &Scene,
        drawn: &mut Drawn,
    ) -> Result<(), Error> {
        self.timers.clear();
        let contacts = Contacts::of(scene);
        let on_members = contacts == Contacts::OnMembers;
        let (models, commands) = (self.models.as_slice(), &mut self.commands);
        commands.clear();
        let shadow = calls(&batches.shadow, Pass::Shadow, models, commands);
        let opaque = calls(&batches.opaque, Pass::Opaque { on_members }, models, commands);
        let blended = calls(&batches.blended, Pass::Blended, models, commands);
        let contact = match contacts {
            Contacts::None => Vec::new(),
            _ => contact_calls(&batches.opaque, models, commands),
        };
        commands.upload()?;
        self.timed(SHADOW_PASS, |renderer| {
            if shadows {
                renderer.shadow.iter().for_each(ShadowTarget::begin);
                renderer.draw_calls(&shadow, Pass::Shadow, &mut drawn.shadow)?;
            }
            if contacts == Contacts::None {
                return Ok(());
            }
            renderer.draw_contacts(&contact, &mut drawn.shadow)
        })?;
        if let Some(shadow) = &self.shadow {
            shadow.bind_texture(SHADOW_UNIT);
        }
        self.timed(MEMBER_PASS, |renderer| {
            renderer.begin_members()?;
            renderer.draw_calls(&opaque, Pass::Opaque { on_members }, &mut drawn.members)?;
            renderer.draw_calls(&blended, Pass::Blended, &mut drawn.members)
        })?;
        self.timed(SURROUNDINGS_PASS, |renderer| {
            renderer.draw_surroundings(scene, contacts, &mut drawn.surroundings)
        })?;
        let instances = |runs: &[Run]| runs.iter().map(|run| run.count as usize).sum();
        drawn.members.instances = instances(&batches.opaque);
        drawn.shadow.instances = instances(&batches.shadow);
        Ok(())
    }

    /// Makes the grid of samples the current framebuffer. Hides members outside of the picture.
    pub(super) fn begin_members(&mut self) -> Result<(), Error> {
        self.picture.begin();
        let unseen = DrawState { cull: Cull::Nothing, color_write: false, ..DrawState::OPAQUE };
        self.gl.set_state(unseen);
        self.gl.draw_strip(self.programs.get(Kind::Beyond)?, &self.no_attributes, 10);
        Ok(())
    }

    /// Draws a pass, and times it.
    fn timed(
        &mut self,
        pass: usize,
        draw: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.timers.begin(pass);
        let result = draw(self);
        self.timers.end();
        result
    }

    /// Draws calls, and counts them and their triangles.
    pub(super) fn draw_calls(
        &mut self,
        calls: &[Call],
        pass: Pass,
        counts: &mut PassCounts,
    ) -> Result<(), Error> {
        let most = self.gl.limits().handed_over;
        let mut waiting = 0;
        for call in calls {
            let [model, level, part] = call.part;
            let part = &self.models.as_slice()[model].levels[level].parts[part];
            self.palettes.bind(call.page, PALETTE_UNIT);
            self.programs.get(call.kind)?.bind();
            self.gl.set_state(state(pass, call.cull));
            part.surface.bind_uniform();
            if let Some(texture) = &part.texture {
                texture.bind(TEXTURE_UNIT);
            }
            part.bind_maps(call.kind.maps());
            let meshes = self.models.shared().skinned(part.influences);
            for (triangles, commands) in self.commands.shares(&call.commands, most) {
                waiting += triangles;
                if waiting > most {
                    self.gl.flush();
                    waiting = triangles;
                }
                meshes.draw(&self.commands, commands, &self.instances);
                counts.triangles += triangles;
                counts.draw_calls += 1;
            }
        }
        Ok(())
    }

    /// Draws sky and ground, and blends the members over them. Ground and sky have no edges that
    /// several samples per pixel would smooth, and one sample takes a fraction of the time.
    fn draw_surroundings(
        &mut self,
        scene: &Scene,
        contacts: Contacts,
        counts: &mut PassCounts,
    ) -> Result<(), Error> {
        let surroundings =
            DrawState { cull: Cull::Nothing, depth_write: false, ..DrawState::OPAQUE };
        self.picture.begin_resolve(MEMBER_UNIT, 1.0);
        self.gl.set_state(surroundings);
        self.gl.draw_strip(self.programs.get(Kind::Sky)?, &self.no_attributes, 4);
        // The sky, and the members that are blended over it.
        counts.draw_calls += 2;
        if scene.ground.is_some() {
            let ground = Kind::Ground { contacts: contacts == Contacts::OnGround };
            self.gl.draw_strip(self.programs.get(ground)?, &self.no_attributes, 4);
            counts.draw_calls += 1;
        }
        self.gl.set_state(DrawState { blend: true, ..surroundings });
        self.gl.draw_strip(self.programs.get(Kind::Resolve)?, &self.no_attributes, 4);
        Ok(())
    }
}

impl Renderer {
    /// Draws the contact map: the contact shadows of instances on the floor.
    fn draw_contacts(
        &mut self,
        calls: &[(usize, Range<usize>)],
        counts: &mut PassCounts,
    ) -> Result<(), Error> {
        let map = match &mut self.contact_map {
            Some(map) => map,
            empty => empty.insert(ContactTarget::new(&self.gl, self.picture.size())?),
        };
        map.begin();
        let state = DrawState { cull: Cull::Nothing, blend: true, ..DrawState::OPAQUE };
        self.gl.set_state(DrawState { depth_write: false, ..state });
        self.programs.get(Kind::Contact)?.bind();
        let meshes = &self.models.shared().contacts;
        for (page, commands) in calls {
            self.palettes.bind(*page, PALETTE_UNIT);
            meshes.draw(&self.commands, commands.clone(), &self.instances);
            counts.draw_calls += 1;
        }
        if let Some(map) = &self.contact_map {
            map.bind_texture(CONTACT_UNIT);
        }
        Ok(())
    }
}

/// The surface on which contact shadows lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contacts {
    None,
    /// The ground is as high as the floor.
    OnGround,
    /// The ground is elsewhere.
    OnMembers,
}

impl Contacts {
    pub(super) fn of(scene: &Scene) -> Self {
        match scene.ground {
            Some(_) if scene.contact_shadows == 0.0 => Self::None,
            Some(ground) if ground.height_m == scene.floor_m => Self::OnGround,
            Some(_) => Self::OnMembers,
            None => Self::None,
        }
    }
}

fn state(pass: Pass, cull: Cull) -> DrawState {
    match pass {
        Pass::Shadow => {
            DrawState { cull, depth_offset: [1.5, 2.0], depth_clamp: true, ..DrawState::OPAQUE }
        }
        Pass::Hiding { .. } => DrawState { cull, color_write: false, ..DrawState::OPAQUE },
        Pass::Opaque { .. } | Pass::Marks => DrawState { cull, ..DrawState::OPAQUE },
        Pass::Blended => DrawState { cull, blend: true, depth_write: false, ..DrawState::OPAQUE },
    }
}
