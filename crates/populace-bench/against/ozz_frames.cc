// Times frames of a crowd in ozz-animation, for `populace bench --against`.
//
// Usage: ozz_frames THREADS. Standard input begins with a scene, as Scene::write_text in
// crates/populace-bench/src/text.rs describes it. Skeletons and clips are built from it by
// ozz-animation's own builder and optimizer with the default settings of its importers, then "ready"
// is printed. Each empty line that follows is answered by the milliseconds of one frame, 1/60 s after
// the last: every member samples its clips, blends them, goes down the hierarchy, and writes a
// palette of 3x4 matrices. A line with the index of a member is answered by its palette.
#include <algorithm>
#include <barrier>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "ozz/animation/offline/animation_builder.h"
#include "ozz/animation/offline/animation_optimizer.h"
#include "ozz/animation/offline/raw_animation.h"
#include "ozz/animation/offline/raw_skeleton.h"
#include "ozz/animation/offline/skeleton_builder.h"
#include "ozz/animation/runtime/animation.h"
#include "ozz/animation/runtime/blending_job.h"
#include "ozz/animation/runtime/local_to_model_job.h"
#include "ozz/animation/runtime/sampling_job.h"
#include "ozz/animation/runtime/skeleton.h"
#include "ozz/base/maths/simd_math.h"
#include "ozz/base/maths/soa_transform.h"
#include "ozz/base/maths/transform.h"

namespace anim = ozz::animation;
namespace offline = ozz::animation::offline;
using ozz::math::Float3;
using ozz::math::Float4x4;
using ozz::math::Quaternion;
using ozz::math::SoaTransform;
using ozz::math::Transform;

// Seconds between the full sets of keys from which a clip is sampled after a jump, the default of
// ozz-animation's importers.
const float kIframeSecs = 10;

[[noreturn]] static void fail(const std::string &why) {
    std::fprintf(stderr, "ozz_frames: %s\n", why.c_str());
    std::exit(1);
}

static float number() {
    float value;
    if (std::scanf("%f", &value) != 1) fail("the scene ends early");
    return value;
}

static int count() { return static_cast<int>(number()); }

static void read(Float3 &to) { to.x = number(), to.y = number(), to.z = number(); }

static void read(Quaternion &to) {
    to.x = number(), to.y = number(), to.z = number(), to.w = number();
}

template <class Keys> static void read_track(Keys &keys) {
    keys.resize(count());
    for (auto &key : keys) {
        key.time = number();
        read(key.value);
    }
}

// One matrix of a palette.
struct Entry {
    int joint;
    Float4x4 joint_from_bind;
};

struct Character {
    ozz::unique_ptr<anim::Skeleton> skeleton;
    std::vector<Entry> palette;
    std::vector<ozz::unique_ptr<anim::Animation>> clips;
    // The joint of ozz-animation for each joint of the scene: it sorts them depth first.
    std::vector<int> places;
};

// A joint's name is its index in the scene.
static offline::RawSkeleton::Joint joint_with_children(
    int index, const std::vector<int> &parents, const std::vector<Transform> &rest) {
    offline::RawSkeleton::Joint joint;
    joint.name = std::to_string(index).c_str();
    joint.transform = rest[index];
    for (size_t child = 0; child < parents.size(); child++)
        if (parents[child] == index)
            joint.children.push_back(joint_with_children(child, parents, rest));
    return joint;
}

static void read_skeleton(Character &character) {
    const int joints = count();
    std::vector<int> parents(joints);
    std::vector<Transform> rest(joints);
    for (int joint = 0; joint < joints; joint++) {
        parents[joint] = count();
        read(rest[joint].translation);
        read(rest[joint].rotation);
        read(rest[joint].scale);
    }
    offline::RawSkeleton raw;
    for (int joint = 0; joint < joints; joint++)
        if (parents[joint] < 0) raw.roots.push_back(joint_with_children(joint, parents, rest));
    character.skeleton = offline::SkeletonBuilder()(raw);
    if (!character.skeleton) fail("a skeleton could not be built");
    character.places.resize(joints);
    for (int place = 0; place < joints; place++)
        character.places[std::atoi(character.skeleton->joint_names()[place])] = place;
}

static void read_clip(Character &character) {
    offline::RawAnimation raw, small;
    raw.duration = number();
    if (raw.duration <= 0) raw.duration = 1;
    raw.tracks.resize(character.places.size());
    for (const int place : character.places) {
        offline::RawAnimation::JointTrack &track = raw.tracks[place];
        read_track(track.translations);
        read_track(track.rotations);
        read_track(track.scales);
    }
    if (!offline::AnimationOptimizer()(raw, *character.skeleton, &small))
        fail("a clip could not be optimized");
    offline::AnimationBuilder builder;
    builder.iframe_interval = kIframeSecs;
    character.clips.push_back(builder(small));
    if (!character.clips.back()) fail("a clip could not be built");
}

static Character read_character() {
    Character character;
    read_skeleton(character);
    character.palette.resize(count());
    for (Entry &entry : character.palette) {
        entry.joint = character.places.at(count());
        float rows[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
        for (int at = 0; at < 12; at++) rows[at] = number();
        Float4x4 transposed;
        for (int row = 0; row < 4; row++)
            transposed.cols[row] = ozz::math::simd_float4::LoadPtrU(rows + 4 * row);
        entry.joint_from_bind = Transpose(transposed);
    }
    for (int clips = count(); clips > 0; clips--) read_clip(character);
    return character;
}

// One playing clip of a member. Its context keeps decompressed keys from frame to frame.
struct Playing {
    anim::SamplingJob::Context keys;
    const anim::Animation *clip;
    float phase, weight;
};

struct Crowd {
    std::vector<Character> characters;
    size_t members, slots;
    std::vector<Playing> playing;
    std::vector<float> palettes;
    // The first float of each member's palette, and the number of all.
    std::vector<size_t> starts = {0};
    double secs = 0;

    Crowd() {
        for (int left = count(); left > 0; left--) characters.push_back(read_character());
        members = count(), slots = count();
        playing = std::vector<Playing>(members * slots);
        for (size_t member = 0; member < members; member++) {
            const Character &character = character_of(member);
            starts.push_back(starts.back() + character.palette.size() * 12);
            for (size_t slot = 0; slot < slots; slot++) {
                Playing &one = playing[member * slots + slot];
                one.clip = character.clips.at(count()).get();
                one.phase = number();
                one.weight = number();
                one.keys.Resize(character.skeleton->num_joints());
            }
        }
        palettes.resize(starts.back());
    }

    const Character &character_of(size_t member) const {
        return characters[member % characters.size()];
    }

    // Evaluates the members of one thread.
    void frame(size_t first, size_t end) {
        size_t joints = 0;
        for (const Character &one : characters) joints = std::max(joints, one.places.size());
        const size_t vectors = (joints + 3) / 4;
        std::vector<std::vector<SoaTransform>> poses(slots, std::vector<SoaTransform>(vectors));
        std::vector<SoaTransform> mixed(vectors);
        std::vector<Float4x4> models(joints);
        std::vector<anim::BlendingJob::Layer> layers(slots);
        for (size_t member = first; member < end; member++) {
            const Character &character = character_of(member);
            for (size_t slot = 0; slot < slots; slot++) {
                Playing &one = playing[member * slots + slot];
                anim::SamplingJob sampling;
                sampling.animation = one.clip;
                sampling.context = &one.keys;
                const double turns = one.phase + secs / one.clip->duration();
                sampling.ratio = static_cast<float>(turns - std::floor(turns));
                sampling.output = ozz::make_span(poses[slot]);
                if (!sampling.Run()) fail("sampling failed");
                layers[slot].transform = ozz::make_span(poses[slot]);
                layers[slot].weight = one.weight;
            }
            anim::BlendingJob blending;
            blending.layers = ozz::make_span(layers);
            blending.rest_pose = character.skeleton->joint_rest_poses();
            blending.output = ozz::make_span(mixed);
            if (slots > 1 && !blending.Run()) fail("blending failed");
            anim::LocalToModelJob models_job;
            models_job.skeleton = character.skeleton.get();
            models_job.input = ozz::make_span(slots > 1 ? mixed : poses[0]);
            models_job.output = ozz::make_span(models);
            if (!models_job.Run()) fail("the hierarchy failed");
            float *out = &palettes[starts[member]];
            for (const Entry &entry : character.palette) {
                const Float4x4 rows = Transpose(models[entry.joint] * entry.joint_from_bind);
                for (int row = 0; row < 3; row++, out += 4)
                    ozz::math::StorePtrU(rows.cols[row], out);
            }
        }
    }
};

int main(int arguments, char **argument) {
    const size_t threads = arguments == 2 ? std::strtoul(argument[1], nullptr, 10) : 0;
    if (threads == 0) fail("usage: THREADS");
    Crowd crowd;
    for (int left = 0; left != '\n' && left != EOF;) left = std::getchar();
    std::puts("ready");
    std::fflush(stdout);
    std::barrier<> gate(threads);
    bool ends = false;
    const auto share = [&](size_t nth) {
        crowd.frame(crowd.members * nth / threads, crowd.members * (nth + 1) / threads);
    };
    std::vector<std::thread> others;
    for (size_t nth = 1; nth < threads; nth++)
        others.emplace_back([&, nth] {
            for (gate.arrive_and_wait(); !ends; gate.arrive_and_wait()) {
                share(nth);
                gate.arrive_and_wait();
            }
        });
    char line[32];
    while (std::fgets(line, sizeof line, stdin)) {
        if (line[0] != '\n') {
            const size_t member = std::strtoul(line, nullptr, 10);
            for (size_t at = crowd.starts.at(member); at < crowd.starts.at(member + 1); at++)
                std::printf("%.9g ", crowd.palettes[at]);
            std::puts("");
        } else {
            const auto start = std::chrono::steady_clock::now();
            crowd.secs += 1.0 / 60;
            gate.arrive_and_wait();
            share(0);
            gate.arrive_and_wait();
            const auto took = std::chrono::steady_clock::now() - start;
            std::printf("%.6f\n", std::chrono::duration<double, std::milli>(took).count());
        }
        std::fflush(stdout);
    }
    ends = true;
    gate.arrive_and_wait();
    for (std::thread &other : others) other.join();
}
