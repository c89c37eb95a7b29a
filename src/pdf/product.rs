//! tmp
use super::{Pdf, Sample};
impl<P: Pdf, const D: usize> Pdf for [P; D] {
    type Unit = [P::Unit; D];
    type Point = [P::Point; D];
    #[inline]
    fn sample(&self, u: Self::Unit) -> Sample<Self::Point> {
        let mut density = 1.0;
        let point = core::array::from_fn(|k| {
            let x = self[k].sample(u[k]);
            density *= x.density;
            x.point
        });
        Sample { point, density }
    }
    fn density(&self, x: &Self::Point) -> f64 {
        self.iter().zip(x).map(|(p, x)| p.density(x)).product()
    }
}
