use super::*;

#[test]
fn outfits_differ_between_numbers_and_builds() {
    let looks: Vec<Look> = (0..5)
        .flat_map(|n| Look::presets().into_iter().map(move |look| look.in_outfit(n)))
        .collect();
    for (index, a) in looks.iter().enumerate() {
        for b in &looks[..index] {
            assert_ne!(a.name, b.name);
            let same = a.rig == b.rig && a.hair == b.hair;
            assert!(!same || a.colors != b.colors, "{} and {} are clones", a.name, b.name);
        }
    }
    assert_eq!(Look::man().in_outfit(0), Look::man());
}

#[test]
fn outfits_of_all_numbers_are_there() {
    let last = Look::man().in_outfit(usize::MAX);
    assert!(last.name.ends_with(&usize::MAX.to_string()), "{}", last.name);
}
