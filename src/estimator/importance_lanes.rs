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
/// let f = |x: &[f64; LANES]| x.map(|x| x + 2.0);
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
    /// dimensions `Fn([&[f64; LANES]; D]) -> [V; LANES]`.
    pub const fn new<V>(integrand: F, pdf: P) -> Self
    where
        F: for<'a> Fn(<P::Point as Lanes>::Lanes<'a>) -> [V; LANES],
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
        if !densities.iter().fold(true, |all, p| all & right(p)) {
            return weigh_each(&values, &densities);
        }
        let mut primaries = [F::Value::wide(Components::ZERO); LANES];
        for l in 0..LANES {
            primaries[l] = values[l].over(densities[l]);
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

/// Where one of the densities is wrong: each by itself.
#[cold]
#[inline(never)]
fn weigh_each<V: Value>(values: &[V; LANES], densities: &[f64; LANES]) -> [V::Wide; LANES] {
    core::array::from_fn(|l| weigh(values[l], densities[l]))
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
        // The rest apart, so that whole groups are stored from registers; one call for
        // both, so that it is inlined.
        let (whole, rest) = self.values.as_chunks_mut();
        let mut last = [F::Value::wide(Components::ZERO); LANES];
        for (values, group) in whole.iter_mut().chain([&mut last]).zip(groups) {
            *values = if P::Point::COLUMNS > P::Unit::COLUMNS {
                wider[..P::Unit::COLUMNS].copy_from_slice(group);
                self.estimator.primaries(&mut wider[..P::Point::COLUMNS])
            } else {
                self.estimator.primaries(group)
            };
        }
        rest.copy_from_slice(&last[..rest.len()]);
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

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Some(P::Unit::DIM)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.pdf, u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Importance;
    use crate::lanes::exp;
    use crate::pdf::{Cuboid, Exponential, Interval, Sample, UniformSphere, UnitCube};
    use crate::sampler::{Block, Independent, IndependentLanes, Sampler, Sobol};

    const INF: f64 = f64::INFINITY;

    fn bits(values: &[f64]) -> Vec<u64> {
        values.iter().map(|x| x.to_bits()).collect()
    }

    /// Estimates on lanes are those of `Importance`, whatever the number and
    /// wherever they begin; the points go on after them.
    #[track_caller]
    fn agree<P: Pdf, S: Sampler>(
        pdf: P,
        sampler: &S,
        one: impl Fn(P::Point) -> f64,
        eight: impl for<'a> Fn(<P::Point as Lanes>::Lanes<'a>) -> [f64; LANES],
    ) where
        P::Point: Lanes,
    {
        let block = Block {
            index: 3,
            start: 0,
            len: 10_000,
        };
        let plain = Importance::new(&one, &pdf);
        let lanes = ImportanceLanes::new(eight, &pdf);
        let each = ImportanceLanes::of(&one, &pdf);
        for len in [0, 1, 7, 8, 9, 255, 256, 1000] {
            for skipped in [0, 1, 7, 8, 100] {
                let mut expected = vec![0.0; skipped + len];
                let mut points = sampler.stream(block);
                plain.estimate_all(&mut points, &mut expected);
                points.next_point();
                let next = points.next_1d();

                let mut values = vec![0.0; skipped + len];
                let mut points = sampler.stream(block);
                let (first, rest) = values.split_at_mut(skipped);
                for value in first {
                    points.next_point();
                    *value = lanes.estimate(&mut points);
                }
                lanes.estimate_all(&mut points, rest);
                assert_eq!(bits(&values), bits(&expected), "{skipped} {len}");
                points.next_point();
                assert_eq!(points.next_1d(), next);

                let mut points = sampler.stream(block);
                each.estimate_all(&mut points, &mut values);
                assert_eq!(bits(&values), bits(&expected), "{skipped} {len}");
            }
        }
    }

    #[track_caller]
    fn on_all_samplers<P: Pdf>(
        pdf: P,
        one: impl Fn(P::Point) -> f64,
        eight: impl for<'a> Fn(<P::Point as Lanes>::Lanes<'a>) -> [f64; LANES],
    ) where
        P::Point: Lanes,
    {
        agree(&pdf, &IndependentLanes::new(7), &one, &eight);
        agree(&pdf, &Independent::new(7), &one, &eight);
        agree(&pdf, &Sobol::new(3).unwrap(), &one, &eight);
    }

    #[test]
    fn lanes_say_what_single_points_say() {
        let each = |f: fn(f64) -> f64| move |x: &[f64; LANES]| x.map(f);
        for (a, b) in [(1.0, 4.0), (1.0, INF), (-INF, 4.0), (-INF, INF)] {
            let f = |x: f64| exp(-x * x);
            on_all_samplers(Interval::new(a, b).unwrap(), f, each(f));
        }
        for end in [2.0, INF] {
            on_all_samplers(
                Cuboid::new([0.0..1.0, -1.0..end, 0.0..3.0]).unwrap(),
                |[x, y, z]| x * y - exp(-z * z),
                |[x, y, z]: [&[f64; LANES]; 3]| {
                    core::array::from_fn(|l| x[l] * y[l] - exp(-z[l] * z[l]))
                },
            );
        }
        on_all_samplers(
            UnitCube::<40>,
            |x| x.iter().sum(),
            |x: [&[f64; LANES]; 40]| core::array::from_fn(|l| x.iter().map(|x| x[l]).sum()),
        );
        // No method of its own; points of more numbers than they take.
        on_all_samplers(
            (UniformSphere, Exponential::new(0.0, 2.0).unwrap()),
            |([x, _, z], t)| x * x + z * t,
            |([x, _, z], t): ([&[f64; LANES]; 3], &[f64; LANES])| {
                core::array::from_fn(|l| x[l] * x[l] + z[l] * t[l])
            },
        );
    }

    #[test]
    fn a_wrong_density_spoils_its_own_value_alone() {
        /// No density below one half.
        struct Upper;
        impl Pdf for Upper {
            type Unit = f64;
            type Point = f64;
            fn sample(&self, u: f64) -> Sample<f64> {
                let density = self.density(&u);
                Sample { point: u, density }
            }
            fn density(&self, x: &f64) -> f64 {
                f64::from(*x >= 0.5)
            }
        }
        let mut values = [0.0; 203];
        let block = Block {
            index: 0,
            start: 0,
            len: 203,
        };
        let mut points = Independent::new(1).stream(block);
        ImportanceLanes::of(|x: f64| x, Upper).estimate_all(&mut points, &mut values);
        let mut points = Independent::new(1).stream(block);
        for value in values {
            let u = points.next_1d();
            assert!(if u < 0.5 { value.is_nan() } else { value == u });
        }
    }

    /// Values of several components, and a message about a point.
    #[test]
    fn any_value_will_do() {
        let f = |x: &[f64; LANES]| x.map(|x| [x as f32, 2.0]);
        let estimator = ImportanceLanes::new(f, Interval::new(0.0, 4.0).unwrap());
        let block = Block {
            index: 0,
            start: 0,
            len: 9,
        };
        let sampler = IndependentLanes::new(1);
        let mut values = [[0.0; 2]; 9];
        estimator.estimate_all(&mut sampler.stream(block), &mut values);
        let mut points = sampler.stream(block);
        for value in values {
            points.next_point();
            let x = 4.0 * points.clone().next_1d();
            assert_eq!(value, [4.0 * f64::from(x as f32), 8.0]);
            let location = Estimator::locate(&estimator, &mut points);
            assert_eq!(location.point, Some(format!("{x:?}")));
        }
    }
}
