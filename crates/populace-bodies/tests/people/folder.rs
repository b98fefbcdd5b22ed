//! A tiny body system, made by code in the layout that the crate reads: tubes for the trunk, the
//! head and the limbs, 52 joints, and a few targets.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Map, Value, json};

type Point = [f32; 3];

/// Joints with their parents and places, in decimetres; those of the left side have a twin.
const JOINTS: [(&str, &str, Point); 8] = [
    ("Hips", "", [0.0, 0.7, 0.1]),
    ("Spine", "Hips", [0.0, 1.2, 0.0]),
    ("Spine1", "Spine", [0.0, 2.6, 0.0]),
    ("Spine2", "Spine1", [0.0, 4.2, 0.0]),
    ("Neck", "Spine2", [0.0, 5.9, 0.1]),
    ("Head", "Neck", [0.0, 6.9, 0.2]),
    ("LeftShoulder", "Spine2", [0.4, 5.3, 0.1]),
    ("LeftUpLeg", "Hips", [0.9, 0.5, 0.1]),
];
const LIMBS: [(&str, &str, Point); 6] = [
    ("LeftArm", "LeftShoulder", [1.7, 5.2, 0.1]),
    ("LeftForeArm", "LeftArm", [3.1, 3.6, 0.1]),
    ("LeftHand", "LeftForeArm", [4.3, 2.5, 0.4]),
    ("LeftLeg", "LeftUpLeg", [1.0, -3.7, 0.2]),
    ("LeftFoot", "LeftLeg", [1.1, -7.4, 0.0]),
    ("LeftToeBase", "LeftFoot", [1.1, -8.0, 1.2]),
];

#[derive(Default)]
struct Builder {
    points: Vec<Point>,
    groups: BTreeMap<String, Vec<Vec<usize>>>,
    weights: BTreeMap<String, Vec<(usize, f32)>>,
}

impl Builder {
    fn point(&mut self, point: Point) -> usize {
        self.points.push(point);
        self.points.len() - 1
    }

    /// Adds a closed tube of rings around points, with radii across the tube's two axes and the
    /// joint that each ring follows.
    fn tube(&mut self, group: &str, axes: [Point; 2], rings: &[(Point, [f32; 2], &str)]) {
        const SIDES: usize = 16;
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for (center, radii, joint) in rings {
            let mut row = Vec::new();
            for side in 0..SIDES {
                let (sin, cos) = (side as f32 / SIDES as f32 * std::f32::consts::TAU).sin_cos();
                let at = [0, 1, 2].map(|k: usize| {
                    center[k] + axes[0][k] * cos * radii[0] + axes[1][k] * sin * radii[1]
                });
                let vertex = self.point(at);
                self.weights.entry(format!("mixamorig:{joint}")).or_default().push((vertex, 1.0));
                row.push(vertex);
            }
            rows.push(row);
        }
        let faces = self.groups.entry(group.to_owned()).or_default();
        for pair in rows.windows(2) {
            for side in 0..SIDES {
                let next = (side + 1) % SIDES;
                faces.push(vec![pair[0][side], pair[0][next], pair[1][next], pair[1][side]]);
            }
        }
        let last = rows.last().cloned().unwrap_or_default();
        faces.push(rows[0].iter().rev().copied().collect());
        faces.push(last);
    }

    fn body(&mut self) {
        const X: Point = [1.0, 0.0, 0.0];
        const Y: Point = [0.0, 1.0, 0.0];
        const Z: Point = [0.0, 0.0, 1.0];
        // Rings rise along +Y with axes Z and X, so that faces point outwards.
        let trunk = [(-0.4, "Hips"), (0.5, "Hips"), (1.3, "Spine"), (2.6, "Spine1")];
        let chest = [(4.2, "Spine2"), (5.2, "Spine2"), (5.5, "Spine2"), (5.75, "Neck")];
        let wide: [f32; 8] = [1.6, 1.7, 1.3, 1.4, 1.7, 1.6, 0.9, 0.45];
        let rings: Vec<_> = trunk
            .iter()
            .chain(&chest)
            .zip(wide)
            .map(|((y, joint), wide)| ([0.0, *y, 0.1], [wide.min(1.1), wide], *joint))
            .collect();
        self.tube("body", [Z, X], &rings);
        let neck = [(5.6, 0.45, 0.1), (5.9, 0.45, 0.1), (6.3, 0.5, 0.2)];
        let skull = [(6.6, 0.8, 0.5), (7.0, 0.9, 0.5), (7.3, 0.9, 0.5), (7.6, 0.9, 0.5)];
        let crown = [(8.0, 0.85, 0.5), (8.3, 0.6, 0.4), (8.49, 0.1, 0.4)];
        let all = neck.iter().chain(&skull).chain(&crown);
        let head: Vec<_> =
            all.map(|(y, r, z)| ([0.0, *y, *z], [*r * 1.1, r * 0.85], "Head")).collect();
        self.tube("body", [Z, X], &head);
        for (side, sign) in [("Left", 1.0), ("Right", -1.0)] {
            let arm = |t: f32| [sign * (1.5 + 3.2 * t), 5.2 - 3.0 * t, 0.1 + 0.4 * t * t];
            let rings: Vec<_> = (0..9)
                .map(|k| {
                    let joint = ["Arm", "Arm", "Arm", "Arm", "ForeArm"][k.min(4)];
                    let joint = if k > 6 { "Hand" } else { joint };
                    (arm(k as f32 / 8.0), [0.35, 0.35], format!("{side}{joint}"))
                })
                .collect();
            let rings: Vec<_> = rings.iter().map(|(p, r, j)| (*p, *r, j.as_str())).collect();
            self.tube("body", [[0.0, 0.0, sign], [0.7, 0.7 * sign, 0.0]], &rings);
            let heights = [-8.0, -7.4, -6.0, -4.5, -3.7, -2.0, -0.5, 0.4];
            let rings: Vec<_> = heights
                .iter()
                .map(|y| {
                    let joint = match y {
                        ..-7.3 => "Foot",
                        ..-3.6 => "Leg",
                        _ => "UpLeg",
                    };
                    ([sign, *y, 0.1], [0.4 + 0.05 * (y + 8.0); 2], format!("{side}{joint}"))
                })
                .collect();
            let rings: Vec<_> = rings.iter().map(|(p, r, j)| (*p, *r, j.as_str())).collect();
            self.tube("body", [Z, X], &rings);
            let (foot, toes) = (format!("{side}Foot"), format!("{side}ToeBase"));
            let rings: Vec<_> = [(-0.4, 0.5, &foot), (0.4, 0.5, &foot), (1.2, 0.35, &toes)]
                .iter()
                .chain(&[(1.8, 0.2, &toes)])
                .map(|(z, high, joint)| ([sign, -8.0 + high, *z], [0.45, *high], joint.as_str()))
                .collect();
            self.tube("body", [X, Y], &rings);
            let eye = format!("helper-{}-eye", if sign > 0.0 { "l" } else { "r" });
            let ball = [(1.0, 0.05), (1.1, 0.13), (1.25, 0.14), (1.38, 0.03)];
            let rings: Vec<_> =
                ball.map(|(z, r)| ([sign * 0.31, 7.28, z], [r, r], "Head")).to_vec();
            self.tube(&eye, [X, Y], &rings);
        }
    }

    /// Adds a joint: a vertex of its own, or the cube of a group for some.
    fn joint(&mut self, name: &str, place: Point) -> Value {
        if name != "Neck" {
            return json!({ "strategy": "MEAN", "vertex_indices": [self.point(place)] });
        }
        let corners: Vec<_> = [-0.05, 0.05].map(|d| self.point(place.map(|c| c + d))).to_vec();
        let face = vec![corners[0], corners[1], corners[0]];
        self.groups.insert("joint-neck".into(), vec![face]);
        json!({ "strategy": "CUBE", "cube_name": "joint-neck" })
    }

    fn bones(&mut self) -> Value {
        let mut all: Vec<(String, String, Point)> = Vec::new();
        for (name, parent, place) in JOINTS.iter().chain(&LIMBS) {
            all.push((name.to_string(), parent.to_string(), *place));
        }
        for finger in ["Thumb", "Index", "Middle", "Ring", "Pinky"] {
            for bone in 1..=3_u8 {
                let name = format!("LeftHand{finger}{bone}");
                let parent =
                    format!("LeftHand{finger}{}", bone - 1).replace(&format!("{finger}0"), "");
                let out = 0.15 * f32::from(bone);
                all.push((name, parent, [4.4 + out, 2.4 - out, 0.5]));
            }
        }
        let right = |(name, parent, [x, y, z]): &(String, String, Point)| {
            let name = name.strip_prefix("Left").map(|rest| format!("Right{rest}"))?;
            Some((name, parent.replace("Left", "Right"), [-x, *y, *z]))
        };
        let mirrored: Vec<_> = all.iter().filter_map(right).collect();
        all.extend(mirrored);
        let mut bones = Map::new();
        for (name, parent, place) in all {
            let parent = if parent.is_empty() { parent } else { format!("mixamorig:{parent}") };
            let head = self.joint(&name, place);
            bones.insert(format!("mixamorig:{name}"), json!({ "parent": parent, "head": head }));
        }
        bones.into()
    }

    fn obj(&self) -> String {
        let mut text = String::from("# A mesh made by a test, CC0\n");
        for [x, y, z] in &self.points {
            writeln!(text, "v {x} {y} {z}").expect("text grows");
        }
        for (group, faces) in &self.groups {
            writeln!(text, "g {group}").expect("text grows");
            for face in faces {
                let corners: Vec<_> = face.iter().map(|c| format!("{}/1", c + 1)).collect();
                writeln!(text, "f {}", corners.join(" ")).expect("text grows");
            }
        }
        text
    }

    /// Lines of a target that scales the mesh from the ground by a factor.
    fn scaled(&self, factor: f32) -> String {
        let line = |(index, [x, y, z]): (usize, &Point)| {
            let k = factor - 1.0;
            format!("{index} {} {} {}\n", x * k, (y + 8.0) * k, z * k)
        };
        self.points.iter().enumerate().map(line).collect()
    }

    /// Lines of a target that pushes two points of the chest 3 cm forward.
    fn mounds(&self) -> String {
        let points = self.points.iter().enumerate();
        let in_front = |[x, y, z]: &Point| *y == 4.2 && *z > 0.8 && (0.1..1.0).contains(&x.abs());
        let mounds = points.filter(|(_, point)| in_front(point));
        mounds.map(|(index, _)| format!("{index} 0 0 0.3\n")).collect()
    }
}

/// Two ranges with a middle, as the rules list them.
fn range(names: [&str; 3]) -> Value {
    let part = |lowest: f32, highest: f32, [low, high]: [&str; 2]| {
        json!({
            "lowest": lowest,
            "highest": highest,
            "low": low,
            "high": high,
        })
    };
    json!({ "parts": [
        part(0.0, 0.4999, [names[0], names[1]]),
        part(0.5, 1.0, [names[1], names[2]]),
    ] })
}

/// Writes the body system to a folder. Its licence says `licence`.
pub(crate) fn write(root: &Path, licence: &str) {
    let mut builder = Builder::default();
    builder.body();
    let bones = builder.bones();
    let save = |name: &str, bytes: &[u8]| {
        let path = root.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("the folder is made");
        std::fs::write(path, bytes).expect("the file is written");
    };
    let packed = |text: &str| {
        let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
        std::io::Write::write_all(&mut gzip, text.as_bytes()).expect("memory grows");
        gzip.finish().expect("memory grows")
    };
    let obj = builder.obj().replace("CC0", licence);
    save("3dobjs/base.obj", obj.as_bytes());
    save("rigs/standard/rig.mixamo.json", json!({ "bones": bones }).to_string().as_bytes());
    let weights = json!({ "weights": builder.weights }).to_string();
    save("rigs/standard/weights.mixamo.json", weights.as_bytes());
    let macros = json!({
        "macrotargets": {
            "gender": { "parts": [{ "lowest": 0, "highest": 1, "low": "female", "high": "male" }] },
            "age": range(["child", "young", "old"]),
            "muscle": range(["minmuscle", "averagemuscle", "maxmuscle"]),
            "weight": range(["minweight", "averageweight", "maxweight"]),
            "height": range(["minheight", "", "maxheight"]),
        },
        "combinations": {
            "racegenderage": ["race", "gender", "age"],
            "genderagemuscleweight": ["gender", "age", "muscle", "weight"],
            "genderagemuscleweightheight": ["gender", "age", "muscle", "weight", "height"],
        },
    });
    save("targets/macrodetails/macro.json", macros.to_string().as_bytes());
    for gender in ["female", "male"] {
        let child = packed(&builder.scaled(0.7));
        let name = format!("targets/macrodetails/caucasian-{gender}-child.target.gz");
        save(&name, &child);
    }
    save("targets/breast/mounds.target", builder.mounds().as_bytes());
    let tall = "male-young-averagemuscle-averageweight-maxheight";
    let text = format!("# a comment\n{}", builder.scaled(1.2));
    save(&format!("targets/macrodetails/height/{tall}.target"), text.as_bytes());
}
