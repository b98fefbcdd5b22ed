// constants.cl - Constants of the arithmetic. Each has the name and the value of its twin in Rust.

// populace-core/src/math/real.rs: bits from which the first guess of 1 / sqrt(x) is computed.
#define INVERSE_SQRT_BITS 0x5f3759df
// populace-core/src/math/vec3.rs: squared lengths below this count as 0.
#define TINY 1e-20f
// populace-core/src/math/angle.rs: pi and pi / 2.
#define HALF_TURN 3.14159274101257324f
#define QUARTER_TURN 1.57079637050628662f
// populace-native/src/constraints/gaze.rs. STEEP: sine of the angle from straight up or down below
// which a target's sideways direction is faded out, because it changes wildly there. UPRIGHT: level
// part that replaces a facing direction of less.
#define STEEP 0.17f
#define UPRIGHT 1e-3f
// populace-native/src/constraints/limb.rs: weight of the preferred bend direction against the
// limb's own bend.
#define OWN_BEND 0.05f
// populace-native/src/constraints/chain.rs: passes along the chain and back. The count is fixed, so
// that the result moves smoothly with the target.
#define PASSES 16
// populace-native/src/constraints/feet.rs. RELEASE_SECS: time constant, in seconds, in which a
// released foot returns to its clip. SINKS_MOST: how far the pelvis may sink, in leg lengths.
#define RELEASE_SECS 0.06f
#define SINKS_MOST 0.5f
// populace-native/src/constraints/targets.rs: distance, in metres, at which a direction target is
// placed.
#define FAR_M 1000.0f
// populace-native/src/stages.rs: a result of a user's stage is dropped if a component is larger
// than this.
#define STAGE_BOUND 1e9f
