//! The base mesh: vertices and quads of the body and its helpers, by group.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::Error;

/// The base mesh in its own units: decimetres, +Y up, +Z front.
pub(crate) struct BaseMesh {
    pub(crate) positions: Vec<Vec3>,
    /// Faces of each group, three or more corners each.
    pub(crate) groups: BTreeMap<String, Vec<Vec<u32>>>,
}

impl BaseMesh {
    /// Reads Wavefront OBJ text: `v`, `g` and `f` lines.
    pub(crate) fn parse(text: &str) -> Result<Self, Error> {
        let bad = |line: usize, what: &str| {
            Error::bad("3dobjs/base.obj", format!("line {}: {what}", line + 1))
        };
        let (mut positions, mut groups) = (Vec::new(), BTreeMap::<String, Vec<Vec<u32>>>::new());
        let mut group = String::new();
        for (number, line) in text.lines().enumerate() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let [x, y, z] =
                        numbers(&mut words).ok_or_else(|| bad(number, "needs three numbers"))?;
                    positions.push(Vec3::new(x, y, z));
                }
                Some("g") => group = words.next().unwrap_or_default().to_owned(),
                Some("f") => {
                    let corner = |word: &str| -> Option<u32> {
                        word.split('/').next()?.parse::<u32>().ok()?.checked_sub(1)
                    };
                    let face: Option<Vec<u32>> = words.map(corner).collect();
                    let face = face.filter(|face| face.len() >= 3);
                    let face = face.ok_or_else(|| bad(number, "is not a face"))?;
                    groups.entry(group.clone()).or_default().push(face);
                }
                _ => {}
            }
        }
        let count = positions.len();
        if groups.values().flatten().flatten().any(|corner| *corner as usize >= count) {
            return Err(Error::bad("3dobjs/base.obj", "a face names a vertex that is not there"));
        }
        match groups.contains_key("body") {
            true => Ok(Self { positions, groups }),
            false => Err(Error::bad("3dobjs/base.obj", "has no group \"body\"")),
        }
    }

    /// The faces of a group; empty if there is none.
    pub(crate) fn faces(&self, group: &str) -> &[Vec<u32>] {
        self.groups.get(group).map_or(&[], Vec::as_slice)
    }

    /// The vertices of a group, each once, ascending.
    pub(crate) fn vertices(&self, group: &str) -> Vec<usize> {
        let mut all: Vec<_> = self.faces(group).iter().flatten().map(|v| *v as usize).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// Returns the next numbers of a line, all finite.
pub(crate) fn numbers<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a str>,
) -> Option<[f32; N]> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = words.next()?.parse().ok().filter(|v: &f32| v.is_finite())?;
    }
    Some(values)
}

/// Splits faces into triangles.
pub(crate) fn fans(faces: &[Vec<u32>]) -> Vec<[u32; 3]> {
    let fan = |face: &Vec<u32>| {
        let (first, rest) = (face[0], face[1..].to_vec());
        rest.windows(2).map(|pair| [first, pair[0], pair[1]]).collect::<Vec<_>>()
    };
    faces.iter().flat_map(fan).collect()
}
