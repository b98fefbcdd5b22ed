//! Masks of the layers of scene files: clips move the parts of bodies that the file names.
#![allow(clippy::unwrap_used, reason = "a scene that cannot be made fails the test")]

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use populace::model::{Role, Side};
use populace::{Crowd, Device, MemberId};
use populace_locomotion::GaitSpace;
use populace_scene::plan::{BehaviourPlan, ScenePlan};
use populace_scene::{Behaviours, Error, Person, Stage};

/// A man who stands, with layers.
fn stands(layers: &str) -> ScenePlan {
    let text = format!(
        "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\n\
         count = 1\nlayers = [{layers}]\ndoes.stand = {{ clip = \"Idle\" }}\n"
    );
    ScenePlan::parse(&text).unwrap()
}

struct Live {
    crowd: Crowd,
    behaviours: Behaviours,
}

/// Brings a scene in which everybody is the same character.
fn live(plan: &ScenePlan, character: populace::character::Character) -> Result<Live, Error> {
    let builder = Crowd::builder().device(Device::native()).capacity(100).slots_per_member(8);
    let mut crowd = builder.build()?;
    let character = crowd.add_character(character)?;
    let gaits = GaitSpace::of_all(&mut crowd, &[character]).into_iter().flatten().collect();
    let person = Person { character, scale: 1.0, look: None };
    let people: Vec<_> = plan.crowds.iter().map(|of| vec![person; of.count]).collect();
    let prepare = |character| Ok(Arc::new(character));
    let stage = Stage::new(&mut crowd, plan, &BTreeMap::new(), &prepare)?;
    let behaviours = Behaviours::new(&mut crowd, plan, &stage, &people, gaits)?;
    Ok(Live { crowd, behaviours })
}

fn man() -> populace::character::Character {
    populace_cast::person(&populace_cast::Look::man()).unwrap()
}

impl Live {
    fn step(&mut self) {
        self.behaviours.advance(&mut self.crowd, 0.1).unwrap();
        self.crowd.update(0.1).unwrap();
    }

    fn member(&self) -> MemberId {
        self.behaviours.people().next().unwrap()
    }

    /// Returns where joints of the first person are in its own space.
    fn joints(&mut self, roles: [Role; 4]) -> [Vec3; 4] {
        let member = self.member();
        let mut member = self.crowd.member_mut(member).unwrap();
        let model = member.model_from_joints().unwrap();
        roles.map(|role| {
            let rows = model[member.joint(role).unwrap().index()].rows;
            Vec3::from(rows.map(|row| row[3]))
        })
    }
}

/// Both hands, the head and the left knee.
const JOINTS: [Role; 4] =
    [Role::Hand(Side::Left), Role::Hand(Side::Right), Role::Head, Role::LowerLeg(Side::Left)];

/// Returns which joints a layer moves by more than 5 mm.
fn moved(layers: &str) -> [bool; 4] {
    let mut both = [live(&stands(layers), man()).unwrap(), live(&stands(""), man()).unwrap()];
    let [with, without] = both.each_mut().map(|live| {
        live.step();
        live.joints(JOINTS)
    });
    std::array::from_fn(|nth| with[nth].distance(without[nth]) > 0.005)
}

#[test]
fn a_layer_moves_the_part_of_the_body_that_its_mask_names() {
    let shield = |mask: &str| moved(&format!("{{ clip = \"Shield\"{mask} }}"));
    assert_eq!(shield(", mask = \"whole_body\""), [true, true, true, true]);
    assert_eq!(shield(", mask = \"upper_body\""), [true, true, true, false]);
    assert_eq!(shield(""), [true, true, true, false]);
    assert_eq!(shield(", mask = \"left_arm\""), [true, false, false, false]);
    assert_eq!(shield(", mask = \"right_arm\""), [false, true, false, false]);
}

#[test]
fn a_part_that_a_character_has_not_is_an_error_that_names_it() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"bin.glb\"]\n[[crowd]]\ncast = \"a\"\n\
                count = 1\nlayers = [{ clip = \"Shield\", mask = \"left_arm\" }]\n\
                does.spectate = {}\n[[seat]]\nat = [0, 0.45, 0]\nfacing_deg = 0\n";
    let bin = populace_props::bin().unwrap();
    let name = format!("{:?}", bin.name);
    let error = live(&ScenePlan::parse(text).unwrap(), bin).err().unwrap();
    let words = error.to_string();
    assert!(words.contains("mask = \"left_arm\"") && words.contains(&name), "{words}");
}

/// A soldier whose layer lifts the shield with the left arm thrusts with the right one.
#[test]
fn a_shield_stays_up_while_the_spear_thrusts() {
    let mut plan = ScenePlan::parse(include_str!("../../../scenes/battle.toml")).unwrap();
    plan.crowds.truncate(1);
    let of = &mut plan.crowds[0];
    (of.count, of.layers[0].share) = (1, 1.0);
    let BehaviourPlan::Fight(fight) = &mut of.does else { panic!("another behaviour") };
    (fight.rank, fight.advance_m, fight.thrust, fight.hit) = (1, 0.5, 60.0, 0.0);
    let mut live = live(&plan, man()).unwrap();
    let (mut lowest, mut ahead) = (f32::MAX, [f32::MAX, f32::MIN]);
    for step in 0..150 {
        live.step();
        let [shield, spear, head, _] = live.joints(JOINTS);
        if step > 20 {
            lowest = lowest.min(shield.y / head.y);
            ahead = [ahead[0].min(spear.z), ahead[1].max(spear.z)];
        }
    }
    assert!(live.behaviours.counts().thrust > 3);
    assert!(ahead[1] - ahead[0] > 0.3, "the spear goes from {} to {}", ahead[0], ahead[1]);
    assert!(lowest > 0.6, "the shield sinks to {lowest} of the height of the head");
}
