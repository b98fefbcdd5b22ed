//! Draws a picture with everything over it: `cargo run --example look -- FILE.png WIDTH HEIGHT`.

use populace_overlay::{Anchor, Canvas, Corner, Label, Legend, Scale, TextStyle, Trail};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let path = words.next().ok_or("name a PNG file to write")?;
    let size = [words.next().unwrap_or("960".into()), words.next().unwrap_or("540".into())];
    let size = [size[0].parse::<u32>()?, size[1].parse::<u32>()?];
    let grey = |x: u32, y: u32| {
        u8::try_from(60 + 150 * x / size[0] + (x / 8 + y / 8) % 2 * 12).unwrap_or(255)
    };
    let mut rgba: Vec<u8> = (0..size[1])
        .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
        .flat_map(|(x, y)| [grey(x, y), grey(x, y), grey(x, y), 255])
        .collect();
    let mut canvas = Canvas::new(&mut rgba, size)?;
    let [width, height] = size.map(f64::from);
    let scale = Scale::number(0.0, 1.83);
    let point = |trail: u32, i: u32| {
        let (t, u) = (f64::from(i) / 40.0, f64::from(trail) / 8.0);
        [(0.1 + 0.75 * t) * width, (0.3 + 0.4 * u + 0.08 * (9.0 * t + 5.0 * u).sin()) * height]
    };
    let trails: Vec<_> = (0..8)
        .map(|trail| Trail {
            points: (0..=40).map(|i| point(trail, i)).collect(),
            colors: (0..40).map(|i| scale.color(f64::from(i) / 22.0).srgb()).collect(),
            depths_m: Vec::new(),
            opacity: 0.9,
            width_px: height / 180.0,
        })
        .collect();
    canvas.trails(&trails, &[]);
    let labels: Vec<_> = (0..8)
        .map(|trail| Label { at: point(trail, 40), text: format!("{}", 101 + trail) })
        .collect();
    let style = TextStyle::new(canvas.text_size());
    canvas.labels(&labels, &style);
    let mut y = 0.25 * height;
    for size_px in [12.0, 16.0, 24.0, 48.0] {
        let text = "Sphinx of black quartz, judge 0123456789 (µm/s²) · 20° ×";
        canvas.text(text, [0.03 * width, y], Anchor::Start, &TextStyle::new(size_px));
        y += 1.6 * size_px;
    }
    canvas.clock(12.4, Corner::TopLeft);
    let legend = |title: &str, unit: &str, scale: Scale, words: &[&str]| Legend {
        title: title.to_owned(),
        unit: unit.to_owned(),
        scale,
        words: words.iter().map(|word| (*word).to_owned()).collect(),
        has_none: true,
    };
    canvas.legend(&legend("Speed", "m/s", scale, &[]), Corner::BottomRight);
    canvas.legend(&legend("Density", "1/m²", Scale::number(-0.5, 4.0), &[]), Corner::TopRight);
    let groups = ["commuters", "pupils", "staff", "d", "e", "f", "g", "h", "i", "j"];
    canvas.legend(&legend("Group", "", Scale::words(10), &groups), Corner::BottomLeft);
    image::save_buffer(path, &rgba, size[0], size[1], image::ColorType::Rgba8)?;
    Ok(())
}
