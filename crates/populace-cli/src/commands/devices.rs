//! `populace devices`

use populace::{Device, DeviceReport};
use populace_render::{PaletteInterop, Renderer};
use serde_json::json;

use crate::cli::DevicesArgs;
use crate::failure::Failure;
use crate::report;

/// The transport of a device's palettes to OpenGL, or the reason why there is none.
type PaletteReport = Result<PaletteInterop, String>;

pub(crate) fn run(args: &DevicesArgs) -> Result<(), Failure> {
    let best = Device::best();
    let mut renderer = Renderer::headless([16, 16]);
    let devices = populace::devices().into_iter().map(|report| {
        let palettes = match (report.device, &mut renderer) {
            (Some(device), Ok(renderer)) => Some(try_palettes(device, renderer)),
            _ => None,
        };
        (report, palettes)
    });
    let devices: Vec<_> = devices.collect();
    let drawing = renderer.map(|renderer| renderer.driver().to_owned());
    if args.json {
        let list: Vec<_> =
            devices.iter().map(|(report, palettes)| as_json(report, palettes, best)).collect();
        let drawing = match &drawing {
            Ok(driver) => json!({"driver": driver}),
            Err(error) => json!({"driver": null, "detail": error.to_string()}),
        };
        return report::json(&json!({"schema": 1, "devices": list, "drawing": drawing}));
    }
    let mut text = String::new();
    for (d, palettes) in &devices {
        let device = d.device.map_or("unusable".to_owned(), |d| d.to_string());
        let best = if d.device == Some(best) { ", the default" } else { "" };
        text += &format!("{device:<10} {}: {}{best}\n", d.name, d.detail);
        text += &match palettes {
            Some(Ok(way)) => format!("{:<10} palettes {way}\n", ""),
            Some(Err(reason)) => {
                format!("{:<10} palettes cannot be passed to OpenGL: {reason}\n", "")
            }
            None => String::new(),
        };
    }
    text += &match drawing {
        Ok(driver) => format!("{:<10} {driver}\n", "drawing"),
        Err(error) => format!("{:<10} unusable: {error}\n", "drawing"),
    };
    report::text(&text)
}

/// Passes empty palettes to OpenGL, since only a trial shows what drivers can do.
fn try_palettes(device: Device, renderer: &mut Renderer) -> PaletteReport {
    let palettes = device.empty_palettes(&renderer.gl_context());
    renderer.connect_palettes(&mut *palettes.map_err(|e| e.to_string())?).map_err(|e| e.to_string())
}

fn as_json(
    report: &DeviceReport,
    palettes: &Option<PaletteReport>,
    best: Device,
) -> serde_json::Value {
    let palettes = palettes.as_ref().map(|palettes| match palettes {
        Ok(PaletteInterop { transport: way, refused }) => {
            let refused: Vec<_> = refused
                .iter()
                .map(|(way, reason)| json!({"way": way.name(), "reason": reason}))
                .collect();
            json!({"way": way.name(), "refused": refused})
        }
        Err(reason) => json!({"way": null, "detail": reason}),
    });
    json!({
        "device": report.device.map(|d| d.to_string()),
        "name": report.name,
        "detail": report.detail,
        "best": report.device == Some(best),
        "palettes": palettes,
    })
}
