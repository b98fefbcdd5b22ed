//! CPU skinning with palettes read back from a device.

use populace::character::Part;
use populace::model::Affine;

/// Skins one vertex in double precision with the device's palette.
pub(crate) fn skinned(part: &Part, vertex: usize, palette: &[Affine]) -> [f64; 3] {
    let influences = &part.mesh.influences;
    let range = vertex * influences.per_vertex..(vertex + 1) * influences.per_vertex;
    let [x, y, z] = part.mesh.positions[vertex].map(f64::from);
    let mut sum = [0.0; 3];
    for (&entry, &weight) in
        influences.entries[range.clone()].iter().zip(&influences.weights[range])
    {
        for (to, row) in sum.iter_mut().zip(palette[usize::from(entry)].rows) {
            let [a, b, c, d] = row.map(f64::from);
            *to += f64::from(weight) * (a * x + b * y + c * z + d);
        }
    }
    sum
}
