//! Scene files: what is written is read again, and what is wrong is named with its line.

use populace_scene::plan::{MaskPlan, ScenePlan};
use populace_scene::{StreetSettings, street};

/// A file with a footway and people on it, before a line that is put in.
const GOOD: &str = "\
schema = 1

[[cast]]
name = \"people\"
from = [\"@people\"]

[[footway]]
name = \"path\"
points = [[0, 0], [20, 0]]
width_m = 4

[[crowd]]
cast = \"people\"
count = 20
does.stroll = { speed = 1.2 }
";

#[path = "../../../fuzz/seeds.rs"]
mod fuzz_seeds;

#[track_caller]
fn refused(text: &str, line: usize, words: &str) {
    let error = ScenePlan::parse(text).expect_err("a refusal");
    assert_eq!(error.line, line, "{error}");
    assert!(error.message.contains(words), "no {words:?} in: {error}");
}

#[test]
fn a_street_is_written_and_read_again() {
    let [large, plan] = [20_000, 500].map(|members| street(StreetSettings { members, seed: 3 }));
    assert!(large.to_toml().is_ok(), "{:?}", large.to_toml().err());
    let text = plan.to_toml().unwrap();
    assert_eq!(ScenePlan::parse(&text).unwrap(), plan);
    assert!(text.starts_with("schema = 1\n"), "{text}");
    fuzz_seeds::write("scene_file", "street", text.as_bytes());
}

#[test]
fn a_small_file_is_read() {
    let plan = ScenePlan::parse(GOOD).unwrap();
    fuzz_seeds::write("scene_file", "small", GOOD.as_bytes());
    assert_eq!(plan.member_count(), 20);
    assert_eq!(plan.light.sky, "day", "what is left out has its default");
}

#[test]
fn misspelt_keys_are_named_with_their_line_and_the_nearest() {
    refused(
        &GOOD.replace("width_m", "widht_m"),
        10,
        "no key `widht_m` here; did you mean \"width_m\"",
    );
    refused(&GOOD.replace("does.stroll", "does.strol"), 15, "no key `strol`");
    refused(&GOOD.replace("speed", "sped"), 15, "did you mean \"speed\"");
    refused(&GOOD.replace("[[crowd]]", "[[crowds]]"), 12, "did you mean \"crowd\"");
    refused(&GOOD.replace("count = 20\n", ""), 12, "missing field `count`");
    refused("schema = 1\nseed = x\n", 2, "");
    let single = GOOD.replace("[[crowd]]", "[crowd]");
    refused(&single, 12, "`crowd` must be a list, not a table; each is written as `[[crowd]]`");
    let twice = format!("{single}\n[crowd]\ncast = \"people\"\n");
    refused(&twice, 17, "`crowd` is written a second time here; each is written as `[[crowd]]`");
    refused(
        &GOOD.replace("seed", "").replace("schema = 1", "schema = 1\nseed = 1\nseed = 2"),
        3,
        "`seed` is written a second time here",
    );
}

#[test]
fn values_out_of_range_and_unknown_names_are_named_with_their_line() {
    refused(&GOOD.replace("schema = 1", "schema = 2"), 1, "`schema` must be 1");
    refused(&GOOD.replace("count = 20", "count = 0"), 14, "`count` of a [[crowd]] must be from 1");
    let negative = "`count` must be a whole number from 1 on, not -9";
    refused(&GOOD.replace("count = 20", "count = -9"), 14, negative);
    refused(
        &GOOD.replace("cast = \"people\"", "cast = \"poeple\""),
        13,
        "none is \"poeple\"; did you mean \"people\"",
    );
    refused(&GOOD.replace("width_m = 4", "width_m = -4"), 10, "`width_m` of a [[footway]]");
    refused(&GOOD.replace(", [20, 0]", ""), 9, "at least two points");
    refused(
        &GOOD.replace("[20, 0]", "[2e7, 0]"),
        9,
        "from -1000000 to 1000000 metres, not 20000000",
    );
    let twice = format!("{GOOD}\n[[cast]]\nname = \"people\"\nfrom = [\"@man\"]\n");
    refused(&twice, 18, "must be unique");
    let bay = format!("{GOOD}\n[[bay]]\nlane = \"north\"\nat = [0, 0]\n");
    refused(&bay, 18, "none is \"north\"");
    let lane = "[[lane]]\nname = \"north\"\nends = [[0, 0], [40, 0]]\nvehicles = 2\n";
    let at_end = bay.replace("at = [0, 0]", "at = [36, 3]") + lane;
    refused(&at_end, 19, "9 metres or more from both of its ends");
    let camera =
        "\n[[camera]]\nname = \"a\"\n[[camera.key]]\nfrom = [0, 1, 2]\nto = [0, 1, 0]\nfov = 0\n";
    refused(&format!("{GOOD}{camera}"), 22, "`fov` of `key` of a [[camera]] must be from 1 to 170");
    let stroll = GOOD.replace("speed = 1.2", "footways = [\"road\"]");
    refused(&stroll, 15, "none is \"road\"");
}

#[test]
fn a_prop_is_of_a_kind_or_of_a_file() {
    let with = |keys: &str| format!("{GOOD}\n[[prop]]\nat = [0, 0, 0]\n{keys}\n");
    let plan = ScenePlan::parse(&with("file = \"kiosk.glb\"")).unwrap();
    assert_eq!(plan.props[0].file.as_deref(), Some("kiosk.glb"));
    assert_eq!(ScenePlan::parse(&plan.to_toml().unwrap()).unwrap(), plan);
    refused(&with("kind = \"banch\""), 19, "did you mean \"bench\"");
    refused(&with("kind = \"bench\"\nfile = \"kiosk.glb\""), 20, "one or the other");
    refused(&with(""), 17, "there must be a `file`");
}

#[test]
fn layers_move_a_part_of_the_body_that_is_named() {
    let with = |mask: &str| format!("{GOOD}layers = [{{ clip = \"Wave\"{mask} }}]\n");
    for (mask, part) in [
        ("", MaskPlan::UpperBody),
        (", mask = \"whole_body\"", MaskPlan::WholeBody),
        (", mask = \"upper_body\"", MaskPlan::UpperBody),
        (", mask = \"left_arm\"", MaskPlan::LeftArm),
        (", mask = \"right_arm\"", MaskPlan::RightArm),
    ] {
        let plan = ScenePlan::parse(&with(mask)).unwrap();
        assert_eq!(plan.crowds[0].layers[0].mask, part, "{mask}");
        assert_eq!(ScenePlan::parse(&plan.to_toml().unwrap()).unwrap(), plan);
    }
    let misspelt = with(", mask = \"left_amr\"");
    refused(&misspelt, 16, "no value `left_amr` here; did you mean \"left_arm\"");
    refused(
        &with(", mask = \"tail\""),
        16,
        "there are whole_body, upper_body, left_arm, right_arm",
    );
    refused(&with(", msak = \"left_arm\""), 16, "no key `msak` here; did you mean \"mask\"");
}

#[test]
fn values_of_another_type_are_named_with_their_key_and_what_is_expected() {
    let with = |prop: &str| format!("{GOOD}\n[[prop]]\nkind = \"bench\"\n{prop}\n");
    refused(&with("at = [0, 0]"), 19, "`at` must be a list of 3 numbers, not of 2");
    refused(&with("at = 4"), 19, "`at` must be a list of 3 numbers, not 4");
    refused(&with("at = [0, 0, true]"), 19, "`at` must be a number, not true");
    refused(
        &with("at = [0, 0, 0]\nfacing_deg = \"south\""),
        20,
        "`facing_deg` must be a number, not the text \"south\"",
    );
    refused(
        &with("at = [0, 0, 0]\nseed = -3"),
        20,
        "`seed` must be a whole number from 0 on, not -3",
    );
    refused(&GOOD.replace("count = 20", "count = -3"), 14, "`count` must be a whole number");
    refused(&GOOD.replace("count = 20", "count = 2.5"), 14, "from 1 on, not 2.5");
    refused(
        &GOOD.replace("speed = 1.2", "speed = [1]"),
        15,
        "`speed` must be a number, not a list",
    );
    refused(&GOOD.replace("{ speed = 1.2 }", "7"), 15, "`stroll` must be a table, not 7");
    refused(&GOOD.replace("[20, 0]", "[20]"), 9, "`points` must be a list of 2 numbers, not of 1");
    refused(
        &GOOD.replace("name = \"path\"", "name = 3"),
        8,
        "`name` must be a text in quotes, not 3",
    );
}

#[test]
fn names_that_resemble_none_come_with_all_that_there_are() {
    let sky = format!("{GOOD}\n[light]\nsky = \"night\"\n");
    refused(&sky, 18, "none is \"night\"; there are day, evening, overcast, studio");
    let holds = |thing: &str| GOOD.replace("from = [", &format!("holds = [\"{thing}\"]\nfrom = ["));
    refused(&holds("sword"), 5, "none is \"sword\"; there are box, helmet, phone, shield, spear");
    refused(&holds("shild"), 5, "did you mean \"shield\"");
    let file = "\n[[prop]]\nfile = \"sword.glb\"\nat = [0, 0, 0]\n";
    ScenePlan::parse(&(holds("sword.glb") + file)).unwrap();
    let words = "the right hand has \"phone\" and \"spear\"";
    refused(&holds("shield\", \"phone\", \"spear"), 5, words);
    refused(&holds("helmet\", \"helmet"), 5, "the head has \"helmet\" and \"helmet\"");
    ScenePlan::parse(&holds("helmet\", \"shield\", \"spear")).unwrap();
}

#[test]
fn footways_with_more_people_than_find_room_are_doubted() {
    let text = |count: usize, vehicles: usize| {
        format!(
            "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[footway]]\n\
             name = \"short\"\npoints = [[0, 0], [9, 0]]\nwidth_m = 3\n[[footway]]\n\
             name = \"long\"\npoints = [[0, 9], [18, 9]]\nwidth_m = 30\n[[crowd]]\n\
             cast = \"a\"\ncount = {count}\ndoes.stroll = {{}}\n[[lane]]\nname = \"l\"\n\
             ends = [[0, 90], [900, 90]]\nvehicles = {vehicles}\n"
        )
    };
    let doubts = |count, vehicles| ScenePlan::parse(&text(count, vehicles)).unwrap().doubts();
    // A third is on the short one, of 27 square metres.
    assert!(doubts(400, 0).is_empty() && doubts(500, 100).is_empty());
    let found = doubts(450, 0);
    let words = "the footway \"short\", 9.0 m long and 3.0 m wide, has 150 people, 6 on a square";
    assert!(found.len() == 1 && found[0].starts_with(words), "{found:?}");
    for members in [24, 300, 3000] {
        let plan = street(StreetSettings { members, seed: 1 });
        assert_eq!(plan.doubts(), [""; 0], "{members} people");
    }
}
