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
/// A tree may begin at another part than the first ([`starting_at`](Self::starting_at)):
/// of several that follow each other, each made where its parts were computed,
/// [`append`](Self::append) makes the one that pushing every part would have made.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tree<P> {
    /// The number of the part after the last.
    end: u64,
    /// Complete subtrees, in the order of their parts, with their sizes.
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
        Self::starting_at(0)
    }

    /// A tree whose first part will be that of number `start`.
    #[must_use]
    pub const fn starting_at(start: u64) -> Self {
        Self {
            end: start,
            subtrees: Vec::new(),
        }
    }

    /// The number of the part that is to come.
    #[must_use]
    pub const fn end(&self) -> u64 {
        self.end
    }
}

impl<P: Merge> Tree<P> {
    /// Adds the next part.
    pub fn push(&mut self, part: P) {
        self.attach(1, part);
    }

    /// Adds the parts of `right`, the first of which is to come.
    ///
    /// # Example
    ///
    /// ```
    /// # use estimand::merge::{Merge, Tree};
    /// # struct Text(String);
    /// # impl Merge for Text {
    /// #     fn merge(&mut self, right: Text) { self.0 = format!("({}{})", self.0, right.0); }
    /// # }
    /// let (mut tree, mut rest) = (Tree::new(), Tree::starting_at(3));
    /// ["0", "1", "2"].map(|part| tree.push(Text(part.into())));
    /// ["3", "4", "5"].map(|part| rest.push(Text(part.into())));
    /// tree.append(rest);
    /// assert_eq!(tree.finish().map(|t| t.0).as_deref(), Some("(((01)(23))(45))"));
    /// ```
    pub fn append(&mut self, right: Self) {
        debug_assert_eq!(
            self.end,
            right.end - right.subtrees.iter().map(|s| s.0).sum::<u64>()
        );
        for (size, part) in right.subtrees {
            self.attach(size, part);
        }
    }

    /// Adds a complete subtree of so many parts. Two of one size are a larger one
    /// where that has its place in the tree: at a multiple of its own size.
    fn attach(&mut self, size: u64, part: P) {
        let mut right = (size, part);
        let mut middle = self.end;
        self.end += size;
        while let Some((size, mut left)) = self
            .subtrees
            .pop_if(|(size, _)| *size == right.0 && (middle - *size).is_multiple_of(2 * *size))
        {
            left.merge(right.1);
            middle -= size;
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

#[cfg(test)]
mod tests {
    use super::*;

    struct Text(String);

    impl Merge for Text {
        fn merge(&mut self, right: Self) {
            self.0 = format!("({}{})", self.0, right.0);
        }
    }

    fn tree(parts: core::ops::Range<u64>) -> Tree<Text> {
        let mut tree = Tree::starting_at(parts.start);
        parts.for_each(|part| tree.push(Text(format!("[{part}]"))));
        tree
    }

    /// Wherever the parts are cut into three, two of which are joined first.
    #[test]
    fn cut_and_joined_it_is_the_same_tree() {
        for n in 0..20 {
            let whole = tree(0..n).finish().map(|t| t.0);
            for (i, j) in (0..=n).flat_map(|i| (i..=n).map(move |j| (i, j))) {
                let (mut all, mut rest) = (tree(0..i), tree(i..j));
                rest.append(tree(j..n));
                all.append(rest);
                assert_eq!(all.end(), n);
                assert_eq!(all.finish().map(|t| t.0), whole, "{i} {j} {n}");
            }
        }
    }

    /// The control: of trees that do not know where they begin, it is another.
    #[test]
    fn a_tree_has_to_know_where_it_begins() {
        let (mut all, mut rest) = (tree(0..3), Tree::new());
        (3..6).for_each(|part| rest.push(Text(format!("[{part}]"))));
        all.append(rest);
        let whole = tree(0..6).finish().map(|t| t.0);
        assert_ne!(all.finish().map(|t| t.0), whole);
    }
}
