//! Lists of a fixed length. The arrays of serde drop the items past their length; these refuse them.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, SeqAccess, Visitor};

/// Reads a value whose lists have exactly their length: for `deserialize_with`.
pub(super) fn exact<'de, T: Exact, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    T::read(from)
}

/// A value that is, or contains, lists of a fixed length.
pub(super) trait Exact: Sized {
    /// Name of such values in messages, in the plural.
    const NAME: &'static str;

    fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error>;
}

/// Reads what is inside of a list or an option.
struct Inner<T>(T);

impl<'de, T: Exact> Deserialize<'de> for Inner<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        T::read(from).map(Self)
    }
}

impl Exact for f32 {
    const NAME: &'static str = "numbers";

    fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(from)
    }
}

impl Exact for u32 {
    const NAME: &'static str = "numbers";

    fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(from)
    }
}

impl<T: Exact> Exact for Option<T> {
    const NAME: &'static str = T::NAME;

    fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let inner = Option::<Inner<T>>::deserialize(from)?;
        Ok(inner.map(|Inner(value)| value))
    }
}

impl<T: Exact> Exact for Vec<T> {
    const NAME: &'static str = "lists";

    fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let all = Vec::<Inner<T>>::deserialize(from)?;
        Ok(all.into_iter().map(|Inner(value)| value).collect())
    }
}

impl<T: Exact, const N: usize> Exact for [T; N] {
    const NAME: &'static str = "points";

    fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_seq(Items(PhantomData))
    }
}

/// Reads the items of a list.
struct Items<T, const N: usize>(PhantomData<T>);

impl<'de, T: Exact, const N: usize> Visitor<'de> for Items<T, N> {
    type Value = [T; N];

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "a list of {N} {}", T::NAME)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<[T; N], A::Error> {
        let mut items = Vec::with_capacity(N);
        while items.len() < N
            && let Some(Inner(item)) = from.next_element()?
        {
            items.push(item);
        }
        let mut count = items.len();
        while from.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        match items.try_into() {
            Ok(items) if count == N => Ok(items),
            _ => Err(A::Error::invalid_length(count, &self)),
        }
    }
}
