//! The meaning of pbrt-v3 scene files.
//!
//! [`load()`] reads a scene file and its included files. It returns a [`Scene`], a plain value with every name,
//! default, unit and transformation resolved, and the diagnostics. It reads files through a function of the caller,
//! so that a scene can come from anywhere:
//!
//! ```
//! use std::path::Path;
//!
//! let text = r#"
//!     LookAt 0 0 -4  0 0 0  0 1 0
//!     Camera "perspective" "float fov" 40
//!     Film "image" "integer xresolution" 64 "integer yresolution" 48
//!     Sampler "sobol" Integrator "path"
//!     WorldBegin
//!     LightSource "infinite"
//!     Shape "sphere" "float raduis" 1
//!     WorldEnd
//! "#;
//! let loaded = lookat_scene::load(Path::new("demo.pbrt"), &|_| Ok(text.into()), &Default::default());
//! assert_eq!(loaded.scene.unwrap().view.film.resolution, [64, 48]);
//! assert_eq!(loaded.diagnostics[0].help.as_deref(), Some("did you mean \"radius\"?"));
//! assert_eq!(loaded.sources.location(loaded.diagnostics[0].span()).line, 8);
//! ```
//!
//! A scene can also be built in code: its parts are plain values, and constructors check what indices and lengths must keep.
//! [`Scene::validate`] checks the rest.
//!
//! A scene that is loaded guarantees to the renderer: indices are in range, transformations are invertible, lengths are
//! positive where they must be, and all numbers are finite, except an unlimited `max_sample_luminance`.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod advice;
mod cache;
mod camera;
mod color;
mod directive_text;
mod draft;
mod facts;
mod files;
mod film;
mod filter;
mod integrator;
mod json;
mod kinds;
mod light;
mod load;
mod material;
mod medium;
mod mesh;
mod names;
mod options;
mod params;
mod picture;
mod ply;
mod report;
mod resolve;
mod sampler;
mod scene;
pub mod schema;
mod shape;
mod sources;
mod symbols;
mod texture;
mod transform;
mod validate;

pub use cache::{LoadCache, Stamp, Stamped};
pub use camera::{
    Camera, CameraPlacement, EquivalentView, FileCamera, Lens, LensElement, LensSystem, MILLIMETER,
    Projection, Pupil, ScreenWindow, Shutter, ThickLens, ViewOverride, Weighting,
};
pub use color::LUMINANCE;
pub use directive_text::DirectiveText;
pub use files::{Open, Read};
pub use film::{Film, FilmOverride, MAX_PIXELS, MAX_SIDE, PixelBounds};
pub use filter::{Filter, FilterKind};
pub use glam;
pub use integrator::{DirectStrategy, Integrator, LightChoice};
pub use json::{JsonDiagnostic, Place, as_json};
pub use light::{Emission, Light};
pub use load::{Loaded, load, load_again, load_opened, load_str};
pub use lookat_syntax as syntax;
pub use material::{
    Disney, FourierTable, Glass, Hair, HairColor, Interior, Material, MaterialKind, Matte, Metal, Mirror,
    Mix, Needs, Plastic, Roughness, Series, Substrate, Subsurface, ThinDisney, Translucent, Uber,
};
pub use mesh::{Cutout, Mesh, MeshArray, MeshError};

pub use kinds::kinds;
pub use medium::{Density, DensityGrid, Medium};
pub use options::LoadOptions;
pub use sampler::{MAX_SAMPLES, Sampler, SamplerKind};
pub use scene::{Instance, MediumInterface, Memory, Object, Places, Primitive, Scene, View, World};
pub use shape::{
    Cone, Curve, CurveKind, Cylinder, Disk, Hyperboloid, Paraboloid, Quadric, QuadricForm, Shape, Sphere,
};
pub use sources::{Location, Source, Sources};
pub use symbols::{Symbol, SymbolKind};
pub use texture::{
    AnyTexture, Bilerp, Cells, Checkerboard, Dots, ImageFilter, ImageMap, Mapping, Marble, Node, Octaves,
    Texture, Value, Varying,
};
pub use transform::{AnimatedTransform, LookAtError, MirrorsOnTheWay, Transform};
pub use validate::{InvalidField, InvalidScene};
