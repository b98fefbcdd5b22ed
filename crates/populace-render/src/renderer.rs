//! Draws a crowd: the sun's depth map, then members, ground and sky.

use std::rc::Rc;
use std::sync::Arc;

use glam::{Mat4, Vec3};
use populace_character::{Character, Image, Part};
use populace_device::layout::Float4;
use populace_device::{GlContext, PaletteSource};

use crate::batch::{Batches, CharacterFacts, Run};
use crate::gl::{
    Buffer, BufferUse, Cull, DrawRange, DrawState, Gl, PictureTarget, ShadowTarget, VertexArray,
};
use crate::layout::{Frame, Influences4, Influences8, InstanceData};
use crate::model::{Alpha, Model, ModelPart, Skin};
use crate::palettes::{HandOver, Palettes};
use crate::programs::{Kind, Programs};
use crate::sun::{Ball, SunView};
use crate::{CharacterHandle, Error, Ground, Instance, Scene};

/// Texels along each side of the sun's depth map, at least and at most.
const SHADOW_SIZES: [u32; 2] = [1024, 4096];
const PALETTE_BINDING: u32 = 0;
const TEXTURE_UNIT: u32 = 0;
const SHADOW_UNIT: u32 = 1;

/// Draws crowds into a picture in memory.
///
/// A renderer belongs to the thread that made it. Several can be used in turn on one thread.
pub struct Renderer {
    size: [u32; 2],
    picture: PictureTarget,
    shadow: Option<ShadowTarget>,
    programs: Programs,
    skin4: VertexArray,
    skin8: VertexArray,
    no_attributes: VertexArray,
    palettes: Palettes,
    models: Vec<Model>,
    instances: Buffer<InstanceData>,
    frame: Buffer<Frame>,
    gl: Rc<Gl>,
}

/// Where members are drawn into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pass {
    Shadow,
    Opaque,
    Blended,
}

impl Renderer {
    /// Opens OpenGL without a window, for pictures of `size` pixels, width before height.
    ///
    /// # Errors
    ///
    /// [`Error::NoGl`] says what was tried and what to install; [`Error::EmptyPicture`] and
    /// [`Error::TooLarge`] name a size that cannot be had.
    pub fn headless(size: [u32; 2]) -> Result<Self, Error> {
        let gl = Gl::headless()?;
        Ok(Self {
            size,
            picture: PictureTarget::new(&gl, size)?,
            shadow: None,
            programs: Programs::new(&gl),
            skin4: VertexArray::skinned::<Influences4>(&gl)?,
            skin8: VertexArray::skinned::<Influences8>(&gl)?,
            no_attributes: VertexArray::empty(&gl)?,
            palettes: Palettes::default(),
            models: Vec::new(),
            instances: Buffer::new(&gl, BufferUse::Stream)?,
            frame: Buffer::new(&gl, BufferUse::Stream)?,
            gl,
        })
    }

    /// The driver's name and version, for people.
    #[must_use]
    pub fn driver(&self) -> &str {
        self.gl.driver()
    }

    /// Width and height of the picture in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Uploads a character's meshes and textures, but for the parts for which `hide` is true.
    ///
    /// # Errors
    ///
    /// A texture or mesh past the driver's limits, or no room for it.
    pub fn add_character(
        &mut self,
        character: &Character,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<CharacterHandle, Error> {
        self.gl.make_current()?;
        self.models.push(Model::new(&self.gl, character, hide)?);
        Ok(CharacterHandle(self.models.len() - 1))
    }

    /// The context of OpenGL's, for a device that is to write its memory: see
    /// [`PaletteTransport::Shared`](populace_device::PaletteTransport::Shared).
    #[must_use]
    pub fn gl_context(&self) -> Arc<dyn GlContext> {
        self.gl.context()
    }

    /// Lends a crowd memory of OpenGL's for its palettes, in the best way that works, and says
    /// which and why not a better one. [`take_palettes`](Self::take_palettes) does this by itself
    /// where it was not done before; a crowd that is lent memory before its first frame saves one
    /// copy.
    ///
    /// The crowd can outlive the renderer, and the other way round. A crowd writes for one renderer
    /// at a time: the one that lent last.
    ///
    /// # Errors
    ///
    /// A failing device or driver. That a way is not to be had is no error while there is another.
    pub fn link_palettes(&mut self, source: &mut dyn PaletteSource) -> Result<HandOver, Error> {
        self.gl.make_current()?;
        self.palettes.link(&self.gl, source)
    }

    /// Takes the palettes of a crowd's last frame for the draws to come, in place of all others.
    /// Waits until the device has written them, and until the draws before the last call are done,
    /// since the crowd's next frame goes where those read. Without memory of OpenGL's, palettes are
    /// copied.
    ///
    /// # Errors
    ///
    /// A failing device or driver, or pages past the driver's limits.
    pub fn take_palettes(&mut self, source: &mut dyn PaletteSource) -> Result<(), Error> {
        self.gl.make_current()?;
        self.palettes.take(&self.gl, source)
    }

    /// Replaces a page of palettes: three elements for each palette entry, from the page's first,
    /// as [`PaletteSource::with_page`] hands them out.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past the limits of [`layout`](populace_device::layout) or of the driver,
    /// [`Error::PartialMatrix`] where the last entry is cut off, or no room for it.
    pub fn upload_page(&mut self, page: usize, palette: &[Float4]) -> Result<(), Error> {
        self.gl.make_current()?;
        self.palettes.upload(&self.gl, page, palette)
    }

    /// Draws the scene with these members into the picture.
    ///
    /// Members whose transform or tint is not finite are left out.
    ///
    /// # Errors
    ///
    /// A camera or scene that is no such thing, an instance of an unknown character or of a palette
    /// that was not uploaded, a shader that the driver refuses, or a failing driver.
    pub fn draw(&mut self, scene: &Scene, instances: &[Instance]) -> Result<(), Error> {
        scene.check()?;
        #[expect(clippy::cast_precision_loss, reason = "no picture is 2^24 pixels wide")]
        let aspect = self.size[0] as f32 / self.size[1] as f32;
        let clip_from_world = scene.camera.clip_from_world(aspect)?;
        let facts: Vec<CharacterFacts> = self.models.iter().map(|model| model.facts).collect();
        let page_len = |page: usize| self.palettes.entries(page);
        let batches = Batches::new(instances, &facts, &page_len, Vec3::from(scene.camera.eye))?;
        self.gl.make_current()?;
        self.instances.fill(&batches.instances, "upload the crowd's places")?;
        let sun = self.sun_view(scene, instances, clip_from_world)?;
        self.frame.fill(&[frame(scene, clip_from_world, sun)], "upload the scene")?;
        self.frame.bind_uniform();
        if let (Some(_), Some(shadow)) = (sun, &self.shadow) {
            shadow.begin();
            self.draw_runs(&batches.opaque, Pass::Shadow)?;
        }
        if let Some(shadow) = &self.shadow {
            shadow.bind_texture(SHADOW_UNIT);
        }
        self.picture.begin();
        self.draw_runs(&batches.opaque, Pass::Opaque)?;
        self.draw_surroundings(scene.ground)?;
        self.draw_runs(&batches.blended, Pass::Blended)?;
        self.palettes.drawn(&self.gl)?;
        self.gl.check("draw the crowd")
    }

    /// Reads the picture that was drawn last, sRGB, rows from the top; waits until it is done.
    ///
    /// # Errors
    ///
    /// A failing driver.
    pub fn read_image(&mut self) -> Result<Image, Error> {
        self.gl.make_current()?;
        self.picture.read()
    }

    /// Makes the depth map if shadows are wanted, and finds what it covers.
    fn sun_view(
        &mut self,
        scene: &Scene,
        instances: &[Instance],
        clip_from_world: Mat4,
    ) -> Result<Option<SunView>, Error> {
        if !scene.sun.casts_shadows {
            return Ok(None);
        }
        let shadow = match &mut self.shadow {
            Some(shadow) => shadow,
            empty => empty.insert(ShadowTarget::new(&self.gl, shadow_size(self.size))?),
        };
        let balls: Vec<Ball> = instances.iter().filter_map(|i| ball(&self.models, i)).collect();
        let to_sun = Vec3::from(scene.sun.to_sun).normalize();
        let eye = Vec3::from(scene.camera.eye);
        Ok(SunView::over(&balls, eye, clip_from_world, to_sun, shadow.size()))
    }

    fn draw_runs(&mut self, runs: &[Run], pass: Pass) -> Result<(), Error> {
        for run in runs {
            self.palettes.bind(run.page, PALETTE_BINDING);
            for part in &self.models[run.character].parts {
                let eight_influences = matches!(part.skin, Skin::Eight(_));
                let alpha = part.alpha;
                if (alpha == Alpha::Blended) != (pass == Pass::Blended) {
                    continue;
                }
                let kind = match pass {
                    Pass::Shadow => Kind::Shadow { eight_influences, alpha },
                    Pass::Opaque | Pass::Blended => Kind::Member { eight_influences, alpha },
                };
                self.programs.get(kind)?.bind();
                self.gl.set_state(state(pass, part.cull(run.mirrored)));
                part.surface.bind_uniform();
                part.texture.bind(TEXTURE_UNIT);
                match &part.skin {
                    Skin::Four(influences) => {
                        self.skin4.draw(&range(part, influences, &self.instances, run))
                    }
                    Skin::Eight(influences) => {
                        self.skin8.draw(&range(part, influences, &self.instances, run))
                    }
                }
            }
        }
        Ok(())
    }

    /// The ground goes behind members by a hair, so that soles at y = 0 show; both come after them,
    /// which saves shading what they hide.
    fn draw_surroundings(&mut self, ground: Option<Ground>) -> Result<(), Error> {
        let surroundings = DrawState { cull: Cull::Nothing, ..DrawState::OPAQUE };
        if ground.is_some() {
            self.gl.set_state(DrawState { depth_offset: [1.0, 1.0], ..surroundings });
            self.gl.draw_strip(self.programs.get(Kind::Ground)?, &self.no_attributes, 4);
        }
        self.gl.set_state(DrawState { depth_write: false, ..surroundings });
        self.gl.draw_strip(self.programs.get(Kind::Sky)?, &self.no_attributes, 4);
        Ok(())
    }
}

/// As fine as the picture, and half as fine again since the map's texels lie askew to its pixels.
fn shadow_size([width, height]: [u32; 2]) -> u32 {
    let [low, high] = SHADOW_SIZES;
    (width.max(height).min(high) * 3 / 2).next_power_of_two().clamp(low, high)
}

fn range<'a, I>(
    part: &'a ModelPart,
    influences: &'a Buffer<I>,
    instances: &'a Buffer<InstanceData>,
    run: &Run,
) -> DrawRange<'a, I> {
    DrawRange {
        vertices: &part.vertices,
        influences,
        indices: &part.indices,
        instances,
        first_instance: run.first,
        instance_count: run.count,
    }
}

fn state(pass: Pass, cull: Cull) -> DrawState {
    match pass {
        Pass::Shadow => {
            DrawState { cull, depth_offset: [1.5, 2.0], depth_clamp: true, ..DrawState::OPAQUE }
        }
        Pass::Opaque => DrawState { cull, ..DrawState::OPAQUE },
        Pass::Blended => DrawState { cull, blend: true, depth_write: false, ..DrawState::OPAQUE },
    }
}

/// The ball around an instance; `None` where its transform is not finite.
fn ball(models: &[Model], instance: &Instance) -> Option<Ball> {
    let (middle, radius) = models.get(instance.character.0)?.ball;
    let world = &instance.world_from_model;
    let column = |c: usize| Vec3::from(world.rows.map(|row| row[c])).length();
    let radius = radius * column(0).max(column(1)).max(column(2));
    let middle = Vec3::from(world.transform_point(middle.to_array())) + Vec3::from(instance.moved);
    (middle.is_finite() && radius.is_finite()).then_some(Ball { middle, radius })
}

fn frame(scene: &Scene, clip_from_world: Mat4, sun: Option<SunView>) -> Frame {
    let color = |[r, g, b]: [f32; 3]| Float4([r, g, b, 1.0]);
    let with = |[x, y, z]: [f32; 3], w| Float4([x, y, z, w]);
    let to_sun = Vec3::from(scene.sun.to_sun).normalize().to_array();
    Frame {
        clip_from_world: clip_from_world.into(),
        world_from_clip: clip_from_world.inverse().into(),
        shadow_from_world: sun.map_or(Mat4::IDENTITY, |s| s.shadow_from_world).into(),
        eye: with(scene.camera.eye, scene.camera.far),
        to_sun: with(to_sun, sun.map_or(0.0, |s| s.texel_m)),
        sun_color: with(scene.sun.color, scene.highlights.knee()),
        sky_light: color(scene.ambient.sky),
        ground_light: color(scene.ambient.ground),
        zenith_color: color(scene.sky.zenith),
        horizon_color: color(scene.sky.horizon),
        ground_color: color(scene.ground.map_or([0.0; 3], |g| g.color)),
        line_color: color(scene.ground.map_or([0.0; 3], |g| g.line_color)),
    }
}

#[cfg(test)]
mod tests;
