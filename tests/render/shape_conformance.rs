//! The shapes are pdfs like those of `pdf_conformance.rs`, by the same suite:
//! over charts of their surfaces, and of the directions in which they are seen.

use std::f64::consts::TAU;

use crate::support::chart::{self, Chart};
use crate::support::pdf_laws::{Fault, PdfLaws, cells, over};
use estimand::pdf::{Pdf, Sample};
use estimand::render::{Quad, Shape, Sphere, SphereCone, SurfacePoint, Triangle};
use glam::{DVec3, dvec3};

/// The points of a surface, by a chart of their positions.
struct Surface<C> {
    chart: C,
    /// The error of positions on it.
    error: f64,
}

impl<C: Chart<2, Point = [f64; 3]>> Chart<2> for Surface<C> {
    type Point = SurfacePoint;
    fn point(&self, s: [f64; 2]) -> SurfacePoint {
        SurfacePoint {
            position: self.chart.point(s).into(),
            normal: DVec3::Y,
            error: self.error,
        }
    }
    fn locate(&self, x: &SurfacePoint) -> [f64; 2] {
        self.chart.locate(&x.position.to_array())
    }
    fn measure(&self, s: [f64; 2]) -> f64 {
        self.chart.measure(s)
    }
    fn exists(&self, s: [f64; 2]) -> bool {
        self.chart.exists(s)
    }
}

/// A parallelogram by (a, b): x = corner + a u + b v.
struct Parallelogram([DVec3; 3]);

impl Chart<2> for Parallelogram {
    type Point = [f64; 3];
    fn point(&self, [a, b]: [f64; 2]) -> [f64; 3] {
        let [corner, u, v] = self.0;
        (corner + a * u + b * v).to_array()
    }
    fn locate(&self, &x: &[f64; 3]) -> [f64; 2] {
        let [corner, u, v] = self.0;
        let n = u.cross(v);
        let d = DVec3::from(x) - corner;
        // Cramer's rule.
        [d.cross(v).dot(n), u.cross(d).dot(n)].map(|c| c / n.length_squared())
    }
    fn measure(&self, _: [f64; 2]) -> f64 {
        let [_, u, v] = self.0;
        u.cross(v).length()
    }
}

/// A sphere by the cosine with and the angle about an axis; dA = R² dω.
struct Ball {
    center: DVec3,
    radius: f64,
}

impl Chart<2> for Ball {
    type Point = [f64; 3];
    fn point(&self, s: [f64; 2]) -> [f64; 3] {
        let w = DVec3::from(chart::Sphere.point(s));
        (self.center + self.radius * w).to_array()
    }
    fn locate(&self, &x: &[f64; 3]) -> [f64; 2] {
        let w = (DVec3::from(x) - self.center) / self.radius;
        chart::Sphere.locate(&w.to_array())
    }
    fn measure(&self, _: [f64; 2]) -> f64 {
        self.radius * self.radius
    }
    fn exists(&self, s: [f64; 2]) -> bool {
        chart::Sphere.exists(s)
    }
}

fn surface<P, C>(name: &'static str, pdf: P, chart: C, error: f64) -> PdfLaws<P, Surface<C>, 2>
where
    P: Pdf<Point = SurfacePoint>,
    C: Chart<2, Point = [f64; 3]>,
{
    let unit = || cells(0.0, 1.0, 8);
    over(name, pdf, Surface { chart, error }, [unit(), unit()])
}

#[test]
fn quads() {
    let [corner, u, v] = [
        dvec3(1.0, 2.0, -3.0),
        dvec3(2.0, 0.5, 0.1),
        dvec3(-0.3, 1.5, 1.0),
    ];
    let quad = Shape::from(Quad::new(corner, u, v).unwrap());
    let error = quad.sample([0.5, 0.5]).point.error;
    surface("quad", quad, Parallelogram([corner, u, v]), error).hold();
}

#[test]
fn triangles() {
    let corners = [
        dvec3(1.0, 2.0, 3.0),
        dvec3(2.0, 2.5, 1.0),
        dvec3(0.0, 4.0, 3.5),
    ];
    let [a, b, c] = corners;
    let triangle = Shape::from(Triangle::new(a, b, c).unwrap());
    let error = triangle.sample([0.5, 0.5]).point.error;
    let chart = chart::Triangle(corners.map(|x| x.to_array()));
    surface("triangle", triangle, chart, error).hold();
}

#[test]
fn spheres() {
    let (center, radius) = (dvec3(0.0, 0.0, 0.0), 2.0);
    let sphere = Shape::from(Sphere::new(center, radius).unwrap());
    let chart = Surface {
        chart: Ball { center, radius },
        error: sphere.sample([0.5, 0.5]).point.error,
    };
    over(
        "sphere",
        sphere,
        chart,
        [cells(-1.0, 1.0, 8), cells(0.0, TAU, 12)],
    )
    .hold();
}

/// The near side of a unit sphere about the origin, by the direction in which
/// it is seen from −d ẑ: its cosine with ẑ and the angle about ẑ.
struct Seen {
    distance: f64,
}

impl Seen {
    fn new(distance: f64) -> (Self, SphereCone, [Vec<f64>; 2]) {
        let sphere = Sphere::new(DVec3::ZERO, 1.0).unwrap();
        let cone = sphere.cone_from(-distance * DVec3::Z).unwrap();
        let rim = (1.0 - 1.0 / (distance * distance)).sqrt();
        (
            Self { distance },
            cone,
            [cells(rim, 1.0, 8), cells(0.0, TAU, 12)],
        )
    }
}

impl Chart<2> for Seen {
    type Point = SurfacePoint;
    fn point(&self, s: [f64; 2]) -> SurfacePoint {
        let w = DVec3::from(chart::Sphere.point(s));
        let d = self.distance;
        // The near root t of |t ω − d ẑ| = 1, and t ω − d ẑ.
        let square = w.x * w.x + w.y * w.y;
        let root = (1.0 - d * d * square).max(0.0).sqrt();
        let t = d * w.z - root;
        let x = dvec3(t * w.x, t * w.y, -(d * square + root * w.z)).normalize();
        SurfacePoint {
            position: x,
            normal: x,
            error: 16.0 * f64::EPSILON,
        }
    }
    fn locate(&self, x: &SurfacePoint) -> [f64; 2] {
        let w = (x.position + self.distance * DVec3::Z).normalize();
        chart::Sphere.locate(&w.to_array())
    }
    fn exists(&self, [z, phi]: [f64; 2]) -> bool {
        chart::Sphere.exists([z, phi]) && self.distance.powi(2) * (1.0 - z * z) <= 1.0
    }
}

/// With respect to solid angle.
#[test]
fn spheres_seen_from_outside() {
    for distance in [1.01, 2.0, 30.0] {
        let (seen, cone, edges) = Seen::new(distance);
        over("cone", cone, seen, edges).hold();
    }
}

/// The negative control: points that are uniform by area on the near side, with
/// the density of directions.
#[test]
fn points_by_area_are_not_directions_by_solid_angle() {
    struct ByArea(SphereCone, f64);
    impl Pdf for ByArea {
        type Unit = [f64; 2];
        type Point = SurfacePoint;
        fn sample(&self, [a, b]: [f64; 2]) -> Sample<SurfacePoint> {
            // From the pole that is seen, 1 − cos uniform up to the rim.
            let cos = 1.0 - a * (1.0 - 1.0 / self.1);
            let w = DVec3::from(chart::Sphere.point([-cos, TAU * b]));
            let error = 16.0 * f64::EPSILON;
            let point = SurfacePoint {
                position: w,
                normal: w,
                error,
            };
            Sample {
                density: self.0.density(&point),
                point,
            }
        }
        fn density(&self, x: &SurfacePoint) -> f64 {
            self.0.density(x)
        }
    }
    let (seen, cone, edges) = Seen::new(2.0);
    let fault = over("by area", ByArea(cone, 2.0), seen, edges).check();
    assert!(matches!(fault, Err(Fault::Frequencies(_))), "{fault:?}");
}
