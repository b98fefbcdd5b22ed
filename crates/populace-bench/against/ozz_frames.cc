// Times frames of a crowd in ozz-animation, for `populace bench --against`.
//
// Usage: ozz_frames MEMBERS SLOTS THREADS. It prints "joints N", then for each line on standard
// input the milliseconds of one frame: every member samples SLOTS clips at 60 frames a second,
// blends them, goes down the hierarchy, and writes a palette of 3x4 matrices. OZZ_MEDIA is the
// folder of the skeleton and the clips, which build.sh sets.
#include <barrier>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "ozz/animation/runtime/animation.h"
#include "ozz/animation/runtime/blending_job.h"
#include "ozz/animation/runtime/local_to_model_job.h"
#include "ozz/animation/runtime/sampling_job.h"
#include "ozz/animation/runtime/skeleton.h"
#include "ozz/base/io/archive.h"
#include "ozz/base/io/stream.h"
#include "ozz/base/maths/simd_math.h"
#include "ozz/base/maths/soa_transform.h"

namespace anim = ozz::animation;
using ozz::math::Float4x4;
using ozz::math::SoaTransform;

[[noreturn]] static void fail(const std::string &why) {
    std::fprintf(stderr, "ozz_frames: %s\n", why.c_str());
    std::exit(1);
}

template <class Asset> static void load(const char *name, Asset &asset) {
    const std::string path = std::string(OZZ_MEDIA) + "/" + name;
    ozz::io::File file(path.c_str(), "rb");
    if (!file.opened()) fail("cannot open " + path);
    ozz::io::IArchive archive(&file);
    if (!archive.TestTag<Asset>()) fail(path + " holds something else");
    archive >> asset;
}

// One playing clip of a member. Its context keeps decompressed keys from frame to frame.
struct Playing {
    anim::SamplingJob::Context keys;
    float ratio, speed, weight;
};

struct Crowd {
    anim::Skeleton skeleton;
    anim::Animation clips[2];
    size_t members, slots;
    std::vector<Playing> playing;
    std::vector<Float4x4> joint_from_bind;
    std::vector<float> palettes;

    Crowd(size_t members, size_t slots) : members(members), slots(slots), playing(members * slots) {
        load("pab_skeleton.ozz", skeleton);
        load("pab_walk.ozz", clips[0]);
        load("pab_jog.ozz", clips[1]);
        std::mt19937 random(1);
        std::uniform_real_distribution<float> part(0, 1);
        for (Playing &one : playing) {
            one.keys.Resize(skeleton.num_joints());
            one.ratio = part(random);
            one.speed = 0.8f + 0.4f * part(random);
            one.weight = 0.2f + 0.8f * part(random);
        }
        joint_from_bind.assign(skeleton.num_joints(), Float4x4::identity());
        palettes.resize(members * skeleton.num_joints() * 12);
    }

    // Evaluates the members of one thread.
    void frame(size_t first, size_t end) {
        const size_t vectors = skeleton.num_soa_joints();
        std::vector<std::vector<SoaTransform>> poses(slots, std::vector<SoaTransform>(vectors));
        std::vector<SoaTransform> mixed(vectors);
        std::vector<Float4x4> models(skeleton.num_joints());
        std::vector<anim::BlendingJob::Layer> layers(slots);
        for (size_t member = first; member < end; member++) {
            for (size_t slot = 0; slot < slots; slot++) {
                Playing &one = playing[member * slots + slot];
                const anim::Animation &clip = clips[slot % 2];
                one.ratio += one.speed / 60 / clip.duration();
                one.ratio -= one.ratio >= 1 ? 1 : 0;
                anim::SamplingJob sampling;
                sampling.animation = &clip;
                sampling.context = &one.keys;
                sampling.ratio = one.ratio;
                sampling.output = ozz::make_span(poses[slot]);
                if (!sampling.Run()) fail("sampling failed");
                layers[slot].transform = ozz::make_span(poses[slot]);
                layers[slot].weight = one.weight;
            }
            anim::BlendingJob blending;
            blending.layers = ozz::make_span(layers);
            blending.rest_pose = skeleton.joint_rest_poses();
            blending.output = ozz::make_span(mixed);
            if (slots > 1 && !blending.Run()) fail("blending failed");
            anim::LocalToModelJob models_job;
            models_job.skeleton = &skeleton;
            models_job.input = ozz::make_span(slots > 1 ? mixed : poses[0]);
            models_job.output = ozz::make_span(models);
            if (!models_job.Run()) fail("the hierarchy failed");
            float *out = &palettes[member * models.size() * 12];
            for (size_t joint = 0; joint < models.size(); joint++, out += 12) {
                const Float4x4 rows = Transpose(models[joint] * joint_from_bind[joint]);
                for (int row = 0; row < 3; row++)
                    ozz::math::StorePtrU(rows.cols[row], out + 4 * row);
            }
        }
    }
};

int main(int count, char **arguments) {
    const auto number = [&](int nth) { return std::strtoul(arguments[nth], nullptr, 10); };
    if (count != 4 || !number(1) || !number(2) || !number(3)) fail("usage: MEMBERS SLOTS THREADS");
    const size_t members = number(1), threads = number(3);
    Crowd crowd(members, number(2));
    std::printf("joints %d\n", crowd.skeleton.num_joints());
    std::fflush(stdout);
    std::barrier<> gate(threads);
    bool ends = false;
    const auto share = [&](size_t nth) {
        crowd.frame(members * nth / threads, members * (nth + 1) / threads);
    };
    std::vector<std::thread> others;
    for (size_t nth = 1; nth < threads; nth++)
        others.emplace_back([&, nth] {
            for (gate.arrive_and_wait(); !ends; gate.arrive_and_wait()) {
                share(nth);
                gate.arrive_and_wait();
            }
        });
    for (int next = std::getchar(); next != EOF; next = std::getchar()) {
        if (next != '\n') continue;
        const auto start = std::chrono::steady_clock::now();
        gate.arrive_and_wait();
        share(0);
        gate.arrive_and_wait();
        const auto took = std::chrono::steady_clock::now() - start;
        std::printf("%.6f\n", std::chrono::duration<double, std::milli>(took).count());
        std::fflush(stdout);
    }
    ends = true;
    gate.arrive_and_wait();
    for (std::thread &other : others) other.join();
}
