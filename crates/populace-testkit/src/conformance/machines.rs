//! Checks of state machines.

use populace_clip::{TICKS_PER_SEC, ticks_from_secs};
use populace_device::layout::{Float4, MACHINE_PARAMETERS, NONE, RUNNING_ELEMENTS, Running, Slot};
use populace_device::{Backend, Condition, Frame, MachineState, StageBuffer, Transition};
use populace_model::convert::single;

use super::plans;
use crate::compare::Judge;
use crate::oracle::{OracleCourse, OracleEntry, Timing, Weighting};
use crate::scenes::Scene;
use crate::{LayerPlan, MemberPlan, Play, Rng, TestCrowd};

const PARAMETERS: usize = MACHINE_PARAMETERS as usize;
/// The clock at the first frame.
const START_SECS: f64 = 6.0;
const FRAMES: u64 = 24;
/// The grid on which most frames, fades and conditions lie, so that they meet to the tick.
const STEP_TICKS: u64 = TICKS_PER_SEC / 24;
const MEMBERS: usize = 18;
/// Slots that play clips beside a machine.
const PLAIN: usize = 2;
const STATES: usize = 4;

/// A machine that runs on a member.
struct Machine {
    member: usize,
    /// The clips that play beside it.
    beside: Vec<Play>,
    layer: u32,
    /// Index of the first state in the tables.
    first_state: u32,
    instance: u32,
    /// What each state plays; its start is that of its entry.
    states: Vec<Play>,
    ways: Vec<Vec<Transition>>,
    parameters: [f32; PARAMETERS],
    /// The ramp of the machine's weight: its start, both weights and its length.
    ramp: (u64, f32, f32, f32),
    course: OracleCourse,
}

/// Returns one of few values, so that parameters often equal what they are compared with.
fn level(rng: &mut Rng) -> f32 {
    single(0.25 * rng.below(5) as f64)
}

fn condition(rng: &mut Rng) -> Condition {
    let parameter = u32::try_from(rng.below(PARAMETERS)).expect("few parameters");
    match rng.below(3) {
        0 => Condition::Above(parameter, level(rng)),
        1 => Condition::Below(parameter, level(rng)),
        _ => Condition::After(rng.below(5) as u64 * STEP_TICKS),
    }
}

fn transition(rng: &mut Rng) -> Transition {
    let fade_secs = match rng.below(4) {
        0 => 0.0,
        1 => single(rng.between(0.05, 0.4)),
        _ => single(rng.below(5) as f64 * STEP_TICKS as f64 / TICKS_PER_SEC as f64),
    };
    let conditions = (0..rng.below(3)).map(|_| condition(rng)).collect();
    Transition { to: rng.below(STATES), fade_secs, conditions }
}

impl Machine {
    fn new(rng: &mut Rng, crowd: &mut TestCrowd<'_>, nth: usize, tick: u64) -> Self {
        let scene = crowd.scene;
        let (body, clips) = (nth % scene.bodies.len(), scene.tight_clips());
        let mut layers = vec![LayerPlan::default()];
        layers.extend((0..nth % 3).map(|_| plans::layer(rng, scene.bodies[body].joints.len())));
        let layer = u32::try_from(layers.len() - 1).expect("few layers");
        let beside: Vec<Play> = (0..rng.below(PLAIN + 1))
            .map(|_| {
                let play = plans::play(rng, &clips);
                if rng.chance(0.5) { play.on_layer(layer) } else { play }
            })
            .collect();
        let plan = MemberPlan { body, plays: beside.clone(), inertialization: Vec::new(), layers };
        let member = crowd.add(plan);
        let states: Vec<Play> = (0..STATES).map(|_| plans::play(rng, &clips)).collect();
        let ways: Vec<Vec<Transition>> =
            (0..STATES).map(|_| (0..1 + rng.below(3)).map(|_| transition(rng)).collect()).collect();
        let rows: Vec<MachineState> = states
            .iter()
            .zip(&ways)
            .map(|(play, ways)| MachineState {
                slot: crowd.slot(play, body),
                transitions: ways.clone(),
            })
            .collect();
        let body = crowd.body_index(body);
        let first_state = crowd.tables.add_states(body, &rows).expect("the states are valid");
        let parameters = std::array::from_fn(|_| level(rng));
        let course = OracleCourse::new(0, tick);
        let to = single(rng.between(0.3, 1.0));
        let ramp = match nth % 3 {
            0 => (tick, to, to, 0.0),
            1 => (tick, 0.0, to, 0.3),
            _ => (tick, to, 0.2, 0.7),
        };
        let mut machine = Self {
            member,
            beside,
            layer,
            first_state,
            instance: NONE,
            states,
            ways,
            parameters,
            ramp,
            course,
        };
        machine.begin(crowd, tick);
        machine
    }

    /// Restarts the machine, in an instance of its own. Its parameters stay.
    fn begin(&mut self, crowd: &mut TestCrowd<'_>, tick: u64) {
        let index = crowd.index(self.member);
        let empty = Slot { bound_clip: NONE, ..Slot::default() };
        for which in 0..2 {
            crowd.tables.set_slot(index, PLAIN + which, &empty).expect("empty slots are valid");
        }
        let (tables, state) = (&mut crowd.tables, self.first_state);
        self.instance = tables
            .add_machine_instance(state, tick, self.parameters)
            .expect("the machine fits in the tables");
        self.course = OracleCourse::new(0, tick);
        let (start, from, to, secs) = self.ramp;
        for which in 0..2 {
            let mut slot = Slot::machine(self.instance, which, tick).on_layer(self.layer);
            // Each slot has half of the machine's weight.
            slot.ramp_weight(start, 0.5 * from, 0.5 * to, secs);
            tables.set_slot(index, PLAIN + which as usize, &slot).expect("the slot is valid");
        }
    }

    /// Sets some parameters for the frame.
    fn change(&mut self, rng: &mut Rng, crowd: &mut TestCrowd<'_>) {
        for _ in 0..rng.below(4) {
            let at = rng.below(PARAMETERS);
            self.parameters[at] = level(rng);
            let number = u32::try_from(at).expect("few parameters");
            let value = self.parameters[at];
            crowd
                .tables
                .set_machine_parameter(self.instance, number, value)
                .expect("the parameter exists");
        }
    }

    /// Returns what a state plays since it was entered.
    fn played(&self, entry: OracleEntry, share: f64) -> Play {
        let mut play = self.states[entry.state];
        if let Timing::Loop { start_tick, .. } | Timing::Once { start_tick, .. } = &mut play.timing
        {
            *start_tick = entry.tick;
        }
        let (tick, from, to, secs) = self.ramp;
        let weighting = Weighting::Share { tick, from, to, secs, share };
        Play { weighting, layer: self.layer, ..play }
    }

    /// Follows the frame, and tells the crowd's oracle what the member plays in it.
    fn follow(&mut self, crowd: &mut TestCrowd<'_>, tick: u64) {
        self.course.step(&self.ways, &self.parameters, tick);
        let states = self.course.shown(tick).into_iter();
        let states = states.map(|(entry, share)| self.played(entry, share));
        crowd.show(self.member, self.beside.iter().copied().chain(states).collect());
    }

    /// Compares the state that the machine is in, and when it was entered.
    fn judge_state(&self, judge: &mut Judge, backend: &mut dyn Backend, crowd: &TestCrowd<'_>) {
        let mut elements = [Float4::default(); RUNNING_ELEMENTS as usize];
        let first = self.instance as usize * elements.len();
        backend
            .read(&crowd.tables, StageBuffer::Running, first, &mut elements)
            .expect("the states of machines can be read");
        let (got, wanted) = (Running::from_elements(elements), self.course.now());
        let state = single(f64::from(got.state) - f64::from(self.first_state));
        let name = |what| move || format!("the {what} of the machine of member {}", self.member);
        judge.number(state, wanted.state as f64, 0.0, 1.0, name("state"));
        let late = got.entry_tick as f64 - wanted.tick as f64;
        judge.number(single(late), 0.0, 0.0, 1.0, name("entry"));
    }
}

/// Checks machines of four states: transitions by parameters and by time, several of which hold at
/// once or meet their limits exactly, cuts and fades, machines that fade in and out themselves,
/// beside other clips and in layers, and machines that begin again.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_machines(backend: &mut dyn Backend) {
    let (scene, mut rng) = (Scene::new(), Rng::new(78));
    let mut judge = Judge::coarse("state machines");
    let mut crowd = plans::crowd(&scene, PLAIN + 2, None);
    let mut tick = ticks_from_secs(START_SECS);
    let mut machines: Vec<Machine> =
        (0..MEMBERS).map(|nth| Machine::new(&mut rng, &mut crowd, nth, tick)).collect();
    let mut taken = 0;
    for frame in 0..FRAMES {
        for (nth, machine) in machines.iter_mut().enumerate() {
            if frame == FRAMES / 2 && nth % 4 == 1 {
                taken += machine.course.transitions();
                machine.begin(&mut crowd, tick);
            }
            machine.change(&mut rng, &mut crowd);
            machine.follow(&mut crowd, tick);
        }
        crowd.update(backend);
        backend.run(&crowd.tables, Frame::of_all(tick)).expect("the backend runs a frame");
        judge.members(backend, &crowd, tick);
        for machine in &machines {
            machine.judge_state(&mut judge, backend, &crowd);
        }
        // Some frames are off the grid.
        tick += if rng.chance(0.3) { 1 + rng.below(40_000) as u64 } else { STEP_TICKS };
        if rng.chance(0.5) {
            tick = tick.next_multiple_of(STEP_TICKS);
        }
    }
    judge.done();
    taken += machines.iter().map(|machine| machine.course.transitions()).sum::<usize>();
    assert!(taken > 4 * MEMBERS, "only {taken} transitions were taken");
}
