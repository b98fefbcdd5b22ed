//! The renderer: shadow map, members, ground and sky of one frame.

mod calls;
mod constants;
pub(crate) mod interface;
pub(crate) mod marks;
pub(crate) mod passes;

use std::rc::Rc;
use std::sync::Arc;

use glam::{Mat4, Vec3};
use populace_character::{Character, Image, Part};
use populace_device::{DrawSource, GlContext, Instance, PaletteSource, Visibility};
use rayon::prelude::*;

use self::constants::{bounding_sphere, frame, pixel_m, sides};
use self::interface::Interface;
use crate::batch::{Batches, Caster, Drawn, Instances, ModelInfo};
use crate::gl::{
    Buffer, BufferUse, ContactTarget, DrawCommands, Gl, MarkTarget, PictureTarget, ShadowTarget,
    Timers, VertexArray, WindowTarget,
};
use crate::layout::{Frame, InstanceData};
use crate::models::Models;
use crate::palettes::{PaletteInterop, Palettes};
use crate::programs::Programs;
use crate::sun::{Sphere, SunView};
use crate::{Camera, Error, Scene};

/// Smallest and largest side of the shadow map in texels.
const SHADOW_SIZES: [u32; 2] = [1024, 4096];
/// Least error in metres with which a coarser level throws a shadow. The error of a level is
/// measured at rest; where a pose adds to it, the level would shade the surface that is seen.
const LEAST_SHADOW_ERROR_M: f32 = 0.01;

/// An OpenGL renderer that draws crowds into a picture in memory, and from there into a window if
/// it has one.
///
/// A renderer is bound to the thread that created it. One thread can use several renderers in turn.
pub struct Renderer {
    size: [u32; 2],
    picture: PictureTarget,
    shadow: Option<ShadowTarget>,
    contact_map: Option<ContactTarget>,
    programs: Programs,
    no_attributes: VertexArray,
    palettes: Palettes,
    models: Models,
    instances: Buffer<InstanceData>,
    commands: DrawCommands,
    frame: Buffer<Frame>,
    timers: Timers<3>,
    /// The instances in the last picture.
    last: Batches,
    /// Created on first use.
    marks: Option<MarkTarget>,
    /// What a window shows besides the picture; created on first use.
    interface: Option<Interface>,
    gl: Rc<Gl>,
}

impl Renderer {
    /// Creates a renderer without a window, for pictures of `size` pixels (width, height).
    ///
    /// # Errors
    ///
    /// [`Error::NoGl`] with the attempts and the remedy if the machine has no usable OpenGL;
    /// [`Error::EmptyPicture`] or [`Error::TooLarge`] for a size out of range; other errors if the
    /// driver fails.
    pub fn headless(size: [u32; 2]) -> Result<Self, Error> {
        Self::of(Gl::headless()?, size)
    }

    /// Creates a renderer for a window, with pictures of `size` pixels (width, height). It keeps
    /// the window as long as it needs it.
    ///
    /// [`draw`](Self::draw) draws the picture, [`compose`](Self::compose) brings it and a user
    /// interface into the window, and [`present`](Self::present) shows the window.
    ///
    /// # Errors
    ///
    /// As for [`headless`](Self::headless). Windows of X11 (by Xlib) and of Wayland are known.
    pub fn in_window(window: Arc<dyn WindowTarget>, size: [u32; 2]) -> Result<Self, Error> {
        Self::of(Gl::in_window(window, size)?, size)
    }

    fn of(gl: Rc<Gl>, size: [u32; 2]) -> Result<Self, Error> {
        Ok(Self {
            size,
            picture: PictureTarget::new(&gl, size)?,
            shadow: None,
            contact_map: None,
            programs: Programs::new(&gl),
            no_attributes: VertexArray::empty(&gl)?,
            palettes: Palettes::default(),
            models: Models::new(&gl)?,
            instances: Buffer::new(&gl, BufferUse::Stream)?,
            commands: DrawCommands::new(&gl)?,
            frame: Buffer::new(&gl, BufferUse::Stream)?,
            timers: Timers::new(&gl)?,
            last: Batches::default(),
            marks: None,
            interface: None,
            gl,
        })
    }

    /// Changes the size of pictures, in pixels (width, height). The picture is lost.
    ///
    /// # Errors
    ///
    /// [`Error::EmptyPicture`] or [`Error::TooLarge`] for a size out of range, and errors of the
    /// driver; the old size stays then.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), Error> {
        self.gl.make_current()?;
        self.picture = PictureTarget::new(&self.gl, size)?;
        (self.size, self.marks, self.contact_map) = (size, None, None);
        self.last = Batches::default();
        if self.shadow.as_ref().is_some_and(|map| u32::from(map.size()) != shadow_size(size)) {
            self.shadow = None;
        }
        Ok(())
    }

    /// Returns width and height of pictures in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the driver's name and version, for display.
    #[must_use]
    pub fn driver(&self) -> &str {
        self.gl.driver()
    }

    /// Uploads a character's meshes and textures, without the parts for which `hide` returns true.
    /// It is drawn that way until it is uploaded again.
    ///
    /// A character that is drawn without this call is uploaded whole when it is first seen. Once
    /// nothing holds the character any more, its textures are released, and the memory of its
    /// meshes is used again.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] for a texture or mesh above the driver's limits;
    /// [`Error::OutOfMemory`] or [`Error::GlError`] if the driver fails.
    pub fn upload_character(
        &mut self,
        character: &Arc<Character>,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<(), Error> {
        self.gl.make_current()?;
        self.models.upload(&self.gl, character, hide).map(|_| ())
    }

    /// Returns the OpenGL context. A device created for it can write OpenGL buffers: see
    /// [`PaletteTransport::Shared`](populace_device::PaletteTransport::Shared).
    #[must_use]
    pub fn gl_context(&self) -> Arc<dyn GlContext> {
        self.gl.context()
    }

    /// Connects a crowd to this renderer by the best transport that works: the crowd's device
    /// writes its palettes into OpenGL buffers, or they are copied each frame. Returns the
    /// transport, and the reasons against better ones.
    ///
    /// [`draw`](Self::draw) connects a crowd that is not connected. Calling this function before
    /// the crowd's first frame saves one copy.
    ///
    /// Crowd and renderer can be dropped in any order. A crowd is connected to one renderer at a
    /// time, the last one that called this function.
    ///
    /// # Errors
    ///
    /// [`Error::NoTransport`] if no transport works, and errors of the device or driver in the last
    /// resort, the copy. The failure of a better transport is not an error.
    pub fn connect_palettes(
        &mut self,
        source: &mut dyn PaletteSource,
    ) -> Result<PaletteInterop, Error> {
        self.gl.make_current()?;
        self.palettes.connect(&self.gl, source)
    }

    /// Draws a crowd in the state of its last update into the picture. Does not wait for the
    /// result.
    ///
    /// Characters that were not drawn before are uploaded. The crowd's palettes are acquired, as
    /// [`acquire_palettes`](Self::acquire_palettes) says, and all of its instances are drawn.
    ///
    /// # Errors
    ///
    /// As for [`upload_character`](Self::upload_character),
    /// [`acquire_palettes`](Self::acquire_palettes) and
    /// [`draw_instances`](Self::draw_instances).
    pub fn draw(
        &mut self,
        crowd: &mut dyn DrawSource,
        camera: &Camera,
        scene: &Scene,
    ) -> Result<Drawn, Error> {
        self.draw_crowds(&mut [crowd], camera, scene)
    }

    /// Draws several crowds into one picture, each as [`draw`](Self::draw) does.
    ///
    /// # Errors
    ///
    /// As for [`draw`](Self::draw), and [`Error::TooLarge`] if the crowds together have more than
    /// 2^32 palette entries.
    pub fn draw_crowds(
        &mut self,
        crowds: &mut [&mut dyn DrawSource],
        camera: &Camera,
        scene: &Scene,
    ) -> Result<Drawn, Error> {
        self.gl.make_current()?;
        self.clear_palettes();
        let mut first_entries = Vec::with_capacity(crowds.len());
        for crowd in crowds.iter_mut() {
            first_entries.push(self.palettes.acquire(&self.gl, &mut **crowd)?);
        }
        let mut instances = Vec::new();
        for (crowd, first) in crowds.iter().zip(first_entries) {
            let mut own = crowd.instances();
            for instance in &mut own {
                instance.palette_first = instance.palette_first.saturating_add(first);
            }
            if instances.is_empty() {
                instances = own;
            } else {
                instances.append(&mut own);
            }
        }
        self.draw_instances(&instances, camera, scene)
    }

    /// Acquires the palettes of a crowd's last frame for the following calls of
    /// [`draw_instances`](Self::draw_instances). They replace all others.
    ///
    /// Waits until the device has written the palettes. Also waits for the draws from the previous
    /// frame's palettes, since the crowd writes its next frame into the same buffers. Copies the
    /// palettes if the crowd's device cannot write OpenGL buffers.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] for pages above the limits of [`layout`](populace_device::layout) or of
    /// the driver, [`Error::PartialMatrix`] if a page ends inside a matrix, and errors of the
    /// device or driver.
    pub fn acquire_palettes(&mut self, source: &mut dyn PaletteSource) -> Result<(), Error> {
        self.gl.make_current()?;
        self.clear_palettes();
        self.palettes.acquire(&self.gl, source).map(|_| ())
    }

    /// Gives up all palettes, and with them the instances that are drawn from their pages.
    fn clear_palettes(&mut self) {
        self.palettes.clear();
        self.last = Batches::default();
    }

    /// Draws `instances` from the palettes that were last acquired, for callers who choose, place
    /// or tint instances themselves. Does not wait for the result.
    ///
    /// Instances with a non-finite transform are skipped.
    ///
    /// # Errors
    ///
    /// [`Error::BadCamera`] or [`Error::BadScene`] for invalid settings, [`Error::NoPalette`] for
    /// an instance without palette, those of [`upload_character`](Self::upload_character) for a
    /// character that was not drawn before, [`Error::Shader`] if the driver rejects a shader, and
    /// other errors if the driver fails.
    pub fn draw_instances(
        &mut self,
        instances: &[Instance<'_>],
        camera: &Camera,
        scene: &Scene,
    ) -> Result<Drawn, Error> {
        // They would name models that may be gone, if this fails.
        self.last = Batches::default();
        scene.check()?;
        let [wide, high] = sides(self.size);
        let clip_from_world = camera.clip_from_world(wide / high)?;
        self.gl.make_current()?;
        let models = self.models_of(instances)?;
        let infos: Vec<&ModelInfo> = self.models.as_slice().iter().map(|m| &m.info).collect();
        let spheres = spheres(instances, &models, &infos, scene);
        let casting: Vec<Sphere> = spheres.iter().flatten().copied().collect();
        let shadow = shadow_map(&self.gl, &mut self.shadow, self.size, scene)?;
        let eye = (Vec3::from(camera.eye), pixel_m(clip_from_world, self.size));
        let sun = shadow.and_then(|map| sun_view(map, scene, &casting, eye, clip_from_world));
        let caster = |index: usize| {
            let (sun, info, instance) = (sun?, infos[models[index]], &instances[index]);
            let (_, model_radius) = info.sphere;
            let sphere = spheres[index].filter(|sphere| sun.covers(sphere))?;
            let scale = if model_radius > 0.0 { sphere.radius / model_radius } else { 1.0 };
            let in_texels_m = scene.sun.error_texels * sun.texel_m;
            let in_pixels_m = scene.sun.error_px * eye.1 * sphere.center.distance(eye.0);
            let error_m = in_texels_m.max(in_pixels_m);
            let is_trusted = error_m >= LEAST_SHADOW_ERROR_M;
            let coarsest = if is_trusted { info.level_within(error_m / scale) } else { 0 };
            // The mesh that is seen throws no false shadow on itself.
            let seen = info.level(instance.level);
            let level = coarsest.max(seen);
            let apart_m = if level > seen { scale * info.level_error_m(level) } else { 0.0 };
            Some(Caster { level, apart_m })
        };
        let casters: Vec<_> = (0..instances.len()).into_par_iter().map(caster).collect();
        let batches = Batches::new(&Instances {
            all: instances,
            models: &models,
            infos: &infos,
            page_lengths: &self.palettes.lengths(),
            casters: &casters,
            eye: Vec3::from(camera.eye),
        })?;
        self.instances.fill(&batches.instances, "upload the instances")?;
        let mut drawn = Drawn::default();
        let frame = frame(camera, scene, clip_from_world, sun, self.size);
        self.frame.fill(&[frame], "upload the scene")?;
        self.frame.bind_uniform();
        self.draw_passes(&batches, sun.is_some(), scene, &mut drawn)?;
        self.palettes.fence_draws(&self.gl)?;
        self.gl.check("draw the crowd")?;
        self.last = batches;
        Ok(drawn)
    }

    /// Reads back the last picture: sRGB, top row first. Waits until it is drawn.
    ///
    /// # Errors
    ///
    /// Errors of the driver.
    pub fn read_image(&mut self) -> Result<Image, Error> {
        self.gl.make_current()?;
        self.picture.read()
    }

    /// Returns the index of each instance's model, uploads characters that are new, and releases
    /// those that are gone.
    fn models_of(&mut self, instances: &[Instance<'_>]) -> Result<Vec<usize>, Error> {
        self.models.release_unused();
        let known = self.models.known();
        let found: Option<Vec<usize>> =
            instances.par_iter().map(|i| known.find(i.character)).collect();
        match found {
            Some(models) => Ok(models),
            None => instances.iter().map(|i| self.models.index_of(&self.gl, i.character)).collect(),
        }
    }
}

/// Creates the shadow map on first use. Returns `None` if the sun casts no shadows.
fn shadow_map<'a>(
    gl: &Rc<Gl>,
    map: &'a mut Option<ShadowTarget>,
    size: [u32; 2],
    scene: &Scene,
) -> Result<Option<&'a ShadowTarget>, Error> {
    if !scene.sun.casts_shadows {
        return Ok(None);
    }
    Ok(Some(match map {
        Some(map) => map,
        empty => empty.insert(ShadowTarget::new(gl, shadow_size(size))?),
    }))
}

/// Returns the projection of the shadow map; `None` if no shadow could reach the picture.
fn sun_view(
    map: &ShadowTarget,
    scene: &Scene,
    spheres: &[Sphere],
    eye: (Vec3, f32),
    clip_from_world: Mat4,
) -> Option<SunView> {
    let to_sun = Vec3::from(scene.sun.to_sun).normalize();
    SunView::over(spheres, eye, clip_from_world, to_sun, map.size())
}

/// Returns the bounding sphere at rest of each instance that is not hidden; empty without shadows.
fn spheres(
    instances: &[Instance<'_>],
    models: &[usize],
    infos: &[&ModelInfo],
    scene: &Scene,
) -> Vec<Option<Sphere>> {
    if !scene.sun.casts_shadows {
        return Vec::new();
    }
    let sphere = |(instance, model): (&Instance<'_>, &usize)| {
        let shown = instance.visibility != Visibility::Hidden;
        shown.then(|| bounding_sphere(infos[*model], instance)).flatten()
    };
    instances.par_iter().zip(models).map(sphere).collect()
}

/// Returns the side of the shadow map in texels: 1.5 times the larger side of the picture, since
/// texels and pixels are not aligned, rounded up to a power of two.
fn shadow_size([width, height]: [u32; 2]) -> u32 {
    let [low, high] = SHADOW_SIZES;
    (width.max(height).min(high) * 3 / 2).next_power_of_two().clamp(low, high)
}

#[cfg(test)]
mod tests;
