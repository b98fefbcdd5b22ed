//! Calls for many members do the same as the calls for one, and change nothing on an error.

#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![expect(
    clippy::expect_used,
    clippy::unwrap_used,
    dead_code,
    reason = "a failed call fails the test; not every test uses the whole fixture"
)]

#[path = "controls/fixture.rs"]
mod fixture;

use fixture::{Scene, joint, scene};
use populace::{
    Affine, BlendSpace, BlendSpacePlayback, ClipPlayback, Condition, Device, Error,
    MachinePlayback, MemberId, Placement, Schedule, SpacePoint, StateMachine, StatePlayback,
    Weight,
};

const COUNT: u8 = 5;

fn placement(nth: u8) -> Placement {
    Placement::at([f32::from(nth), 0.0, 2.0]).facing(0.3 * f32::from(nth)).scaled(1.5)
}

/// Two equal scenes: one for single calls, one for batches.
fn twins() -> [(Scene, Vec<MemberId>); 2] {
    [(); 2].map(|()| {
        let mut scene = scene(Device::native(), Schedule::Fused);
        let members = (0..COUNT).map(|nth| scene.member(placement(nth))).collect();
        (scene, members)
    })
}

fn palettes(scene: &mut Scene) -> Vec<(MemberId, Vec<Affine>)> {
    let mut all = Vec::new();
    scene.crowd.palettes(&mut |member, palette| all.push((member, palette.to_vec()))).unwrap();
    all
}

/// Updates both scenes and compares their palettes.
#[track_caller]
fn assert_equal(single: &mut Scene, batch: &mut Scene) {
    for frame in 0..4 {
        single.update(0.07);
        batch.update(0.07);
        let bits = |scene: &mut Scene| palettes(scene).into_iter().map(|(_, p)| p).collect();
        let [a, b]: [Vec<_>; 2] = [bits(single), bits(batch)];
        assert!(!a.is_empty() && a == b, "frame {frame}");
    }
}

#[test]
fn spawned_members_and_placements_equal_those_of_single_calls() {
    let [(mut single, _), (mut batch, _)] = twins();
    let all: Vec<_> = (0..COUNT).map(placement).collect();
    let one_by_one: Vec<_> = all.iter().map(|at| single.member(*at)).collect();
    let body = batch.body;
    let at_once = batch.crowd.spawn_many(body, &all).expect("room for five");
    assert_eq!(one_by_one.len(), at_once.len());
    let moves = |members: &[MemberId]| -> Vec<_> {
        (10..).zip(members).map(|(nth, member)| (*member, placement(nth))).collect()
    };
    for (member, at) in moves(&one_by_one) {
        single.edit(member).look_at([0.0, 1.5, 9.0], Weight::FULL).expect("a head");
        single.edit(member).set_placement(at).expect("a placement");
    }
    for member in &at_once {
        batch.edit(*member).look_at([0.0, 1.5, 9.0], Weight::FULL).expect("a head");
    }
    batch.crowd.set_placements(&moves(&at_once)).expect("placements");
    assert_equal(&mut single, &mut batch);
    let placed = batch.crowd.member(at_once[3]).expect("a member").placement();
    assert_eq!(placed, placement(13));
}

#[test]
fn parameters_equal_those_of_single_calls() {
    let scenes = twins().map(|(mut scene, members)| {
        let [sway, walk] = ["sway", "walk"].map(|name| scene.clip(name));
        let machine = StateMachine::new()
            .parameter("speed", 0.0)
            .state("sways", sway, StatePlayback::looping())
            .state("walks", walk, StatePlayback::looping())
            .transition("sways", "walks", 0.1, &[Condition::above("speed", 0.5)]);
        let machine = scene.crowd.add_machine(&machine).expect("a machine");
        let space = BlendSpace::line(&[(sway, 0.0), (walk, 1.0)]).expect("a line");
        let space = scene.crowd.add_blend_space(space).expect("a blend space");
        for member in &members {
            let mut view = scene.edit(*member);
            view.play_blend_space(space, 0.2, BlendSpacePlayback::new()).expect("a start");
            view.play_machine(machine, MachinePlayback::new().on_layer(1)).expect("a start");
        }
        scene.update(0.1);
        (scene, members, machine)
    });
    let [(mut single, ones, _), (mut batch, many, machine)] = scenes;
    let speed = batch.crowd.parameter(machine, "speed").expect("a parameter");
    let faster = |members: &[MemberId]| -> Vec<_> {
        members.iter().zip(0..COUNT).map(|(member, nth)| (*member, f32::from(nth))).collect()
    };
    for (member, value) in faster(&ones) {
        single.edit(member).set_parameter("speed", value).expect("a parameter");
        single.edit(member).set_blend_parameter(0.1 * value, 0.2).expect("a position");
    }
    batch.crowd.set_parameters(speed, &faster(&many)).expect("parameters");
    let points: Vec<(MemberId, SpacePoint)> =
        faster(&many).into_iter().map(|(member, value)| (member, (0.1 * value).into())).collect();
    batch.crowd.set_blend_parameters(&points, 0.2).expect("positions");
    assert_equal(&mut single, &mut batch);
    assert_eq!(&*batch.edit(many[4]).machine_state(1).expect("a state"), "walks");
    assert_eq!(&*batch.edit(many[0]).machine_state(1).expect("a state"), "sways");
    let unknown = batch.crowd.parameter(machine, "sped").expect_err("no such parameter");
    assert!(unknown.to_string().ends_with("did you mean \"speed\"?"), "{unknown}");
    batch.edit(many[0]).set_parameter(speed, 1.0).expect("the same by id");
}

#[test]
fn joints_and_palettes_equal_those_of_single_reads() {
    for schedule in [Schedule::Fused, Schedule::Staged] {
        for device in [Device::native(), Device::opencl(0)] {
            let mut scene = scene(device, schedule);
            let clip = scene.clip("walk");
            let members: Vec<_> = (0..COUNT).map(|nth| scene.member(placement(nth))).collect();
            for (nth, member) in members.iter().enumerate() {
                let play = ClipPlayback::looping().phase(0.1 * nth as f32);
                scene.edit(*member).play(clip, play).expect("a start");
            }
            scene.update(0.1);
            scene.crowd.despawn(members[1]).expect("a member");
            let late = scene.member(placement(9));
            let wanted: Vec<_> = [4, 0, 2, 3]
                .into_iter()
                .flat_map(|nth| ["head", "leftHand"].map(|name| (members[nth], joint(name))))
                .collect();
            let mut models = vec![Affine::IDENTITY; wanted.len()];
            scene.crowd.read_joints(&wanted, &mut models).expect("joints");
            for ((member, joint), model) in wanted.iter().zip(&models) {
                let all = scene.edit(*member).model_from_joints().expect("joints");
                assert_eq!(all[joint.index()], *model, "{schedule}, {device}");
            }
            let read = palettes(&mut scene);
            let mut present: Vec<_> = read.iter().map(|(member, _)| *member).collect();
            present.sort_by_key(|member| member.number());
            assert_eq!(present, [members[0], members[2], members[3], members[4]]);
            for (member, palette) in read {
                assert_eq!(scene.edit(member).palette().expect("a palette"), palette);
            }
            let error = scene.crowd.read_joints(&[(late, joint("head"))], &mut models[..1]);
            assert!(matches!(error, Err(Error::Backend(_))), "not evaluated yet: {error:?}");
        }
    }
}

#[test]
fn a_batch_with_an_error_changes_nothing() {
    let [_, (mut scene, members)] = twins();
    scene.update(0.1);
    let gone = members[4];
    scene.crowd.despawn(gone).expect("a member");
    let body = scene.body;
    let before = scene.crowd.member_count();
    let bad = [placement(0), placement(1).scaled(f32::NAN)];
    assert!(matches!(scene.crowd.spawn_many(body, &bad), Err(Error::BadValue { .. })));
    let many = vec![placement(0); 100_000];
    assert!(matches!(scene.crowd.spawn_many(body, &many), Err(Error::Full { .. })));
    assert_eq!(scene.crowd.member_count(), before);
    let moves = [(members[0], placement(7)), (gone, placement(8))];
    assert_eq!(scene.crowd.set_placements(&moves), Err(Error::StaleMember));
    let at = scene.crowd.member(members[0]).expect("a member").placement();
    assert_eq!(at, placement(0), "the first of the batch");
    let points = [(members[0], SpacePoint::from(1.0)), (gone, 1.0.into())];
    assert_eq!(scene.crowd.set_blend_parameters(&points, 0.1), Err(Error::StaleMember));
    let mut models = [Affine::IDENTITY; 2];
    let head = joint("head");
    let wrong = scene.crowd.read_joints(&[(members[0], head)], &mut models);
    assert!(matches!(wrong, Err(Error::BadValue { .. })), "{wrong:?}");
    let beyond = populace::JointIndex(999);
    let wrong = scene.crowd.read_joints(&[(members[0], beyond)], &mut models[..1]);
    let count = scene.crowd.character(body).expect("a body").asset().skeleton.joint_count();
    assert_eq!(
        wrong.expect_err("no such joint").to_string(),
        format!("there is no joint 999; the skeleton has {count}")
    );
}
