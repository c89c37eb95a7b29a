"""The generating vector of src/sampler/lattice_vector.rs, one component a line.

Fast construction, component by component (Nuyens & Cools 2006), of rules embedded in
each other (Cools, Kuo & Nuyens 2006). Takes minutes for 1,024 components.

    python3 lattice_vector.py 1024
"""

import sys

import numpy as np
from scipy.fft import irfft, rfft

LEAST, MOST = 8, 20  # log2 of the sizes that count


def kernel(x):
    return 2 * np.pi**2 * (x * x - x + 1 / 6)


def weight(j):
    return 0.15 * min(1, 16 / j) ** 2


def powers_of_five(m):
    """5^i mod 2^m for i < 2^(m - 2): with their negatives, all odd numbers."""
    powers = np.ones(1 << (m - 2), dtype=np.int64)
    n = 1
    while n < len(powers):
        powers[n : 2 * n] = powers[:n] * pow(5, n, 1 << m) % (1 << m)
        n *= 2
    return powers


levels = range(3, MOST + 1)
# The points k/N with N = 2^m, by the odd part of k: those of 5^i/2^m, whose negatives
# count as much, and 0, 1/2 and 1/4. The kernel there, and the product over components.
kernels = {m: kernel(powers_of_five(m) / 2**m) for m in levels}
spectra = {m: rfft(kernels[m]) for m in levels}
products = {m: np.ones(1 << (m - 2)) for m in levels}
few = kernel(np.array([0.0, 0.5, 0.25]))
count = np.array([1, 1, 2])
few_products = np.ones(3)
candidates = powers_of_five(MOST)

for j in range(1, int(sys.argv[1]) + 1):
    gamma = weight(j)
    # N e^2 + N of the rule so far, and what z = 5^i adds to it, for all i at once.
    so_far = count @ few_products
    added = np.array([count @ (few_products * few)])
    worst = np.zeros(1)
    for m in levels:
        n = len(products[m])
        sums = irfft(np.conj(rfft(products[m])) * spectra[m], n=n)
        added = np.tile(added, n // len(added)) + 2 * sums
        so_far += 2 * products[m].sum()
        worst = np.tile(worst, n // len(worst))
        if m >= LEAST and j > 1:
            square = (so_far + gamma * added) / 2**m - 1
            worst = np.maximum(worst, square / square.min())
    best = int(np.argmin(worst)) if j > 1 else 0
    print(candidates[best])
    for m in levels:
        n = len(products[m])
        products[m] *= 1 + gamma * np.roll(kernels[m], -(best % n))
    few_products *= 1 + gamma * few
