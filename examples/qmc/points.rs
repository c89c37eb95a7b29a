//! The points themselves, by pairs of coordinates.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use estimand::prelude::*;
use estimand::sampler::{Block, Owen};

use crate::Outcome;

/// 256 points in two dimensions, and what they are.
pub struct Set {
    name: String,
    detail: String,
    points: Vec<[f64; 2]>,
}

const POINTS: u64 = 256;
/// Boxes on a side: as many boxes as points.
const BOXES: usize = 16;
/// Dimensions among which bad pairs are looked for.
const DIMENSIONS: usize = 32;

/// Axes `j` and `k` of the points of a sampler.
fn set(name: &str, detail: &str, sampler: &impl Sampler, [j, k]: [usize; 2]) -> Set {
    let mut stream = sampler.stream(Block {
        index: 0,
        start: 0,
        len: POINTS,
    });
    let point = |_| {
        stream.next_point();
        let x: Vec<f64> = (0..=j.max(k)).map(|_| stream.next_1d()).collect();
        [x[j], x[k]]
    };
    Set {
        name: name.into(),
        detail: detail.into(),
        points: (0..POINTS).map(point).collect(),
    }
}

impl Set {
    /// How many of 16 × 16 boxes hold none of the points.
    fn empty(&self) -> usize {
        let mut seen = [[false; BOXES]; BOXES];
        for x in &self.points {
            let [column, row] = x.map(|x| (x * BOXES as f64) as usize);
            seen[row][column] = true;
        }
        seen.iter().flatten().filter(|s| !**s).count()
    }
}

/// Every kind of points, then bad pairs of dimensions.
pub fn table() -> Outcome<Vec<Set>> {
    let first = [0, 1];
    let net = Sobol::new(DIMENSIONS)?;
    let scrambled = net.scrambled(Owen, 7);
    let halton = Halton::unscrambled(DIMENSIONS)?;
    let permuted = Halton::new(DIMENSIONS, 7)?;
    let grid = Stratified::new([16, 16], 1, 7)?;
    let hypercube = LatinHypercube::new(POINTS, 2, 7)?;
    let pairs = (0..DIMENSIONS).flat_map(|k| (0..k).map(move |j| [j, k]));
    let worst = pairs.max_by_key(|pair| set("", "", &net, *pair).empty());
    let worst = worst.ok_or("no pair")?;
    let of = worst.map(|k| k + 1);
    let dimensions = format!("dims {}, {}", of[0], of[1]);
    let late = "dims 29, 30: bases 109, 113";
    let sets = vec![
        set("Independent", "", &Independent::new(7), first),
        set("Stratified", "one in each box", &grid, first),
        set(
            "Latin hypercube",
            "one in each row, column",
            &hypercube,
            first,
        ),
        set("Lattice", "shifted", &Lattice::new(2, 7)?, first),
        set("Halton", "dims 1, 2: bases 2, 3", &halton, first),
        set(
            "Halton, permuted",
            "dims 1, 2: bases 2, 3",
            &permuted,
            first,
        ),
        set("Sobol'", "dims 1, 2", &net, first),
        set("Sobol', Owen", "dims 1, 2", &scrambled, first),
        set("Halton", late, &halton, [28, 29]),
        set("Halton, permuted", late, &permuted, [28, 29]),
        set("Sobol'", &dimensions, &net, worst),
        set("Sobol', Owen", &dimensions, &scrambled, worst),
    ];

    println!("256 points on the square: how many of 16 × 16 boxes are empty\n");
    for set in &sets {
        println!("{:<20}{:<32}{:>5}", set.name, set.detail, set.empty());
    }
    let empty: Vec<_> = sets.iter().map(Set::empty).collect();
    // 256 (1 − 1/256)²⁵⁶ ± 5.
    assert!((70..=118).contains(&empty[0]));
    // Strata, and nets in base 2, however scrambled.
    assert_eq!([empty[1], empty[6], empty[7]], [0; 3]);
    // Points on a few lines, which permuted digits turn and spread.
    assert!(empty[8] > 140 && empty[9] < empty[8]);
    // Scrambling moves what is empty, and does not fill it.
    assert!(empty[10] > 94 && empty[11] == empty[10]);
    Ok(sets)
}

/// Sides of a picture and of what it takes with its caption; how far edges are
/// off.
const PICTURE: usize = 210;
const CELL: [usize; 2] = [PICTURE + 20, PICTURE + 62];
const EDGE: usize = 20;
const COLUMNS: usize = 4;

/// Writes the sheet. Dots are lines of no length with round ends.
pub fn draw(path: &Path, sets: &[Set]) -> Outcome<()> {
    let (width, height) = (
        EDGE + COLUMNS * CELL[0],
        EDGE + sets.len().div_ceil(COLUMNS) * CELL[1],
    );
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    for (i, set) in sets.iter().enumerate() {
        let left = EDGE + i % COLUMNS * CELL[0];
        let top = EDGE + i / COLUMNS * CELL[1];
        let empty = set.empty();
        writeln!(
            svg,
            "<g transform=\"translate({left} {top})\">\n\
             <text y=\"12\" font-size=\"15\" fill=\"#282828\">{}</text>\n\
             <text y=\"29\" font-size=\"12\" fill=\"#5a5a5a\">{}</text>\n\
             <text x=\"{PICTURE}\" y=\"12\" font-size=\"12\" fill=\"#5a5a5a\" \
             text-anchor=\"end\">{empty} empty</text>\n\
             <g transform=\"translate(0 37)\">",
            set.name, set.detail
        )?;
        let step = PICTURE as f64 / BOXES as f64;
        let mut rules = String::new();
        for k in 1..BOXES {
            let at = k as f64 * step;
            write!(rules, "M{at:.1} 0v{PICTURE}M0 {at:.1}h{PICTURE}")?;
        }
        let mut dots = String::new();
        for [x, y] in &set.points {
            let [x, y] = [*x, 1.0 - y].map(|x| x * PICTURE as f64);
            write!(dots, "M{x:.1} {y:.1}h0")?;
        }
        writeln!(
            svg,
            "<path d=\"{rules}\" stroke=\"#ececec\"/>\n\
             <rect width=\"{PICTURE}\" height=\"{PICTURE}\" fill=\"none\" stroke=\"#828282\"/>\n\
             <path d=\"{dots}\" stroke=\"#0072b2\" stroke-width=\"4\" stroke-linecap=\"round\"/>\n\
             </g></g>"
        )?;
    }
    svg.push_str("</svg>\n");
    fs::write(path, svg)?;
    Ok(())
}
