//! A crowd under test: members planned in plain words, given to a backend as tables and to the
//! oracle as it is.

use std::collections::HashMap;

use populace_device::layout::{Layer, NONE, Slot};
use populace_device::{Backend, BodyIndex, Frame, LayerSettings, Schedule, Stage, Tables, far_row};
use populace_model::Mask;
use populace_retarget::Binding;

use crate::oracle::{Timing, Weighting};
use crate::scenes::Scene;
use crate::{Inertialization, MemberPlan, Play};

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
        let place = self.tables.add_member(self.bodies[plan.body]).expect("a member fits");
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
        let taken = plan.plays.len() + plan.inertialization.len();
        assert!(taken <= slots.len(), "{} slots are too few", slots.len());
        for index in 0..slots.len() {
            let inertialization =
                index.checked_sub(plan.plays.len()).and_then(|nth| plan.inertialization.get(nth));
            let value = match (plan.plays.get(index), inertialization) {
                (Some(play), _) => self.slot(play, plan.body),
                (None, Some(inertialization)) => {
                    self.inertialization_slot(inertialization, plan.body)
                }
                (None, None) => Slot { bound_clip: NONE, ..Slot::default() },
            };
            self.tables.set_slot(place, index, value).expect("a slot that points at what is there");
        }
        for (index, layer) in plan.layers.iter().enumerate() {
            let mask = layer.mask.as_ref().map(|mask| self.mask(plan.body, mask));
            let value = Layer::new(LayerSettings { mode: layer.mode, weight: layer.weight }, mask);
            self.tables
                .set_layer(place, index, value)
                .expect("a layer that points at what is there");
        }
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
        let there = |(number, member): (usize, &'_ Option<(u32, MemberPlan)>)| {
            member.as_ref().map(|_| number)
        };
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

    fn inertialization_slot(&mut self, inertialization: &Inertialization, body: usize) -> Slot {
        let stands = [inertialization.left, inertialization.taking].map(|play| {
            let slot = self.slot(&play, body);
            self.tables.stand(&slot, inertialization.tick)
        });
        let share = [inertialization.share, inertialization.share_per_sec];
        Slot::inertialization(inertialization.tick, inertialization.ticks, stands, share)
            .on_layer(inertialization.left.layer)
    }

    fn slot(&mut self, play: &Play, body: usize) -> Slot {
        let bound_clip = self.bound_clip(play.clip, body);
        self.slot_of(play, bound_clip)
    }

    /// How a clip stands: where, and a row not far from there, in seconds on its own axis.
    pub(crate) fn stand_secs(&self, play: &Play, body: usize, tick: u64) -> [f64; 2] {
        let bound = self.bound_clips[&(play.clip, body)];
        let stand = self.tables.stand(&self.slot_of(play, bound), tick);
        let clip = self.tables.clips().as_slice()[self.clips[&play.clip] as usize];
        let far = far_row(stand.row, clip.row_count - 1);
        let far_secs = if clip.row_count == 1 {
            f64::from(clip.start_secs)
        } else if clip.rows_per_sec > 0.0 {
            f64::from(clip.start_secs) + f64::from(far) / f64::from(clip.rows_per_sec)
        } else {
            f64::from(self.tables.row_times().as_slice()[(clip.time_first + far) as usize])
        };
        let secs = play.timing.time_secs(tick, &self.scene.clips[play.clip].clip);
        // Where a clip steps, two rows share a time, and the one that is near to what comes before
        // is meant.
        [secs, if far_secs > secs { far_secs - 1e-9 } else { far_secs }]
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
        }
        slot
    }

    fn bound_clip(&mut self, clip: usize, body: usize) -> u32 {
        let (scene, tables, body_index) = (self.scene, &mut self.tables, self.bodies[body]);
        let source = &scene.clips[clip].clip;
        let index = *self
            .clips
            .entry(clip)
            .or_insert_with(|| tables.add_clip(source).expect("a clip fits"));
        *self.bound_clips.entry((clip, body)).or_insert_with(|| {
            let skeleton = &scene.bodies[body].skeleton;
            let binding = match scene.retargets.contains_key(&(clip, body)) {
                false => Binding::new(source, skeleton),
                true => {
                    let (from, onto) = (&scene.bodies[scene.clips[clip].body], &scene.bodies[body]);
                    let binding =
                        Binding::retarget(source, &from.role_map(), skeleton, &onto.role_map());
                    binding.expect("both are humanoid")
                }
            };
            tables.add_bound_clip(index, body_index, &binding).expect("a bound clip fits")
        })
    }

    fn mask(&mut self, body: usize, by_source: &[f32]) -> u32 {
        let skeleton = &self.scene.bodies[body].skeleton;
        let by_level = skeleton.joints().map(|j| by_source[skeleton.source_from_joint(j)]);
        let mask = Mask::new(skeleton, by_level.collect()).expect("masks fit");
        self.tables.add_mask(&mask).expect("a mask fits")
    }

    /// Gives the backend what changed.
    ///
    /// # Panics
    ///
    /// If the backend fails.
    pub fn update(&mut self, backend: &mut dyn Backend) {
        backend.update(&self.tables).expect("the backend takes the tables over");
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

    /// Runs every stage alone, in order; a whole frame where the schedule has no stages.
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
