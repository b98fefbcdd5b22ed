//! Parity of leaf functions: each function that exists in Rust and in OpenCL C runs over the same
//! random and extreme inputs, and must return the same bits. NaN equals NaN, since its bits depend
//! on the order of operands that a compiler chooses.

use std::fmt::Write as _;

use populace_model::math::{Affine, Real, angle, components, quat, vec3};
use populace_testkit::Rng;

use super::*;
use crate::launch::WorkSize;

/// Inputs of every function: 16 numbers for each.
const ITEMS: usize = 65_536;
const WIDTH: usize = 16;
/// Files whose functions are compared.
const FILES: [(&str, &str); 5] = [
    ("real", include_str!("../../../kernels/real.cl")),
    ("quat", include_str!("../../../kernels/quat.cl")),
    ("vec3", include_str!("../../../kernels/vec3.cl")),
    ("affine", include_str!("../../../kernels/affine.cl")),
    ("angle", include_str!("../../../kernels/angle.cl")),
];
/// Functions that the tests below reach only through others, with the reason.
const HELPERS: [(&str, &str); 7] = [
    ("repeated", "spreads a row for products of matrices"),
    ("last_column", "picks a column for products of matrices"),
    ("quat_identity", "takes no input"),
    ("vec", "puts numbers together"),
    ("quat_choose", "copies; each function that chooses runs it"),
    ("vec3_choose", "copies; each function that chooses runs it"),
    ("mix_real", "takes one number for all lanes: quat_mix and vec3_mix are its like"),
];

type Inputs = [f32; WIDTH];

/// A function in both languages.
struct Twin {
    /// The name in OpenCL C.
    name: &'static str,
    /// A statement in OpenCL C that puts the result.
    call: &'static str,
    /// Only one lane: a function of one joint.
    one: bool,
    rust: fn(&Inputs) -> Vec<f32>,
}

fn v(x: &Inputs, at: usize) -> [f32; 3] {
    [x[at], x[at + 1], x[at + 2]]
}

fn q(x: &Inputs, at: usize) -> [f32; 4] {
    [x[at], x[at + 1], x[at + 2], x[at + 3]]
}

/// The matrix of the first twelve numbers.
fn m(x: &Inputs) -> Affine {
    Affine { rows: [q(x, 0), q(x, 4), q(x, 8)] }
}

/// Returns a vector as a kernel's `float4` holds it.
fn four([x, y, z]: [f32; 3]) -> Vec<f32> {
    vec![x, y, z, 0.0]
}

macro_rules! twins {
    ($($kind:ident $name:literal $call:literal $rust:expr;)*) => {
        [$(Twin { name: $name, call: $call, one: stringify!($kind) == "one", rust: $rust }),*]
    };
}

#[expect(clippy::too_many_lines, reason = "a line for each function")]
fn twins() -> impl IntoIterator<Item = Twin> {
    twins! {
        lanes "inverse_sqrt" "PUT1(inverse_sqrt(fabs(IN(0))));" |x| vec![x[0].abs().inverse_sqrt()];
        one "inverse_root" "PUT1(inverse_root(fabs(IN(0))));" |x| vec![x[0].abs().inverse_sqrt()];
        lanes "square_root" "PUT1(square_root(IN(0)));" |x| vec![vec3::root(x[0])];
        one "root" "PUT1(root(IN(0)));" |x| vec![vec3::root(x[0])];
        lanes "quat_dot" "PUT1(quat_dot(Q(0), Q(4)));" |x| vec![quat::dot(q(x, 0), q(x, 4))];
        lanes "quat_scale" "PUTQ(quat_scale(Q(0), IN(4)));" |x| quat::scale(q(x, 0), x[4]).to_vec();
        lanes "quat_add" "PUTQ(quat_add(Q(0), Q(4)));" |x| quat::add(q(x, 0), q(x, 4)).to_vec();
        lanes "quat_mix" "PUTQ(quat_mix(Q(0), Q(4), IN(8)));"
            |x| quat::mix(q(x, 0), q(x, 4), x[8]).to_vec();
        lanes "quat_normalize_or" "PUTQ(quat_normalize_or(Q(0), Q(4)));"
            |x| quat::normalize_or(q(x, 0), q(x, 4)).to_vec();
        lanes "quat_side" "PUT1(quat_side(Q(0), Q(4)));" |x| vec![quat::side(q(x, 0), q(x, 4))];
        lanes "quat_hemisphere" "PUTQ(quat_hemisphere(Q(0), Q(4)));"
            |x| quat::hemisphere(q(x, 0), q(x, 4)).to_vec();
        lanes "quat_short_way" "PUTQ(quat_short_way(Q(0)));" |x| quat::short_way(q(x, 0)).to_vec();
        lanes "quat_conjugate" "PUTQ(quat_conjugate(Q(0)));" |x| quat::conjugate(q(x, 0)).to_vec();
        lanes "quat_mul" "PUTQ(quat_mul(Q(0), Q(4)));" |x| quat::mul(q(x, 0), q(x, 4)).to_vec();
        lanes "quat_part_as_told" "PUTQ(quat_part_as_told(Q(0), IN(4)));"
            |x| vec3::part_as_told(q(x, 0), x[4]).to_vec();
        lanes "quat_part" "PUTQ(quat_part(Q(0), IN(4)));" |x| vec3::part_of(q(x, 0), x[4]).to_vec();
        lanes "vec3_scale" "PUTV(vec3_scale(V(0), IN(3)));" |x| vec3::scale(v(x, 0), x[3]).to_vec();
        lanes "vec3_add" "PUTV(vec3_add(V(0), V(3)));" |x| vec3::add(v(x, 0), v(x, 3)).to_vec();
        lanes "vec3_dot" "PUT1(vec3_dot(V(0), V(3)));" |x| vec![vec3::dot(v(x, 0), v(x, 3))];
        lanes "vec3_cross" "PUTV(vec3_cross(V(0), V(3)));"
            |x| vec3::cross(v(x, 0), v(x, 3)).to_vec();
        lanes "vec3_add_scaled" "PUTV(vec3_add_scaled(V(0), V(3), IN(6)));"
            |x| vec3::add_scaled(v(x, 0), v(x, 3), x[6]).to_vec();
        lanes "vec3_mix" "PUTV(vec3_mix(V(0), V(3), IN(6)));"
            |x| [0, 1, 2].map(|i| x[i].mix(x[3 + i], x[6])).to_vec();
        lanes "vec3_across" "PUTV(vec3_across(V(0), V(3)));"
            |x| vec3::across(v(x, 0), v(x, 3)).to_vec();
        lanes "vec3_unit_or" "PUTV(vec3_unit_or(V(0), V(3)));"
            |x| vec3::unit_or(v(x, 0), v(x, 3)).to_vec();
        lanes "vec3_any_across" "PUTV(vec3_any_across(V(0)));"
            |x| vec3::any_across(v(x, 0)).to_vec();
        lanes "quat_rotated" "PUTV(quat_rotated(Q(0), V(4)));"
            |x| vec3::rotated(q(x, 0), v(x, 4)).to_vec();
        one "vec_dot" "PUT1(vec_dot(V4(0), V4(3)));" |x| vec![vec3::dot(v(x, 0), v(x, 3))];
        one "vec_cross" "PUT4(vec_cross(V4(0), V4(3)));" |x| four(vec3::cross(v(x, 0), v(x, 3)));
        one "add_scaled" "PUT4(add_scaled(V4(0), V4(3), IN(6)));"
            |x| four(vec3::add_scaled(v(x, 0), v(x, 3), x[6]));
        one "vec_length" "PUT1(vec_length(V4(0)));" |x| vec![vec3::length(v(x, 0))];
        one "unit_or" "const float4 u = unit_or(V4(0), V4(3)); out[0] = u.x; out[1] = u.y; \
                       out[2] = u.z;" |x| vec3::unit_or(v(x, 0), v(x, 3)).to_vec();
        one "across" "PUT4(across(V4(0), V4(3)));" |x| four(vec3::across(v(x, 0), v(x, 3)));
        one "any_across" "const float4 u = any_across(V4(0)); out[0] = u.x; out[1] = u.y; \
                          out[2] = u.z;" |x| vec3::any_across(v(x, 0)).to_vec();
        one "rotation_dot" "PUT1(rotation_dot(F4(0), F4(4)));"
            |x| vec![quat::dot(q(x, 0), q(x, 4))];
        one "rotation_unit" "PUT4(rotation_unit(F4(0)));"
            |x| quat::normalize_or(q(x, 0), quat::identity()).to_vec();
        one "rotation_mul" "PUT4(rotation_mul(F4(0), F4(4)));"
            |x| quat::mul(q(x, 0), q(x, 4)).to_vec();
        one "rotated" "PUT4(rotated(F4(0), V4(4)));" |x| four(vec3::rotated(q(x, 0), v(x, 4)));
        one "rotation_between" "PUT4(rotation_between(V4(0), V4(3), V4(6)));"
            |x| vec3::between(v(x, 0), v(x, 3), v(x, 6)).to_vec();
        one "part_of" "PUT4(part_of(F4(0), IN(4)));" |x| vec3::part_of(q(x, 0), x[4]).to_vec();
        one "affine_mul" "PUTM(affine_mul(M(), TURNED));" |x| flat(&m(x).mul(&turned(x)));
        one "affine_mul_rows"
            "PUTM(affine_mul_rows(M(), TURNED.s0123, TURNED.s4567, TURNED.s89ab));"
            |x| flat(&m(x).mul(&turned(x)));
        one "affine_row"
            "PUT4(affine_row(F4(0), TURNED.s0123, TURNED.s4567, TURNED.s89ab));"
            |x| m(x).mul(&turned(x)).rows[0].to_vec();
        one "origin_of" "PUT4(origin_of(M()));" |x| four(m(x).origin());
        one "transform_point" "PUT4(transform_point(M(), V4(12)));"
            |x| four(m(x).transform_point(v(x, 12)));
        one "transform_vector" "PUT4(transform_vector(M(), V4(12)));"
            |x| four(m(x).transform_vector(v(x, 12)));
        one "affine_rotated" "PUTM(affine_rotated(M(), F4(12)));"
            |x| flat(&m(x).rotated(q(x, 12)));
        lanes "components_of" "Real p[12]; const Local l = { V(0), Q(3), V(7) }; \
                               components_of(l, p); for (int i = 0; i < 12; i++) put(out, i, p[i]);"
            |x| components(v(x, 0), q(x, 3), v(x, 7)).to_vec();
        lanes "angle_of" "PUT1(angle_of(IN(0), IN(1)));" |x| vec![angle::of(x[0], x[1])];
        lanes "sin_cos" "Real s, c; sin_cos(IN(0), &s, &c); put(out, 0, s); put(out, 1, c);"
            |x| { let (sine, cosine) = angle::sin_cos(x[0]); vec![sine, cosine] };
    }
}

/// The matrix of the last twelve numbers.
fn turned(x: &Inputs) -> Affine {
    Affine { rows: [q(x, 4), q(x, 8), q(x, 12)] }
}

fn flat(of: &Affine) -> Vec<f32> {
    of.rows.concat()
}

/// What the probe needs besides the arithmetic. `put` stores a lane's result in the lane's own row.
const HEAD: &str = r"
INLINE Real in_lanes(__global const float *in, uint at)
{
    Real all = (Real)(0.0f);
    for (uint lane = 0; lane < LANES; lane++) PUT(all, lane, in[lane * 16u + at]);
    return all;
}
INLINE void put(__global float *out, uint at, Real value)
{
    for (uint lane = 0; lane < LANES; lane++) out[lane * 16u + at] = LANE(value, lane);
}
INLINE void put_quat(__global float *out, Quat q)
{
    put(out, 0, q.x); put(out, 1, q.y); put(out, 2, q.z); put(out, 3, q.w);
}
INLINE void put_vec3(__global float *out, Vec3 v)
{
    put(out, 0, v.x); put(out, 1, v.y); put(out, 2, v.z);
}
#define IN(k) in_lanes(in, k)
#define PUT1(value) put(out, 0, value)
#define PUTQ(value) put_quat(out, value)
#define PUTV(value) put_vec3(out, value)
#define PUT4(value) vstore4(value, 0, out)
#define PUTM(value) vstore16(value, 0, out)
#define F4(k) vload4(0, in + (k))
#define V4(k) vec(in[k], in[(k) + 1], in[(k) + 2])
#define M() vload16(0, in)
#define TURNED ((float16)(F4(4), F4(8), F4(12), (float4)(0.0f)))
#define Q(k) quat_at(in, k)
#define V(k) vec3_at(in, k)
INLINE Quat quat_at(__global const float *in, uint k)
{
    const Quat q = { IN(k), IN(k + 1), IN(k + 2), IN(k + 3) };
    return q;
}
INLINE Vec3 vec3_at(__global const float *in, uint k)
{
    const Vec3 v = { IN(k), IN(k + 1), IN(k + 2) };
    return v;
}
";

/// Returns the probe's text for one, eight or sixteen lanes.
fn probe(lanes: usize) -> String {
    let mut text = format!(
        "#pragma OPENCL FP_CONTRACT OFF\n#define LANES {lanes}\n{}",
        populace_device::layout::opencl_prelude()
    );
    text += include_str!("../../../kernels/lanes.cl");
    for name in ["real", "quat", "vec3"] {
        text += FILES.iter().find(|(file, _)| *file == name).unwrap().1;
    }
    text += include_str!("../../../kernels/local.cl");
    text += FILES[3].1;
    text += FILES[4].1;
    text += HEAD;
    text += "__kernel void probe(__global const float *inputs, __global float *outputs, \
             uint function)\n{\n    const uint first = get_global_id(0) * LANES * 16u;\n    \
             __global const float *in = inputs + first;\n    \
             __global float *out = outputs + first;\n    switch (function) {\n";
    for (number, twin) in twins().into_iter().enumerate() {
        if lanes == 1 || !twin.one {
            writeln!(text, "    case {number}: {{ {} break; }}", twin.call).unwrap();
        }
    }
    text + "    }\n}\n"
}

/// Numbers at the ends of the format and around the functions' thresholds.
const EDGES: [f32; 22] = [
    0.0,
    -0.0,
    f32::from_bits(1),
    -f32::from_bits(1),
    f32::from_bits(0x007f_ffff),
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-20,
    9.9e-11,
    1.1e-10,
    -1e-10,
    1e-7,
    0.5,
    1.0,
    -1.0,
    std::f32::consts::PI,
    1e19,
    -1e19,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Returns the inputs of one item: unit quaternions and their negatives, plain numbers, numbers of
/// any exponent, or extremes.
fn inputs(rng: &mut Rng, item: usize) -> Inputs {
    let near = rng.rotation().to_array().map(populace_model::convert::single);
    std::array::from_fn(|at| match item % 4 {
        // Two quaternions, nearly opposite, then two vectors, nearly opposite.
        0 if at < 4 => near[at],
        0 if at < 8 => -near[at - 4] + 1e-7 * rng.signed(),
        0 if at < 12 => near[at - 8],
        0 => -near[at - 12],
        1 => 3.0 * rng.signed(),
        2 => f32::from_bits(u32::try_from(rng.bits() & 0xffff_ffff).unwrap()),
        _ if rng.chance(0.6) => EDGES[rng.below(EDGES.len())],
        _ => rng.signed(),
    })
}

fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

/// Runs every function of a number of lanes on the device, and compares.
fn compare_in_lanes(lanes: usize) {
    let mut rng = Rng::new(61);
    let inputs: Vec<Inputs> = (0..ITEMS).map(|item| inputs(&mut rng, item)).collect();
    let device = device();
    let program = device.build(&probe(lanes)).unwrap();
    let (kernel, queue) = (Kernel::create(&program, "probe").unwrap(), device.queue().unwrap());
    let buffer = || crate::buffer::Buffer::<f32>::new(&device, ITEMS * WIDTH, "the probe").unwrap();
    let (mut given, mut out) = (buffer(), buffer());
    given.write(&queue, 0, &inputs.concat()).unwrap();
    let mut found = vec![0.0; ITEMS * WIDTH];
    for (number, twin) in twins().into_iter().enumerate().filter(|(_, t)| lanes == 1 || !t.one) {
        out.write(&queue, 0, &vec![0.0; ITEMS * WIDTH]).unwrap();
        Launch::of(&kernel)
            .buffer("inputs", &given)
            .buffer("outputs", &out)
            .uint("function", u32::try_from(number).unwrap())
            .run(&queue, WorkSize::of(ITEMS / lanes, 16))
            .unwrap();
        out.read(&queue, 0, &mut found).unwrap();
        let (mut different, mut first) = (0, None);
        for (inputs, found) in inputs.iter().zip(found.chunks(WIDTH)) {
            let wanted = (twin.rust)(inputs);
            if !wanted.iter().zip(found).all(|(a, b)| same(*a, *b)) {
                different += 1;
                first = first.or_else(|| Some((*inputs, wanted, found.to_vec())));
            }
        }
        let name = twin.name;
        assert!(different == 0, "{name}, {lanes} lanes: {different} of {ITEMS} differ: {first:?}");
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn leaf_functions_give_equal_bits_for_one_joint() {
    compare_in_lanes(1);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn leaf_functions_give_equal_bits_in_lanes() {
    compare_in_lanes(8);
    compare_in_lanes(16);
}

/// A function that is added to a kernel's file must be added here.
#[test]
fn every_leaf_function_is_compared() {
    let mut missing = Vec::new();
    for (file, text) in FILES {
        for line in text.lines().filter(|line| line.starts_with("INLINE ")) {
            let name = line.split('(').next().and_then(|head| head.split(' ').next_back());
            let name = name.unwrap_or_default();
            let known = twins().into_iter().any(|twin| twin.name == name)
                || HELPERS.iter().any(|(helper, _)| *helper == name);
            if !known {
                missing.push(format!("{file}.cl: {name}"));
            }
        }
    }
    assert!(missing.is_empty(), "not compared: {missing:?}");
}
