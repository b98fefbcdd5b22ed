//! A crowd under test: members planned in plain words, given to a backend as tables and to the oracle as it is.

use std::collections::HashMap;

use populace_core::layout::{Float4, Layer, NONE, Slot};
use populace_core::{
    Backend, Binding, BodyIndex, Frame, LayerMode, Mask, Stage, StageBuffer, TICKS_PER_SEC, Tables,
};

use crate::oracle::{OracleLayer, OraclePose, OracleSlot, Timing, Weighting, evaluate};
use crate::scenes::Scene;
use crate::tolerance::{AffineBound, LocalBound, SampleBound, WEIGHT_ERROR, model_bounds, palette_bounds};

/// A playing clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// Index into [`Scene::clips`].
    pub clip: usize,
    /// When it shows what.
    pub timing: Timing,
    /// How much it weighs.
    pub weighting: Weighting,
    /// Its layer.
    pub layer: u32,
}

impl Play {
    /// A clip that stands at a time, of weight 1, in layer 0.
    #[must_use]
    pub fn held(clip: usize, secs: f32) -> Self {
        Self {
            clip,
            timing: Timing::Held { secs },
            weighting: Weighting::Constant(1.0),
            layer: 0,
        }
    }

    /// With another weight.
    #[must_use]
    pub fn weighing(self, weight: f32) -> Self {
        let weighting = Weighting::Constant(weight);
        Self { weighting, ..self }
    }

    /// On another layer.
    #[must_use]
    pub fn on_layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }
}

/// A layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerPlan {
    /// How it meets what lies beneath.
    pub mode: LayerMode,
    /// From 0 to 1.
    pub weight: f32,
    /// A weight per joint, in the order of the source.
    pub mask: Option<Vec<f32>>,
}

impl Default for LayerPlan {
    fn default() -> Self {
        Self {
            mode: LayerMode::Override,
            weight: 1.0,
            mask: None,
        }
    }
}

/// A member.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberPlan {
    /// Index into [`Scene::bodies`].
    pub body: usize,
    /// Its slots, in order.
    pub plays: Vec<Play>,
    /// Its layers, at least one.
    pub layers: Vec<LayerPlan>,
}

impl MemberPlan {
    /// A member with one plain layer.
    #[must_use]
    pub fn plain(body: usize, plays: Vec<Play>) -> Self {
        let layers = vec![LayerPlan::default()];
        Self { body, plays, layers }
    }
}

/// What a backend computed for a member; joints in the order of the source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MemberReading {
    /// Local translations, metres.
    pub translations: Vec<[f32; 3]>,
    /// Local rotations.
    pub rotations: Vec<[f32; 4]>,
    /// Local scales.
    pub scales: Vec<[f32; 3]>,
    /// `model_from_joint`, 3x4, row-major.
    pub models: Vec<[f32; 12]>,
    /// `model_from_bind` of each palette entry, 3x4, row-major.
    pub palette: Vec<[f32; 12]>,
}

/// What the oracle says of a member, and how far a backend may be off.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    pub(crate) pose: OraclePose,
    pub(crate) locals: Vec<LocalBound>,
    pub(crate) models: Vec<AffineBound>,
    pub(crate) palette: Vec<AffineBound>,
}

/// Members of a scene, as tables.
pub struct TestCrowd<'a> {
    /// What members are made of.
    pub scene: &'a Scene,
    /// What backends are given.
    pub tables: Tables,
    bodies: Vec<BodyIndex>,
    clips: HashMap<usize, u32>,
    bound_clips: HashMap<(usize, usize), u32>,
    members: Vec<Option<(u32, MemberPlan)>>,
}

impl<'a> TestCrowd<'a> {
    /// A crowd of nobody. Clips enter the tables when first played.
    ///
    /// # Panics
    ///
    /// If the tables refuse a body.
    #[must_use]
    pub fn new(scene: &'a Scene, slots_per_member: usize) -> Self {
        let mut tables = Tables::new(slots_per_member);
        let bodies = scene
            .bodies
            .iter()
            .map(|b| tables.add_body(&b.skeleton, &b.palette).expect("a body fits"))
            .collect();
        Self {
            scene,
            tables,
            bodies,
            clips: HashMap::new(),
            bound_clips: HashMap::new(),
            members: Vec::new(),
        }
    }

    /// Adds a member and returns its number, which stays.
    ///
    /// # Panics
    ///
    /// If the plan does not fit the scene or the tables.
    pub fn add(&mut self, plan: MemberPlan) -> usize {
        let place = self
            .tables
            .add_member(self.bodies[plan.body])
            .expect("a member fits");
        self.members.push(Some((place, plan.clone())));
        self.direct(self.members.len() - 1, plan);
        self.members.len() - 1
    }

    /// Gives a member another plan for the same body.
    ///
    /// # Panics
    ///
    /// If the plan does not fit the member, the scene or the tables.
    pub fn direct(&mut self, member: usize, plan: MemberPlan) {
        let (place, old) = self.members[member].take().expect("a member of that number");
        assert_eq!(old.body, plan.body, "members keep their bodies");
        let slots = self.tables.slot_range(place);
        assert!(
            plan.plays.len() <= slots.len(),
            "{} slots are too few",
            slots.len()
        );
        for (index, slot) in slots.enumerate() {
            let value = match plan.plays.get(index) {
                Some(play) => self.slot(play, plan.body),
                None => Slot {
                    bound_clip: NONE,
                    ..Slot::default()
                },
            };
            self.tables.slots.set(slot, value);
        }
        for (layer, at) in plan.layers.iter().zip(self.tables.layer_range(place)) {
            let mask = layer
                .mask
                .as_ref()
                .map_or(NONE, |mask| self.mask(plan.body, mask));
            let (weight, mode) = (layer.weight, layer.mode.device_value());
            let value = Layer {
                weight,
                mask,
                mode,
                unused: 0,
            };
            self.tables.layers.set(at, value);
        }
        let mut device = self.tables.members.as_slice()[place as usize];
        device.layer_count = u32::try_from(plan.layers.len()).expect("few layers");
        self.tables.members.set(place as usize, device);
        self.members[member] = Some((place, plan));
    }

    /// Removes a member.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn remove(&mut self, member: usize) {
        let (place, _) = self.members[member].take().expect("a member of that number");
        self.tables.remove_member(place);
    }

    /// The members that are there.
    pub fn members(&self) -> impl Iterator<Item = (usize, u32, &MemberPlan)> {
        let there =
            |(number, member): (usize, &'_ Option<(u32, MemberPlan)>)| member.as_ref().map(|_| number);
        let numbers: Vec<usize> = self.members.iter().enumerate().filter_map(there).collect();
        numbers.into_iter().filter_map(|number| {
            let (place, plan) = self.members[number].as_ref()?;
            Some((number, *place, plan))
        })
    }

    /// A member's plan.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn plan(&self, member: usize) -> &MemberPlan {
        &self.members[member].as_ref().expect("a member of that number").1
    }

    /// A member's place in the tables.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn place(&self, member: usize) -> u32 {
        self.members[member].as_ref().expect("a member of that number").0
    }

    fn slot(&mut self, play: &Play, body: usize) -> Slot {
        let bound_clip = self.bound_clip(play.clip, body);
        let clip = &self.scene.clips[play.clip].clip;
        let (start, duration) = (clip.start_secs(), clip.duration_secs());
        let slot = match play.timing {
            Timing::Loop {
                start_tick,
                phase,
                speed,
            } => Slot::looping(bound_clip, start_tick, duration, phase, speed),
            Timing::Once { start_tick, speed } => Slot::once(bound_clip, start_tick, start, duration, speed),
            Timing::Held { secs } => Slot::held(bound_clip, 0, secs),
        };
        let mut slot = slot.on_layer(play.layer);
        match play.weighting {
            Weighting::Constant(weight) => slot = slot.with_weight(weight),
            Weighting::Ramp { tick, from, to, secs } => slot.ramp_weight(tick, from, to, secs),
        }
        slot
    }

    fn bound_clip(&mut self, clip: usize, body: usize) -> u32 {
        let (scene, tables) = (self.scene, &mut self.tables);
        let source = &scene.clips[clip].clip;
        let index = *self
            .clips
            .entry(clip)
            .or_insert_with(|| tables.add_clip(source).expect("a clip fits"));
        *self.bound_clips.entry((clip, body)).or_insert_with(|| {
            let binding = Binding::new(source, &scene.bodies[body].skeleton);
            tables.add_bound_clip(index, &binding).expect("a bound clip fits")
        })
    }

    fn mask(&mut self, body: usize, by_source: &[f32]) -> u32 {
        let skeleton = &self.scene.bodies[body].skeleton;
        let by_level = skeleton
            .joints()
            .map(|j| by_source[skeleton.source_from_joint(j)]);
        let mask = Mask::new(skeleton, by_level.collect()).expect("masks fit");
        self.tables.add_mask(&mask).expect("a mask fits")
    }

    /// Gives the backend what changed.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn update(&mut self, backend: &mut dyn Backend) {
        backend
            .update(&self.tables)
            .expect("the backend takes the tables over");
        self.tables.mark_clean();
    }

    /// Runs a whole frame.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn run(&mut self, backend: &mut dyn Backend, tick: u64) {
        self.update(backend);
        backend
            .run(&self.tables, Frame { tick })
            .expect("the backend runs a frame");
    }

    /// Runs every stage alone, in order.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn run_stages(&mut self, backend: &mut dyn Backend, tick: u64) {
        self.update(backend);
        for stage in Stage::ALL {
            self.run_stage(backend, tick, stage);
        }
    }

    /// Runs one stage.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn run_stage(&self, backend: &mut dyn Backend, tick: u64, stage: Stage) {
        backend
            .run_stage(&self.tables, Frame { tick }, stage)
            .expect("the backend runs a stage");
    }

    /// Reads a member's palette.
    ///
    /// # Panics
    ///
    /// If the backend fails, or there is no such member.
    pub fn read_palette(&self, backend: &mut dyn Backend, member: usize) -> Vec<[f32; 12]> {
        let plan = self.plan(member);
        let first = 3 * self.tables.members.as_slice()[self.place(member) as usize].palette_first as usize;
        let mut rows = vec![Float4::default(); 3 * self.scene.bodies[plan.body].palette.len()];
        if !rows.is_empty() {
            backend
                .read(StageBuffer::Palette, first, &mut rows)
                .expect("palettes can be read");
        }
        rows.chunks(3).map(|r| flat([r[0], r[1], r[2]])).collect()
    }

    /// Reads all that a backend computed for a member.
    ///
    /// # Panics
    ///
    /// If the backend fails, or there is no such member.
    pub fn read(&self, backend: &mut dyn Backend, member: usize) -> MemberReading {
        let mut joints = |buffer| self.read_joints(backend, member, buffer);
        let translations = joints(StageBuffer::Translations);
        let rotations = joints(StageBuffer::Rotations);
        let scales = joints(StageBuffer::Scales);
        let model_rows = [
            StageBuffer::ModelRow0,
            StageBuffer::ModelRow1,
            StageBuffer::ModelRow2,
        ]
        .map(joints);
        MemberReading {
            translations: translations.into_iter().map(Float4::xyz).collect(),
            rotations: rotations.into_iter().map(|q| q.0).collect(),
            scales: scales.into_iter().map(Float4::xyz).collect(),
            models: (0..model_rows[0].len())
                .map(|joint| flat([0, 1, 2].map(|row: usize| model_rows[row][joint])))
                .collect(),
            palette: self.read_palette(backend, member),
        }
    }

    /// A member's elements of a joint-wise buffer, in the order of the source.
    fn read_joints(&self, backend: &mut dyn Backend, member: usize, buffer: StageBuffer) -> Vec<Float4> {
        let skeleton = &self.scene.bodies[self.plan(member).body].skeleton;
        let first = self.tables.members.as_slice()[self.place(member) as usize].joint_first as usize;
        let mut by_level = vec![Float4::default(); skeleton.joint_count()];
        backend
            .read(buffer, first, &mut by_level)
            .expect("joints can be read");
        (0..skeleton.joint_count())
            .map(|source| by_level[skeleton.joint_from_source(source).index()])
            .collect()
    }

    /// Writes a member's elements of a joint-wise buffer, given in the order of the source.
    ///
    /// # Panics
    ///
    /// If the backend fails, or there is no such member.
    pub fn write_joints(
        &self,
        backend: &mut dyn Backend,
        member: usize,
        buffer: StageBuffer,
        by_source: &[[f32; 4]],
    ) {
        let skeleton = &self.scene.bodies[self.plan(member).body].skeleton;
        let first = self.tables.members.as_slice()[self.place(member) as usize].joint_first as usize;
        let by_level: Vec<_> = skeleton
            .joints()
            .map(|j| Float4(by_source[skeleton.source_from_joint(j)]))
            .collect();
        backend
            .write(buffer, first, &by_level)
            .expect("joints can be written");
    }

    /// The slots of a member at a time, for the oracle.
    #[must_use]
    pub fn oracle_slots(&self, plan: &MemberPlan, tick: u64) -> Vec<OracleSlot<'a>> {
        let scene = self.scene;
        let slot = |play: &Play| {
            let clip = &scene.clips[play.clip].clip;
            OracleSlot {
                clip: clip.source(),
                time_secs: play.timing.time_secs(tick, clip),
                weight: play.weighting.weight(tick),
                layer: play.layer as usize,
            }
        };
        plan.plays.iter().map(slot).collect()
    }

    /// What a member must look like; `None` where one of its clips jumps so near that either side is right, or where
    /// only a clip's own bound holds.
    pub(crate) fn expected(&self, member: usize, tick: u64) -> Option<Expected> {
        let plan = self.plan(member);
        let clip = |play: &Play| &self.scene.clips[play.clip];
        let jumps = |play: &Play| play.timing.is_near_jump(tick, &clip(play).clip);
        if plan.plays.iter().any(jumps) {
            return None;
        }
        let mut bound = SampleBound::default();
        for play in &plan.plays {
            let of_clip = match play.timing {
                Timing::Held { secs } if is_exact(&clip(play).key_times(), secs) => clip(play).at_keys,
                _ => clip(play).between_keys?,
            };
            bound = bound.or(of_clip);
        }
        Some(self.expected_within(member, tick, bound))
    }

    /// What a member must look like where each slot's sample is within `bound`.
    pub(crate) fn expected_within(&self, member: usize, tick: u64, bound: SampleBound) -> Expected {
        let plan = self.plan(member);
        let body = &self.scene.bodies[plan.body].oracle;
        let layer = |layer: &LayerPlan| OracleLayer {
            mode: layer.mode,
            weight: f64::from(layer.weight),
            mask: layer
                .mask
                .as_ref()
                .map(|mask| mask.iter().map(|w| f64::from(*w)).collect()),
        };
        let layers: Vec<_> = plan.layers.iter().map(layer).collect();
        let slots = self.oracle_slots(plan, tick);
        let pose = evaluate(body, &slots, &layers);
        let bound = widen_for_ramps(bound, plan, &slots);
        let locals: Vec<_> = (0..body.joints.len())
            .map(|j| LocalBound::after_pose(&bound, &body.rest(j), &pose.gains[j], slots.len()))
            .collect();
        let models = model_bounds(body, &pose.locals, &pose.model_from_joint, &locals);
        let palette = palette_bounds(body, &pose.model_from_joint, &models);
        Expected {
            pose,
            locals,
            models,
            palette,
        }
    }
}

/// Whether rows hold the value at a time exactly: a key's, or one outside of all keys.
fn is_exact(key_times: &[f32], secs: f32) -> bool {
    let outside = key_times.first().is_none_or(|t| secs <= *t) || key_times.last().is_none_or(|t| secs >= *t);
    outside || key_times.contains(&secs)
}

fn widen_for_ramps(bound: SampleBound, plan: &MemberPlan, slots: &[OracleSlot<'_>]) -> SampleBound {
    let ramps = |play: &Play| matches!(play.weighting, Weighting::Ramp { .. });
    if !plan.plays.iter().any(ramps) {
        return bound;
    }
    let total = |layer: usize| -> f64 {
        let of_layer = slots.iter().filter(|s| s.layer == layer);
        of_layer.map(|s| s.weight).sum()
    };
    let least = (0..plan.layers.len())
        .map(total)
        .filter(|t| *t > 0.0)
        .fold(1.0, f64::min);
    bound.with_weight_error(WEIGHT_ERROR, slots.len(), least)
}

fn flat(rows: [Float4; 3]) -> [f32; 12] {
    std::array::from_fn(|element| rows[element / 4].0[element % 4])
}

/// Ticks in whole and part seconds, for tests.
pub(crate) fn ticks(secs: f64) -> u64 {
    populace_core::ticks_from_secs(secs)
}

/// Ticks of one frame at 60 Hz.
pub(crate) const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;
