//! Small pictures, compared with the expected ones.
#![expect(clippy::unwrap_used, reason = "a step that fails fails the test")]

use populace_overlay::{
    Anchor, Canvas, Corner, Label, Legend, Scale, TextStyle, Trail, text_width,
};

const GREY: [u8; 4] = [120, 120, 120, 255];

fn picture([width, height]: [u32; 2]) -> Vec<u8> {
    GREY.repeat((width * height) as usize)
}

/// Returns a grey picture on which `draw` has drawn.
fn drawn(size: [u32; 2], draw: impl FnOnce(&mut Canvas)) -> Vec<u8> {
    let mut rgba = picture(size);
    draw(&mut Canvas::new(&mut rgba, size).unwrap());
    rgba
}

fn pixel(rgba: &[u8], width: u32, [x, y]: [u32; 2]) -> [u8; 4] {
    let begin = 4 * (y * width + x) as usize;
    rgba[begin..begin + 4].try_into().unwrap()
}

/// Returns the pixels that differ from grey.
fn changed(rgba: &[u8], width: u32) -> Vec<[u32; 2]> {
    let indices = (0_u32..).zip(rgba.chunks_exact(4)).filter(|(_, p)| **p != GREY);
    indices.map(|(i, _)| [i % width, i / width]).collect()
}

fn legend(scale: Scale, words: &[&str]) -> Legend {
    Legend {
        title: "Speed".to_owned(),
        unit: "m/s".to_owned(),
        scale,
        words: words.iter().map(|word| (*word).to_owned()).collect(),
        has_none: false,
    }
}

fn trail(points: Vec<[f64; 2]>) -> Trail {
    let colors = vec![[255, 0, 0], [0, 0, 255]];
    Trail { points, colors, depths_m: Vec::new(), opacity: 1.0, width_px: 3.0 }
}

/// Rows of the letters as characters: the lighter, the denser.
fn sketch(rgba: &[u8], width: u32) -> Vec<String> {
    let marks: Vec<_> = " .:+#".chars().collect();
    let rows = rgba.chunks_exact(4 * width as usize);
    rows.map(|row| row.chunks_exact(4).map(|p| marks[usize::from(p[0]) / 52]).collect()).collect()
}

#[test]
fn small_text_is_sharp() {
    let size = [26, 11];
    let mut rgba = [0, 0, 0, 255].repeat(26 * 11);
    let style = TextStyle { halo: false, ..TextStyle::new(12.0) };
    Canvas::new(&mut rgba, size).unwrap().text("E1o", [1.0, 9.0], Anchor::Start, &style);
    let found = sketch(&rgba, size[0]);
    assert_eq!(found, include_str!("text.txt").lines().collect::<Vec<_>>(), "{found:#?}");
}

#[test]
fn text_stays_where_it_is_measured() {
    let style = TextStyle { halo: false, ..TextStyle::new(20.0) };
    for (anchor, begin) in [(Anchor::Start, 0.0), (Anchor::Middle, 0.5), (Anchor::End, 1.0)] {
        let text = "Queue, 3 m";
        let rgba = drawn([300, 60], |canvas| canvas.text(text, [150.0, 30.0], anchor, &style));
        let low = 150.0 - begin * text_width(text, 20.0);
        let inside = low - 1.0..low + text_width(text, 20.0) + 1.0;
        let pixels = changed(&rgba, 300);
        assert!(pixels.len() > 200);
        assert!(pixels.iter().all(|p| inside.contains(&(f64::from(p[0]) + 0.5))), "{anchor:?}");
        assert!(pixels.iter().all(|p| (12..36).contains(&p[1])), "{anchor:?}");
    }
}

#[test]
fn halo_darkens_around_text() {
    let white = [255; 4].repeat(60 * 40);
    let mut rgba = white.clone();
    let style = TextStyle::new(24.0);
    Canvas::new(&mut rgba, [60, 40]).unwrap().text("H", [20.0, 30.0], Anchor::Start, &style);
    let dark = rgba.chunks_exact(4).filter(|p| p[0] < 90).count();
    assert!(dark > 40, "{dark} dark pixels");
}

#[test]
fn labels_do_not_overlap() {
    let label = |x, y, text: &str| Label { at: [x, y], text: text.to_owned() };
    let labels = [
        label(50.0, 50.0, "101"),
        label(55.0, 52.0, "102"),
        label(120.0, 50.0, "103"),
        label(50.0, 80.0, "104"),
        label(1.0, 50.0, "105"),
        label(f64::NAN, 50.0, "106"),
    ];
    let mut shown = Vec::new();
    let style = TextStyle::new(16.0);
    let all = drawn([160, 100], |canvas| shown = canvas.labels(&labels, &style));
    assert_eq!(shown, [0, 2, 3]);
    let kept = [labels[0].clone(), labels[2].clone(), labels[3].clone()];
    let few = drawn([160, 100], |canvas| {
        canvas.labels(&kept, &style);
    });
    assert_eq!(all, few, "the labels left out leave no trace");
}

/// Soft dark edges of text are a part of it.
#[test]
fn labels_near_the_edge_are_whole_or_left_out() {
    let style = TextStyle::new(16.0);
    let shown = |at: [f64; 2]| {
        let (mut shown, labels) = (Vec::new(), [Label { at, text: "107".to_owned() }]);
        let rgba = drawn([160, 100], |canvas| shown = canvas.labels(&labels, &style));
        (changed(&rgba, 160).len(), !shown.is_empty())
    };
    let (whole, _) = shown([80.0, 50.0]);
    let mut left_out = 0;
    for off in 0..40 {
        let off = f64::from(off);
        for at in [[off, 50.0], [160.0 - off, 50.0], [80.0, off], [80.0, 100.0 - off]] {
            let (pixels, is_shown) = shown(at);
            assert_eq!(pixels, if is_shown { whole } else { 0 }, "at {at:?}");
            left_out += usize::from(!is_shown);
        }
    }
    assert!((30..100).contains(&left_out), "{left_out} of 160 are left out");
}

#[test]
fn trails_fade_and_change_colour() {
    let points = vec![[10.0, 10.5], [50.0, 10.5], [90.0, 10.5]];
    let rgba = drawn([100, 20], |canvas| canvas.trails(&[trail(points)], &[]));
    let [old, middle, new] = [12, 45, 88].map(|x| pixel(&rgba, 100, [x, 10]));
    assert!(old[0].abs_diff(120) < 12, "{old:?}");
    assert!(middle[0] > 170 && middle[2] < 80, "{middle:?}");
    assert!(new[2] > 245 && new[0] < 10, "{new:?}");
    assert_eq!(pixel(&rgba, 100, [60, 15]), GREY);
}

#[test]
fn trails_are_faint_behind_surfaces() {
    // From 4 m away to 2 m, behind a wall 2.2 m away in the right half of the picture.
    let points = vec![[10.0, 10.5], [90.0, 10.5]];
    let trail = Trail { colors: vec![[255, 0, 0]], depths_m: vec![4.0, 2.0], ..trail(points) };
    let depths: Vec<f32> =
        (0..2000).map(|pixel| if pixel % 100 < 50 { f32::INFINITY } else { 2.2 }).collect();
    let open = drawn([100, 20], |canvas| canvas.trails(std::slice::from_ref(&trail), &[]));
    let walled = drawn([100, 20], |canvas| canvas.trails(&[trail], &depths));
    let at = |rgba: &[u8], x| pixel(rgba, 100, [x, 10]);
    assert_eq!(at(&walled, 45), at(&open, 45));
    // There the trail is 2.56 m away, and then 2.13 m.
    assert!(at(&walled, 55)[0] < 150 && at(&open, 55)[0] > 180, "{:?}", at(&walled, 55));
    assert_eq!(at(&walled, 80), at(&open, 80));
}

#[test]
fn trail_is_even_where_its_parts_meet() {
    let bent = drawn([100, 20], |canvas| {
        let points = (0..=80).map(|i| [10.0 + f64::from(i), 10.5]).collect();
        canvas.trails(&[Trail { colors: vec![[255; 3]], ..trail(points) }], &[]);
    });
    let row: Vec<_> = (11..90).map(|x| pixel(&bent, 100, [x, 10])[0]).collect();
    assert!(row.windows(2).all(|p| p[0] <= p[1] && p[1] - p[0] < 6), "{row:?}");
}

#[test]
fn legends_leave_room_in_small_pictures() {
    let legend = legend(Scale::number(0.0, 2.0), &[]);
    for size in [[320, 180], [640, 360], [1280, 720]] {
        let rgba = drawn(size, |canvas| canvas.legend(&legend, Corner::TopRight));
        let first = changed(&rgba, size[0]).iter().map(|at| at[0]).min().expect("a legend");
        assert!(first > size[0] * 3 / 5, "from column {first} of {}", size[0]);
    }
}

#[test]
fn bounds_of_legends_are_those_of_what_is_drawn() {
    let numbers = legend(Scale::number(0.0, 2.0), &[]);
    let words = legend(Scale::words(2), &["in", "out"]);
    let with_none = [&numbers, &words].map(|of| Legend { has_none: true, ..of.clone() });
    let corners = [Corner::TopLeft, Corner::TopRight, Corner::BottomLeft, Corner::BottomRight];
    let legends = [&numbers, &words, &with_none[0], &with_none[1]];
    for (legend, corner) in legends.into_iter().flat_map(|of| corners.map(|c| (of, c))) {
        let size = [640, 360];
        let rgba = drawn(size, |canvas| canvas.legend(legend, corner));
        let [low, high] = legend.bounds(size, corner).expect("a legend");
        let drawn = changed(&rgba, size[0]);
        for axis in 0..2 {
            let all = drawn.iter().map(|at| at[axis] as f64);
            let [first, last] = [all.clone().fold(f64::MAX, f64::min), all.fold(0.0, f64::max)];
            assert!((first - low[axis]).abs() < 3.0, "{corner:?}: {first} is not {}", low[axis]);
            assert!((last - high[axis]).abs() < 3.0, "{corner:?}: {last} is not {}", high[axis]);
        }
    }
    let (mut none, size) = (legend(Scale::words(0), &[]), [640, 360]);
    (none.title, none.unit) = (String::new(), String::new());
    assert_eq!(none.bounds(size, Corner::TopRight), None);
}

#[test]
fn legend_shows_the_colours_of_its_scale() {
    let scale = Scale::number(0.0, 2.0);
    let legend = legend(scale.clone(), &[]);
    let rgba = drawn([640, 360], |canvas| canvas.legend(&legend, Corner::BottomRight));
    let found: Vec<_> = rgba.chunks_exact(4).collect();
    for value in [0.05, 1.0, 1.95] {
        let color = scale.color(value).srgb();
        let near = |p: &&[u8]| (0..3).all(|i| p[i].abs_diff(color[i]) <= 3);
        assert!(found.iter().any(near), "{value}: {color:?}");
    }
    let none = Legend { has_none: true, ..legend };
    let rgba = drawn([640, 360], |canvas| canvas.legend(&none, Corner::BottomRight));
    let color = scale.color(f64::NAN).opaque();
    assert!(rgba.chunks_exact(4).filter(|p| **p == color).count() > 40, "none");
    let words = ["pupils", "staff"];
    let scale = Scale::words(2);
    let legend = self::legend(scale.clone(), &words);
    let rgba = drawn([640, 360], |canvas| canvas.legend(&legend, Corner::TopLeft));
    for word in [0.0, 1.0] {
        let color = scale.color(word).opaque();
        assert!(rgba.chunks_exact(4).filter(|p| **p == color).count() > 40, "{word}");
    }
}

/// Ticks stand under both ends of a bar, also where its numbers are not round.
#[test]
fn bars_of_legends_have_ticks_at_both_ends() {
    for (low, high) in [(0.0, 2.0), (0.0, 1.83), (-3.0, 7.0), (0.123, 0.987), (5e9, 5e9 + 1.0)] {
        let scale = Scale::number(low, high);
        let legend = legend(scale.clone(), &[]);
        let rgba = drawn([640, 360], |canvas| canvas.legend(&legend, Corner::TopLeft));
        for (end, value) in [("low", low), ("high", high)] {
            let color = scale.color(value).srgb();
            let near = |at: &[u32; 2]| {
                let found = pixel(&rgba, 640, *at);
                (0..3).all(|i| found[i].abs_diff(color[i]) <= 3)
            };
            let bar = changed(&rgba, 640).into_iter().filter(near);
            // The lowest pixel of its first or last column.
            let key = |at: &[u32; 2]| (if end == "low" { 640 - at[0] } else { at[0] }, at[1]);
            let [x, y] = bar.max_by_key(key).expect("a bar");
            let under = pixel(&rgba, 640, [x, y + 1]);
            assert!(under[0] > 150, "{low} to {high}: {under:?} under the {end} end");
        }
    }
}

#[test]
fn panels_lie_in_their_corners_at_any_size() {
    for size in [[640, 360], [1920, 1080]] {
        let [width, height] = size;
        for (corner, right, bottom) in [
            (Corner::TopLeft, false, false),
            (Corner::TopRight, true, false),
            (Corner::BottomLeft, false, true),
            (Corner::BottomRight, true, true),
        ] {
            let legend = legend(Scale::words(30), &["a long name of a group"; 30]);
            for rgba in [
                drawn(size, |canvas| canvas.clock(3_599.96, corner)),
                drawn(size, |canvas| canvas.legend(&legend, corner)),
            ] {
                let pixels = changed(&rgba, width);
                let in_corner = |p: &[u32; 2]| {
                    let [x, y] =
                        [f64::from(p[0]) / f64::from(width), f64::from(p[1]) / f64::from(height)];
                    let [x, y] =
                        [if right { 1.0 - x } else { x }, if bottom { 1.0 - y } else { y }];
                    x > 0.003 && y > 0.003 && x < 0.45 && y < 0.7
                };
                assert!(!pixels.is_empty() && pixels.iter().all(in_corner), "{size:?} {corner:?}");
            }
        }
    }
}

#[test]
fn tiny_pictures_and_odd_input_are_drawn_without_harm() {
    for size in [[1, 1], [0, 0], [3, 2], [640, 1]] {
        drawn(size, |canvas| {
            canvas.clock(1.0, Corner::TopLeft);
            canvas.legend(&legend(Scale::number(f64::NAN, 1.0), &[]), Corner::BottomRight);
            canvas.legend(&legend(Scale::words(3), &["", "b"]), Corner::TopRight);
            canvas.legend(&legend(Scale::words(0), &[]), Corner::TopRight);
            canvas.labels(&[], &TextStyle::new(12.0));
            canvas.trails(&[trail(vec![]), trail(vec![[0.0; 2]]), trail(vec![[1e300; 2]; 3])], &[]);
            let far = trail(vec![[-1e9, 0.0], [1e9, 1.0], [f64::NAN, 0.0], [f64::INFINITY, 2.0]]);
            canvas.trails(&[far], &[]);
            for size_px in [0.0, -3.0, f64::NAN, f64::INFINITY, 1e-9, 1e5] {
                canvas.text("Az漢\u{0}", [0.0, 1.0], Anchor::Middle, &TextStyle::new(size_px));
            }
            canvas.text("", [f64::NAN, 1.0], Anchor::End, &TextStyle::new(12.0));
        });
    }
}
