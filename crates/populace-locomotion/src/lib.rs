//! Walkers: local avoidance.

pub mod avoidance;
