//! Which numbers a seed gives, to the bit. A release that changes one of them
//! changes the results of every run, and says so in its notes.
//!
//! All values were computed apart from the crate, in Python's integers and
//! doubles: SplitMix64's finaliser from Steele, Lea & Flood (2014), seeding
//! O'Neill's PCG XSL-RR 128/64 (MCG) from *PCG: A Family of Simple Fast
//! Space-Efficient Statistically Good Algorithms for Random Number Generation*
//! (2014), whose Python twin gives the numbers of the C reference for state 42
//! (63b4a3a813ce700a, 382954200617ab24, a7fd85ae3fe950ce).

use estimand::sampler::{
    Block, Coordinates, Halton, Independent, IndependentLanes, LatinHypercube, Lattice, Randomize,
    Sampler, Stratified,
};

fn bits<S: Sampler, const D: usize, const N: usize>(sampler: &S, block: Block) -> [[u64; D]; N] {
    let mut stream = sampler.stream(block);
    std::array::from_fn(|_| {
        stream.next_point();
        std::array::from_fn(|_| stream.next_1d().to_bits())
    })
}

const FIRST: Block = Block {
    index: 0,
    start: 0,
    len: 6,
};

#[test]
fn independent() {
    for (seed, index, expected) in [
        (
            0,
            0,
            [
                [0x3fe2_b611_9b59_e33b, 0x3fdd_a262_2ad7_6130],
                [0x3fc0_a898_2383_7af0, 0x3fc5_8071_7ecd_ecb0],
            ],
        ),
        (
            1,
            0,
            [
                [0x3fdd_192f_ea41_3156, 0x3fe1_f278_1df2_69b7],
                [0x3fd6_1322_e143_f61e, 0x3fe4_b6bc_36da_509c],
            ],
        ),
        (
            1,
            1,
            [
                [0x3fec_8c55_2ad2_eebf, 0x3fcf_43ee_7266_44d8],
                [0x3fd4_cb00_b209_45b8, 0x3fc3_8274_a5e4_b074],
            ],
        ),
        (
            2,
            0,
            [
                [0x3fef_f566_e763_4259, 0x3f61_8dad_8e6e_2900],
                [0x3fcf_264a_765d_d988, 0x3fe0_8ecc_eb4f_9f80],
            ],
        ),
        (
            3,
            7,
            [
                [0x3fe5_d1b5_f491_15c3, 0x3f98_6481_a700_c7e0],
                [0x3fec_b4cd_d79c_c16d, 0x3fed_49bc_c47f_8b87],
            ],
        ),
        (
            u64::MAX,
            u64::MAX,
            [
                [0x3fe6_9947_7b99_3ee1, 0x3fec_39c3_ecae_17fd],
                [0x3f8a_d559_1b85_00c0, 0x3fd5_5084_c651_e5ea],
            ],
        ),
    ] {
        let sampler: Independent = Independent::new(seed);
        assert_eq!(
            bits(&sampler, Block { index, ..FIRST }),
            expected,
            "{seed} {index}"
        );
    }
}

/// The first two points and, of the same two generators, the next: Blackman &
/// Vigna's xoshiro256+, whose Python twin gives the published numbers for state
/// 1, 2, 3, 4, seeded as above.
#[test]
fn independent_lanes() {
    for (seed, index, expected) in [
        (
            0,
            0,
            [
                [0x3feb_558c_1c3d_ad48, 0x3fc8_ab50_ed06_e040],
                [0x3fec_17b3_94a3_57e2, 0x3fe1_d61b_04db_c8ea],
                [0x3fef_3747_c650_ba08, 0x3fd3_f465_1847_6e9c],
                [0x3fe1_d480_fece_72f0, 0x3fe9_7ae5_c441_a7c6],
            ],
        ),
        (
            1,
            1,
            [
                [0x3fe8_6034_a00c_1ef8, 0x3fd7_327d_5938_0e10],
                [0x3fea_62b6_0eb6_1128, 0x3fc7_ebf2_4740_faf8],
                [0x3fe5_791b_02ec_1d06, 0x3fca_482b_7481_7088],
                [0x3fe8_2891_910b_ebc2, 0x3fe0_405d_98e3_0a92],
            ],
        ),
        (
            u64::MAX,
            u64::MAX,
            [
                [0x3fee_cdbc_1366_bda4, 0x3fe2_2492_ddcf_5a1e],
                [0x3fe7_3626_edf8_82d8, 0x3fdb_98e5_4b9b_e5b0],
                [0x3f77_ae9b_feec_0c00, 0x3fec_47a2_38ac_f88e],
                [0x3fd8_6cdf_397e_9f88, 0x3fe2_97ba_d655_ad44],
            ],
        ),
    ] {
        let points: [_; 10] = bits(&IndependentLanes::new(seed), Block { index, ..FIRST });
        let found = [points[0], points[1], points[8], points[9]];
        assert_eq!(found, expected, "{seed} {index}");
    }
}

#[test]
fn replicates_of_independent() {
    for (replicate, expected) in [
        (0, [[0x3fde_5f96_007a_938a, 0x3fe5_ed95_504c_d4c3]]),
        (1, [[0x3fec_b8c1_a3e9_9305, 0x3fea_4e57_e4cc_bc51]]),
    ] {
        let sampler = Independent::new(1).randomize(replicate);
        let sampler: Independent = sampler;
        assert_eq!(bits(&sampler, FIRST), expected, "{replicate}");
    }
}

#[test]
fn stratified() {
    let expected = [
        [0x3fcd_192f_ea41_3155, 0x3fc7_edf5_7d43_379d],
        [0x3fc6_1322_e143_f61d, 0x3fe1_923e_bcf3_7033],
        [0x3fd2_39c1_7e5d_b3c9, 0x3fed_974e_8eb2_d5b3],
        [0x3fe7_c716_97dc_5e6e, 0x3fd1_c1ec_c69b_1c48],
        [0x3fe0_3db0_8c48_b8d1, 0x3fe2_4857_9607_3bba],
        [0x3fe5_1ddb_7437_3351, 0x3feb_f696_a33c_8939],
    ];
    assert_eq!(
        bits(&Stratified::new([2, 3], 1, 1).unwrap(), FIRST),
        expected
    );

    // From the middle of a stratum into the grid's second round, and one
    // coordinate beyond the strata.
    let expected = [
        [0x3fe4_ad06_9a91_bed7, 0x3fd1_218d_39f3_7f52],
        [0x3fe8_7efe_d2ed_d53e, 0x3fe4_ccc2_bc98_d82d],
        [0x3fe8_b342_9586_eb89, 0x3fea_deb1_71de_2a55],
        [0x3fc6_0ef4_910e_a88d, 0x3fe9_c9b6_18d6_0506],
    ];
    let block = Block {
        index: 2,
        start: 3,
        len: 4,
    };
    assert_eq!(bits(&Stratified::new([3], 2, 3).unwrap(), block), expected);
}

/// Lattices: first points with a coordinate beyond, and a replicate, folded,
/// from the middle of a run.
#[test]
fn lattice() {
    let lattice = Lattice::new(2, 1).unwrap();
    assert_eq!(
        bits(&lattice, FIRST),
        [
            [
                0x3faf_f69c_cf3d_5cf0,
                0x3fdb_a888_45db_1732,
                0x3fdd_192f_ea41_3156
            ],
            [
                0x3fe1_ff69_ccf3_d5cf,
                0x3fed_d444_22ed_8b99,
                0x3fe1_f278_1df2_69b7
            ],
            [
                0x3fd3_fed3_99e7_ab9e,
                0x3fe5_d444_22ed_8b99,
                0x3fd6_1322_e143_f61e
            ],
            [
                0x3fe9_ff69_ccf3_d5cf,
                0x3fc7_5110_8bb6_2e64,
                0x3fe4_b6bc_36da_509c
            ],
        ]
    );
    let block = Block {
        index: 2,
        start: 5,
        len: 3,
    };
    assert_eq!(
        bits(&lattice.baker().randomize(3), block),
        [
            [
                0x3fdf_759f_59d3_a8d0,
                0x3fa0_d772_e8f2_4ac0,
                0x3fe3_199d_ccb7_af5e
            ],
            [
                0x3fef_bacf_ace9_d468,
                0x3fdd_e511_a2e1_b6a8,
                0x3fd0_13ac_7a72_4a3a
            ],
            [
                0x3f81_4c14_c58a_e600,
                0x3fe1_0d77_2e8f_24ac,
                0x3fe1_43d9_23e5_4219
            ],
        ]
    );
}

/// The coordinates on these axes of one point.
fn point<S: Sampler, const N: usize>(sampler: &S, start: u64, axes: [usize; N]) -> [u64; N] {
    let mut stream = sampler.stream(Block { start, ..FIRST });
    stream.next_point();
    let all: Vec<u64> = (0..1024).map(|_| stream.next_1d().to_bits()).collect();
    axes.map(|k| all[k])
}

#[test]
fn halton() {
    let halton = Halton::new(1024, 1).unwrap();
    let nested = Halton::nested(1024, 1).unwrap();
    assert_eq!(
        [0, 1, 2, 1000].map(|i| point(&halton, i, [0, 1, 2])),
        [
            [
                0x3fe6_8af3_ac78_a0ff,
                0x3fee_dfbd_761a_eb15,
                0x3fce_352a_0d2b_a351
            ],
            [
                0x3fca_2bce_b1e2_83fd,
                0x3fe4_3512_cb70_406a,
                0x3fe4_5a17_5017_b5a1
            ],
            [
                0x3fee_8af3_ac78_a0ff,
                0x3fd3_14d0_418b_2b7e,
                0x3fa2_6e41_ce48_26dc
            ],
            [
                0x3fe4_72f3_ac78_a0ff,
                0x3fe4_f05c_a816_785e,
                0x3fcd_d6ca_dc43_a3f9
            ],
        ]
    );
    assert_eq!(
        point(&halton.randomize(3), 7, [0, 1, 1023]),
        [
            0x3fce_9f27_7a8b_ed79,
            0x3fed_65a5_3dda_799f,
            0x3fe1_0eff_5add_72dd
        ]
    );
    assert_eq!(
        [0, 1, 2, 1000].map(|i| point(&nested, i, [0, 1, 2])),
        [
            [
                0x3fdc_9871_49a8_6113,
                0x3fe5_0864_1a7a_9b7a,
                0x3fcf_f746_4b37_9ad7
            ],
            [
                0x3fe6_e153_4962_930f,
                0x3fee_88a1_d4b1_0a05,
                0x3fda_6ff0_2f5e_9dac
            ],
            [
                0x3fad_11db_2cb7_6669,
                0x3fd5_16bd_da1a_3ee8,
                0x3fe8_f2e6_a8da_fa2e
            ],
            [
                0x3fdb_74fe_935d_e3e7,
                0x3fed_d399_7fd4_4f5d,
                0x3fcf_ccf4_f162_b126
            ],
        ]
    );
    assert_eq!(
        point(&nested.randomize(3), 7, [0, 1, 1023]),
        [
            0x3fe3_14da_d41b_ceb9,
            0x3fce_0b46_7cf3_ea14,
            0x3fd9_d6dd_07f0_1bcc
        ]
    );
}

/// From one hypercube into the next, and a coordinate beyond.
#[test]
fn latin_hypercube() {
    assert_eq!(
        bits(&LatinHypercube::new(5, 2, 1).unwrap(), FIRST),
        [
            [
                0x3fdf_6b6f_fba6_a377,
                0x3fbc_b726_9650_a924,
                0x3fd6_1322_e143_f61e
            ],
            [
                0x3fe7_57bf_3e2b_a9b8,
                0x3fed_3ec0_4c79_23f4,
                0x3fe8_c5eb_ac18_8120
            ],
            [
                0x3fd3_05ab_acb0_4b8c,
                0x3fe8_86fa_3b94_eee2,
                0x3f8e_d846_245c_68c0
            ],
            [
                0x3fc2_4738_9b44_8f58,
                0x3fdd_b17c_5cf8_f5db,
                0x3fe3_e3c3_e9b5_9bb0
            ],
            [
                0x3fef_be2f_0755_fa96,
                0x3fd8_2ce5_fb68_2dcc,
                0x3fcc_253f_ac99_1de8
            ],
            [
                0x3fed_c62e_56a5_36ff,
                0x3fe5_88d5_b2f8_8acc,
                0x3fef_189e_9955_5a30
            ],
        ]
    );
    let block = Block {
        index: 2,
        start: 998,
        len: 4,
    };
    assert_eq!(
        bits(
            &LatinHypercube::new(1000, 2, 1).unwrap().randomize(3),
            block
        ),
        [
            [
                0x3fe8_87f6_2c7e_22bb,
                0x3fe6_db25_5590_b277,
                0x3fe1_43d9_23e5_4219
            ],
            [
                0x3fe4_dfd9_df5b_5447,
                0x3fa3_2b61_665c_44d2,
                0x3fd2_8883_6ead_419a
            ],
            [
                0x3fd8_1de8_6831_2a36,
                0x3fa9_1b23_3d7a_8049,
                0x3fe9_0b83_50b5_c24d
            ],
            [
                0x3fe8_4aac_0705_f3a8,
                0x3fe0_606a_9b4f_3145,
                0x3fea_9400_eb5b_a3d9
            ],
        ]
    );
}

/// A whole run: how passes are cut, blocks seeded and sums merged. These bits
/// are the crate's own; the values that they are near to are known.
#[test]
fn runs() {
    use estimand::prelude::*;
    let estimator = Importance::new(|[x, y]: [f64; 2]| x + 2.0 * y, estimand::pdf::UnitCube);
    let stop = Stop::samples(10_000);
    let mut plain = MonteCarlo::new(estimator, Independent::new(7));
    let e = run(&mut plain, &Serial, &stop).unwrap().answer;
    assert!((e.mean - 1.5).abs() < 5.0 * (5.0_f64 / 12.0 / 10_000.0).sqrt());
    assert_eq!(
        [e.mean, e.standard_error].map(f64::to_bits),
        [4_609_450_840_237_002_009, 4_574_048_409_425_697_412]
    );
    let grid = Stratified::new([50, 50], 2, 7).unwrap();
    let mut strata = StratifiedMonteCarlo::new(estimator, grid);
    let e = run(&mut strata, &Serial, &stop).unwrap().answer;
    assert!((e.mean - 1.5).abs() < 5.0 * (5.0_f64 / 12.0 / 10_000.0).sqrt() / 50.0);
    assert_eq!(
        [e.mean, e.standard_error].map(f64::to_bits),
        [4_609_434_086_633_561_901, 4_548_919_289_168_483_562]
    );
}
