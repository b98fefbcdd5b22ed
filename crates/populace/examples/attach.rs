//! Seven people walk with raised torches and feathered hats.
//!
//! Each torch, hat and feather is a member. Torches and hats are attached to a joint of a person,
//! and feathers to a hat. Attachments follow their parent within the same frame.
//!
//! `cargo run --example attach [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

#[path = "shared/prop.rs"]
mod prop;
mod shared;

use std::error::Error;
use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use populace::character::Character;
use populace::model::math::{quat, vec3};
use populace::{
    CharacterId, ClipPlayback, Crowd, JointIndex, MemberId, Placement, Reach, Target, Trs, Weight,
};
use populace_cast::{Look, person};

const WOOD: [f32; 3] = [0.12, 0.05, 0.02];
const TORCH: [prop::Piece; 3] = [
    (WOOD, &[[0.0, -0.22], [0.012, -0.22], [0.017, 0.26], [0.0, 0.26]]),
    ([0.02, 0.02, 0.02], &[[0.017, 0.2], [0.034, 0.24], [0.034, 0.3], [0.0, 0.3]]),
    ([1.0, 0.3, 0.02], &[[0.028, 0.3], [0.04, 0.34], [0.022, 0.43], [0.0, 0.5]]),
];
const HAT: [prop::Piece; 2] = [
    (
        [0.5, 0.33, 0.12],
        &[[0.1, 0.0], [0.2, -0.01], [0.2, 0.0], [0.1, 0.01], [0.085, 0.1], [0.0, 0.11]],
    ),
    ([0.35, 0.02, 0.02], &[[0.101, 0.008], [0.099, 0.035]]),
];
const FEATHER: [prop::Piece; 1] =
    [([0.75, 0.8, 0.85], &[[0.0, 0.0], [0.004, 0.02], [0.018, 0.1], [0.014, 0.2], [0.0, 0.27]])];

/// Returns a hat's offset from the head joint.
fn hat_offset(person: &Character, head: JointIndex) -> Trs {
    let top = person.rest_bounds().map_or(0.0, |bounds| bounds.high[1]);
    let up = top - person.skeleton.rest_model(head).origin()[1] - 0.07;
    Trs { translation: [0.0, up, 0.0], ..Trs::IDENTITY }
}

/// A person with a torch.
struct Walker {
    member: MemberId,
    hand: JointIndex,
    /// The torch's position relative to the hand.
    fist: [f32; 3],
    torch: MemberId,
}

/// Spawns a walking person with torch, hat and feather.
fn spawn_walker(
    crowd: &mut Crowd,
    id: CharacterId,
    [torch, hat, feather]: [CharacterId; 3],
    nth: usize,
) -> Result<Walker, Box<dyn Error>> {
    let person = Arc::clone(crowd.character(id)?.asset());
    let joint = |name: &str| person.skeleton.find(name).ok_or(format!("no joint {name}"));
    let (head, hand, knuckles) = (joint("head")?, joint("r_hand")?, joint("r_fingers")?);
    let x = nth as f32 - 3.0;
    let member =
        crowd.spawn(id, Placement::at([0.85 * x, 0.0, 0.2 * x.abs()]).facing(0.25 - 0.1 * x))?;
    let walk = crowd.clip(id, "Walk")?;
    crowd.member_mut(member)?.play(walk, ClipPlayback::looping().phase(nth as f32 / 7.0))?;
    let size = person.height_m() / 1.7;
    let up = [-0.42 * size, (1.05 + 0.1 * (nth % 3) as f32) * size, 0.3 * size];
    crowd.member_mut(member)?.reach(Reach::with(hand), Target::InModel(up), Weight::FULL)?;

    // The torch lies across the fist: it points forward if the arm hangs, and up if it is bent.
    let fist = person.skeleton.rest(knuckles).translation;
    let across = quat::mul([0.0, -0.3, 0.0, 0.954], [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
    let here = Placement::at([0.0; 3]);
    let [torch, hat, feather] =
        [crowd.spawn(torch, here)?, crowd.spawn(hat, here)?, crowd.spawn(feather, here)?];
    crowd.member_mut(torch)?.attach_to(
        member,
        hand,
        Trs { translation: fist, rotation: across, scale: [0.9 * size; 3] },
    )?;
    crowd.member_mut(hat)?.attach_to(member, head, hat_offset(&person, head))?;
    let aslant =
        Trs { translation: [0.1, 0.0, 0.0], rotation: [-0.3, 0.0, -0.2, 0.933], ..Trs::IDENTITY };
    crowd.member_mut(feather)?.attach_to(hat, JointIndex(0), aslant)?;
    Ok(Walker { member, hand, fist, torch })
}

fn main() -> Result<(), Box<dyn Error>> {
    let looks = [Look::woman(), Look::heavy_man(), Look::child()];
    let characters = [("torch", &TORCH[..]), ("hat", &HAT), ("feather", &FEATHER)]
        .map(|(name, of)| prop::revolved(name, of));
    let mut characters: Vec<Character> = characters.into_iter().collect::<Result<_, _>>()?;
    for nth in 0..7 {
        characters.push(person(&looks[nth % 3].in_outfit(nth))?);
    }
    let mut crowd = Crowd::builder().build()?;
    let mut ids = Vec::new();
    for character in characters {
        ids.push(crowd.add_character(character)?);
    }
    let props = [ids[0], ids[1], ids[2]];
    let mut walkers = Vec::new();
    for (nth, &id) in ids[3..].iter().enumerate() {
        walkers.push(spawn_walker(&mut crowd, id, props, nth)?);
    }
    for _ in 0..60 {
        crowd.update(1.0 / 60.0)?;
    }
    for (nth, Walker { member, hand, fist, torch }) in walkers.into_iter().enumerate() {
        let fist =
            crowd.member_mut(member)?.model_from_joints()?[hand.index()].transform_point(fist);
        let torch = crowd.member_mut(torch)?.model_from_joints()?[0].origin();
        let apart = vec3::length(vec3::sub(fist, torch));
        println!(
            "{nth}: the torch is {apart:.3} m from the fist, {:.2} m above the ground",
            torch[1]
        );
    }
    let path = shared::output("attach.png");
    shared::draw(&mut crowd, &[[-3.2, -0.2, 0.9], [3.2, 2.2, 0.0]], &path)?;
    println!("on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
