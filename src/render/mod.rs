//! The rendering equation, and the film its answers are put on.

mod film;
mod film_error;
mod image;
#[cfg(feature = "png")]
mod png;
mod randomized_film;
mod tiles;
mod window;

pub use film::Film;
pub use film_error::{FilmError, PixelError};
pub use image::{Image, Pixel};
pub use randomized_film::RandomizedFilm;
pub use tiles::FilmPartial;
pub use window::{Window, WindowStream};
