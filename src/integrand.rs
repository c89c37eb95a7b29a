//! WHAT: the function under the integral.

use core::cell::Cell;

use thread_local::ThreadLocal;

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
}

impl<X, V: Value, F: Fn(X) -> V> Integrand<X> for F {
    type Value = V;
    #[inline]
    fn evaluate(&self, x: X) -> V {
        self(x)
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
