//! The degree of a rule on a box.

/// Up to which degree polynomials are integrated exactly in each box of two or
/// more dimensions.
///
/// | n | 2 | 3 | 4 | 5 | 6 | 8 | 10 | 15 |
/// |---|---|---|---|---|---|---|---|---|
/// | evaluations in a box, degree 7 | 21 | 39 | 65 | 103 | 161 | 417 | 1265 | 33279 |
/// | degree 9 | 37 | 83 | 161 | 283 | 465 | 1121 | 2625 | 35999 |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Degree {
    /// Genz and Malik's rule of 1980. More boxes for the same budget: better for
    /// jumps, kinks and narrow peaks, and where the budget pays for few boxes.
    Seven,
    /// Genz and Malik's rule of 1983. Better where the integrand is smooth.
    #[default]
    Nine,
}
