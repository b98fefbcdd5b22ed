//! Stages that are refused, and crowds that are unchanged by the refusal.

use populace::{After, BackendError, Device, Error, Schedule, StageUse, UserStage};

use crate::fixture::{Scene, at, everywhere, stage};

#[cfg_attr(any(not(feature = "opencl"), skip_opencl), ignore = "there is no OpenCL")]
#[test]
fn compile_error_names_the_line_of_the_users_text() {
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        let (mut staged, [bend, _]) = Scene::staged(Device::opencl(0), schedule);
        let given = [0.0, 0.6, 0.0, 0.8, 1.0];
        staged.crowd.set_stage_parameters(bend, &given).expect("parameters");
        staged.edit(staged.members[2]).set_stage(bend, StageUse::on([at(4)])).expect("a stage use");
        staged.update(0.1);
        let before = staged.bits();
        let broken = "void gust(StageJoint *joint)\n{\n    joint->row0.x += strength;\n}\n";
        let missing = "void draught(StageJoint *joint) { }\n";
        let clash = "void gust(StageJoint *joint)\n{\n    joint->row9 = 0;\n}\n#define members 3\n";
        let names = [
            "stage gust:3:",
            "each stage's text defines the function of its name",
            "stage gust:3:",
        ];
        for (text, words) in [broken, missing, clash].into_iter().zip(names) {
            let gust = UserStage::new("gust").opencl_c(text).rust(|_| ());
            let error = staged
                .crowd
                .add_stage(After::Transform, gust)
                .expect_err("a text that does not compile");
            assert!(matches!(error, Error::Backend(BackendError::BadStages { .. })), "{error}");
            assert!(error.to_string().contains(words), "{schedule}: {error}");
        }
        // Nothing changed, and a valid text under the same name is accepted.
        staged.update(0.0);
        assert_eq!(staged.bits(), before, "{schedule}");
        let good =
            "#define member 3\nvoid gust(StageJoint *joint)\n{\n    joint->row1.w += 1.0f;\n}\n";
        let gust = UserStage::new("gust").opencl_c(good);
        let gust = staged.crowd.add_stage(After::Transform, gust).expect("a stage");
        staged.edit(staged.members[0]).set_stage(gust, StageUse::on([at(0)])).expect("a stage use");
        staged.update(0.0);
        let after = staged.bits();
        assert!(after[0] != before[0] && after[1..] == before[1..], "{schedule}");
    }
}

#[cfg_attr(any(not(feature = "opencl"), skip_opencl), ignore = "there is no OpenCL")]
#[test]
fn device_without_a_stages_form_names_the_stage() {
    let text_only = || {
        UserStage::new("gust").opencl_c("void gust(StageJoint *joint) { joint->row1.w += 1.0f; }")
    };
    let rust_only = || UserStage::new("gust").rust(|joint| joint.model.rows[1][3] += 1.0);
    let both = [Device::Native { threads: 1 }, Device::opencl(0)];
    let refused = |error: Error, words: &str| {
        assert!(matches!(error, Error::Backend(BackendError::NoForm { .. })), "{error}");
        let said = error.to_string();
        assert!(said.contains(words) && said.contains("\"gust\""), "{said}");
    };
    let (in_rust, in_c) = ("the native device cannot run", "a text in OpenCL C");
    let mut native = Scene::on(Device::native(), Schedule::Fused);
    refused(native.crowd.add_stage(After::Pose, text_only()).expect_err("no Rust"), in_rust);
    let mut opencl = Scene::on(Device::opencl(0), Schedule::Fused);
    refused(opencl.crowd.add_stage(After::Pose, rust_only()).expect_err("no text"), in_c);
    let mut split = Scene::on(both, Schedule::Fused);
    refused(split.crowd.add_stage(After::Pose, text_only()).expect_err("no Rust"), in_rust);
    refused(split.crowd.add_stage(After::Pose, rust_only()).expect_err("no text"), in_c);
    split.update(0.1);

    // A crowd moves only to devices that can run its stages, and takes the stages along.
    let gust = native.crowd.add_stage(After::Transform, rust_only()).expect("a stage");
    native.edit(native.members[3]).set_stage(gust, StageUse::on([at(0)])).expect("a stage use");
    native.update(0.1);
    let before = native.bits();
    refused(native.crowd.move_to(Device::opencl(0)).expect_err("no text"), in_c);
    refused(native.crowd.move_to(both).expect_err("no text"), in_c);
    assert_eq!(native.crowd.device_info().devices.as_slice(), [Device::native()]);
    native.crowd.remove(gust).expect("a stage");
    let whole =
        UserStage::new("gust").opencl_c("void gust(StageJoint *joint) { joint->row1.w += 1.0f; }");
    let whole = whole.rust(|joint| joint.model.rows[1][3] += 1.0);
    let gust = native.crowd.add_stage(After::Transform, whole).expect("a stage");
    native.edit(native.members[3]).set_stage(gust, StageUse::on([at(0)])).expect("a stage use");
    native.crowd.move_to(both).expect("both forms");
    native.update(0.0);
    assert_eq!(native.bits(), before);
}

#[test]
fn bad_stage_values_are_refused_and_change_nothing() {
    for (devices, schedule) in everywhere() {
        let (mut staged, [bend, _]) = Scene::staged(devices, schedule);
        let member = staged.members[0];
        staged.edit(member).set_stage(bend, StageUse::on([at(1)])).expect("a stage use");
        staged.update(0.1);
        let before = staged.bits();
        let nan = StageUse::on([at(1)]).with_values([0.0, f32::NAN, 0.0, 0.0]);
        for bad in [nan, StageUse::on([at(99)])] {
            assert!(
                staged.crowd.member_mut(member).and_then(|mut m| m.set_stage(bend, bad)).is_err()
            );
        }
        assert!(staged.crowd.set_stage_parameters(bend, &[f32::INFINITY]).is_err());
        assert!(staged.crowd.set_stage_parameters(bend, &[0.0; 17]).is_err());
        for name in ["", "3d", "a-b", "gust()"] {
            let error =
                staged.crowd.add_stage(After::Pose, UserStage::new(name).rust(|_| ()).opencl_c(""));
            assert!(matches!(error, Err(Error::Tables(_))), "{error:?}");
        }
        let other = stage().opencl_c("void act(StageJoint *joint) { }");
        assert!(
            staged.crowd.add_stage(After::Pose, other).is_err(),
            "two texts may define one function"
        );
        assert!(staged.crowd.add_stage(After::Pose, UserStage::new("formless")).is_err());
        staged.update(0.0);
        assert_eq!(staged.bits(), before);
    }
}

#[test]
fn at_most_eight_stages_can_be_added() {
    let mut staged = Scene::on(Device::native(), Schedule::Fused);
    let lift = || UserStage::new("lift").rust(|joint| joint.model.rows[1][3] += 1.0);
    staged.update(0.0);
    let before = staged.models(0)[0].rows[1][3];
    for _ in 0..8 {
        let id = staged.crowd.add_stage(After::Transform, lift()).expect("enough capacity");
        staged.edit(staged.members[0]).set_stage(id, StageUse::on([at(0)])).expect("a stage use");
    }
    assert!(staged.crowd.add_stage(After::Transform, lift()).is_err(), "a ninth stage was added");
    staged.update(0.0);
    assert!((staged.models(0)[0].rows[1][3] - before - 8.0).abs() < 1e-5);
}
