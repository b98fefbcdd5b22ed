//! Benchmarks of crowds: scenes, frame times, memory, and a check of each result.
//!
//! [`measure`] times [`Subject`]s: a [`Scene`] evaluated by one [`Method`] on one [`DeviceSetup`].
//! Each result is compared with the oracle of `populace-testkit`. A [`Document`] holds all
//! measurements and formats them. A [`SkateDocument`] holds the foot skate of characters.
//!
//! ```
//! use populace::{Device, Schedule, Split};
//! use populace_bench::{DeviceSetup, Load, Method, Scene, SceneSettings, Subject, measure};
//!
//! let settings = SceneSettings { joints: Some(20), slots: 2, seed: 0 };
//! let scenes = [Scene::new(settings, Load::Plain)?.with_members(10)];
//! let setups = [DeviceSetup { devices: Device::native().into(), split: Split::Measured }];
//! let subjects = Subject::all(&scenes, &setups, &[Method::Crowd(Schedule::Fused)]);
//! let runs = measure(subjects, 2, &mut ())?;
//! assert!(runs.iter().all(|run| run.fault().is_none() && run.ms_median > 0.0));
//! # Ok::<(), populace::Error>(())
//! ```

mod baked;
mod changes;
mod chart;
mod check;
mod constraints;
mod document;
mod errors;
mod machine;
mod measurements;
mod memory;
mod observer;
mod rigs;
mod scene;
mod skate;
mod spec;
mod table;
mod text;
mod timing;

pub use baked::TableSizes;
pub use document::Document;
pub use machine::machine;
pub use observer::Observer;
pub use scene::{DeviceSetup, Load, Scene, SceneSettings};
pub use skate::SkateDocument;
pub use spec::{Measurement, Method, Subject};
pub use timing::measure;
