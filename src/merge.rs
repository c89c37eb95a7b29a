//! Combining the parts of a run, always along the same tree.

/// A summary of part of a run that a summary of what follows can be added to.
///
/// Associative up to rounding; [`Tree`] fixes the order, so that rounding is
/// the same every time.
pub trait Merge {
    /// Adds the summary of what comes right after.
    fn merge(&mut self, right: Self);
}

/// Merges parts that arrive in order along one fixed binary tree.
///
/// A range [a, b) of parts is split at a + m, m the largest power of two
/// below b − a, and the two halves are merged; a tree of 6 is ((01)(23))(45).
/// Whoever computed the parts, the result has the same bits, and no more than
/// log₂ n of them are held at a time.
///
/// # Example
///
/// ```
/// use estimand::merge::{Merge, Tree};
///
/// struct Text(String);
/// impl Merge for Text {
///     fn merge(&mut self, right: Text) { self.0 = format!("({}{})", self.0, right.0); }
/// }
///
/// let mut tree = Tree::new();
/// for part in ["0", "1", "2", "3", "4", "5"] {
///     tree.push(Text(part.into()));
/// }
/// assert_eq!(tree.finish().map(|t| t.0).as_deref(), Some("(((01)(23))(45))"));
/// ```
#[derive(Clone, Debug)]
pub struct Tree<P> {
    /// Complete subtrees, from the largest to the smallest, with their sizes.
    subtrees: Vec<(u64, P)>,
}

impl<P> Default for Tree<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P> Tree<P> {
    /// A tree without parts.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            subtrees: Vec::new(),
        }
    }
}

impl<P: Merge> Tree<P> {
    /// Adds the next part.
    pub fn push(&mut self, part: P) {
        let mut right = (1, part);
        while let Some((size, mut left)) = self.subtrees.pop_if(|(size, _)| *size == right.0) {
            left.merge(right.1);
            right = (2 * size, left);
        }
        self.subtrees.push(right);
    }

    /// All parts merged, or `None` if there were none.
    #[must_use]
    pub fn finish(mut self) -> Option<P> {
        let (_, mut right) = self.subtrees.pop()?;
        while let Some((_, mut left)) = self.subtrees.pop() {
            left.merge(right);
            right = left;
        }
        Some(right)
    }
}
