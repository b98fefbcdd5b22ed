//! Local avoidance: what walkers do in scenes, and what it promises for any input.

#![expect(clippy::cast_possible_truncation, reason = "numbers of scenes are small")]

mod bystanders;
mod flows;
mod groups;
mod inputs;
mod scenes;
mod sliding;
mod walk;
