//! Comparing what a backend computed with what the oracle says.

use glam::DAffine3;
use populace_device::Backend;

use crate::expected::Expected;
use crate::tolerance::{COARSE, LOCAL_CAP, MODEL_CAP, ROUNDING_CAP};
use crate::{MemberReading, TestCrowd};

/// Compares number by number, and keeps count, so that a check that compared nothing fails too.
pub(crate) struct Judge {
    check: &'static str,
    local_cap: f64,
    model_cap: f64,
    compared: usize,
    left_out: usize,
    worst: f64,
}

impl Judge {
    /// For whole frames.
    pub(crate) fn new(check: &'static str) -> Self {
        Self {
            check,
            local_cap: LOCAL_CAP,
            model_cap: MODEL_CAP,
            compared: 0,
            left_out: 0,
            worst: 0.0,
        }
    }

    /// For sensitive scenes.
    pub(crate) fn coarse(check: &'static str) -> Self {
        Self { local_cap: COARSE * LOCAL_CAP, model_cap: COARSE * MODEL_CAP, ..Self::new(check) }
    }

    /// For a stage alone, where only rounding is left.
    pub(crate) fn of_stage(check: &'static str) -> Self {
        Self { model_cap: ROUNDING_CAP, ..Self::new(check) }
    }

    /// Fails where `got` is further from `wanted` than `bound`; leaves it out where the bound is
    /// above `cap`.
    pub(crate) fn number(
        &mut self,
        got: f32,
        wanted: f64,
        bound: f64,
        cap: f64,
        place: impl FnOnce() -> String,
    ) {
        if bound.is_nan() || bound > cap {
            self.left_out += 1;
            return;
        }
        let off = (f64::from(got) - wanted).abs();
        if off.is_nan() || off > bound {
            panic!(
                "{}: {} is off by {off:.3e}, where {bound:.3e} is allowed: {got} instead of \
                 {wanted}",
                self.check,
                place()
            );
        }
        self.compared += 1;
        if bound > 0.0 {
            self.worst = self.worst.max(off / bound);
        }
    }

    /// Fails where a bit differs.
    pub(crate) fn bits(&mut self, got: f32, wanted: f32, place: impl FnOnce() -> String) {
        if got.to_bits() != wanted.to_bits() {
            let units = i64::from(got.to_bits()) - i64::from(wanted.to_bits());
            panic!(
                "{}: {} is off by {} units in the last place: {got:e} instead of {wanted:e}",
                self.check,
                place(),
                units.abs()
            );
        }
        self.compared += 1;
    }

    /// Notes that `count` numbers could not be compared.
    pub(crate) fn leave_out(&mut self, count: usize) {
        self.left_out += count;
    }

    /// Ends the check.
    pub(crate) fn done(self) {
        let Self { check, compared, left_out, worst, .. } = self;
        println!(
            "{check}: {compared} numbers compared, {left_out} left out, worst at {worst:.2} of \
             its bound"
        );
        assert!(compared > 0, "{check}: nothing was compared");
        assert!(
            left_out * 5 <= compared,
            "{check}: {left_out} numbers left out beside {compared}; a check that leaves out so \
             much is none"
        );
    }

    /// Local transforms.
    pub(crate) fn locals(
        &mut self,
        crowd: &TestCrowd<'_>,
        member: usize,
        got: &MemberReading,
        wanted: &Expected,
    ) {
        let cap = self.local_cap;
        for (joint, (local, bound)) in wanted.pose.locals.iter().zip(&wanted.locals).enumerate() {
            let place = |what, c: usize| {
                move || format!("{} {what} {c}", joint_place(crowd, member, joint))
            };
            for c in 0..3 {
                let (value, want) = (got.translations[joint][c], local.translation[c]);
                self.number(value, want, bound.translation, cap, place("translation", c));
                let (value, want) = (got.scales[joint][c], local.scale[c]);
                self.number(value, want, bound.scale, cap, place("scale", c));
            }
            // A quaternion and its negative are one rotation.
            let want = local.rotation.to_array();
            let side: f64 =
                got.rotations[joint].iter().zip(want).map(|(g, w)| f64::from(*g) * w).sum();
            for c in 0..4 {
                let want = if side < 0.0 { -want[c] } else { want[c] };
                let value = got.rotations[joint][c];
                self.number(value, want, bound.rotation, cap, place("rotation", c));
            }
        }
    }

    /// `model_from_joint`.
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
                        joint_place(crowd, member, joint)
                    )
                });
            }
        }
    }

    /// The palette.
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

    /// Two matrices for each place, bit for bit.
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

    /// A frame of all members: once stage by stage, where everything is compared, and once as a
    /// whole.
    pub(crate) fn frame(
        &mut self,
        backend: &mut dyn Backend,
        crowd: &mut TestCrowd<'_>,
        tick: u64,
    ) {
        crowd.run_stages(backend, tick);
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
                self.leave_out(10 * got.rotations.len());
            }
        }
        crowd.run(backend, tick);
        for (member, wanted) in all {
            self.palette(member, &crowd.read_palette(backend, member), &wanted);
        }
    }
}

/// A joint, for messages.
pub(crate) fn joint_place(crowd: &TestCrowd<'_>, member: usize, joint: usize) -> String {
    let body = crowd.plan(member).body;
    let name = &crowd.scene.bodies[body].joints[joint].name;
    format!("member {member} (body {body}) joint {joint} \"{name}\"")
}

/// Rows of an affine transform.
pub(crate) fn row_major(m: &DAffine3) -> [f64; 12] {
    std::array::from_fn(|element| {
        let row = element / 4;
        match element % 4 {
            3 => m.translation[row],
            column => m.matrix3.col(column)[row],
        }
    })
}
