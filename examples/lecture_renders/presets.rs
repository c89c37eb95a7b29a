//! What is compared: the pseudo-codes of the lectures, with numbers of rays
//! that leave a few samples a pixel.

use estimand::render::{Directions, Layout, Roulette, Technique};

pub struct Preset {
    /// Where in the lectures, and what it is called there.
    pub name: &'static str,
    /// With which numbers.
    pub detail: &'static str,
    pub technique: Technique,
}

pub fn all() -> [Preset; 10] {
    let preset = |name, detail, technique| Preset {
        name,
        detail,
        technique,
    };
    let rays = Technique::monte_carlo_ray_tracing(1, 4, 2);
    let roulette = Roulette::go_on(0.8);
    [
        preset(
            "A4 classic ray tracing",
            "4 × 8 fixed directions, 2 vertices",
            Technique::classic(4, 8, 2),
        ),
        preset("A13 MC_RT, uniform", "4 rays a vertex, 4 vertices", rays),
        preset(
            "A13 MC_RT, stratified",
            "2 × 2 rays a vertex, 4 vertices",
            Technique {
                layout: Layout::Stratified(2, 2),
                ..rays
            },
        ),
        preset(
            "A13 MC_RT, cosine-weighted",
            "4 rays a vertex, 4 vertices",
            Technique {
                directions: Directions::Cosine,
                ..rays
            },
        ),
        preset(
            "B2 direct, by hitting",
            "16 rays a vertex, 2 vertices",
            Technique::shade_direct(16),
        ),
        preset(
            "B3 branching",
            "4 rays a vertex, 4 vertices",
            Technique::shade_branching(4, 4),
        ),
        preset(
            "B4 path tracing",
            "1 ray a vertex, 4 vertices",
            Technique::shade_path(4),
        ),
        preset(
            "B5 roulette",
            "goes on with 0.8",
            Technique::shade_roulette(roulette),
        ),
        preset(
            "B6 the light’s area",
            "and roulette, goes on with 0.8",
            Technique::shade_light(roulette),
        ),
        preset("path_tracing()", "this crate’s", Technique::path_tracing()),
    ]
}
