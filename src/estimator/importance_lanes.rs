//! f(x)/p(x) of several points side by side.

use super::{Estimator, Location, locate, weigh};
use crate::integrand::{Integrand, OnLanes};
use crate::lanes::{LANES, Lanes, Loop, widest};
use crate::pdf::Pdf;
use crate::sampler::{Coordinates, UnitPoint};
use crate::value::{Components, Value};

/// [`Importance`](super::Importance) of [`LANES`] points at a time: generator,
/// warp, integrand and weight work on all of them at once.
///
/// The estimates are those of `Importance` at the same points, to the last bit,
/// if the integrand's are; what is won is time, above all with the points of
/// [`IndependentLanes`](crate::sampler::IndependentLanes).
///
/// Where fewer than [`LANES`] points are left, the last of them stands in the
/// lanes that are over, and what the integrand says there is dropped.
///
/// # Example
///
/// ```
/// use estimand::estimator::ImportanceLanes;
/// use estimand::lanes::LANES;
/// use estimand::prelude::*;
/// use estimand::sampler::IndependentLanes;
///
/// // ∫₁⁴ (x + 2) dx
/// let f = |x: [f64; LANES]| x.map(|x| x + 2.0);
/// let estimator = ImportanceLanes::new(f, Interval::new(1.0, 4.0)?);
/// let mut integrator = MonteCarlo::new(estimator, IndependentLanes::new(7));
/// let found = run(&mut integrator, &Serial, &Stop::samples(100_000))?.answer;
/// assert!((found.mean - 13.5).abs() < 5.0 * found.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// [`lanes`](crate::lanes) says what compilers make vectors of. The coordinates
/// read, and the numbers that make a point, are 1 to 240; others do not compile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportanceLanes<F, P> {
    integrand: F,
    pdf: P,
}

/// How many columns there is room for: for few coordinates, and for many. A
/// small buffer is cheaper to clear.
const FEW: usize = 30;
const MANY: usize = 240;

impl<F, P: Pdf> ImportanceLanes<OnLanes<F>, P>
where
    P::Point: Lanes,
{
    /// `integrand`/`pdf`, for an integrand that takes points side by side: in D
    /// dimensions `Fn([[f64; LANES]; D]) -> [V; LANES]`.
    pub const fn new<V>(integrand: F, pdf: P) -> Self
    where
        F: Fn(<P::Point as Lanes>::Lanes) -> [V; LANES],
    {
        Self {
            integrand: OnLanes(integrand),
            pdf,
        }
    }
}

impl<F, P: Pdf> ImportanceLanes<F, P>
where
    P::Point: Lanes,
    F: Integrand<P::Point>,
{
    /// `integrand`/`pdf`, for any [`Integrand`], of which
    /// [`evaluate_lanes`](Integrand::evaluate_lanes) is called. One that takes
    /// points one by one will do: generator and warp are on lanes all the same.
    pub const fn of(integrand: F, pdf: P) -> Self {
        Self { integrand, pdf }
    }

    const NUMBERS: usize = {
        let (unit, point) = (P::Unit::COLUMNS, P::Point::COLUMNS);
        let most = if unit < point { point } else { unit };
        assert!(
            unit > 0 && most <= MANY,
            "points on lanes have 1 to 240 coordinates"
        );
        most
    };

    /// f(x)/p(x) at the points whose coordinates are in the columns, one group
    /// of [`LANES`] after the other, as far as there are `values`. Writes over
    /// the columns.
    ///
    /// Out of line, and the only place where the integrand is called, so that it
    /// is inlined here.
    #[inline(never)]
    fn weigh<const ROOM: usize>(
        &self,
        columns: &mut [[f64; LANES]],
        values: &mut [<F::Value as Value>::Wide],
    ) {
        widest(Weigh::<'_, F, P, ROOM> {
            estimator: self,
            columns,
            values,
        });
    }

    #[inline(always)]
    fn primaries(&self, columns: &mut [[f64; LANES]]) -> [<F::Value as Value>::Wide; LANES] {
        let densities = self.pdf.sample_lanes(columns);
        let values = self.integrand.evaluate_lanes(columns);
        let right = |&p: &f64| (p > 0.0) & (p <= f64::MAX);
        let mut primaries = [F::Value::wide(Components::ZERO); LANES];
        if densities.iter().fold(true, |all, p| all & right(p)) {
            for l in 0..LANES {
                primaries[l] = values[l].over(densities[l]);
            }
        } else {
            for l in 0..LANES {
                primaries[l] = weigh(values[l], densities[l]);
            }
        }
        primaries
    }

    /// With the same point in all lanes.
    fn one<const ROOM: usize>(&self, unit: P::Unit) -> <F::Value as Value>::Wide {
        let mut columns = [[0.0; LANES]; ROOM];
        for l in 0..LANES {
            unit.put(&mut columns, l);
        }
        let mut value = [F::Value::wide(Components::ZERO)];
        self.weigh::<ROOM>(&mut columns, &mut value);
        value[0]
    }

    #[inline(always)]
    fn all<const ROOM: usize>(
        &self,
        points: &mut impl Coordinates,
        values: &mut [<F::Value as Value>::Wide],
    ) {
        let dim = P::Unit::COLUMNS;
        let mut columns = [[0.0; LANES]; ROOM];
        let (first, values) = values.split_at_mut(points.until_lanes().min(values.len()));
        let whole = values.len() - values.len() % LANES;
        let (whole, rest) = values.split_at_mut(whole);
        self.some::<ROOM>(points, first);
        for values in whole.chunks_mut(ROOM / dim * LANES) {
            let columns = &mut columns[..values.len() / LANES * dim];
            points.fill_lanes(dim, columns);
            self.weigh::<ROOM>(columns, values);
        }
        self.some::<ROOM>(points, rest);
    }

    /// Fewer than [`LANES`].
    fn some<const ROOM: usize>(
        &self,
        points: &mut impl Coordinates,
        values: &mut [<F::Value as Value>::Wide],
    ) {
        if values.is_empty() {
            return;
        }
        let mut columns = [[0.0; LANES]; ROOM];
        for l in 0..values.len() {
            points.next_point();
            P::Unit::read(points).put(&mut columns, l);
        }
        let last = P::Unit::get(&columns, values.len() - 1);
        for l in values.len()..LANES {
            last.put(&mut columns, l);
        }
        self.weigh::<ROOM>(&mut columns, values);
    }
}

/// What [`ImportanceLanes::weigh`] does.
struct Weigh<'a, F: Integrand<P::Point>, P: Pdf, const ROOM: usize> {
    estimator: &'a ImportanceLanes<F, P>,
    columns: &'a mut [[f64; LANES]],
    values: &'a mut [<F::Value as Value>::Wide],
}

impl<F: Integrand<P::Point>, P: Pdf, const ROOM: usize> Loop for Weigh<'_, F, P, ROOM>
where
    P::Point: Lanes,
{
    #[inline(always)]
    fn run(self) {
        let mut wider = [[0.0; LANES]; ROOM];
        let groups = self.columns.chunks_exact_mut(P::Unit::COLUMNS);
        for (values, group) in self.values.chunks_mut(LANES).zip(groups) {
            let primaries = if P::Point::COLUMNS > P::Unit::COLUMNS {
                wider[..P::Unit::COLUMNS].copy_from_slice(group);
                self.estimator.primaries(&mut wider[..P::Point::COLUMNS])
            } else {
                self.estimator.primaries(group)
            };
            match <&mut [_; LANES]>::try_from(&mut *values) {
                Ok(values) => *values = primaries,
                Err(_) => values.copy_from_slice(&primaries[..values.len()]),
            }
        }
    }
}

impl<F: Integrand<P::Point>, P: Pdf> Estimator for ImportanceLanes<F, P>
where
    P::Point: Lanes,
{
    type Value = <F::Value as Value>::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        if Self::NUMBERS <= FEW {
            self.one::<FEW>(P::Unit::read(u))
        } else {
            self.one::<MANY>(P::Unit::read(u))
        }
    }

    #[inline]
    fn estimate_all<C: Coordinates>(&self, points: &mut C, values: &mut [Self::Value]) {
        if Self::NUMBERS <= FEW {
            self.all::<FEW>(points, values);
        } else {
            self.all::<MANY>(points, values);
        }
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.pdf, u)
    }
}
