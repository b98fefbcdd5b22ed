#![allow(clippy::print_stdout, reason = "x")]
fn main() {
    for s in 0..60u64 {
        let w = 5.0 + (s % 8) as f32;
        let p = populace_props::shopfront(s, w).unwrap();
        let mut per = std::collections::BTreeMap::new();
        for q in &p.character.parts {
            *per.entry(p.character.materials[q.material.unwrap()].name.clone()).or_insert(0) +=
                q.mesh.indices.len() / 3;
        }
        let t: usize = per.values().sum();
        println!("{t} w{w} {s} {per:?}");
    }
}
