//! WHAT: the function under the integral.

use core::cell::Cell;

use thread_local::ThreadLocal;

use crate::lanes::{LANES, Lanes};
use crate::value::Value;

/// What to average: a function of a point of the domain.
///
/// Every `Fn(X) -> V` is one. Points come by value, so that closures
/// destructure: `|[x, y]: [f64; 2]| x * y`. Pure: called again with the same
/// point, on any thread, it gives the same value.
///
/// # Example
///
/// A type with parameters:
///
/// ```
/// use estimand::integrand::Integrand;
///
/// struct Monomial { power: i32 }
/// impl Integrand<f64> for Monomial {
///     type Value = f64;
///     fn evaluate(&self, x: f64) -> f64 { x.powi(self.power) }
/// }
/// assert_eq!(Monomial { power: 3 }.evaluate(2.0), 8.0);
/// assert_eq!((|x: f64| x + 2.0).evaluate(1.0), 3.0);
/// ```
pub trait Integrand<X> {
    /// What it returns.
    type Value: Value;

    /// f(x)
    fn evaluate(&self, x: X) -> Self::Value;

    /// f at points side by side, whose numbers are in the columns `x`: what
    /// [`ImportanceLanes`](crate::estimator::ImportanceLanes) asks for.
    ///
    /// Provided, one by one. One that does more of it at once says
    /// `#[inline(always)]`, and gives the same values.
    #[inline(always)]
    fn evaluate_lanes(&self, x: &[[f64; LANES]]) -> [Self::Value; LANES]
    where
        X: Lanes,
    {
        // Not `from_fn`, of which compilers make no vectors.
        let mut values = [self.evaluate(X::get(x, 0)); LANES];
        for (l, value) in values.iter_mut().enumerate().skip(1) {
            *value = self.evaluate(X::get(x, l));
        }
        values
    }
}

impl<X, V: Value, F: Fn(X) -> V> Integrand<X> for F {
    type Value = V;
    #[inline]
    fn evaluate(&self, x: X) -> V {
        self(x)
    }
}

/// A function of [`LANES`] points side by side, coordinate by coordinate, that
/// returns a value for each: in D dimensions `Fn([&[f64; LANES]; D]) -> [V; LANES]`.
///
/// Each value depends on the point in its own lane alone.
///
/// # Example
///
/// ```
/// use estimand::integrand::{Integrand, OnLanes};
/// use estimand::lanes::LANES;
///
/// let f = OnLanes(|[x, y]: [&[f64; LANES]; 2]| std::array::from_fn(|l| x[l] * y[l]));
/// let value: f64 = f.evaluate([2.0, 3.0]);
/// assert_eq!(value, 6.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnLanes<F>(pub F);

impl<X: Lanes, V: Value, F: for<'a> Fn(X::Lanes<'a>) -> [V; LANES]> Integrand<X> for OnLanes<F> {
    type Value = V;

    /// With the same point in all lanes.
    ///
    /// # Panics
    ///
    /// If the point has more than 64 numbers.
    fn evaluate(&self, x: X) -> V {
        let mut columns = [[0.0; LANES]; 64];
        for l in 0..LANES {
            x.put(&mut columns, l);
        }
        self.0(X::side_by_side(&columns))[0]
    }

    #[inline(always)]
    fn evaluate_lanes(&self, x: &[[f64; LANES]]) -> [V; LANES] {
        self.0(X::side_by_side(x))
    }
}

/// A function that needs working memory, made once on each thread that calls
/// it (and once more for a call that is made while another one on the same
/// thread is under way).
///
/// What the memory holds between calls must not change the result.
///
/// # Example
///
/// ```
/// use estimand::integrand::with_scratch;
///
/// let f = with_scratch(
///     || vec![0.0; 3],
///     |powers: &mut Vec<f64>, x: f64| {
///         for (k, p) in powers.iter_mut().enumerate() {
///             *p = x.powi(k as i32);
///         }
///         powers.iter().sum::<f64>()
///     },
/// );
/// assert_eq!(f(2.0), 7.0);
/// ```
pub fn with_scratch<S: Send, X, R>(
    make: impl Fn() -> S,
    f: impl Fn(&mut S, X) -> R,
) -> impl Fn(X) -> R {
    let idle = ThreadLocal::new();
    move |x| {
        // Taken out while in use: whoever waits inside f for other threads may
        // be given another call of f meanwhile.
        let mine: &Cell<Option<S>> = idle.get_or(|| Cell::new(None));
        let mut scratch = mine.take().unwrap_or_else(&make);
        let result = f(&mut scratch, x);
        mine.set(Some(scratch));
        result
    }
}

#[cfg(test)]
mod tests {
    use super::with_scratch;

    #[test]
    fn a_call_within_a_call_has_memory_of_its_own() {
        let add = with_scratch(
            || [0],
            |memory: &mut [u32; 1], n: u32| {
                memory[0] = n;
                memory[0]
            },
        );
        let nested = with_scratch(
            || [0],
            |memory: &mut [u32; 1], n: u32| {
                memory[0] = n;
                let inner = add(n + 1);
                memory[0] + inner
            },
        );
        assert_eq!(nested(3), 7);
    }
}
