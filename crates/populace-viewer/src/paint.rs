//! The panels as triangles for the renderer.

use egui::epaint::{ClippedPrimitive, ImageData, Primitive};
use egui::{Context, FullOutput, TextureId};
use populace_render::{Error, Renderer, Sheet, SheetCorner, TexturePatch};

/// The texture with the picture and what the show drew over it.
pub(crate) const OVER: u64 = u64::MAX;

/// Triangles of a frame.
struct Painted {
    clip: [u32; 4],
    texture: u64,
    corners: Vec<SheetCorner>,
    indices: Vec<u32>,
}

/// The place of the picture in the window, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Width and height of the window.
    pub(crate) window: [u32; 2],
    /// Upper left corner of the picture.
    pub(crate) at: [i32; 2],
    /// Its width and height.
    pub(crate) size: [u32; 2],
    /// sRGB colour beside the picture, from 0 to 1.
    pub(crate) margin: [f32; 3],
}

/// Brings the last picture and the panels into the window.
pub(crate) fn paint(
    renderer: &mut Renderer,
    context: &Context,
    output: FullOutput,
    frame: &Frame,
) -> Result<(), Error> {
    for (id, delta) in &output.textures_delta.set {
        let ImageData::Color(image) = &delta.image;
        let rgba: Vec<u8> = image.pixels.iter().flat_map(egui::Color32::to_array).collect();
        renderer.set_texture(&TexturePatch {
            texture: number(*id),
            at: delta.pos.map(|at| at.map(u32_from)),
            size: image.size.map(u32_from),
            rgba: &rgba,
        })?;
    }
    let scale = output.pixels_per_point;
    let panels = context.tessellate(output.shapes, scale).into_iter();
    let panels = panels.filter_map(|primitive| triangles(primitive, scale, frame.window));
    let painted: Vec<Painted> = std::iter::once(over(frame)).chain(panels).collect();
    let sheets: Vec<Sheet<'_>> = painted
        .iter()
        .map(|p| Sheet {
            clip: p.clip,
            texture: p.texture,
            corners: &p.corners,
            indices: &p.indices,
        })
        .collect();
    renderer.compose(frame.window, frame.at, frame.margin, &sheets)?;
    output.textures_delta.free.iter().for_each(|id| renderer.remove_texture(number(*id)));
    Ok(())
}

fn triangles(primitive: ClippedPrimitive, scale: f32, window: [u32; 2]) -> Option<Painted> {
    let Primitive::Mesh(mesh) = primitive.primitive else { return None };
    let rect = primitive.clip_rect;
    let pixel = |points: f32, most: u32| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "floats saturate"
        )]
        let pixel = (points * scale).round().max(0.0) as u32;
        pixel.min(most)
    };
    let [left, right] = [rect.min.x, rect.max.x].map(|x| pixel(x, window[0]));
    let [top, bottom] = [rect.min.y, rect.max.y].map(|y| pixel(y, window[1]));
    let clip = [left, top, right.saturating_sub(left), bottom.saturating_sub(top)];
    let corner = |vertex: &egui::epaint::Vertex| SheetCorner {
        position: [vertex.pos.x * scale, vertex.pos.y * scale],
        uv: [vertex.uv.x, vertex.uv.y],
        color: vertex.color.to_array(),
    };
    let corners = mesh.vertices.iter().map(corner).collect();
    let texture = number(mesh.texture_id);
    (clip[2] > 0 && clip[3] > 0).then_some(Painted {
        clip,
        texture,
        corners,
        indices: mesh.indices,
    })
}

/// Returns the rectangle of the picture, which is drawn if there is a texture for it.
fn over(frame: &Frame) -> Painted {
    let [x, y] = frame.at.map(|at| u32::try_from(at).unwrap_or(0));
    let [width, height] = frame.size;
    #[expect(clippy::cast_precision_loss, reason = "no window is 2^24 pixels wide")]
    let corner = |u: f32, v: f32| SheetCorner {
        position: [x as f32 + u * width as f32, y as f32 + v * height as f32],
        uv: [u, v],
        color: [u8::MAX; 4],
    };
    Painted {
        clip: [x, y, width, height],
        texture: OVER,
        corners: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

/// Returns the renderer's number of a texture.
fn number(id: TextureId) -> u64 {
    match id {
        TextureId::Managed(number) => 2 * number,
        TextureId::User(number) => 2 * number + 1,
    }
}

fn u32_from(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}
