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
    Block, Coordinates, DigitalShift, Independent, LinearMatrix, Owen, Randomize, Sampler,
    Scramble, Sobol, Stratified,
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

/// Three dimensions of a net and one beyond; Joe and Kuo's table is read, and all
/// else made, apart from the crate.
#[test]
fn sobol() {
    fn check<S: Scramble>(
        scramble: S,
        first: [[u64; 4]; 3],
        later: [[u64; 4]; 3],
        replicate: [u64; 3],
    ) {
        let net = Sobol::new(3).unwrap();
        let scrambled = net.scrambled(scramble, 1);
        assert_eq!(bits(&scrambled, FIRST), first);
        assert_eq!(bits(&net.scrambled(scramble, 3), LATER), later);
        let [_, second] = bits(&scrambled.randomize(2), FIRST);
        assert_eq!(second, replicate);
    }
    const LATER: Block = Block {
        index: 7,
        start: 123_456_789_012,
        len: 3,
    };
    let net = Sobol::new(3).unwrap();
    assert_eq!(
        bits(&net, FIRST),
        [
            [
                0x0000_0000_0000_0000,
                0x0000_0000_0000_0000,
                0x0000_0000_0000_0000,
                0x3fe2_b611_9b59_e33b
            ],
            [
                0x3fe0_0000_0000_0000,
                0x3fe0_0000_0000_0000,
                0x3fe0_0000_0000_0000,
                0x3fdd_a262_2ad7_6130
            ],
            [
                0x3fe8_0000_0000_0000,
                0x3fd0_0000_0000_0000,
                0x3fd0_0000_0000_0000,
                0x3fc0_a898_2383_7af0
            ],
        ]
    );
    assert_eq!(
        bits(&net, LATER),
        [
            [
                0x3fde_3a6a_e1d2_0000,
                0x3fc1_c772_0ca4_0000,
                0x3fed_90d4_94e5_0000
            ],
            [
                0x3fef_1d35_70e9_0000,
                0x3fe4_71dc_8329_0000,
                0x3fdb_21a9_29ca_0000
            ],
            [
                0x3fe7_1d35_70e9_0000,
                0x3fd8_e3b9_0652_0000,
                0x3fe5_90d4_94e5_0000
            ],
        ]
    );
    check(
        DigitalShift,
        [
            [
                0x3fdd_5eca_2212_e6dc,
                0x3fc5_8737_9e20_5314,
                0x3fee_5dbc_9d9c_b467,
                0x3fdd_192f_ea41_3156,
            ],
            [
                0x3fee_af65_1109_736e,
                0x3fe5_61cd_e788_14c5,
                0x3fdc_bb79_3b39_68ce,
                0x3fe1_f278_1df2_69b7,
            ],
            [
                0x3fe6_af65_1109_736e,
                0x3fda_c39b_cf10_298a,
                0x3fe6_5dbc_9d9c_b467,
                0x3fd6_1322_e143_f61e,
            ],
        ],
        [
            [
                0x3fe2_e15e_903d_2796,
                0x3fd5_79c7_7326_aff6,
                0x3feb_07bc_ed8c_9db1,
                0x3fe5_d1b5_f491_15c3,
            ],
            [
                0x3fb7_0af4_81e9_3cb0,
                0x3fea_bce3_b993_57fb,
                0x3fd6_0f79_db19_3b62,
                0x3f98_6481_a700_c7e0,
            ],
            [
                0x3fd5_c2bd_207a_4f2c,
                0x3fb5_e71d_cc9a_bfd8,
                0x3fe3_07bc_ed8c_9db1,
                0x3fec_b4cd_d79c_c16d,
            ],
        ],
        [
            0x3fe3_6eac_3344_2872,
            0x3fe4_ada9_a2e2_8e43,
            0x3fe9_f943_066c_1fe1,
        ],
    );
    check(
        LinearMatrix,
        [
            [
                0x3fe8_d2b2_3ecf_0a7a,
                0x3fef_ed10_0f28_9560,
                0x3fe9_5885_8a9b_25ed,
                0x3fdd_192f_ea41_3156,
            ],
            [
                0x3fc9_f75c_bf19_e450,
                0x3fc4_f688_f2d4_6668,
                0x3fce_278e_6a25_615c,
                0x3fe1_f278_1df2_69b7,
            ],
            [
                0x3fd6_3835_909c_dba2,
                0x3fe5_2b5f_2c3a_b444,
                0x3fe7_4680_7918_e296,
                0x3fd6_1322_e143_f61e,
            ],
        ],
        [
            [
                0x3fe2_397f_ae5b_bd49,
                0x3fec_646f_bbca_59bb,
                0x3fea_0b1a_927b_09f1,
                0x3fe5_d1b5_f491_15c3,
            ],
            [
                0x3fdf_8a28_9d1f_35be,
                0x3fce_f1c0_3151_f6a8,
                0x3fb6_5fee_11aa_e8b0,
                0x3f98_6481_a700_c7e0,
            ],
            [
                0x3fa0_82b7_435c_d240,
                0x3fe1_e3c6_9e95_8b6e,
                0x3fe2_63ce_74ca_e4ba,
                0x3fec_b4cd_d79c_c16d,
            ],
        ],
        [
            0x3fb8_8f96_46ae_6ae0,
            0x3fec_303b_765c_57e7,
            0x3fd8_b87f_0a9f_68de,
        ],
    );
    check(
        Owen,
        [
            [
                0x3fea_4cb3_d884_2754,
                0x3fe8_895c_3a34_37f4,
                0x3fe8_5c7d_ee11_7771,
                0x3fdd_192f_ea41_3156,
            ],
            [
                0x3fd1_15fe_b2a1_dfca,
                0x3fdb_b452_229f_4520,
                0x3fd6_cea7_5857_60c8,
                0x3fe1_f278_1df2_69b7,
            ],
            [
                0x3fcf_108f_e32c_7fc8,
                0x3fe5_a60e_ee55_f336,
                0x3fe3_79ca_0ec9_4959,
                0x3fd6_1322_e143_f61e,
            ],
        ],
        [
            [
                0x3fec_025f_2bc3_9e72,
                0x3fca_1944_fdad_5238,
                0x3fda_bddc_e3d1_cd4c,
                0x3fe5_d1b5_f491_15c3,
            ],
            [
                0x3fd0_b931_8b1c_f332,
                0x3fe6_439b_2992_52f7,
                0x3fe2_7e77_e5b3_48b2,
                0x3f98_6481_a700_c7e0,
            ],
            [
                0x3fc6_4b38_d128_5088,
                0x3fd8_da71_60a5_7b00,
                0x3fb6_0028_c377_7348,
                0x3fec_b4cd_d79c_c16d,
            ],
        ],
        [
            0x3fe3_eb9d_a2d8_e51d,
            0x3fe5_9705_8649_df68,
            0x3fe6_9dcf_9299_b2cf,
        ],
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
