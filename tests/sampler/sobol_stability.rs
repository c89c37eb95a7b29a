//! Golden bits of Sobol's nets: no release changes them. As in
//! `value_stability.rs`, the vectors were made by a second implementation.

use estimand::sampler::{
    Block, Coordinates, DigitalShift, LinearMatrix, Owen, Randomize, Sampler, Scramble, Sobol,
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
