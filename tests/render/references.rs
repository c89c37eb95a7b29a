//! Images against those of another renderer, and techniques against each other.
//!
//! An image is compared by its mean and by the means of its blocks of 8 × 8
//! pixels, in each channel. Single pixels would need thousands of samples: where
//! a part of the light is rare, most pixels are a little too dark, and too sure
//! of it. The spread is that of 32 independent images, by Student's t, which
//! with so few is slow to reject: the safe side, means being skewed.
//!
//! What these comparisons can't see, furnaces do: a roulette that is a little
//! off.

use crate::support::mean::student_survival;
use crate::support::reference::{SIZE, read};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::{
    Camera, Choice, Direct, Film, Heuristic, Image, LightPoints, Lights, Radiance, Roulette, Scene,
    Surface, Technique, scenes,
};
use glam::DVec3;

/// How many images the spread is judged by.
const BATCHES: u64 = 32;

/// Pixels along the side of a block.
const BLOCK: u32 = 8;

/// As many independent images, with so many samples a pixel in all.
fn batches<E>(estimator: E, size: [u32; 2], samples: u64, points: Independent) -> Vec<Image>
where
    E: Estimator<Value = DVec3> + Copy,
{
    let pixels = u64::from(size[0] * size[1]);
    let stop = Stop::samples(pixels * samples / BATCHES);
    let batch = |batch| {
        let mut film = Film::new(estimator, points.randomize(batch), size).unwrap();
        run(&mut film, &Serial, &stop).unwrap().answer
    };
    (0..BATCHES).map(batch).collect()
}

/// The pixels of every block, and those of the whole image.
fn regions(image: &Image) -> Vec<Vec<usize>> {
    let across = image.width / BLOCK;
    let mut regions = vec![Vec::new(); (across * (image.height / BLOCK)) as usize];
    for row in 0..image.height {
        for column in 0..image.width {
            let block = row / BLOCK * across + column / BLOCK;
            regions[block as usize].push((row * image.width + column) as usize);
        }
    }
    regions.push((0..image.pixels.len()).collect());
    regions
}

/// A mean, its standard error, and with how many degrees of freedom that is
/// known.
#[derive(Clone, Copy)]
struct Mean {
    value: f64,
    error: f64,
    freedom: f64,
}

impl Mean {
    /// Over images, of one channel over some pixels.
    fn of(images: &[Image], region: &[usize], channel: usize) -> Self {
        let over = |image: &Image| {
            let sum: f64 = region.iter().map(|&p| image.pixels[p].mean[channel]).sum();
            sum / region.len() as f64
        };
        let n = images.len() as f64;
        let value = images.iter().map(over).sum::<f64>() / n;
        let squares: f64 = images.iter().map(|i| (over(i) - value).powi(2)).sum();
        Self {
            value,
            error: (squares / (n - 1.0) / n).sqrt(),
            freedom: n - 1.0,
        }
    }

    /// Of a reference, whose pixels know their own errors from 48 batches or
    /// more, over many pixels.
    fn of_reference(image: &Image, region: &[usize], channel: usize) -> Self {
        let n = region.len() as f64;
        let pixels = || region.iter().map(|&p| &image.pixels[p]);
        let squares: f64 = pixels().map(|p| p.standard_error[channel].powi(2)).sum();
        Self {
            value: pixels().map(|p| p.mean[channel]).sum::<f64>() / n,
            error: squares.sqrt() / n,
            freedom: 47.0 * n,
        }
    }

    /// The two-sided p-value of two means that should be one.
    ///
    /// Source: Welch, *The Generalization of "Student's" Problem when Several
    /// Different Population Variances Are Involved* (1947).
    fn p_value(self, other: Self) -> f64 {
        let [u, v] = [self, other].map(|m| m.error * m.error);
        let off = self.value - other.value;
        if off == 0.0 {
            return 1.0;
        }
        if u + v == 0.0 {
            return 0.0;
        }
        let freedom = (u + v).powi(2) / (u * u / self.freedom + v * v / other.freedom);
        student_survival(off / (u + v).sqrt(), freedom)
    }
}

/// The least of several p-values, as one that is uniform if they all are and
/// are independent; as it should be, larger if they are not.
fn least(p: impl Iterator<Item = f64>) -> f64 {
    // NaN is implausible.
    let worst = |(least, n), p: f64| (p.max(0.0).min(least), n + 1.0);
    let (least, tests) = p.fold((1.0, 0.0), worst);
    // 1 − (1 − p)ⁿ
    -(tests * (-least).ln_1p()).exp_m1()
}

/// The p-value of images against a reference: 36 blocks and the whole, three
/// channels of each.
fn against(images: &[Image], reference: &Image) -> f64 {
    let regions = regions(reference);
    least(regions.iter().flat_map(|region| {
        (0..3).map(move |channel| {
            let expected = Mean::of_reference(reference, region, channel);
            Mean::of(images, region, channel).p_value(expected)
        })
    }))
}

/// The images of a technique.
fn render(
    (scene, camera): &(Scene, Camera),
    technique: Technique,
    samples: u64,
    seed: u64,
) -> Vec<Image> {
    let seen = Radiance::new(scene, technique).unwrap().seen_by(*camera);
    batches(seen, SIZE, samples, Independent::new(seed))
}

const FULL: Technique = Technique::path_tracing();

const DIRECT: Technique = Technique {
    max_vertices: Some(2),
    ..FULL
};

fn looks_as_elsewhere(name: &str, view: &(Scene, Camera), samples: u64) {
    let (full, direct) = (format!("{name}.full"), format!("{name}.direct"));
    for (name, technique) in [(full, FULL), (direct, DIRECT)] {
        let reference = read(&name).unwrap();
        for seed in SEEDS {
            let images = render(view, technique, samples, seed);
            assert_plausible(against(&images, &reference), &format!("{name}, {seed}"));
        }
    }
}

#[test]
fn a_box_looks_as_it_does_elsewhere() {
    looks_as_elsewhere("cornell2", &scenes::cornell2().unwrap(), 512);
}

#[test]
fn a_small_light_looks_as_it_does_elsewhere() {
    looks_as_elsewhere("small_light", &scenes::small_light().unwrap(), 1024);
}

fn mirrored(image: &Image) -> Image {
    let rows = image.pixels.chunks(image.width as usize);
    let pixels = rows.flat_map(|row| row.iter().rev().copied()).collect();
    Image { pixels, ..*image }
}

#[test]
fn another_image_is_rejected() {
    const SAMPLES: u64 = 512;
    let view = scenes::cornell2().unwrap();
    let full = read("cornell2.full").unwrap();
    let direct = read("cornell2.direct").unwrap();
    let render = |view, technique| render(view, technique, SAMPLES, SEEDS[0]);

    let images = render(&view, DIRECT);
    assert_rejected(against(&images, &full), "direct light for all");
    let images: Vec<_> = images.iter().map(mirrored).collect();
    assert_rejected(against(&images, &direct), "a mirrored image");

    let one_more = Technique {
        max_vertices: Some(3),
        ..FULL
    };
    let images = render(&view, one_more);
    assert_rejected(against(&images, &direct), "a vertex too many");

    let (scene, camera) = &view;
    let radiance = Radiance::new(scene, FULL).unwrap();
    let off = FromFn(|mut u: &mut dyn Coordinates| {
        let [x, y] = u.next_2d();
        let ray = camera.ray(x + 0.5 / f64::from(SIZE[0]), y);
        radiance.along(ray).estimate(&mut u)
    });
    let images = batches(off, SIZE, SAMPLES, Independent::new(SEEDS[0]));
    assert_rejected(against(&images, &full), "half a pixel");

    let mut primitives = scene.primitives().to_vec();
    let albedo = DVec3::new(0.725, 0.71, 0.68);
    assert_eq!(
        primitives[0].surface,
        Surface::lambertian(albedo).unwrap(),
        "the floor"
    );
    primitives[0].surface = Surface::lambertian(0.95 * albedo).unwrap();
    let darker = (Scene::new(primitives).unwrap(), *camera);
    let p = against(&render(&darker, DIRECT), &direct);
    assert_rejected(p, "a floor 5 % too dark");
}

/// Light is found in a polished plate by sampling its surface, in a dull one
/// by sampling the light: each of the ways finds all of it in the end.
#[test]
fn all_ways_to_find_a_light_agree() {
    const SIZE: [u32; 2] = [16, 16];
    const SAMPLES: u64 = 2048;
    let (scene, camera) = scenes::veach().unwrap();
    let images = |technique, seed, way| {
        let seen = Radiance::new(&scene, technique).unwrap().seen_by(camera);
        let points = Independent::new(seed).randomize(way);
        batches(seen, SIZE, SAMPLES, points)
    };
    let one = Lights {
        choice: Choice::One,
        points: LightPoints::SolidAngle,
    };
    let all = Lights {
        choice: Choice::All { samples: 1 },
        points: LightPoints::Area,
    };
    // Without the pixels in which a light is seen: what light there is would
    // hide all else.
    let lights_alone = Technique {
        max_vertices: Some(1),
        ..FULL
    };
    let lit = images(lights_alone, SEEDS[0], 0);
    let is_dark = |p: &usize| lit.iter().all(|i| i.pixels[*p].mean == DVec3::ZERO);
    let dark: Vec<_> = (0..256).filter(is_dark).collect();
    assert!((200..256).contains(&dark.len()), "{}", dark.len());

    let way = |direct| Technique {
        direct,
        roulette: Roulette::Never,
        max_vertices: Some(3),
        ..FULL
    };
    let agree = |a: &[Image], b: &[Image]| {
        let means = |channel| [a, b].map(|images| Mean::of(images, &dark, channel));
        least((0..3).map(means).map(|[a, b]| a.p_value(b)))
    };
    for seed in SEEDS {
        let both = images(way(Direct::Both(one, Heuristic::Power)), seed, 1);
        let hit = images(way(Direct::Hit), seed, 2);
        let light = images(way(Direct::Light(one)), seed, 3);
        let balance = images(way(Direct::Both(all, Heuristic::Balance)), seed, 4);
        for (what, images) in [("hit", &hit), ("light", &light), ("balance", &balance)] {
            assert_plausible(agree(images, &both), &format!("{what}, seed {seed}"));
        }
        // Both without weights: what is found twice counts twice.
        let mut twice = hit;
        for (sum, light) in twice.iter_mut().zip(&light) {
            for (sum, light) in sum.pixels.iter_mut().zip(&light.pixels) {
                sum.mean += light.mean;
            }
        }
        assert_rejected(agree(&twice, &both), "both ways without weights");
    }
}
