//! What holds for scene files, the meaning of scenes and their pictures, tested through the libraries.

mod albedo;
mod any_text;
mod diagnostics;
mod disney;
mod fourier;
mod furnace;
mod load_again;
mod promises;
mod subsurface;
mod supported;
mod views;
