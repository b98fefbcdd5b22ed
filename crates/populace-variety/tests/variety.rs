//! Crowds of the built-in people, held to what variety promises.

use populace_character::{Character, Material, Region};
use populace_variety::{Appearance, Variety, clones};

fn grid(count: usize, characters: usize) -> Vec<(usize, [f32; 3])> {
    let side = count.isqrt().max(1);
    (0..count).map(|i| (i % characters, [(i % side) as f32, 0.0, (i / side) as f32])).collect()
}

fn dressed(people: &[Character], count: usize, seed: u64) -> (usize, Vec<Appearance>) {
    let characters: Vec<&Character> = people.iter().collect();
    let members = grid(count, people.len());
    let appearances = Variety { seed, ..Variety::default() }.appearances(&characters, &members);
    (clones(&members, &appearances), appearances)
}

#[test]
fn neighbours_share_no_head_and_top_even_with_one_character() {
    let people = populace_cast::cast().unwrap();
    for seed in 0..3 {
        assert_eq!(dressed(&people, 2000, seed).0, 0);
        assert_eq!(dressed(&people[..1], 2000, seed).0, 0);
    }
    let members = grid(100, 1);
    let alike = vec![dressed(&people[..1], 1, 0).1[0]; 100];
    assert!(clones(&members, &alike) > 1000, "equal members are clones");
}

#[test]
fn seeds_decide_everything() {
    let people = populace_cast::cast().unwrap();
    assert_eq!(dressed(&people, 300, 5), dressed(&people, 300, 5));
    assert_ne!(dressed(&people, 300, 5), dressed(&people, 300, 6));
}

#[test]
fn members_with_keys_look_the_same_whoever_else_is_there() {
    let people = populace_cast::cast().unwrap();
    let characters: Vec<&Character> = people.iter().collect();
    let variety = Variety { seed: 5, ..Variety::default() };
    let of = |members: &[(usize, u64)]| variety.appearances_by_key(&characters, members);
    let members: Vec<_> = (0..50).map(|i| (i % people.len(), 1000 * i as u64)).collect();
    let all = of(&members);
    let backwards: Vec<_> = members.iter().rev().copied().collect();
    assert_eq!(of(&backwards).into_iter().rev().collect::<Vec<_>>(), all);
    assert_eq!(of(&members[7..8]), all[7..8]);
    let same = |nth: usize| all.iter().filter(|other| other.look == all[nth].look).count();
    assert!((0..50).all(|nth| same(nth) == 1), "looks differ by key");
    assert_ne!(Variety { seed: 6, ..variety }.appearances_by_key(&characters, &members), all);
}

#[test]
fn heights_and_paces_stay_within_their_ranges() {
    let people = populace_cast::cast().unwrap();
    let (_, appearances) = dressed(&people, 1000, 1);
    let spread = |of: fn(&Appearance) -> f32| {
        let values: Vec<f32> = appearances.iter().map(of).collect();
        let low = values.iter().copied().fold(f32::MAX, f32::min);
        (low, values.iter().copied().fold(f32::MIN, f32::max))
    };
    let (short, tall) = spread(|a| a.height);
    assert!((0.9375..0.96).contains(&short) && (1.04..=1.0625).contains(&tall), "{short} {tall}");
    let (slow, fast) = spread(|a| a.pace);
    assert!((0.94..0.95).contains(&slow) && (1.05..=1.06).contains(&fast), "{slow} {fast}");
}

#[test]
fn regions_get_the_chosen_colours_whatever_the_character_wears() {
    let people = populace_cast::cast().unwrap();
    let (_, appearances) = dressed(&people, 400, 2);
    let mut tops: Vec<[u64; 3]> = Vec::new();
    for (number, appearance) in appearances.iter().enumerate() {
        let character = &people[number % people.len()];
        let is_top = |m: &&Material| Region::of_material(&m.name) == Some(Region::Top);
        let Some(top) = character.materials.iter().find(is_top) else { continue };
        let tint = appearance.look.tint(Region::Top);
        let shown = [0, 1, 2].map(|c: usize| tint[c] * top.base_color[c]);
        assert!(shown.iter().all(|c| (0.0..0.95).contains(c)), "{shown:?}");
        tops.push(shown.map(|c| f64::from(c * 20.0).round().to_bits()));
    }
    tops.sort_unstable();
    tops.dedup();
    assert!(tops.len() > 15, "{} kinds of tops", tops.len());
}

#[test]
fn heights_and_paces_stay_above_zero_for_all_settings() {
    let people = populace_cast::cast().unwrap();
    let characters: Vec<_> = people.iter().collect();
    let members: Vec<_> = (0..200).map(|i| (0, [i as f32, 0.0, 0.0])).collect();
    for of in [f32::NAN, f32::INFINITY, -1.0, 0.5, 3.0] {
        let variety = Variety { height: of, pace: of, ..Variety::default() };
        for appearance in variety.appearances(&characters, &members) {
            let Appearance { height, pace, .. } = appearance;
            assert!((0.25..=1.75).contains(&height) && (0.1..=1.9).contains(&pace), "{of}");
        }
    }
}
