//! Checks citations in sources and documents.

use std::fs;
use std::path::{Path, PathBuf};

/// The paper that is cited by section, figure and equation. Only its first pages were available.
const PAPER: &str = concat!("Lister & Day", " 2012");

/// The known parts of the paper: words that precede numbers, and the valid numbers.
const KNOWN: [(&[&str], &[&str]); 3] = [
    (&["section", "sections"], &["1", "2", "3", "3.1", "3.2"]),
    (&["fig", "figs"], &["1", "2", "3", "4"]),
    (&["eq", "equation"], &["1"]),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the files below a folder with one of the given extensions.
fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("target") {
            found.extend(files(&path, extensions));
        } else if path
            .extension()
            .is_some_and(|e| extensions.iter().any(|extension| e == *extension))
        {
            found.push(path);
        }
    }
    found
}

/// Returns a file's text as one line, without comment marks.
fn joined_text(path: &Path) -> String {
    let text =
        fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let lines =
        text.lines().map(|line| line.trim_start().trim_start_matches(['/', '*', '!']).trim());
    lines.collect::<Vec<_>>().join(" ")
}

/// Returns the numbers that follow one of the words in a citation.
fn numbers<'a>(citation: &'a str, words: &[&str]) -> Vec<&'a str> {
    let mut found = Vec::new();
    let mut follows = false;
    for word in citation.split([' ', ',', '(', ')', ';', ':']).map(|w| w.trim_end_matches('.')) {
        let is_number = word.starts_with(|c: char| c.is_ascii_digit());
        follows = words.contains(&word) || follows && (is_number || matches!(word, "" | "and"));
        if follows && is_number {
            found.push(word);
        }
    }
    found
}

#[test]
fn paper_is_cited_by_known_sections() {
    let endings = ["rs", "cl", "glsl", "md"];
    let mut count = 0;
    for path in
        files(&root().join("crates"), &endings).iter().chain(&files(&root().join("docs"), &endings))
    {
        for citation in joined_text(path).split(PAPER).skip(1) {
            let citation: String = citation.chars().take(40).collect();
            let place = format!("{}: {PAPER}{citation}", path.display());
            assert!(!numbers(&citation, KNOWN[0].0).is_empty(), "names no section: {place}");
            for (words, known) in KNOWN {
                let unknown = numbers(&citation, words).into_iter().find(|n| !known.contains(n));
                assert_eq!(unknown, None, "{} not known: {place}", words[0]);
            }
            count += 1;
        }
    }
    assert!(count > 5, "{count} citations of the paper are too few to trust this test");
}

#[test]
fn twins_name_each_other() {
    let crates = root().join("crates");
    let kernels = crates.join("populace-opencl/kernels");
    let mut count = 0;
    for path in files(&crates, &["rs"]) {
        let text = fs::read_to_string(&path).expect("a source");
        let head: Vec<_> =
            text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim).collect();
        let own = path.strip_prefix(&crates).expect("a path below crates").to_string_lossy();
        let own = own.split_once("src/").map_or(&*own, |(_, file)| file).to_owned();
        for named in head.join(" ").to_lowercase().split("twin of ").skip(1) {
            let Some(kernel) = named.split("`kernels/").nth(1) else { continue };
            let kernel = kernel.split('`').next().expect("a name");
            let text = joined_text(&kernels.join(kernel));
            assert!(text.contains(&own), "{kernel} does not name {}", path.display());
            count += 1;
        }
    }
    assert!(count > 20, "{count} twins are too few to trust this test");
    for path in files(&kernels, &["cl"]) {
        for named in joined_text(&path).split("populace-").skip(1) {
            let file: String =
                named.chars().take_while(|c| c.is_alphanumeric() || "/_.-".contains(*c)).collect();
            let file = file.trim_end_matches('.');
            let file_path = crates.join(format!("populace-{file}"));
            assert!(file_path.exists(), "{} names {}", path.display(), file_path.display());
        }
    }
}

/// Kernel functions whose twin has another name: the kernel, its function, and the twin's file and
/// name. A prefix of [`PREFIXES`] counts as the same name.
const OTHER_NAMES: &[(&str, &str, &str, &str)] = &[
    ("affine", "affine_row", "populace-model/src/math/affine.rs", "mul"),
    ("affine", "affine_mul_rows", "populace-model/src/math/affine.rs", "mul"),
    ("affine", "origin_of", "populace-model/src/math/affine.rs", "origin"),
    ("affine", "components_of", "populace-model/src/math/affine.rs", "components"),
    ("angle", "angle_of", "populace-model/src/math/angle.rs", "of"),
    ("constraints", "solve_joint", "populace-native/src/constraints/descent.rs", "descend"),
    ("fused", "play", "populace-native/src/playback.rs", "play_all"),
    ("fused_grouped", "fused_grouped", "populace-native/src/fused.rs", "fused"),
    ("fused_grouped", "run_frame", "populace-native/src/fused.rs", "write_groups"),
    ("fused_grouped", "batch_models", "populace-native/src/fused.rs", "member_models"),
    ("fused_grouped", "write_palettes", "populace-native/src/fused.rs", "write_palette"),
    ("fused_grouped", "place_below", "populace-native/src/constraints/descent.rs", "descend"),
    ("fused_grouped", "descend_all", "populace-native/src/constraints/descent.rs", "descend"),
    ("fused_grouped", "descend_plain", "populace-native/src/constraints/descent.rs", "descend"),
    ("fused_grouped", "play_all", "populace-native/src/playback.rs", "play_all"),
    ("constraints", "take_steps", "populace-native/src/constraints/descent.rs", "descend"),
    ("foot_state", "foot_state", "populace-native/src/constraints/foot_state.rs", "of_numbers"),
    ("foot_state", "put_foot_state", "populace-native/src/constraints/foot_state.rs", "numbers"),
    ("foot_state", "stance_of", "populace-native/src/constraints/foot_state.rs", "of_numbers"),
    ("hierarchy", "local_in", "populace-native/src/hierarchy.rs", "local_of"),
    ("hierarchy", "models_after", "populace-native/src/matrices.rs", "product"),
    ("hierarchy", "models_of", "populace-native/src/hierarchy.rs", "model_of"),
    ("hierarchy", "keep_beneath", "populace-native/src/matrices.rs", "product"),
    ("hierarchy", "keep_models", "populace-native/src/hierarchy.rs", "keep_model"),
    ("foot", "put_points", "populace-native/src/constraints/foot.rs", "step_foot"),
    ("foot", "same_in_lanes", "populace-native/src/constraints/foot.rs", "splat"),
    ("foot", "stand_on_point", "populace-native/src/constraints/foothold.rs", "stand_on"),
    ("foot", "stand_on_points", "populace-native/src/constraints/foot.rs", "foot_goal"),
    ("foothold", "grounds_at", "populace-native/src/constraints/foothold.rs", "ground_at"),
    ("foothold", "next_heights", "populace-native/src/constraints/foothold.rs", "shown_height"),
    ("fused_grouped", "pose_kept", "populace-native/src/joint.rs", "pose_joint"),
    ("fused_grouped", "inertialize_kept", "populace-native/src/inertialize.rs", "inertialize"),
    ("gaze", "shares_of", "populace-native/src/constraints/gaze.rs", "put_gazes"),
    ("gaze", "targets_most", "populace-native/src/constraints/gaze.rs", "put_gazes"),
    (
        "inertialize",
        "outgoing_state",
        "populace-device/src/playback/inertialize.rs",
        "outgoing_state",
    ),
    (
        "inertialize",
        "incoming_state",
        "populace-device/src/playback/inertialize.rs",
        "incoming_state",
    ),
    ("inertialize", "earlier_start", "populace-native/src/inertialize.rs", "inertialize"),
    ("inertialize", "left_since", "populace-native/src/inertialize.rs", "inertialize"),
    ("inertialize", "inertialized", "populace-native/src/inertialize.rs", "inertialize"),
    (
        "inertialize",
        "inertialization_sample",
        "populace-native/src/inertialize.rs",
        "sampled_poses",
    ),
    ("inertialize", "part_left", "populace-native/src/inertialize.rs", "left_of"),
    ("inertialize", "row_before", "populace-device/src/playback/inertialize.rs", "row_before"),
    ("inertialize", "far_row", "populace-device/src/playback/inertialize.rs", "far_row"),
    ("joint", "layer_pose", "populace-native/src/joint.rs", "lay_over"),
    ("joint", "laying_of", "populace-native/src/joint.rs", "lay_over"),
    ("joint", "is_silent", "populace-native/src/joint.rs", "lay_over"),
    ("joint", "show_layer", "populace-native/src/joint.rs", "lay_over"),
    ("joint", "laid_over", "populace-native/src/joint.rs", "lay_over"),
    ("sums", "sum_spans", "populace-native/src/joint.rs", "sum_layer"),
    ("joint", "share_of", "populace-native/src/joint.rs", "mix_layer"),
    ("joint", "mix_rotations", "populace-native/src/joint.rs", "mix_layer"),
    ("sums", "unit_rotation", "populace-native/src/sample.rs", "normalized"),
    ("sums", "weighted_change", "populace-native/src/joint.rs", "sum_layer"),
    ("sums", "sum_changes", "populace-native/src/joint.rs", "sum_layer"),
    ("local", "add_layer_rotation", "populace-native/src/local.rs", "add_layer"),
    ("local", "add_layer_scale", "populace-native/src/local.rs", "add_layer"),
    ("local", "scale_ratios", "populace-native/src/local.rs", "quotient"),
    ("company", "with_slot", "populace-native/src/playback.rs", "alone_in_layers"),
    ("layers", "put_rotation", "populace-native/src/poses.rs", "put_local"),
    ("layers", "show_alone", "populace-native/src/joint.rs", "sum_layer"),
    ("layers", "show_own", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "show_layer", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "laid_rotation", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "laid_translation", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "laid_scale", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "lay_in_lane", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "lay_over_all", "populace-native/src/joint.rs", "lay_over"),
    ("layers", "change_poses", "populace-native/src/joint.rs", "change_pose"),
    ("joint", "changes_of", "populace-native/src/joint.rs", "is_changed"),
    ("joint", "are_changes", "populace-native/src/joint.rs", "is_changed"),
    ("rows", "rows_of", "populace-native/src/encoding.rs", "of"),
    ("rows", "halves_of", "populace-native/src/encoding.rs", "of"),
    ("lanes", "mix_low", "populace-native/src/registers.rs", "mix_low"),
    ("lanes", "mix_high", "populace-native/src/registers.rs", "mix_high"),
    ("lanes", "mix_pairs", "populace-native/src/registers.rs", "mix_pairs"),
    ("abreast", "sum_members", "populace-native/src/poses.rs", "run"),
    ("abreast", "pose_span", "populace-native/src/poses.rs", "run"),
    ("abreast", "place_span", "populace-native/src/abreast.rs", "place_block"),
    ("abreast", "posed_joint", "populace-native/src/poses.rs", "matrices"),
    ("abreast", "sum_member", "populace-native/src/poses.rs", "run"),
    ("abreast", "pose_alone", "populace-native/src/joint.rs", "sum_layer"),
    ("abreast", "turn_components", "populace-native/src/abreast.rs", "place_block"),
    ("abreast", "posing_of", "populace-native/src/joint.rs", "posing"),
    ("members", "member_phase", "populace-device/src/tables/members.rs", "phase"),
    ("motion", "move_of", "populace-native/src/constraints/motion.rs", "new"),
    ("motion", "moves_over", "populace-native/src/constraints/motion.rs", "over"),
    ("motion", "speed_of", "populace-native/src/constraints/motion.rs", "speed"),
    ("motion", "next_of", "populace-native/src/constraints/motion.rs", "next"),
    ("quat", "quat_part", "populace-model/src/math/vec3.rs", "part_of"),
    ("quat", "quat_part_as_told", "populace-model/src/math/vec3.rs", "part_as_told"),
    ("real", "mix_real", "populace-model/src/math/real.rs", "mix"),
    ("real", "square_root", "populace-model/src/math/vec3.rs", "root"),
    ("real", "root", "populace-model/src/math/vec3.rs", "root"),
    ("real", "inverse_root", "populace-model/src/math/real.rs", "inverse_sqrt"),
    ("rows", "planes_of", "populace-native/src/encoding.rs", "of"),
    ("rows", "columns_of", "populace-native/src/rows.rs", "columns"),
    ("rows", "mix_floats", "populace-native/src/encoding.rs", "parts_in"),
    ("rows", "float_quats", "populace-native/src/block_columns.rs", "rotation"),
    ("rows", "float_vectors", "populace-native/src/block_columns.rs", "vector"),
    ("rows", "reading_of", "populace-native/src/block_columns.rs", "words"),
    ("rows", "sample_at_once", "populace-native/src/sample.rs", "sample_columns"),
    ("rows", "rotation_parts", "populace-native/src/rows.rs", "parts"),
    ("rows", "vector_parts", "populace-native/src/rows.rs", "parts"),
    ("rows", "mix_quats", "populace-native/src/block_columns.rs", "rotation"),
    ("rows", "mix_vectors", "populace-native/src/block_columns.rs", "vector"),
    ("rows", "row_words", "populace-native/src/block_columns.rs", "words"),
    ("rows", "stored_at", "populace-native/src/rows.rs", "stored"),
    ("rows", "stored_real", "populace-native/src/rows.rs", "load_plane"),
    ("rows", "stored_quat", "populace-native/src/rows.rs", "load_quat"),
    ("rows", "stored_vec3", "populace-native/src/rows.rs", "load_vec3"),
    ("rows", "moving_quat", "populace-native/src/rows.rs", "sample_rotation"),
    ("rows", "moving_vector", "populace-native/src/rows.rs", "sample_vector"),
    ("rows", "sample_columns", "populace-native/src/sample.rs", "sample_columns"),
    ("rows", "near_unit_of", "populace-native/src/sample.rs", "unit_of"),
    ("rows", "unit_of", "populace-native/src/sample.rs", "unit_of"),
    ("rows", "normalized", "populace-native/src/sample.rs", "normalized"),
    ("rows", "sample_joint", "populace-native/src/sample.rs", "sample_joint"),
    ("slot", "slot_weight", "populace-device/src/playback.rs", "weight_at"),
    ("slot", "slot_time", "populace-device/src/playback.rs", "time_at"),
    ("slot", "slot_cycles", "populace-device/src/playback.rs", "cycles_between"),
    (
        "foot_state",
        "vec3_direction_to_model",
        "populace-native/src/constraints/targets.rs",
        "direction_to_model",
    ),
    ("foot_state", "vec3_to_model", "populace-native/src/constraints/targets.rs", "to_model"),
    ("foot_state", "vec3_to_world", "populace-native/src/constraints/targets.rs", "to_world"),
    ("chain", "walk_in", "populace-native/src/constraints/chain.rs", "positions"),
    ("chain", "keep_points", "populace-native/src/constraints/chain.rs", "chain"),
    ("chain", "stretch_chain", "populace-native/src/constraints/chain.rs", "chain"),
    ("targets", "solver_of", "populace-native/src/constraints/targets.rs", "new"),
    ("targets", "target_weight", "populace-device/src/control.rs", "weight_at"),
    ("vec3", "vec3_mix", "populace-model/src/math/real.rs", "mix"),
    ("vec3", "vec_dot", "populace-model/src/math/vec3.rs", "dot"),
    ("vec3", "vec_cross", "populace-model/src/math/vec3.rs", "cross"),
    ("vec3", "vec_length", "populace-model/src/math/vec3.rs", "length"),
    ("vec3", "rotation_dot", "populace-model/src/math/quat.rs", "dot"),
    ("vec3", "rotation_unit", "populace-model/src/math/quat.rs", "normalize_or"),
    ("vec3", "rotation_mul", "populace-model/src/math/quat.rs", "mul"),
    ("vec3", "rotation_between", "populace-model/src/math/vec3.rs", "between"),
];

/// Kernel functions without a twin, by file, with the reason. `*` stands for all of a file.
const NO_TWIN: &[(&str, &[&str], &str)] = &[
    ("affine", &["repeated", "last_column"], "vectors of OpenCL C"),
    ("chain", &["point_of", "keep_point", "keep_rotation"], "arrays in Rust"),
    ("contacts", &["stepping", "play_count", "play_in"], "inputs in lanes"),
    ("contacts", &["share_clip", "contacts_of"], "one slice, natively"),
    ("targets", &["target_of"], "targets() returns all"),
    ("feet", &["hand_down_leg", "hand_down_goals", "legs_to_goals"], "stores in Rust"),
    ("floor", &["floor_float4", "floor_matrix", "floor_run"], "one way to write among several"),
    (
        "foot_state",
        &[
            "stored_foot",
            "foot_states",
            "keep_foot_states",
            "epochs_of",
            "foot_number",
            "put_foot_number",
            "foot_heights",
            "put_foot_heights",
        ],
        "one foot of a member, natively",
    ),
    ("fused", &["store_trs"], "a buffer and lanes of the device"),
    (
        "fused_grouped",
        &[
            "grouped_of",
            "body_of",
            "batch_of",
            "models_in",
            "playing_in",
            "rotations_in",
            "keep_pose",
            "kept_pose",
            "pose_member",
            "descend",
            "place_at",
            "list_places",
            "fused_grouped_plain",
            "fused_grouped_joints",
        ],
        "work-groups, their memory, and their readback",
    ),
    (
        "company",
        &["join", "fetch_member", "fetch_controls", "fetch_steps", "fetch_constraints"],
        "members of a work-item, and their memory",
    ),
    ("abreast", &["are_led"], "members of a work-item"),
    ("abreast", &["sum_any_member"], "columns of any storage are sampled apart"),
    ("layers", &["show_any_layer"], "columns of any storage are sampled apart"),
    ("layers", &["complete"], "all properties are computed, to the same numbers"),
    ("abreast", &["at_rest_in_all"], "a loop in PoseBlock"),
    ("fused_wide", &["*"], "work-items, their memory and its caches"),
    (
        "hierarchy",
        &[
            "locals_of",
            "handed_rotations",
            "hand_rotations",
            "handed_rotation_in",
            "hand_rotation_in",
        ],
        "arrays in Rust",
    ),
    ("inertialize", &["inertializes_in"], "closures in Rust"),
    ("joint", &["inertialize"], "a declaration of another file's function"),
    (
        "lanes",
        &["mix_eight", "transpose", "no_numbers", "put_numbers", "turn_numbers", "numbers_in"],
        "arrays in Rust",
    ),
    ("local", &["local_add", "local_scale", "local_less"], "loops over components in Rust"),
    ("machines", &["machine_clip"], "the field of a slot in Rust"),
    ("matrices", &["matrix_in", "put_matrix", "matrix_row", "put_matrix_row"], "arrays in Rust"),
    ("matrices", &["row_product"], "product() computes the rows natively"),
    ("motion", &["between", "motion_row"], "closures in Rust"),
    ("playback", &["playing_at"], "an array's index in Rust"),
    (
        "programs",
        &[
            "own_models",
            "rotate_own",
            "step_in",
            "constraint_in",
            "hand_down",
            "handed_down",
            "settings_of",
            "vec3_of",
            "put_vec3",
            "vec3_in",
        ],
        "members in lanes",
    ),
    ("rows", &["rows_in"], "a field in Rust"),
    ("rows", &["row_start"], "slices in Rust"),
    ("rows", &["words_at", "halves_at"], "formats of a block in the device's registers"),
    ("rows", &["stored_offset"], "slices in Rust"),
    ("stages", &["run_user_stage", "lane_of"], "generated code, and lanes"),
    ("sums", &["no_local"], "a constructor in Rust"),
    (
        "sums",
        &[
            "block_slot",
            "next_span",
            "rotation_of",
            "factor_of",
            "add_vector",
            "unit_alone",
            "rotation_alone",
            "vector_alone",
            "add_property",
            "sum_property",
            "sample_rotations",
            "sum_rotations",
        ],
        "property by property: the same terms in the same order",
    ),
    ("vec3", &["vec"], "vectors of OpenCL C"),
];

/// Prefixes that name the type or module of the twin: `quat_mul` is `quat::mul`.
const PREFIXES: &[&str] = &["quat_", "vec3_", "affine_", "slot_", "move_", "stage_", "matrix_"];

/// Words that begin the definition of a kernel's function.
const STARTS: &[&str] = &["INLINE ", "SELDOM ", "APART ", "__kernel ", "static "];

/// Returns the names of the functions that a kernel file declares or defines.
fn kernel_functions(text: &str) -> Vec<&str> {
    let starts = |line: &&str| STARTS.iter().any(|start| line.starts_with(start));
    let offset = |line: &str| line.as_ptr() as usize - text.as_ptr() as usize;
    let names = text.lines().filter(starts).filter_map(|line| {
        let head = text[offset(line)..].split(['{', ';']).next()?;
        let attribute = head.contains("__attribute__").then(|| head.find("))")).flatten();
        let head = attribute.map_or(head, |end| &head[end + 2..]);
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        head.split('(').next()?.rsplit(|c| !is_word(c)).next()
    });
    names.filter(|name| !name.is_empty()).collect()
}

/// Returns the paths of the Rust files that the head of a kernel file names as twins.
fn twins_of(text: &str) -> Vec<String> {
    let head: Vec<&str> =
        text.lines().take_while(|line| line.is_empty() || line.starts_with("//")).collect();
    let head = head.join(" ").replace("//", " ");
    let named = head.split("Twin of ").nth(1).unwrap_or_default();
    let words = named.split([' ', ',', ':', ';']).filter(|word| word.starts_with("populace-"));
    words.map(|word| word.trim_end_matches('.').to_owned()).collect()
}

/// Returns whether a Rust text has a function of a name.
fn defines(text: &str, name: &str) -> bool {
    let ends = |rest: &str| rest.starts_with(['(', '<']);
    text.split(&format!("fn {name}")).skip(1).any(ends)
}

#[test]
fn kernel_functions_have_twins() {
    let crates = root().join("crates");
    let read = |file: &str| fs::read_to_string(crates.join(file)).expect(file);
    let (mut faults, mut count) = (Vec::new(), 0);
    for path in files(&crates.join("populace-opencl/kernels"), &["cl"]) {
        let kernel = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let text = fs::read_to_string(&path).expect("a kernel");
        let twins: String = twins_of(&text).iter().map(|file| read(file)).collect();
        let excused = NO_TWIN.iter().filter(|(file, ..)| *file == kernel);
        let excused: Vec<&str> = excused.flat_map(|(_, names, _)| names.iter().copied()).collect();
        let functions = kernel_functions(&text);
        for name in excused.iter().filter(|name| **name != "*" && !functions.contains(name)) {
            faults.push(format!("{kernel}.cl has no {name}, which NO_TWIN lists"));
        }
        if twins.is_empty() || excused.contains(&"*") {
            continue;
        }
        for name in functions {
            let other = OTHER_NAMES.iter().find(|(file, own, ..)| *file == kernel && *own == name);
            let short = PREFIXES.iter().filter_map(|prefix| name.strip_prefix(prefix));
            let found = match other {
                Some((_, _, file, twin)) => defines(&read(file), twin),
                None => short.chain([name]).any(|name| defines(&twins, name)),
            };
            if found == excused.contains(&name) {
                faults.push(match found {
                    true => format!("{kernel}.cl: {name} has a twin; NO_TWIN need not list it"),
                    false => format!("{kernel}.cl: {name} has no twin of this name"),
                });
            }
            count += 1;
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 150, "{count} functions are too few to trust this test");
}
