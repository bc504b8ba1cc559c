//! Builds a scene in code: a checkered floor, a glossy ball, a lamp and a sky. Renders it and writes the picture.
//!
//! ```text
//! cargo run --release -p lookat-render --example build_scene -- PICTURE
//! ```

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use lookat_render::glam::{DVec2, DVec3, Vec3};
use lookat_render::scene::{
    Camera, Cells, Checkerboard, Emission, Film, Lens, Light, Mapping, Material, MaterialKind, Matte, Mesh,
    Plastic, Primitive, Projection, Quadric, Roughness, Sampler, SamplerKind, Scene, Shape, Texture,
    Transform, Varying, View, World,
};
use lookat_render::{Settings, render};

fn gray(value: f32) -> Texture<Vec3> {
    Texture::Constant(Vec3::splat(value))
}

/// Squares of the xz plane.
fn checkers() -> Texture<Vec3> {
    let mapping = Mapping::Planar { axes: [DVec3::X, DVec3::Z], offset: DVec2::ZERO };
    let cells = Cells::Plane { mapping, filtered: true };
    Texture::varying(Varying::Checkerboard(Checkerboard { textures: [gray(0.8), gray(0.2)], cells }))
}

fn world() -> Result<World, Box<dyn Error>> {
    let matte = |kd| Material::new(MaterialKind::Matte(Matte { kd, sigma: Texture::Constant(0.0) }), None);
    let corners = [[-9.0, -9.0], [-9.0, 9.0], [9.0, 9.0], [9.0, -9.0]].map(|[x, z]| [x, 0.0, z]);
    let floor = Mesh::new(corners.to_vec(), vec![0, 1, 2, 0, 2, 3])?;

    let roughness = Roughness { u: Texture::Constant(0.05), v: None, remap: true };
    let red = Texture::Constant(Vec3::new(0.6, 0.1, 0.05));
    let glossy = MaterialKind::Plastic(Plastic { kd: red, ks: gray(0.25), roughness });
    let ball = Quadric::sphere(1.0, Transform::translate(DVec3::Y));

    let above = DVec3::new(4.0, 5.0, -3.0);
    let spot_from_world = Transform::look_at(above, above - DVec3::Y, DVec3::Z)?;
    let lamp = Quadric::sphere(0.5, Transform::translate(DVec3::new(-2.5, 4.0, -2.0)));
    let lamp = Primitive::new(Shape::Quadric(Arc::new(lamp)), Arc::new(matte(gray(0.0))));
    Ok(World {
        primitives: vec![
            Primitive::new(Shape::TriangleMesh(Arc::new(floor)), Arc::new(matte(checkers()))),
            Primitive::new(Shape::Quadric(Arc::new(ball)), Arc::new(Material::new(glossy, None))),
            lamp.with_emission(Emission::new(Vec3::splat(40.0))),
        ],
        lights: vec![
            Light::Infinite { radiance: Vec3::new(0.15, 0.2, 0.3), samples: 1 },
            Light::Spot {
                world_from_light: spot_from_world.inverse(),
                intensity: Vec3::splat(30.0),
                cos_total_width: 0.9,
                cos_falloff_start: 0.95,
            },
        ],
        ..World::default()
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let picture = std::env::args().nth(1).ok_or("usage: build_scene PICTURE")?;
    let film = Film::new([320, 200]);
    let look_at = Transform::look_at(DVec3::new(0.0, 2.0, -7.0), DVec3::Y, DVec3::Y)?;
    let camera = Camera::new(look_at, Projection::Perspective { fov: 35.0 }, &film)
        .with_lens(Lens { radius: 0.05, focal_distance: 6.5 });
    let sampler = Sampler { kind: SamplerKind::SOBOL, samples_per_pixel: 64 };
    let scene = Scene::new(View { sampler, ..View::new(camera, film) }, world()?);
    scene.validate()?;

    let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
    rendered.image.write(Path::new(&picture))?;
    println!("{picture}: {} samples", rendered.statistics.samples);
    Ok(())
}
