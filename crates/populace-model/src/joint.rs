//! Indices of joints.

/// Index of a joint in a [`Skeleton`](crate::Skeleton)'s level order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointIndex(pub u32);

impl JointIndex {
    /// The index as a `usize`.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}
