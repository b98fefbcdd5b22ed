use std::io::Cursor;

use populace_character::{AlphaMode, Material, TextureFilter, Wrap};
use serde_json::json;

use super::builder::{File, rigid};
use super::{assert_note, assert_problem, loaded};

fn encoded(format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let pixels = image::RgbImage::from_fn(2, 1, |x, _| {
        image::Rgb(if x == 0 { [255, 0, 0] } else { [0, 0, 255] })
    });
    pixels.write_to(&mut bytes, format).expect("encoding to memory succeeds");
    bytes.into_inner()
}

/// The triangle with a textured material.
fn textured(image: &[u8]) -> File {
    let mut file = rigid();
    let view = file.view(image);
    file.add("images", json!({"bufferView": view, "mimeType": "image/png"}));
    file.add("textures", json!({"source": 0}));
    file.add(
        "materials",
        json!({"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
    );
    file.primitive()["material"] = 0.into();
    file
}

fn material(file: &File) -> Material {
    loaded(&file.glb()).character.materials[0].clone()
}

#[test]
fn factors_alpha_and_sides_are_read() {
    let mut file = rigid();
    file.add("materials", json!({}));
    // The defaults of the format, which are not those of materials made by hand.
    let default = Material { metallic: 1.0, roughness: 1.0, ..Material::default() };
    assert_eq!(material(&file), default);
    file.json["materials"][0] = json!({
        "name": "glass", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 2]}
    });
    let glass = material(&file);
    assert_eq!((glass.name.as_str(), glass.double_sided), ("glass", true));
    assert_eq!(glass.base_color, [0.5, 0.25, 1.0, 1.0]);
    assert_eq!(glass.alpha, AlphaMode::Mask { cutoff: 0.25 });
    assert_note(
        &file.glb(),
        "materials[0].pbrMetallicRoughness: has a value of baseColorFactor outside 0 to 1",
    );
    file.json["materials"][0]["alphaMode"] = "BLEND".into();
    assert_eq!(material(&file).alpha, AlphaMode::Blend);
    file.json["materials"][0]["alphaMode"] = "ADD".into();
    assert_note(&file.glb(), "materials[0]: has the unknown alphaMode \"ADD\"");
    file.json["materials"][0]["alphaMode"] = 1.into();
    assert_problem(&file.glb(), "materials[0].alphaMode: must be a string");
}

#[test]
fn png_jpeg_and_webp_are_decoded_by_content() {
    for format in [image::ImageFormat::Png, image::ImageFormat::Jpeg, image::ImageFormat::WebP] {
        let character = loaded(&textured(&encoded(format)).glb()).character;
        let image = &character.images[0];
        assert_eq!((image.width, image.height, image.rgba.len()), (2, 1, 8));
        let texture = character.materials[0].base_color_texture.unwrap();
        assert_eq!(
            (texture.image, texture.wrap_u, texture.filter),
            (0, Wrap::Repeat, TextureFilter::Linear)
        );
        if format != image::ImageFormat::Jpeg {
            assert_eq!(image.rgba, [255, 0, 0, 255, 0, 0, 255, 255]);
        }
    }
}

#[test]
fn samplers_set_wrap_modes_and_filter() {
    let mut file = textured(&encoded(image::ImageFormat::Png));
    file.add("samplers", json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}));
    file.json["textures"][0]["sampler"] = 0.into();
    let texture = material(&file).base_color_texture.unwrap();
    assert_eq!((texture.wrap_u, texture.wrap_v), (Wrap::ClampToEdge, Wrap::MirroredRepeat));
    assert_eq!(texture.filter, TextureFilter::Nearest);
    file.json["textures"][0]["sampler"] = 1.into();
    assert_problem(&file.glb(), "textures[0].sampler: refers to sampler 1");
}

#[test]
fn webp_extension_replaces_the_source() {
    let mut file = textured(&encoded(image::ImageFormat::Png));
    let view = file.view(&encoded(image::ImageFormat::WebP));
    file.add("images", json!({"bufferView": view, "mimeType": "image/webp"}));
    file.json["textures"][0]["source"] = 9.into();
    assert_problem(&file.glb(), "textures[0].source: refers to image 9");
    file.json["textures"][0] = json!({"extensions": {"EXT_texture_webp": {"source": 1}}});
    assert_eq!(loaded(&file.glb()).character.images.len(), 1);
    assert!(material(&file).base_color_texture.is_some());
}

#[test]
fn maps_and_their_factors_are_read() {
    let mut file = textured(&encoded(image::ImageFormat::Png));
    file.json["materials"][0] = json!({
        "pbrMetallicRoughness": {
            "metallicFactor": 0.25, "roughnessFactor": 0.5, "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0}
        },
        "normalTexture": {"index": 0, "scale": 0.75},
        "occlusionTexture": {"index": 0, "strength": 0.125},
        "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 0.5, 0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}
    });
    let read = material(&file);
    assert_eq!((read.metallic, read.roughness), (0.25, 0.5));
    assert_eq!((read.normal_scale, read.occlusion_strength), (0.75, 0.125));
    assert_eq!(read.emissive, [4.0, 2.0, 0.0]);
    assert_eq!(read.textures().count(), 5);
    let nowhere = json!({"KHR_texture_transform": {"offset": [0, 0]}});
    file.json["materials"][0]["normalTexture"]["extensions"] = nowhere;
    assert_eq!(material(&file).textures().count(), 5, "its transform changes nothing");
    file.json["materials"][0]["normalTexture"]["texCoord"] = 1.into();
    assert_eq!(material(&file).normal_texture, None);
    assert_note(&file.glb(), "materials[0].normalTexture: has other texture coordinates");
    file.json["materials"][0]["emissiveFactor"] = json!([1, 0.5, 3]);
    assert_note(&file.glb(), "materials[0]: has a value of emissiveFactor outside 0 to 1");
}

#[test]
fn diffuse_colour_and_glossiness_are_read() {
    let mut file = textured(&encoded(image::ImageFormat::Png));
    let glossy = json!({
        "diffuseFactor": [0.5, 0.25, 0.125, 1], "diffuseTexture": {"index": 0},
        "glossinessFactor": 0.25
    });
    file.json["materials"][0] =
        json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}});
    file.json["extensionsRequired"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    file.json["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    let read = material(&file);
    assert_eq!((read.metallic, read.roughness), (0.0, 0.75));
    assert_eq!(read.base_color, [0.5, 0.25, 0.125, 1.0]);
    assert!(read.base_color_texture.is_some());
    assert!(loaded(&file.glb()).notes.is_empty(), "nothing is lost");
    let extension = "KHR_materials_pbrSpecularGlossiness";
    file.json["materials"][0]["extensions"][extension]["specularFactor"] = json!([1, 0, 0]);
    assert_note(&file.glb(), "materials[0]: has specular colours");
    // The other way to say the same has precedence.
    file.json["materials"][0]["pbrMetallicRoughness"] = json!({"roughnessFactor": 0.5});
    let read = material(&file);
    assert_eq!((read.metallic, read.roughness), (1.0, 0.5));
    assert!(loaded(&file.glb()).notes.is_empty(), "the extension is not needed");
}

#[test]
fn unavailable_image_is_noted_and_colour_used() {
    let mut broken = encoded(image::ImageFormat::Png);
    broken.truncate(40);
    let mut file = textured(&broken);
    assert_note(&file.glb(), "images[0]: cannot be decoded");
    for uri in ["gone.png", "http://example.com/a.png", "data:image/png;base64,AAAA"] {
        file.json["images"][0] = json!({"uri": uri});
        assert_note(&file.glb(), "images[0]");
        assert_eq!(material(&file).base_color_texture, None, "{uri}");
    }
    file.json["images"][0] = json!({"bufferView": 99});
    assert_problem(&file.glb(), "images[0].bufferView: refers to buffer view 99");
}

/// A factor belongs to its texture: the usual 1 would make everything glow, or metal.
#[test]
fn factors_of_textures_that_are_left_out_are_left_out() {
    let mut file = textured(&encoded(image::ImageFormat::Png));
    file.add("images", json!({"uri": "gone.png"}));
    file.add("textures", json!({"source": 1}));
    for (texture, wanted) in
        [(Some(0), (1.0, [1.0; 3])), (Some(1), (0.0, [0.0; 3])), (None, (1.0, [1.0; 3]))]
    {
        let mut metallic = json!({"baseColorTexture": {"index": 0}});
        let mut material_json = json!({"emissiveFactor": [1, 1, 1]});
        if let Some(index) = texture {
            metallic["metallicRoughnessTexture"] = json!({"index": index});
            material_json["emissiveTexture"] = json!({"index": index});
        }
        material_json["pbrMetallicRoughness"] = metallic;
        file.json["materials"][0] = material_json;
        let read = material(&file);
        assert_eq!((read.metallic, read.emissive), wanted, "{texture:?}");
    }
}

#[test]
fn texture_coordinates_follow_texcoord_and_transform() {
    let mut file = textured(&encoded(image::ImageFormat::Png));
    let second = file.floats("VEC2", &[0.0, 0.0, 0.5, 0.0, 0.0, 0.5]);
    file.primitive()["attributes"]["TEXCOORD_1"] = second.into();
    let uvs = |file: &File| loaded(&file.glb()).character.parts[0].mesh.uvs.clone();
    assert_eq!(uvs(&file)[1], [1.0, 0.0]);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1.into();
    assert_eq!(uvs(&file)[1], [0.5, 0.0]);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 4], "texCoord": 0}});
    assert_eq!(uvs(&file), [[0.25, 0.5], [2.25, 0.5], [0.25, 4.5]]);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] =
        json!({"index": 0, "texCoord": 5});
    assert_note(&file.glb(), "meshes[0].primitives[0]: has no TEXCOORD_5");
}
