use super::super::tests::recording;
use super::*;

#[test]
fn columns_of_the_file_come_before_quantities_of_the_same_name() {
    let recording = recording("id,t,x,y,density\na,0,0,0,150.5\na,1,1,0,250\n");
    let motions = Motions::new(&recording);
    let colours = |name| Colours::new(name, &recording, &motions);
    let density = colours("density").expect("a column");
    assert!(matches!(density.quantity, Quantity::Rows(_)));
    assert_eq!(density.legend.title, "density");
    assert!(matches!(colours("speed").expect("computed").quantity, Quantity::Speed));
    let error = colours("sped").err().expect("no column").to_string();
    let all = "\"sped\"; did you mean \"speed\"?; there are speed, id, density";
    assert!(error.ends_with(all), "{error}");
    let error = colours("z").err().expect("no elevations").to_string();
    assert!(error.ends_with("by \"z\"; there are speed, id, density"), "{error}");
}

#[test]
fn speeds_of_the_whole_recording_are_looked_at() {
    let mut text = "id,t,x,y\n".to_owned();
    for agent in 0..1200 {
        text += &format!("{agent},0,0,{agent}\n{agent},1000,0,{agent}\n");
    }
    // The last one comes late and walks at 2 m/s.
    for second in 990..1000 {
        text += &format!("last,{second},{},0\n", 2 * second);
    }
    let recording = recording(&text);
    let speeds = speeds(&recording, &Motions::new(&recording));
    assert!(speeds.len() <= 50 * SAMPLES + 1201, "{}", speeds.len());
    assert!(speeds.iter().any(|speed| *speed > 1.5), "those at the end");
}

/// Returns the words of the legend of a column, and its values at times.
fn in_words(text: &str, column: &str, at: &[(usize, f64)]) -> (Vec<String>, Vec<f64>) {
    let recording = recording(text);
    let motions = Motions::new(&recording);
    let colours = Colours::new(column, &recording, &motions).expect("a column");
    let value = |(agent, secs): &(usize, f64)| {
        let moment = motions.agents[*agent].at(*secs).expect("somebody");
        colours.value_then(&recording, (*agent, *secs), &moment).expect("a column")
    };
    (colours.legend.words.clone(), at.iter().map(value).collect())
}

#[test]
fn words_of_a_legend_are_in_the_order_of_the_alphabet() {
    let text = "id,t,x,y,group\n1,0,0,0,B\n1,1,1,0,A\n2,0,0,9,C\n2,1,1,9,\n";
    let (words, at) = in_words(text, "group", &[(0, 0.5), (0, 1.0), (1, 0.0), (1, 1.0)]);
    assert_eq!(words, ["A", "B", "C"]);
    assert_eq!(at[..3], [1.0, 0.0, 2.0]);
    assert!(at[3].is_nan(), "no group");
}

#[test]
fn few_whole_numbers_are_words_in_their_order() {
    let text = |numbers: [&str; 4]| {
        let [a, b, c, d] = numbers;
        format!("id,t,x,y,exit\n1,0,0,0,{a}\n1,1,1,0,{b}\n2,0,0,9,{c}\n2,1,1,9,{d}\n")
    };
    let at = [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)];
    let (words, places) = in_words(&text(["16", "8", "-1", ""]), "exit", &at);
    assert_eq!(words, ["-1", "8", "16"]);
    assert_eq!(places[..3], [2.0, 1.0, 0.0]);
    assert!(places[3].is_nan(), "no exit");
    let (words, values) = in_words(&text(["16", "8", "0.5", "8"]), "exit", &at);
    assert_eq!((words.len(), values[0]), (0, 16.0), "a quantity");
    // Words among them leave the numbers sorted as such.
    let (words, _) = in_words(&text(["10", "9", "x", "100"]), "exit", &at);
    assert_eq!(words, ["9", "10", "100", "x"]);
}

#[test]
fn legends_say_that_people_lack_a_value() {
    let has_none = |text: &str| {
        let recording = recording(text);
        let colours = Colours::new("load", &recording, &Motions::new(&recording));
        colours.expect("a column").legend.has_none
    };
    let head = "id,t,x,y,load,type\n".to_owned();
    let rows = head.clone() + "1,0,0,0,0.5,pedestrian\n1,1,1,0,1.5,pedestrian\n";
    assert!(!has_none(&rows));
    assert!(has_none(&(rows.clone() + "2,0,0,9,2.5,pedestrian\n2,1,1,9,,pedestrian\n")));
    assert!(!has_none(&(rows + "c,0,0,9,,car\nc,1,1,9,,car\n")), "vehicles are not drawn");
    assert!(has_none(&(head + "1,0,0,0,A,pedestrian\n1,1,1,0,,pedestrian\n")));
}

#[test]
fn ids_are_words_and_elevations_a_quantity() {
    let text = "id,t,x,y,z\n10,0,0,0,0\n10,9,9,0,0\nb,0,0,9,2\nb,9,9,9,6\n9,0,0,5,4\n9,9,9,5,4\n";
    let at = [(0, 0.0), (1, 0.0), (2, 9.0)];
    let (ids, places) = in_words(text, "id", &at);
    assert_eq!(ids, ["9", "10", "b"]);
    assert_eq!(places, [1.0, 2.0, 0.0]);
    let (words, metres) = in_words(text, "z", &at);
    assert!(words.is_empty());
    for (found, wanted) in metres.iter().zip([0.0, 2.0, 4.0]) {
        assert!((found - wanted).abs() < 0.3, "{metres:?}");
    }
}

#[test]
fn many_whole_numbers_are_a_quantity() {
    let rows = |count: u32| {
        let row = |n: u32| format!("{n},0,0,{n},{n}\n{n},1,1,{n},{n}\n");
        "id,t,x,y,group\n".to_owned() + &(0..count).map(row).collect::<String>()
    };
    assert_eq!(in_words(&rows(10), "group", &[]).0.len(), 10);
    assert_eq!(in_words(&rows(11), "group", &[]).0.len(), 0);
}

#[test]
fn words_of_most_people_have_colours() {
    let mut text = "id,t,x,y,group\n".to_owned();
    // Twelve groups: two people are in some, and one changes over.
    for n in (1..13).chain([2, 8, 9]) {
        let (id, until) = (text.len(), if n == 12 { 1 } else { n });
        text += &format!("{id},0,0,{id},g{n}\n{id},1,1,{id},g{until}\n");
    }
    let people: Vec<(usize, f64)> = (0..12).map(|agent| (agent, 0.0)).collect();
    let (words, places) = in_words(&text, "group", &people);
    assert_eq!(words.len(), 12);
    assert_eq!(words[..10], ["g1", "g10", "g11", "g12", "g2", "g3", "g4", "g5", "g8", "g9"]);
    assert_eq!(words[10..], ["g6", "g7"], "others");
    assert_eq!(places[..2], [0.0, 4.0]);
    assert!(places[5] > 9.0 && places[6] > 9.0, "{places:?}");
}

#[test]
fn trails_have_the_colours_of_their_times() {
    let recording = recording("id,t,x,y,group\n1,0,0,0,B\n1,1,2,0,A\n2,0,0,9,C\n2,1,1,9,C\n");
    let motions = Motions::new(&recording);
    let then = |name: &str, secs: f64| {
        let moment = motions.agents[0].at(secs).expect("somebody");
        let colours = Colours::new(name, &recording, &motions).expect("a quantity");
        colours.value_then(&recording, (0, secs), &moment)
    };
    assert_eq!([then("group", 0.5), then("group", 1.0)], [Some(1.0), Some(0.0)]);
    assert!(then("speed", 0.5).is_some_and(|speed| (speed - 2.0).abs() < 0.1));
    assert_eq!(then("density", 0.5), None, "that of now");
}

#[test]
fn ranges_leave_outliers_out() {
    let mut values: Vec<f64> = (0..100).map(f64::from).collect();
    values.extend([1e9, f64::NAN, -1e9]);
    assert_eq!(range(values), [1.0, 98.0]);
    assert_eq!(range(vec![]), [0.0; 2]);
}
