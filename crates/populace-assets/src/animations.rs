//! Conversion of animations to clips (glTF 2.0, section 3.11).

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use populace_clip::Clip;
use populace_model::{ClipSource, Interpolation, Property, Track};

use crate::accessor::{Component, Shape};
use crate::data::{Data, Format};
use crate::json::Cursor;
use crate::log::{Checked, Log};
use crate::nodes::Node;
use crate::rig::Rig;

/// A sampler: accessors of key times and values.
#[derive(Clone, Debug)]
struct Sampler {
    place: String,
    input: usize,
    output: usize,
    interpolation: Interpolation,
}

/// A channel that drives a property of a node.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    place: String,
    sampler: usize,
    pub(crate) node: usize,
    property: Property,
}

/// The declaration of an animation.
#[derive(Clone, Debug)]
pub(crate) struct Animation {
    name: String,
    place: String,
    samplers: Vec<Checked<Sampler>>,
    pub(crate) channels: Vec<Channel>,
}

/// Reads and checks the declarations of all animations.
pub(crate) fn read(root: &Cursor, nodes: &[Node], data: &Data) -> Vec<Animation> {
    let read = |at: &Cursor| read_animation(at, nodes, data);
    root.objects("animations").iter().map(read).collect()
}

fn read_animation(at: &Cursor, nodes: &[Node], data: &Data) -> Animation {
    let samplers: Vec<_> = at.objects("samplers").iter().map(|s| read_sampler(s, data)).collect();
    let mut channels: Vec<Channel> = Vec::new();
    let mut targets = BTreeMap::new();
    let items = at.objects("channels");
    if items.is_empty() {
        at.note("has no channels; it becomes a clip without tracks");
    }
    for item in items {
        let Ok(Some(channel)) = read_channel(&item, nodes, samplers.len()) else {
            continue;
        };
        if let Some(first) =
            targets.insert((channel.node, channel.property), item.place().to_owned())
        {
            item.problem(format!(
                "drives the same property of node {} as {first}; only one channel may",
                channel.node
            ));
            continue;
        }
        channels.push(channel);
    }
    Animation { name: at.name(), place: at.place().to_owned(), samplers, channels }
}

fn read_sampler(at: &Cursor, data: &Data) -> Checked<Sampler> {
    let accessor = |key| at.require(key).and_then(|i| i.index(data.accessor_count(), "accessor"));
    let (input, output) = (accessor("input"), accessor("output"));
    let interpolation = at.optional("interpolation", |i| match i.text()? {
        "LINEAR" => Ok(Interpolation::Linear),
        "STEP" => Ok(Interpolation::Step),
        "CUBICSPLINE" => Ok(Interpolation::CubicSpline),
        other => Err(i.problem(format!("is \"{other}\"; it must be LINEAR, STEP or CUBICSPLINE"))),
    });
    let (input, output, interpolation) =
        (input?, output?, interpolation?.unwrap_or(Interpolation::Linear));
    let times = data.accessor_with_format(
        input,
        "key times",
        &[Format::plain(Shape::SCALAR, Component::F32)],
    )?;
    let values = data.accessor(output)?;
    for accessor in [times, values] {
        if data.has_stride(accessor) {
            at.note(
                "reads a buffer view with a byteStride, which only vertex data may have; it is \
                 used anyway",
            );
        }
    }
    if !times.has_bounds {
        at.note("has key times without min and max, which glTF requires; they are not used here");
    }
    if interpolation == Interpolation::CubicSpline && times.count < 2 {
        return Err(
            at.problem(format!("has {} keys; a cubic spline needs at least 2", times.count))
        );
    }
    Ok(Sampler { place: at.place().to_owned(), input, output, interpolation })
}

/// Reads a channel. Returns `None` if its target is not supported and is ignored.
fn read_channel(at: &Cursor, nodes: &[Node], sampler_count: usize) -> Checked<Option<Channel>> {
    let sampler = at.require("sampler").and_then(|s| s.index(sampler_count, "sampler"));
    let target = at.require("target")?;
    let path = target.require("path").and_then(|p| p.text());
    let node = target.optional("node", |n| n.index(nodes.len(), "node"));
    let (sampler, path, node) = (sampler?, path?, node?);
    let property = match path {
        "translation" => Property::Translation,
        "rotation" => Property::Rotation,
        "scale" => Property::Scale,
        "weights" => {
            target.note("drives morph targets, which are ignored");
            return Ok(None);
        }
        "pointer" => {
            target.note("drives a pointer (KHR_animation_pointer), which is ignored");
            return Ok(None);
        }
        other => {
            target.note(format!("has the unknown path \"{other}\" and is ignored"));
            return Ok(None);
        }
    };
    let Some(node) = node else {
        target.note("has no node and is ignored");
        return Ok(None);
    };
    if nodes[node].has_matrix {
        return Err(target.problem(format!(
            "drives node {node}, which has a matrix; animated nodes must have translation, \
             rotation and scale instead"
        )));
    }
    Ok(Some(Channel { place: at.place().to_owned(), sampler, node, property }))
}

/// Bytes per joint and row while a clip is being built.
const POSE_BYTES: u64 = Clip::POSE_BYTES as u64;
/// Overhead of a clip's columns in memory and time, expressed in rows.
const COLUMN_ROWS: u64 = 4;
/// Rows by which a clip may exceed its limit while a gap between keys is being subdivided.
const BEGUN_ROWS: u64 = 16;

/// Converts animations to clips.
pub(crate) struct Clips<'a> {
    data: &'a Data<'a>,
    log: &'a Log,
    rig: &'a Rig,
}

impl<'a> Clips<'a> {
    pub(crate) fn new(data: &'a Data<'a>, log: &'a Log, rig: &'a Rig) -> Self {
        Self { data, log, rig }
    }

    /// Converts all animations. Continues after a failure to report the problems of the others.
    pub(crate) fn all(&self, animations: &[Animation]) -> Checked<Vec<Arc<Clip>>> {
        let clips: Vec<_> = animations.iter().map(|a| self.clip(a)).collect();
        clips.into_iter().collect()
    }

    fn clip(&self, animation: &Animation) -> Checked<Arc<Clip>> {
        let mut tracks = Vec::new();
        let mut failed = None;
        for channel in &animation.channels {
            match self.track(animation, channel) {
                Ok(track) => tracks.extend(track),
                Err(reported) => failed = Some(reported),
            }
        }
        if let Some(reported) = failed {
            return Err(reported);
        }
        let max_rows = self.max_rows(animation, &tracks)?;
        let source = ClipSource { name: animation.name.clone(), tracks };
        let clip = Clip::with_at_most(max_rows, source, &self.rig.skeleton)
            .map_err(|e| self.log.problem(&animation.place, e.to_string()))?;
        let stats = clip.stats();
        self.data.budget.spend_poses(self.poses(stats.row_count as u64 + COLUMN_ROWS));
        let columns = self.poses(COLUMN_ROWS) * POSE_BYTES;
        self.data.budget.take(&animation.place, "its rows", stats.row_bytes as u64 + columns)?;
        if stats.error_bound_m > stats.tolerance_m {
            let off = format!(
                "{} m, above the tolerance of {} m",
                stats.error_bound_m, stats.tolerance_m
            );
            let what =
                format!("has curves that need more rows than allowed; poses may be off by {off}");
            self.log.note(&animation.place, what);
        }
        Ok(Arc::new(clip))
    }

    /// Returns the number of joint poses in `rows` rows. Each row holds all joints of the skeleton.
    fn poses(&self, rows: u64) -> u64 {
        rows.saturating_mul(self.rig.skeleton.joint_count() as u64)
    }

    /// Returns the number of rows above which gaps between keys are no longer subdivided. Fails if
    /// the budget does not even allow the rows at the key times.
    fn max_rows(&self, animation: &Animation, tracks: &[Track]) -> Checked<usize> {
        let distinct_times = |steps_only: bool| {
            let counts = |t: &&Track| !steps_only || t.interpolation == Interpolation::Step;
            let tracks = tracks.iter().filter(counts);
            tracks.flat_map(|t| t.times.iter().map(|s| s.to_bits())).collect::<HashSet<u32>>().len()
        };
        let keys = distinct_times(false).max(1);
        // A step needs two rows at the same time.
        let least = (keys + distinct_times(true)) as u64 + COLUMN_ROWS;
        let (budget, joints) = (self.data.budget, self.rig.skeleton.joint_count() as u64);
        let what = format!("rows of {joints} joints at {keys} key times");
        let poses_left = budget.poses_left(&animation.place, &what, self.poses(least))?;
        let bytes = self.poses(least).saturating_mul(POSE_BYTES);
        budget.check(&animation.place, what, bytes)?;
        let rows = poses_left.min((budget.left() - bytes) / POSE_BYTES) / joints;
        Ok(usize::try_from(rows.saturating_sub(BEGUN_ROWS)).unwrap_or(usize::MAX))
    }

    fn track(&self, animation: &Animation, channel: &Channel) -> Checked<Option<Track>> {
        let sampler = animation.samplers[channel.sampler].as_ref().map_err(|reported| *reported)?;
        let Some(joint) = self.rig.joint_from_node[channel.node] else {
            return Ok(None);
        };
        let values = self.data.accessor_with_format(
            sampler.output,
            output_name(channel.property),
            &formats(channel.property),
        )?;
        let keys = self.data.accessor(sampler.input)?.count;
        let per_key = if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if keys.checked_mul(per_key) != Some(values.count) {
            return Err(self.log.problem(
                &channel.place,
                format!(
                    "has {keys} keys and {} values; it must have {per_key} per key",
                    values.count
                ),
            ));
        }
        let times = self.data.accessor(sampler.input)?;
        if keys == 0 || (times.base.is_none() && times.sparse.is_none()) {
            self.log.note(&channel.place, "has no key times and is ignored");
            return Ok(None);
        }
        let name = self.rig.skeleton.name(joint);
        self.data.budget.charge(&channel.place, name.len())?;
        let (times, values) = (self.times(sampler), self.values(sampler, channel.property));
        Ok(Some(Track {
            joint: name.to_owned(),
            property: channel.property,
            interpolation: sampler.interpolation,
            times: times?,
            values: values?,
        }))
    }

    fn times(&self, sampler: &Sampler) -> Checked<Vec<f32>> {
        let times = self.data.floats(sampler.input)?;
        if let Some(at) = times.windows(2).position(|w| w[0] >= w[1]) {
            let what = format!(
                "has key {} at {} s after key {at} at {} s; times must increase strictly (glTF \
                 2.0, section 3.11)",
                at + 1,
                times[at + 1],
                times[at]
            );
            return Err(self.log.problem(&sampler.place, what));
        }
        Ok(times)
    }

    fn values(&self, sampler: &Sampler, property: Property) -> Checked<Vec<f32>> {
        let values = self.data.floats(sampler.output)?;
        if property == Property::Rotation {
            let spline = sampler.interpolation == Interpolation::CubicSpline;
            let is_value = |at: usize| !spline || at % 3 == 1;
            let zero = values
                .chunks(4)
                .enumerate()
                .find(|(at, q)| is_value(*at) && q.iter().all(|v| v.abs() < 1e-6));
            if let Some((at, _)) = zero {
                let what = format!("has a rotation of length zero in element {at} of its values");
                return Err(self.log.problem(&sampler.place, what));
            }
        }
        Ok(values)
    }
}

const fn output_name(property: Property) -> &'static str {
    match property {
        Property::Translation => "values of translation",
        Property::Rotation => "values of rotation",
        Property::Scale => "values of scale",
    }
}

fn formats(property: Property) -> Vec<Format> {
    match property {
        Property::Translation | Property::Scale => vec![Format::plain(Shape::VEC3, Component::F32)],
        Property::Rotation => {
            let normalized = [Component::I8, Component::U8, Component::I16, Component::U16];
            let normalized = normalized.map(|c| Format::normalized(Shape::VEC4, c));
            std::iter::once(Format::plain(Shape::VEC4, Component::F32)).chain(normalized).collect()
        }
    }
}
