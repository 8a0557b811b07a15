//! Chains with parts of which there are several, one or none.

/// Adds parts to what is built in a chain.
pub(crate) trait Each: Sized {
    /// The result of `add` for each part in turn.
    fn each<P>(self, parts: impl IntoIterator<Item = P>, add: impl FnMut(Self, P) -> Self) -> Self {
        parts.into_iter().fold(self, add)
    }
}

impl<T> Each for T {}
