//! The laws of any [`Sampler`], checked to the bit.

use estimand::sampler::{Block, Coordinates, Sampler};

/// The first `dimension` coordinates of the points of a block.
pub fn points<S: Sampler>(sampler: &S, block: Block, dimension: usize) -> Vec<Vec<f64>> {
    let mut stream = sampler.stream(block);
    let point = |_| {
        stream.next_point();
        (0..dimension).map(|_| stream.next_1d()).collect()
    };
    (0..block.len).map(point).collect()
}

/// Consecutive blocks of these lengths.
pub fn blocks(lengths: &[u64]) -> Vec<Block> {
    let mut start = 0;
    let mut block = |(index, &len): (usize, &u64)| {
        start += len;
        Block {
            index: index as u64,
            start: start - len,
            len,
        }
    };
    lengths.iter().enumerate().map(&mut block).collect()
}

/// The same numbers, to the bit.
fn same(a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    let bits = |points: &[Vec<f64>]| -> Vec<u64> {
        points.iter().flatten().map(|x| x.to_bits()).collect()
    };
    bits(a) == bits(b)
}

/// The law that a sampler breaks, for up to `dimension` coordinates.
pub fn check_laws<S: Sampler>(sampler: &S, dimension: usize) -> Result<(), String> {
    let layout = blocks(&[37, 1, 64, 5, 37, 20]);
    let forward: Vec<_> = layout
        .iter()
        .map(|&b| points(sampler, b, dimension))
        .collect();

    for (block, first) in layout.iter().zip(&forward).rev() {
        if !same(&points(sampler, *block, dimension), first) {
            return Err(format!("{block:?} has other points when it is replayed"));
        }
        // How many points are asked for does not change those that come first.
        for len in [1, block.len / 2, 2 * block.len] {
            let other = points(sampler, Block { len, ..*block }, dimension);
            let common = other.len().min(first.len());
            if !same(&other[..common], &first[..common]) {
                return Err(format!("{block:?} begins otherwise when it is {len} long"));
            }
        }
    }
    // Two blocks read by turns do not disturb each other.
    let (mut a, mut b) = (sampler.stream(layout[0]), sampler.stream(layout[2]));
    for (in_a, in_b) in forward[0].iter().zip(&forward[2]) {
        a.next_point();
        b.next_point();
        for (x, y) in in_a.iter().zip(in_b) {
            if [a.next_1d(), b.next_1d()].map(f64::to_bits) != [*x, *y].map(f64::to_bits) {
                return Err("blocks that are read by turns disturb each other".into());
            }
        }
    }
    // `next_2d` is `next_1d` twice.
    let mut stream = sampler.stream(layout[0]);
    for point in &forward[0] {
        stream.next_point();
        for pair in point.chunks(2) {
            let read = match pair {
                [_, _] => stream.next_2d().to_vec(),
                _ => vec![stream.next_1d()],
            };
            if !same(&[read], &[pair.to_vec()]) {
                return Err("next_2d is not next_1d twice".into());
            }
        }
    }
    match forward
        .iter()
        .flatten()
        .flatten()
        .find(|x| !(0.0..1.0).contains(*x))
    {
        Some(x) => Err(format!("{x} is no coordinate")),
        None => Ok(()),
    }
}

#[track_caller]
pub fn assert_laws<S: Sampler>(name: &str, sampler: &S, dimension: usize) {
    if let Err(broken) = check_laws(sampler, dimension) {
        panic!("{name}: {broken}");
    }
}
