//! Clips of one body on others.

use populace::core::{Affine, Role, RoleMap, Side, Skeleton};
use populace::{Crowd, Device, Placement, Play};
use populace_assets::Imported;

const BODIES: [(&str, &str); 3] =
    [("kaykit_knight", "Walking_A"), ("m2m_human_base", "Walk_Loop"), ("quaternius_robot", "Robot_Walking")];

fn load(name: &str) -> Imported {
    let folder = std::env::var("POPULACE_TEST_DATA").expect("test data");
    populace_assets::load(format!("{folder}/characters/{name}.glb")).expect("a sound file")
}

fn place(models: &[Affine], skeleton: &Skeleton, joint: populace::core::JointIndex) -> [f32; 3] {
    let _ = skeleton;
    let m = models[joint.index()].rows;
    [m[0][3], m[1][3], m[2][3]]
}

#[test]
fn measure() {
    for (from, clip_name) in BODIES {
        for (onto, _) in BODIES {
            let (source, target) = (load(from), load(onto));
            let mut crowd =
                Crowd::builder().devices(Device::native()).capacity(2).slots_per_member(1).build().unwrap();
            let s = crowd.add_character(source.character.clone()).unwrap();
            let t = crowd.add_character(target.character.clone()).unwrap();
            let clip = crowd.clip(s, clip_name).unwrap();
            let a = crowd.spawn(s, Placement::at([0.0; 3])).unwrap();
            let b = crowd.spawn(t, Placement::at([0.0; 3])).unwrap();
            let (sk, tk) = (&source.character.skeleton, &target.character.skeleton);
            let (sr, tr) = (RoleMap::detect(sk).unwrap(), RoleMap::detect(tk).unwrap());
            let clips = crowd.clips(s).unwrap();
            let info = &clips.iter().find(|(id, _)| *id == clip).unwrap().1;
            crowd.update(0.0).unwrap();
            let rest = crowd.model_from_joints(b).unwrap();
            let restj = |r: Role| place(&rest, tk, tr.joint(r).unwrap());
            let height = target.character.height_m();
            let mut worst = [(0.0f32, String::new()), (0.0, String::new())];
            let mut lowest = 0.0f32;
            let mut low_vertex = 0.0f32;
            let mut hips = (f32::MAX, f32::MIN);
            let mut hips_s = (f32::MAX, f32::MIN);
            let mut foot = (f32::MAX, f32::MAX);
            for step in 0..60 {
                let time = info.start_secs() + info.duration_secs() * step as f32 / 60.0;
                crowd.play(a, clip, Play::held_at_secs(time)).unwrap();
                crowd.play(b, clip, Play::held_at_secs(time)).unwrap();
                crowd.update(0.0).unwrap();
                let (sm, tm) = (crowd.model_from_joints(a).unwrap(), crowd.model_from_joints(b).unwrap());
                for side in [Side::Left, Side::Right] {
                    for (r, n) in [
                        (Role::UpperArm(side), Role::LowerArm(side)),
                        (Role::LowerArm(side), Role::Hand(side)),
                        (Role::UpperLeg(side), Role::LowerLeg(side)),
                        (Role::LowerLeg(side), Role::Foot(side)),
                    ] {
                        let dir = |m: &[Affine], k: &Skeleton, map: &RoleMap| {
                            let (a, b) =
                                (place(m, k, map.joint(r).unwrap()), place(m, k, map.joint(n).unwrap()));
                            glam_unit([b[0] - a[0], b[1] - a[1], b[2] - a[2]])
                        };
                        let (x, y) = (dir(&sm, sk, &sr), dir(&tm, tk, &tr));
                        let angle =
                            (x[0] * y[0] + x[1] * y[1] + x[2] * y[2]).clamp(-1.0, 1.0).acos().to_degrees();
                        if angle > worst[0].0 {
                            worst[0] = (angle, format!("{r}"));
                        }
                    }
                    for r in [Role::Foot(side), Role::Toes(side)] {
                        if let Some(j) = tr.joint(r) {
                            let y = place(&tm, tk, j)[1];
                            let below = restj(r)[1] - y;
                            lowest = lowest.max(below / height);
                            if r == Role::Foot(side) {
                                foot.0 = foot.0.min(y - restj(r)[1]);
                            }
                        }
                    }
                    let j = sr.joint(Role::Foot(side)).unwrap();
                    foot.1 = foot.1.min(place(&sm, sk, j)[1]);
                }
                let y = place(&tm, tk, tr.joint(Role::Hips).unwrap())[1];
                hips = (hips.0.min(y), hips.1.max(y));
                let y = place(&sm, sk, sr.joint(Role::Hips).unwrap())[1];
                hips_s = (hips_s.0.min(y), hips_s.1.max(y));
                let palette = crowd.palette(b).unwrap();
                for part in &target.character.parts {
                    for v in 0..part.mesh.positions.len() {
                        let inf = &part.mesh.influences;
                        let n = inf.per_vertex;
                        let best = (0..n)
                            .max_by(|a, b| inf.weights[v * n + a].total_cmp(&inf.weights[v * n + b]))
                            .unwrap();
                        let j = target.character.palette[inf.entries[v * n + best] as usize].joint;
                        let feet = [Side::Left, Side::Right].map(|s| tr.joint(Role::Foot(s)).unwrap());
                        if !feet.iter().any(|f| j == *f || tk.is_below(j, *f)) {
                            continue;
                        }
                        let y = vertex_y(part, v, &palette);
                        low_vertex = low_vertex.min(y as f32);
                    }
                }
            }
            println!(
                "{from} on {onto} [{}->{}]: limb {:.2} deg ({}), foot joint below rest {:.2}% of {height:.2} (lowest foot vs rest {:.3}), vertex {:.2}%, hips {:.3}..{:.3} rest {:.3}, source hips {:.3}..{:.3}",
                sr.naming(),
                tr.naming(),
                worst[0].0,
                worst[0].1,
                100.0 * lowest,
                foot.0,
                -100.0 * low_vertex / height,
                hips.0,
                hips.1,
                restj(Role::Hips)[1],
                hips_s.0,
                hips_s.1
            );
        }
    }
}

fn vertex_y(part: &populace::core::Part, vertex: usize, palette: &[Affine]) -> f64 {
    let inf = &part.mesh.influences;
    let n = inf.per_vertex;
    let (mut y, mut total) = (0.0, 0.0);
    for k in 0..n {
        let w = f64::from(inf.weights[vertex * n + k]);
        if w > 0.0 {
            let m = palette[inf.entries[vertex * n + k] as usize];
            y += w * f64::from(m.transform_point(part.mesh.positions[vertex])[1]);
            total += w;
        }
    }
    if total > 0.0 { y / total } else { 0.0 }
}

fn glam_unit(v: [f32; 3]) -> [f32; 3] {
    let l = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|c| c / l)
}
