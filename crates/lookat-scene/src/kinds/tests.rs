//! Constructors read what the schema lists.

use std::io;
use std::path::Path;

use glam::Vec3;
use lookat_image::MemoryBudget;
use lookat_syntax::{Entity, FileId, Span, Text};

use crate::camera::{self, ViewOverride};
use crate::files::{Access, Files};
use crate::film::{self, Film, FilmOverride};
use crate::kinds::kinds;
use crate::names::Names;
use crate::params::Params;
use crate::picture::Pictures;
use crate::report::Report;
use crate::schema::{Effect, Kind, Parameter, Range, number};
use crate::symbols::SymbolKind;
use crate::texture::{Textures, texture};
use crate::transform::{Transform, TransformSet};
use crate::{filter, integrator, light, material, medium, mesh, sampler, shape};

/// The parameters that the constructor of a type reads, when none is given.
fn read(kind: &Kind) -> Vec<&'static str> {
    let missing = |_: &Path| Err(io::ErrorKind::NotFound.into());
    let files = Files::new(Path::new(""), Access::Read(&missing), MemoryBudget::new(0), None);
    let mut report = Report::default();
    let span = Span { file: FileId(0), start: 0, end: 0 };
    let entity = Entity { name: Text { value: kind.name.into(), span }, params: Vec::new() };
    let textures = Textures::default();
    let params = Params::new(kind.directive, entity, &files, &mut report);
    let params = &mut params.with_textures(&textures);
    construct(kind, params);
    params.names()
}

fn construct(kind: &Kind, params: &mut Params) {
    let (here, pictures) = (Transform::IDENTITY, &mut Pictures::default());
    match kind.directive {
        "Camera" => {
            let (placed, film) = (TransformSet::still(here), &Film::new([1, 1]));
            camera::camera(params, &placed, [0.0, 1.0], film, &ViewOverride::default());
        }
        "Film" => drop(film::film(params, &FilmOverride::default())),
        "PixelFilter" => drop(filter::filter(params)),
        "Sampler" => drop(sampler::sampler(params)),
        "Integrator" => drop(integrator::integrator(params)),
        "Shape" => {
            if ["trianglemesh", "plymesh"].contains(&kind.name) {
                mesh::cutout(params);
            }
            drop(shape::shape(params, None, &here.into()));
        }
        "Accelerator" => {}
        "MakeNamedMedium" => {
            medium::named_type(params);
            drop(medium::medium(params, here));
        }
        "Material" | "MakeNamedMaterial" => {
            if kind.directive == "MakeNamedMaterial" {
                material::named_type(params);
            }
            drop(material::material(params, &Names::new(SymbolKind::Material), &mut material::Tables::new()))
        }
        "LightSource" => drop(light::light(params, here, pictures)),
        "AreaLightSource" => drop(light::emission(params)),
        "Texture" => {
            texture::<f64>(params, here, pictures);
            texture::<Vec3>(params, here, pictures);
        }
        other => panic!("no constructor for {other}"),
    }
}

#[test]
fn constructors_read_what_the_schema_lists() {
    for kind in kinds() {
        let (read, listed): (_, Vec<Parameter>) = (read(kind), kind.parameters().collect());
        let what = format!("{} \"{}\"", kind.directive, kind.name);
        for parameter in &listed {
            let is_read = read.contains(&parameter.name);
            assert!(
                is_read || parameter.effect == Effect::NotRendered,
                "{what} does not read {}",
                parameter.name
            );
        }
        // What stands in for a type may read more.
        let is_listed = |name: &&str| listed.iter().any(|parameter| parameter.name == *name);
        let more: Vec<&&str> = read.iter().filter(|name| !is_listed(name)).collect();
        assert!(more.is_empty() || !kind.instead.is_empty(), "{what} also reads {more:?}");
    }
}

#[test]
fn ranges_have_words() {
    let ranges = [Range::ALL, Range::above(0.0), Range::between(0.0, 180.0), Range::from_to(1e-6, 1e6)];
    let words = ranges.map(Range::words);
    assert_eq!(words, ["", "above 0", "above 0 and below 180", "from 1e-6 to 1e6"]);
    let words = [Range::above_to(0.0, 180.0), Range::at_least(1.0), Range::below(90.0)].map(Range::words);
    assert_eq!(words, ["above 0 and at most 180", "at least 1", "below 90"]);
    assert_eq!(
        [f64::from(1e18_f32), f64::from(0.1_f32), 0.1, -2.5].map(number),
        ["1e18", "0.1", "0.1", "-2.5"]
    );
    assert_eq!(Range::from_to(1.0, 1073741824.0).words(), "from 1 to 1073741824");
    assert!(Range::above_to(0.0, 1.0).contains(1.0) && !Range::above_to(0.0, 1.0).contains(0.0));
    assert!(Range::from_to(0.0, 1.0).contains(1.0) && !Range::between(0.0, 1.0).contains(1.0));
    assert!(!Range::ALL.contains(f64::NAN) && !Range::above(0.0).contains(f64::NAN));
}
