//! An engine that draws a crowd with its own OpenGL renderer. All that it takes from `populace` are
//! the character's meshes, the instances and the pages of palettes.
//!
//! It uploads each page as a storage buffer and draws all members of a page with one call for each
//! part. The vertex shader skins. It needs EGL with Mesa's surfaceless platform, and OpenGL 4.3.
//!
//! `cargo run -p populace --example own_renderer [PICTURE.png]`

#![expect(unsafe_code, reason = "the engine makes its calls to EGL and OpenGL itself")]
#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod figure;
mod gl;

use std::error::Error;

use glam::{Mat4, Vec3, camera::rh};
use glow::HasContext;
use populace::character::{Character, Part};
use populace::interop::{PAGE_ENTRIES, PaletteSource};
use populace::{ClipPlayback, Crowd, Device, Placement};

/// The picture is drawn at twice this size, for smooth edges.
const SIZE: [u16; 2] = [960, 400];
const MEMBER_COUNT: u16 = 40;
const FRAMES: u16 = 20;
/// Bindings of the storage buffers, and locations of the uniforms.
const PALETTES: u32 = 0;
const MEMBERS: u32 = 1;
const CAMERA: glow::NativeUniformLocation = glow::NativeUniformLocation(0);
const PART_COLOR: glow::NativeUniformLocation = glow::NativeUniformLocation(1);
const SHADOW: glow::NativeUniformLocation = glow::NativeUniformLocation(2);
/// Linear colours of shirts.
const SHIRTS: [[f32; 3]; 5] =
    [[0.55, 0.08, 0.06], [0.07, 0.2, 0.48], [0.75, 0.5, 0.1], [0.1, 0.33, 0.16], [0.62, 0.6, 0.56]];

const SKIN: &str = include_str!("skin.vert");
const GROUND: &str = include_str!("ground.vert");
const FRAGMENT: &str = "#version 430
    in vec3 color;
    out vec4 result;
    void main() { result = vec4(color, 1); }";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "own_renderer.png".into());
    let mut crowd = Crowd::builder().device(Device::native()).build()?;
    let figure = crowd.add_character(figure::figure()?)?;
    let walk = crowd.clip(figure, "Walk")?;
    for nth in 0..MEMBER_COUNT {
        let [column, row] = [nth % 10, nth / 10].map(f32::from);
        let place = [1.1 * column - 4.95 + 0.4 * (row % 2.0), 0.0, -1.6 * row];
        let member =
            crowd.spawn(figure, Placement::at(place).facing(0.2 * (column % 3.0) - 0.2))?;
        let phase = (f32::from(nth) * 0.37).fract();
        crowd.member_mut(member)?.play(walk, ClipPlayback::looping().phase(phase))?;
    }
    let engine = Engine::new(gl::context()?, crowd.character(figure)?.asset())?;
    for _ in 0..FRAMES {
        crowd.update(1.0 / 60.0)?;
        engine.draw(&mut crowd)?;
    }
    engine.save(&path)?;
    println!("{} members, drawn to {path}", crowd.member_count());
    Ok(())
}

/// A mesh in OpenGL's memory.
struct UploadedPart {
    vertices: glow::VertexArray,
    index_count: i32,
    /// The colour, and in its fourth component how much of the member's shirt colour is seen.
    color: [f32; 4],
}

struct Engine {
    gl: glow::Context,
    skinned: glow::Program,
    ground: glow::Program,
    parts: Vec<UploadedPart>,
    /// Storage buffers by their bindings.
    buffers: [glow::Buffer; 2],
}

impl Engine {
    fn new(gl: glow::Context, character: &Character) -> Result<Self> {
        let [width, height] = SIZE.map(|side| 2 * i32::from(side));
        // SAFETY: the context is current, and all objects come from it.
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(gl.create_framebuffer()?));
            for (attachment, format) in [
                (glow::COLOR_ATTACHMENT0, glow::SRGB8_ALPHA8),
                (glow::DEPTH_ATTACHMENT, glow::DEPTH_COMPONENT24),
            ] {
                let storage = gl.create_renderbuffer()?;
                gl.bind_renderbuffer(glow::RENDERBUFFER, Some(storage));
                gl.renderbuffer_storage(glow::RENDERBUFFER, format, width, height);
                let target = glow::RENDERBUFFER;
                gl.framebuffer_renderbuffer(glow::FRAMEBUFFER, attachment, target, Some(storage));
            }
            gl.viewport(0, 0, width, height);
            gl.enable(glow::FRAMEBUFFER_SRGB);
            gl.enable(glow::CULL_FACE);
            gl.enable(glow::DEPTH_TEST);
            let uploaded = |part| upload(&gl, character, part);
            let parts = character.parts.iter().map(uploaded).collect::<Result<_>>()?;
            let buffers = [gl.create_buffer()?, gl.create_buffer()?];
            let (skinned, ground) =
                (gl::program(&gl, SKIN, FRAGMENT)?, gl::program(&gl, GROUND, FRAGMENT)?);
            Ok(Self { gl, skinned, ground, parts, buffers })
        }
    }

    /// Draws the crowd in the state of its last update.
    fn draw(&self, crowd: &mut Crowd) -> Result<()> {
        let [width, height] = SIZE.map(f32::from);
        let (eye, target) = (Vec3::new(0.0, 2.7, 6.2), Vec3::new(0.0, 0.75, -2.0));
        let view = rh::view::look_at_mat4(eye, target, Vec3::Y);
        let camera = rh::proj::opengl::perspective(0.7, width / height, 0.1, 100.0) * view;
        let mut pages = vec![Vec::new(); crowd.page_lengths().len()];
        for (nth, instance) in crowd.instances().enumerate() {
            let mut member: Vec<f32> = instance.world_from_model.rows.concat();
            member.extend(SHIRTS[nth % SHIRTS.len()]);
            // The shader reads these bits as an integer.
            member.push(f32::from_bits(instance.palette_first % PAGE_ENTRIES));
            pages[(instance.palette_first / PAGE_ENTRIES) as usize].extend(member);
        }
        self.begin(camera);
        for (page, members) in pages.iter().enumerate() {
            crowd.with_page(page, &mut |palettes| self.fill(PALETTES, palettes))?;
            self.fill(MEMBERS, members);
            let count = i32::try_from(members.len() / 16)?;
            self.draw_page(count, true);
            self.draw_page(count, false);
        }
        Ok(())
    }

    /// Clears the picture and draws the ground, which lies behind everything.
    fn begin(&self, camera: Mat4) {
        let gl = &self.gl;
        // SAFETY: the context is current, and all objects come from it.
        unsafe {
            gl.depth_mask(true);
            gl.clear_color(0.5, 0.66, 0.85, 1.0);
            gl.clear(glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT);
            gl.depth_mask(false);
            for program in [self.skinned, self.ground] {
                gl.use_program(Some(program));
                gl.uniform_matrix_4_f32_slice(Some(&CAMERA), false, camera.as_ref());
            }
            gl.draw_arrays(glow::TRIANGLE_STRIP, 0, 4);
            gl.use_program(Some(self.skinned));
        }
    }

    /// Replaces the contents of a storage buffer.
    fn fill<T: bytemuck::Pod>(&self, binding: u32, data: &[T]) {
        let (gl, target) = (&self.gl, glow::SHADER_STORAGE_BUFFER);
        // SAFETY: the context is current, and the buffer comes from it.
        unsafe {
            gl.bind_buffer_base(target, binding, Some(self.buffers[binding as usize]));
            gl.buffer_data_u8_slice(target, bytemuck::cast_slice(data), glow::STREAM_DRAW);
        }
    }

    /// Draws all members of the page that was filled in, or their shadows.
    fn draw_page(&self, member_count: i32, shadow: bool) {
        let gl = &self.gl;
        // SAFETY: the context is current, and all objects come from it. Indices are below the
        // number of vertices, and entries within the page, since characters and crowds are checked.
        unsafe {
            gl.depth_mask(!shadow);
            gl.uniform_1_i32(Some(&SHADOW), i32::from(shadow));
            for part in &self.parts {
                gl.uniform_4_f32_slice(Some(&PART_COLOR), &part.color);
                gl.bind_vertex_array(Some(part.vertices));
                let (mode, kind) = (glow::TRIANGLES, glow::UNSIGNED_INT);
                gl.draw_elements_instanced(mode, part.index_count, kind, 0, member_count);
            }
        }
    }

    /// Reads the picture back and writes it as a PNG.
    fn save(&self, path: &str) -> Result<()> {
        let [width, height] = SIZE.map(|side| 2 * u32::from(side));
        let mut pixels = image::RgbaImage::new(width, height);
        // SAFETY: the context is current, and the image has four bytes for each pixel.
        let error = unsafe {
            let [width, height] = SIZE.map(|side| 2 * i32::from(side));
            let bytes = glow::PixelPackData::Slice(Some(&mut pixels));
            self.gl.read_pixels(0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, bytes);
            self.gl.get_error()
        };
        if error != glow::NO_ERROR {
            return Err(format!("OpenGL failed with error {error:#x}").into());
        }
        // OpenGL's rows begin at the bottom.
        image::imageops::flip_vertical_in_place(&mut pixels);
        let filter = image::imageops::FilterType::Triangle;
        image::imageops::resize(&pixels, width / 2, height / 2, filter).save(path)?;
        Ok(())
    }
}

/// Uploads the mesh of a part.
///
/// # Safety
///
/// The context is current.
unsafe fn upload(gl: &glow::Context, character: &Character, part: &Part) -> Result<UploadedPart> {
    let (mesh, (float, short)) = (&part.mesh, (glow::FLOAT, glow::UNSIGNED_SHORT));
    if mesh.influences.per_vertex != 4 {
        return Err("this engine skins by four palette entries for each vertex".into());
    }
    // SAFETY: the caller promises a current context. Each buffer holds as many elements as there
    // are vertices, which characters are checked for.
    unsafe {
        let buffer = |target, bytes: &[u8]| -> Result<()> {
            gl.bind_buffer(target, Some(gl.create_buffer()?));
            gl.buffer_data_u8_slice(target, bytes, glow::STATIC_DRAW);
            Ok(())
        };
        let vertices = gl.create_vertex_array()?;
        gl.bind_vertex_array(Some(vertices));
        buffer(glow::ARRAY_BUFFER, bytemuck::cast_slice(&mesh.positions))?;
        gl.vertex_attrib_pointer_f32(0, 3, float, false, 0, 0);
        buffer(glow::ARRAY_BUFFER, bytemuck::cast_slice(&mesh.normals))?;
        gl.vertex_attrib_pointer_f32(1, 3, float, false, 0, 0);
        buffer(glow::ARRAY_BUFFER, bytemuck::cast_slice(&mesh.influences.entries))?;
        gl.vertex_attrib_pointer_i32(2, 4, short, 0, 0);
        buffer(glow::ARRAY_BUFFER, bytemuck::cast_slice(&mesh.influences.weights))?;
        gl.vertex_attrib_pointer_f32(3, 4, float, false, 0, 0);
        (0..4).for_each(|attribute| gl.enable_vertex_attrib_array(attribute));
        buffer(glow::ELEMENT_ARRAY_BUFFER, bytemuck::cast_slice(&mesh.indices))?;
        let mut color = part.material.map_or([1.0; 4], |m| character.materials[m].base_color);
        color[3] = if part.node_name == "shirt" { 1.0 } else { 0.0 };
        let index_count = i32::try_from(mesh.indices.len())?;
        Ok(UploadedPart { vertices, index_count, color })
    }
}
