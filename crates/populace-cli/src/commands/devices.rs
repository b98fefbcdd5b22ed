//! `populace devices`

use serde_json::json;

use crate::cli::DevicesArgs;
use crate::failure::Failure;
use crate::report;

pub(crate) fn run(args: &DevicesArgs) -> Result<(), Failure> {
    let devices = populace::devices();
    let best = populace::Device::best();
    let drawing = populace_render::Renderer::headless([16, 16]).map(|renderer| renderer.driver().to_owned());
    if args.json {
        let list: Vec<_> = devices
            .iter()
            .map(|d| {
                let device = d.device.map(|d| d.to_string());
                json!({"device": device, "name": d.name, "detail": d.detail, "best": d.device == Some(best)})
            })
            .collect();
        let drawing = match &drawing {
            Ok(driver) => json!({"driver": driver}),
            Err(error) => json!({"driver": null, "detail": error.to_string()}),
        };
        return report::json(&json!({"schema": 1, "devices": list, "drawing": drawing}));
    }
    let mut text = String::new();
    for d in &devices {
        let device = d.device.map_or("cannot be used".to_owned(), |d| d.to_string());
        let best = if d.device == Some(best) { ", used unless another is named" } else { "" };
        text += &format!("{device:<10} {}: {}{best}\n", d.name, d.detail);
    }
    text += &match drawing {
        Ok(driver) => format!("{:<10} {driver}\n", "drawing"),
        Err(error) => format!("{:<10} cannot be used: {error}\n", "drawing"),
    };
    report::text(&text)
}
