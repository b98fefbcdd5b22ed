//! Cameras below the ground.

use super::Cameras;

impl Cameras {
    /// Returns a warning if a camera with positions of its own is below the ground at one of some
    /// times in seconds since frame 0, which are in order. `ground_m` is the height of the ground
    /// at a point `[x, z]`, in metres.
    pub(crate) fn below_ground(
        &self,
        times: impl Iterator<Item = f64>,
        ground_m: &dyn Fn([f32; 2]) -> f32,
    ) -> Option<String> {
        let rests_from_secs = self.rests_from_secs?;
        for secs in times {
            let [x, y, z] = self.at(&|_| None, secs).eye;
            let ground_m = ground_m([x, z]);
            if y < ground_m {
                let moves = rests_from_secs > 0.0;
                let when =
                    if moves { format!(" {secs:.2} s after frame 0") } else { String::new() };
                return Some(format!(
                    "the camera is below the ground{when}: it is at {x:.2}, {y:.2}, {z:.2} m, \
                     where the ground is at {ground_m:.2} m; the second number is the height, so \
                     give a greater one"
                ));
            }
            if secs >= rests_from_secs {
                break;
            }
        }
        None
    }
}
