//! The types, with the parameters that their constructors read: what the schema is tested against.

use std::io;
use std::path::Path;

use glam::Vec3;
use lookat_image::MemoryBudget;
use lookat_syntax::{Entity, FileId, Span, Text};

use crate::files::{Access, Files};
use crate::film::{Film, PixelBounds};
use crate::names::Names;
use crate::overrides::Overrides;
use crate::params::Params;
use crate::picture::Pictures;
use crate::report::Report;
use crate::schema::names;
use crate::texture::{Texture, TextureParams, Textures};
use crate::transform::Transform;
use crate::{camera, cutout, film, filter, integrator, light, material, sampler, shape, texture};

/// A type of a directive, such as `Shape "sphere"`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    /// The directive.
    pub directive: &'static str,
    /// The name of the type.
    pub name: &'static str,
    /// Its parameters. An unsupported type lists the parameters of its stand-in.
    pub parameters: Vec<&'static str>,
}

/// A directive, its type names, and their constructor.
type Table<'a> = (&'static str, Vec<&'static str>, &'a dyn Fn(&mut TextureParams));

/// All types.
pub fn kinds() -> Vec<Kind> {
    let here = Transform::IDENTITY;
    let tables: [Table; 11] = [
        ("Camera", names(camera::KINDS), &|params| {
            camera::camera(params, here, &square_film());
        }),
        ("Film", names(film::KINDS), &|params| {
            film::film(params, &Overrides::default());
        }),
        ("PixelFilter", names(filter::KINDS), &|params| {
            filter::filter(params);
        }),
        ("Sampler", names(sampler::KINDS), &|params| {
            sampler::sampler(params, &Overrides::default());
        }),
        ("Integrator", names(integrator::KINDS), &|params| {
            integrator::integrator(params);
        }),
        ("Shape", names(shape::KINDS), &|params| {
            if ["trianglemesh", "plymesh"].contains(&params.kind()) {
                cutout::cutout(params);
            }
            shape::shape(params, here);
        }),
        ("Material", names(material::KINDS), &|params| {
            material::material(params, &Names::default());
        }),
        ("LightSource", names(light::KINDS), &|params| {
            light::light(params, here, &mut Pictures::default());
        }),
        ("AreaLightSource", names(light::AREA_KINDS), &|params| {
            light::emission(params);
        }),
        ("Texture", names(texture::KINDS), &|params| {
            let _: Option<Texture<f64>> = texture::texture(params, here, &mut Pictures::default());
        }),
        ("Texture", names(texture::KINDS), &|params| {
            let _: Option<Texture<Vec3>> = texture::texture(params, here, &mut Pictures::default());
        }),
    ];
    let of_table = |(directive, names, make): Table| {
        names.into_iter().map(|name| kind(directive, name, make)).collect::<Vec<_>>()
    };
    tables.into_iter().flat_map(of_table).collect()
}

fn square_film() -> Film {
    let crop = PixelBounds { x0: 0, y0: 0, x1: 1, y1: 1 };
    let max_sample_luminance = f64::INFINITY;
    Film { resolution: [1, 1], crop, scale: 1.0, max_sample_luminance, file: "x.exr".into() }
}

/// A type with the parameters that its constructor reads.
fn kind(directive: &'static str, name: &'static str, make: &dyn Fn(&mut TextureParams)) -> Kind {
    let mut parameters = Vec::new();
    call(directive, name, &mut |params| {
        make(params);
        parameters = params.asked();
    });
    Kind { directive, name, parameters }
}

/// Calls a constructor with an empty parameter list.
fn call(directive: &'static str, name: &str, make: &mut dyn FnMut(&mut TextureParams)) {
    let read = |_: &Path| -> io::Result<Vec<u8>> { Err(io::ErrorKind::NotFound.into()) };
    let (files, mut report) =
        (Files::new(Path::new(""), Access::Read(&read), MemoryBudget::new(0)), Report::default());
    let span = Span { file: FileId(0), start: 0, end: 0 };
    let entity = Entity { name: Text { value: name.into(), span }, params: Vec::new() };
    let textures = Textures::default();
    let params = &mut Params::new(directive, entity, &files, &mut report);
    make(&mut TextureParams::new(params, &textures));
}
