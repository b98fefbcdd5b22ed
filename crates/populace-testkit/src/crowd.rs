//! The crowd under test: members described by plans, given to backends as tables and to the oracle
//! as plans.

use std::collections::HashMap;

use populace_clip::Clip;
use populace_device::layout::{Layer, NONE, Slot};
use populace_device::{Backend, BodyIndex, Frame, LayerSettings, Schedule, Stage, Tables};
use populace_model::Mask;
use populace_retarget::Binding;

use crate::oracle::{Timing, Weighting};
use crate::scenes::Scene;
use crate::{Inertialization, MemberPlan, Play};

/// Members of a scene, kept as plans and as tables.
pub struct TestCrowd<'a> {
    /// Bodies and clips of the members.
    pub scene: &'a Scene,
    /// The tables given to backends.
    pub tables: Tables,
    bodies: Vec<BodyIndex>,
    clips: HashMap<usize, u32>,
    bound_clips: HashMap<(usize, usize), u32>,
    /// Clips as they were converted to bodies.
    pub(crate) converted: HashMap<(usize, usize), Clip>,
    members: Vec<Option<(u32, MemberPlan)>>,
}

impl<'a> TestCrowd<'a> {
    /// Creates a crowd without members. Clips are added to the tables when first played.
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
            .map(|b| tables.add_body(&b.skeleton, &b.palette).expect("a body fits in the tables"))
            .collect();
        Self {
            scene,
            tables,
            bodies,
            clips: HashMap::new(),
            bound_clips: HashMap::new(),
            converted: HashMap::new(),
            members: Vec::new(),
        }
    }

    /// Adds a member and returns its number, which never changes.
    ///
    /// # Panics
    ///
    /// If the plan does not fit the scene or the tables.
    pub fn add(&mut self, plan: MemberPlan) -> usize {
        let index =
            self.tables.add_member(self.bodies[plan.body]).expect("a member fits in the tables");
        self.members.push(Some((index, plan.clone())));
        self.set_plan(self.members.len() - 1, plan);
        self.members.len() - 1
    }

    /// Replaces a member's plan with another for the same body.
    ///
    /// # Panics
    ///
    /// If the plan does not fit the member, the scene or the tables.
    pub fn set_plan(&mut self, member: usize, plan: MemberPlan) {
        let (index, old) = self.members[member].take().expect("the member exists");
        assert_eq!(old.body, plan.body, "a member keeps its body");
        let slots = self.tables.slot_range(index);
        let taken = plan.plays.len() + plan.inertialization.len();
        assert!(taken <= slots.len(), "{taken} slots are needed, {} exist", slots.len());
        for slot in 0..slots.len() {
            let inertialization =
                slot.checked_sub(plan.plays.len()).and_then(|nth| plan.inertialization.get(nth));
            let value = match (plan.plays.get(slot), inertialization) {
                (Some(play), _) => self.slot(play, plan.body),
                (None, Some(inertialization)) => {
                    self.inertialization_slot(inertialization, plan.body)
                }
                (None, None) => Slot { bound_clip: NONE, ..Slot::default() },
            };
            self.tables.set_slot(index, slot, &value).expect("the slot is valid");
        }
        for (nth, layer) in plan.layers.iter().enumerate() {
            let mask = layer.mask.as_ref().map(|mask| self.mask(plan.body, mask));
            let value = Layer::new(LayerSettings { mode: layer.mode, weight: layer.weight }, mask);
            self.tables.set_layer(index, nth, value).expect("the layer is valid");
        }
        self.members[member] = Some((index, plan));
    }

    /// Tells the oracle what a member plays, and leaves the tables as they are.
    pub(crate) fn show(&mut self, member: usize, plays: Vec<Play>) {
        self.members[member].as_mut().expect("the member exists").1.plays = plays;
    }

    /// Removes a member.
    ///
    /// # Panics
    ///
    /// If existing is no such member.
    pub fn remove(&mut self, member: usize) {
        let (index, _) = self.members[member].take().expect("the member exists");
        self.tables.remove_member(index);
    }

    /// Returns the number, table index and plan of each existing member.
    pub fn members(&self) -> impl Iterator<Item = (usize, u32, &MemberPlan)> {
        let existing = |(number, member): (usize, &'_ Option<(u32, MemberPlan)>)| {
            member.as_ref().map(|_| number)
        };
        let numbers: Vec<usize> = self.members.iter().enumerate().filter_map(existing).collect();
        numbers.into_iter().filter_map(|number| {
            let (index, plan) = self.members[number].as_ref()?;
            Some((number, *index, plan))
        })
    }

    /// Returns a member's plan.
    ///
    /// # Panics
    ///
    /// If existing is no such member.
    #[must_use]
    pub fn plan(&self, member: usize) -> &MemberPlan {
        &self.members[member].as_ref().expect("the member exists").1
    }

    /// Returns the index of a body in the tables.
    pub(crate) fn body_index(&self, body: usize) -> BodyIndex {
        self.bodies[body]
    }

    /// Returns a member's index in the tables.
    ///
    /// # Panics
    ///
    /// If existing is no such member.
    #[must_use]
    pub fn index(&self, member: usize) -> u32 {
        self.members[member].as_ref().expect("the member exists").0
    }

    fn inertialization_slot(&mut self, inertialization: &Inertialization, body: usize) -> Slot {
        let states = [inertialization.outgoing, inertialization.incoming].map(|play| {
            let slot = self.slot(&play, body);
            self.tables.sampled_state(&slot, inertialization.tick)
        });
        let share = [inertialization.share, inertialization.share_per_sec];
        Slot::inertialization(inertialization.tick, inertialization.ticks, states, share)
            .on_layer(inertialization.outgoing.layer)
    }

    /// Returns the slot of a play on a body.
    pub(crate) fn slot(&mut self, play: &Play, body: usize) -> Slot {
        let bound_clip = self.bound_clip(play.clip, body);
        self.slot_of(play, bound_clip)
    }

    /// Returns the time at which a play is sampled, and the time towards which its velocity is
    /// measured, in seconds on the clip's own axis: of the two keys around it the one further away,
    /// so that the velocity is that of the gap between both. After the last key it is the key
    /// before.
    pub(crate) fn sampled_secs(&self, play: &Play, tick: u64) -> [f64; 2] {
        let clip = &self.scene.clips[play.clip];
        let secs = play.timing.time_secs(tick, &clip.clip);
        let keys: Vec<f64> = clip.exact_times.iter().map(|key| f64::from(*key)).collect();
        let next = keys.partition_point(|key| *key <= secs).max(1);
        let far = match (keys[next - 1], keys.get(next)) {
            (before, Some(after)) if secs - before < after - secs => *after,
            (before, Some(_)) => before,
            (_, None) => keys[next.saturating_sub(2)],
        };
        // A STEP key jumps. The gap ends before the jump, so the time is moved slightly before it.
        [secs, if far > secs { far - 1e-9 } else { far }]
    }

    fn slot_of(&self, play: &Play, bound_clip: u32) -> Slot {
        let clip = &self.scene.clips[play.clip].clip;
        let duration = clip.duration_secs();
        let slot = match play.timing {
            Timing::Loop { start_tick, phase, speed } => {
                Slot::looping(bound_clip, start_tick, duration, phase, speed)
            }
            Timing::Once { start_tick, speed } => {
                Slot::once(bound_clip, start_tick, duration, speed)
            }
            Timing::Held { secs } => Slot::held(bound_clip, 0, secs),
        };
        let mut slot = slot.on_layer(play.layer);
        match play.weighting {
            Weighting::Constant(weight) => slot = slot.with_weight(weight),
            Weighting::Ramp { tick, from, to, secs } => slot.ramp_weight(tick, from, to, secs),
            Weighting::Share { .. } => unreachable!("shares come from slots of machines"),
        }
        slot
    }

    fn bound_clip(&mut self, clip: usize, body: usize) -> u32 {
        let (scene, tables, body_index) = (self.scene, &mut self.tables, self.bodies[body]);
        let source = &scene.clips[clip].clip;
        let index = *self
            .clips
            .entry(clip)
            .or_insert_with(|| tables.add_clip(source).expect("a clip fits in the tables"));
        let converted = &mut self.converted;
        *self.bound_clips.entry((clip, body)).or_insert_with(|| {
            let skeleton = &scene.bodies[body].skeleton;
            let binding = match scene.retargets.contains_key(&(clip, body)) {
                false => Binding::new(source, skeleton),
                true => {
                    let (from, onto) = (&scene.bodies[scene.clips[clip].body], &scene.bodies[body]);
                    let binding =
                        Binding::retarget(source, &from.role_map(), skeleton, &onto.role_map());
                    binding.expect("both bodies are humanoid")
                }
            };
            if let Some(of_body) = binding.converted() {
                converted.insert((clip, body), of_body.clip.clone());
            }
            tables
                .add_bound_clip(index, body_index, &binding)
                .expect("a bound clip fits in the tables")
        })
    }

    fn mask(&mut self, body: usize, by_source: &[f32]) -> u32 {
        let skeleton = &self.scene.bodies[body].skeleton;
        let by_level = skeleton.joints().map(|j| by_source[skeleton.source_from_joint(j)]);
        let mask =
            Mask::new(skeleton, by_level.collect()).expect("the mask has one weight per joint");
        self.tables.add_mask(&mask).expect("a mask fits in the tables")
    }

    /// Uploads all changes to the backend.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn update(&mut self, backend: &mut dyn Backend) {
        self.tables.sort_pages();
        backend.update(&self.tables).expect("the backend accepts the tables");
        self.tables.mark_clean();
    }

    /// Runs a whole frame.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn run(&mut self, backend: &mut dyn Backend, tick: u64) {
        self.update(backend);
        backend.run(&self.tables, Frame::of_all(tick)).expect("the backend runs a frame");
    }

    /// Runs every stage alone, in order; runs a whole frame if the schedule is not staged.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn run_stages(&mut self, backend: &mut dyn Backend, tick: u64) {
        if backend.schedule() != Schedule::Staged {
            return self.run(backend, tick);
        }
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
            .run_stage(&self.tables, Frame::of_all(tick), stage)
            .expect("the backend runs a stage");
    }
}
