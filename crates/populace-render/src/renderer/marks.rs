//! Depth, instance and coverage of the pixels of a picture.

use glam::Vec3;
use populace_model::convert::u32_from;

use super::Renderer;
use super::calls::{Pass, calls};
use super::constants::sides;
use super::passes::{Contacts, MEMBER_UNIT};
use crate::batch::{PassCounts, Run};
use crate::gl::{Cull, DrawState, MarkTarget};
use crate::programs::Kind;
use crate::{Camera, Error, Scene};

/// Depth, instance and coverage of each pixel of a picture, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Marks {
    /// Distance along the view direction in metres, at the middle of the pixel, of the nearest
    /// instance or the ground; infinity where there is neither.
    pub depths_m: Vec<f32>,
    /// Index among the instances that were drawn, at the middle of the pixel; `None` where there is
    /// none. Blended surfaces count if they hide at least half of what is behind them, and members
    /// that fade count in a share of their pixels that is equal to their opacity.
    pub instances: Vec<Option<u32>>,
    /// Share of the pixel in 1/255 that those instances cover that count, as far as opaque surfaces
    /// of others do not hide them. Blended surfaces count by their alpha.
    pub coverage: Vec<u8>,
}

impl Renderer {
    /// Draws the instances of the last picture again, from its `camera` over the ground of its
    /// `scene`, and reads back what each pixel shows. `covers` returns true for the index of an
    /// instance that counts in the coverage, and false for one that does not, such as a place. No
    /// pixel shows an instance after a change of size, or once other palettes were acquired. The
    /// picture itself cannot be read after this call.
    ///
    /// # Errors
    ///
    /// [`Error::BadCamera`] for invalid settings, and others if the driver fails.
    pub fn read_marks(
        &mut self,
        camera: &Camera,
        scene: &Scene,
        covers: &dyn Fn(u32) -> bool,
    ) -> Result<Marks, Error> {
        self.gl.make_current()?;
        if !self.last.instances.iter().all(|instance| covers(instance.number())) {
            self.draw_covering(scene, covers)?;
        }
        let coverage = self.coverage()?;
        let pixels = self.draw_marks()?;
        let ground = Ground::new(camera, scene, self.size)?;
        let width = self.size[0] as usize;
        let depth_m = |(index, [bits, number]): (usize, &[u32; 2])| match number {
            0 => ground.depth_m([index % width, index / width]),
            _ => f32::from_bits(*bits),
        };
        Ok(Marks {
            depths_m: pixels.iter().enumerate().map(depth_m).collect(),
            instances: pixels.iter().map(|[_, number]| number.checked_sub(1)).collect(),
            coverage,
        })
    }

    /// Draws the instances that count into the picture, without those that do not. The latter hide
    /// the former where they are opaque.
    fn draw_covering(&mut self, scene: &Scene, covers: &dyn Fn(u32) -> bool) -> Result<(), Error> {
        let on_members = Contacts::of(scene) == Contacts::OnMembers;
        let (counting, hiding) = self.parts(&self.last.opaque, covers);
        let (blended, _) = self.parts(&self.last.blended, covers);
        let passes = [
            (hiding, Pass::Hiding { on_members }),
            (counting, Pass::Opaque { on_members }),
            (blended, Pass::Blended),
        ];
        self.commands.clear();
        let (models, commands) = (self.models.as_slice(), &mut self.commands);
        let passes = passes.map(|(runs, pass)| (calls(&runs, pass, models, commands), pass));
        self.commands.upload()?;
        self.frame.bind_uniform();
        self.begin_members()?;
        for (calls, pass) in &passes {
            self.draw_calls(calls, *pass, &mut PassCounts::default())?;
        }
        Ok(())
    }

    /// Returns the parts of runs whose instances count, and the other parts.
    fn parts(&self, runs: &[Run], covers: &dyn Fn(u32) -> bool) -> (Vec<Run>, Vec<Run>) {
        let counts = |index: u32| covers(self.last.instances[index as usize].number());
        let parts = runs.iter().flat_map(|run| {
            let all: Vec<u32> = (run.first..run.first + run.count).collect();
            let parts = all.chunk_by(|a, b| counts(*a) == counts(*b));
            let part = |of: &[u32]| Run { first: of[0], count: u32_from(of.len()), ..*run };
            parts.map(part).collect::<Vec<_>>()
        });
        parts.partition(|run| counts(run.first))
    }

    /// Draws the members' samples of the last picture over nothing, and returns their alpha.
    fn coverage(&mut self) -> Result<Vec<u8>, Error> {
        self.picture.begin_resolve(MEMBER_UNIT, 0.0);
        let state = DrawState { cull: Cull::Nothing, depth_write: false, ..DrawState::OPAQUE };
        self.gl.set_state(state);
        self.gl.draw_strip(self.programs.get(Kind::Resolve)?, &self.no_attributes, 4);
        let image = self.picture.read()?;
        Ok(image.rgba.chunks_exact(4).map(|pixel| pixel[3]).collect())
    }

    /// Draws depths and numbers, and reads them back.
    fn draw_marks(&mut self) -> Result<Vec<[u32; 2]>, Error> {
        let target = match self.marks.take() {
            Some(target) => target,
            None => MarkTarget::new(&self.gl, self.picture.size())?,
        };
        target.begin();
        self.frame.bind_uniform();
        let models = self.models.as_slice();
        self.commands.clear();
        let calls = calls(&self.last.opaque, Pass::Marks, models, &mut self.commands);
        self.commands.upload()?;
        self.draw_calls(&calls, Pass::Marks, &mut PassCounts::default())?;
        let pixels = target.read();
        self.marks = Some(target);
        pixels
    }
}

/// The ground as a camera sees it.
struct Ground {
    /// Camera, and height of the ground in metres, if there is any.
    seen: Option<(Camera, f32)>,
    /// View direction, and vectors along a pixel to the right and upwards, at a depth of one metre.
    axes: [Vec3; 3],
    middle: [f32; 2],
}

impl Ground {
    fn new(camera: &Camera, scene: &Scene, size: [u32; 2]) -> Result<Self, Error> {
        let [wide, high] = sides(size);
        camera.clip_from_world(wide / high)?;
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(Vec3::from);
        let forward = (target - eye).normalize();
        let right = forward.cross(up).normalize();
        let pixel_m = 2.0 * (0.5 * camera.fov_y_rad).tan() / high;
        let axes = [forward, right * pixel_m, right.cross(forward) * pixel_m];
        let seen = scene.ground.map(|ground| (*camera, ground.height_m));
        Ok(Self { seen, axes, middle: [0.5 * wide, 0.5 * high] })
    }

    /// Returns the depth of the ground at the middle of a pixel, or infinity.
    fn depth_m(&self, pixel: [usize; 2]) -> f32 {
        let Some((camera, height_m)) = &self.seen else { return f32::INFINITY };
        let [forward, right, up] = self.axes;
        #[expect(clippy::cast_precision_loss, reason = "no picture is 2^24 pixels wide")]
        let [x, y] = pixel.map(|at| at as f32 + 0.5);
        let direction = forward + right * (x - self.middle[0]) + up * (self.middle[1] - y);
        let depth_m = (height_m - camera.eye[1]) / direction.y;
        if (camera.near..camera.far).contains(&depth_m) { depth_m } else { f32::INFINITY }
    }
}
