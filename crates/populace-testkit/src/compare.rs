//! Comparison of a backend's results with the oracle's.

use glam::DAffine3;
use populace_device::Backend;

use crate::expected::Expected;
use crate::tolerance::{COARSE, LOCAL_CAP, MODEL_CAP, ROUNDING_CAP};
use crate::{MemberReading, TestCrowd};

/// Compares results number by number. Counts the comparisons, so that a check that compared nothing
/// fails too.
pub(crate) struct Judge {
    check: &'static str,
    local_cap: f64,
    model_cap: f64,
    compared: usize,
    skipped: usize,
    worst: f64,
}

impl Judge {
    /// Starts a check of whole frames.
    pub(crate) fn new(check: &'static str) -> Self {
        Self {
            check,
            local_cap: LOCAL_CAP,
            model_cap: MODEL_CAP,
            compared: 0,
            skipped: 0,
            worst: 0.0,
        }
    }

    /// Starts a check of scenes that magnify errors, with wide caps.
    pub(crate) fn coarse(check: &'static str) -> Self {
        Self { local_cap: COARSE * LOCAL_CAP, model_cap: COARSE * MODEL_CAP, ..Self::new(check) }
    }

    /// Starts a check of one stage alone, where the only error is rounding.
    pub(crate) fn of_stage(check: &'static str) -> Self {
        Self { model_cap: ROUNDING_CAP, ..Self::new(check) }
    }

    /// Fails if `got` differs from `wanted` by more than `bound`. Skips the number if the bound is
    /// above `cap`.
    pub(crate) fn number(
        &mut self,
        got: f32,
        wanted: f64,
        bound: f64,
        cap: f64,
        name: impl FnOnce() -> String,
    ) {
        if bound.is_nan() || bound > cap {
            self.skipped += 1;
            return;
        }
        let error = (f64::from(got) - wanted).abs();
        if error.is_nan() || error > bound {
            panic!(
                "{}: {} is off by {error:.3e}, where {bound:.3e} is allowed: {got} instead of \
                 {wanted}",
                self.check,
                name()
            );
        }
        self.compared += 1;
        if bound > 0.0 {
            self.worst = self.worst.max(error / bound);
        }
    }

    /// Fails if any bit differs.
    pub(crate) fn bits(&mut self, got: f32, wanted: f32, name: impl FnOnce() -> String) {
        if got.to_bits() != wanted.to_bits() {
            let units = i64::from(got.to_bits()) - i64::from(wanted.to_bits());
            panic!(
                "{}: {} is off by {} units in the last place: {got:e} instead of {wanted:e}",
                self.check,
                name(),
                units.abs()
            );
        }
        self.compared += 1;
    }

    /// Counts `count` numbers as skipped.
    pub(crate) fn skip(&mut self, count: usize) {
        self.skipped += count;
    }

    /// Ends the check. Fails if nothing was compared, or if the skipped numbers are more than a
    /// fifth of the compared ones.
    pub(crate) fn done(self) {
        let Self { check, compared, skipped, worst, .. } = self;
        println!(
            "{check}: {compared} numbers compared, {skipped} skipped, largest error {worst:.2} \
             of its bound"
        );
        assert!(compared > 0, "{check}: nothing was compared");
        assert!(
            skipped * 5 <= compared,
            "{check}: {skipped} numbers skipped and {compared} compared; at most a fifth of the \
             compared count may be skipped"
        );
    }

    /// Compares local transforms.
    pub(crate) fn locals(
        &mut self,
        crowd: &TestCrowd<'_>,
        member: usize,
        got: &MemberReading,
        wanted: &Expected,
    ) {
        let cap = self.local_cap;
        for (joint, (local, bound)) in wanted.pose.locals.iter().zip(&wanted.locals).enumerate() {
            let name =
                |what, c: usize| move || format!("{} {what} {c}", joint_name(crowd, member, joint));
            for c in 0..3 {
                let (value, want) = (got.translations[joint][c], local.translation[c]);
                self.number(value, want, bound.translation, cap, name("translation", c));
                let (value, want) = (got.scales[joint][c], local.scale[c]);
                self.number(value, want, bound.scale, cap, name("scale", c));
            }
            // A quaternion and its negative are the same rotation.
            let want = local.rotation.to_array();
            let cosine: f64 =
                got.rotations[joint].iter().zip(want).map(|(g, w)| f64::from(*g) * w).sum();
            for c in 0..4 {
                let want = if cosine < 0.0 { -want[c] } else { want[c] };
                let value = got.rotations[joint][c];
                self.number(value, want, bound.rotation, cap, name("rotation", c));
            }
        }
    }

    /// Compares `model_from_joint`.
    pub(crate) fn models(
        &mut self,
        crowd: &TestCrowd<'_>,
        member: usize,
        got: &MemberReading,
        wanted: &Expected,
    ) {
        let cap = self.model_cap;
        for (joint, (model, bound)) in
            wanted.pose.model_from_joint.iter().zip(&wanted.models).enumerate()
        {
            let want = row_major(model);
            for (element, want) in want.into_iter().enumerate() {
                let bound = if element % 4 == 3 { bound.translation } else { bound.linear };
                self.number(got.models[joint][element], want, bound, cap, || {
                    format!(
                        "{} model_from_joint element {element}",
                        joint_name(crowd, member, joint)
                    )
                });
            }
        }
    }

    /// Compares palettes.
    pub(crate) fn palette(&mut self, member: usize, got: &[[f32; 12]], wanted: &Expected) {
        assert_eq!(got.len(), wanted.pose.palette.len(), "{}: palette length", self.check);
        let cap = self.model_cap;
        for (entry, (want, bound)) in wanted.pose.palette.iter().zip(&wanted.palette).enumerate() {
            for element in 0..12 {
                let bound = if element % 4 == 3 { bound.translation } else { bound.linear };
                self.number(got[entry][element], want[element], bound, cap, || {
                    format!("member {member} palette entry {entry} element {element}")
                });
            }
        }
    }

    /// Compares two lists of matrices bit for bit.
    pub(crate) fn same_matrices(&mut self, what: &str, got: &[[f32; 12]], wanted: &[[f32; 12]]) {
        assert_eq!(got.len(), wanted.len(), "{}: {what} length", self.check);
        for (at, (got, wanted)) in got.iter().zip(wanted).enumerate() {
            for element in 0..12 {
                self.bits(got[element], wanted[element], || {
                    format!("{what} {at} element {element}")
                });
            }
        }
    }

    /// Compares all members after a frame. Returns those that could be compared.
    pub(crate) fn members(
        &mut self,
        backend: &mut dyn Backend,
        crowd: &TestCrowd<'_>,
        tick: u64,
    ) -> Vec<(usize, Expected)> {
        let members: Vec<usize> = crowd.members().map(|(member, ..)| member).collect();
        let mut all = Vec::new();
        for member in members {
            let got = crowd.read(backend, member);
            if let Some(wanted) = crowd.expected(member, tick) {
                self.locals(crowd, member, &got, &wanted);
                self.models(crowd, member, &got, &wanted);
                self.palette(member, &got.palette, &wanted);
                all.push((member, wanted));
            } else {
                self.skip(10 * got.rotations.len());
            }
        }
        all
    }

    /// Runs a frame stage by stage and compares everything; then runs it as a whole and compares
    /// the palettes.
    pub(crate) fn frame(
        &mut self,
        backend: &mut dyn Backend,
        crowd: &mut TestCrowd<'_>,
        tick: u64,
    ) {
        crowd.run_stages(backend, tick);
        let all = self.members(backend, crowd, tick);
        crowd.run(backend, tick);
        for (member, wanted) in all {
            self.palette(member, &crowd.read_palette(backend, member), &wanted);
        }
    }
}

/// Names a joint for messages.
pub(crate) fn joint_name(crowd: &TestCrowd<'_>, member: usize, joint: usize) -> String {
    let body = crowd.plan(member).body;
    let name = &crowd.scene.bodies[body].joints[joint].name;
    format!("member {member} (body {body}) joint {joint} \"{name}\"")
}

/// Returns an affine transform as 3x4, row-major.
pub(crate) fn row_major(m: &DAffine3) -> [f64; 12] {
    std::array::from_fn(|element| {
        let row = element / 4;
        match element % 4 {
            3 => m.translation[row],
            column => m.matrix3.col(column)[row],
        }
    })
}
