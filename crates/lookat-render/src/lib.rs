//! Renders [`Scene`]s.
//!
//! ```
//! use lookat_render::scene::load_str;
//! use lookat_render::{Settings, render};
//!
//! let text = r#"
//!     LookAt 0 0 -4  0 0 0  0 1 0
//!     Camera "perspective" "float fov" 40
//!     Film "image" "integer xresolution" 32 "integer yresolution" 32
//!     Sampler "sobol" "integer pixelsamples" 16
//!     Integrator "directlighting"
//!     WorldBegin
//!     LightSource "infinite"
//!     Material "matte" "rgb Kd" [0.5 0.5 0.5]
//!     Shape "sphere"
//!     WorldEnd
//! "#;
//! let scene = load_str(text).scene.unwrap();
//! let rendered = render(&scene, &Settings::default(), &|_| std::ops::ControlFlow::Continue(()));
//! // Half of the light of a white sky comes back from a gray sphere.
//! let middle = rendered.image.rgb().unwrap()[16 * 32 + 16];
//! assert!((middle[0] - 0.5).abs() < 0.01);
//! ```
//!
//! | to | use |
//! |---|---|
//! | render a picture | [`render()`], with [`Settings`] and their stopping rule [`Stop`] |
//! | render many views of a world | [`Prepared`] |
//! | show a picture that grows | [`Progress::snapshot`] |
//! | add up pictures of other samples, exactly | [`Progress::sums`] and [`FilmSums`] |
//! | know what is at a place of a picture | [`Prepared::pick`] |
//! | give a picture depth, normals and other layers | [`Settings::layers`] |
//! | trace rays of your own | [`Prepared::camera`], [`Prepared::nearest`], [`Prepared::occluded`], [`Prepared::surface`] |
//! | know how much light comes to a surface | [`Prepared::irradiance`] |
//! | know where the time goes | [`profile()`] |
//! | know what a scene takes | [`inspect()`], [`film_bytes`], [`preparation_bytes`] |
//!
//! The examples of this crate build a scene in code, render a file with progress, turn a camera around a mesh, and compare two
//! pictures.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bsdf;
mod bssrdf;
mod bvh;
mod camera;
mod columns;
mod curve;
mod curved;
mod cutout;
mod emitters;
mod film;
mod filter;
mod frame;
mod inspect;
mod integrator;
mod irradiance;
mod light;
mod medium;
mod number;
mod parametric;
mod prepare;
mod ray;
mod ray_query;
mod real;
mod render;
mod sampler;
mod shading;
mod surface;
#[cfg(test)]
mod testing;
mod texture;
mod threads;
mod trace;
mod traceable;
mod triangle;
mod warp;

pub use camera::{CameraRays, Focus, LensRays};
pub use film::{FilmSums, FilmSumsError, REPLICATES, SumsHeader};
pub use inspect::{Choice, Elements, Inspection, Surfaces, inspect, simd};
pub use integrator::{SampleDimensions, StageProfile};
pub use irradiance::{Irradiance, LightPlace, r2_sequence};
pub use lookat_image as image;
pub use lookat_scene as scene;
pub use lookat_scene::{Scene, glam};
pub use medium::cost::{GridCost, MediumCost};
pub use prepare::{Prepared, preparation_bytes};
pub use ray::{ElementId, Hit, Ray, ShapeId};
pub use ray_query::Picked;
pub use render::{
    BrightestSample, DARK, Layer, Layers, Part, PathEnd, Progress, Reached, Rendered, Settings, Statistics,
    Stop, StopOptions, StopOptionsError, TargetError, TimeLeft, film_bytes, profile, render,
};
pub use surface::Surface;
pub use threads::{start_threads, threads};
