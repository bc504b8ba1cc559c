//! Broken promises are found.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};

use crate::{
    Bilerp, CurveKind, Cutout, FilterKind, ImageFilter, ImageMap, Integrator, Light, Mapping, Material,
    MaterialKind, Matte, Mesh, MeshFault, Octaves, SamplerKind, Scene, Shape, Texture, Transform, Varying,
    World, load_str,
};

fn scene() -> Scene {
    let loaded = load_str(
        "Film \"image\" Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 3 Sampler \"sobol\"
        Integrator \"path\" WorldBegin LightSource \"point\" ObjectBegin \"o\" Shape \"sphere\" ObjectEnd
        ObjectInstance \"o\" Shape \"sphere\" Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 1 0] WorldEnd",
    );
    loaded.scene.expect("the scene is right")
}

#[test]
fn meshes_are_checked_when_they_are_made() {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = |indices: &[i32]| Mesh::new(positions.clone(), indices.to_vec());
    assert_eq!(mesh(&[0, 1]), Err(MeshFault::OddIndices));
    assert_eq!(mesh(&[0, 1, 3]), Err(MeshFault::IndexOutOfRange));
    assert_eq!(mesh(&[0, 1, -1]), Err(MeshFault::IndexOutOfRange));
    for number in [f64::NAN, 1e200] {
        assert_eq!(Mesh::new(vec![[number; 3]], vec![]), Err(MeshFault::NotFinite));
    }
    let whole = mesh(&[0, 1, 2]).unwrap();
    assert_eq!(whole.clone().with_normals(vec![[0.0; 3]]), Err(MeshFault::WrongLength));
    assert_eq!(whole.clone().with_uvs(vec![[f64::INFINITY; 2]; 3]), Err(MeshFault::NotFinite));
    assert_eq!(whole.with_tangents(vec![[1.0, 0.0, 0.0]; 3]).unwrap().tangents().len(), 3);
}

const PLAIN: Mapping = Mapping::Uv { scale: DVec2::ONE, offset: DVec2::ZERO };

/// Gives the first shape a color that varies.
fn set_color(world: &mut World, color: Varying<Vec3>) {
    let matte = Matte { kd: Texture::varying(color), sigma: Texture::Constant(0.0) };
    world.primitives[0].material = Arc::new(Material::new(MaterialKind::Matte(matte), None));
}

/// Each change breaks one promise, which is named.
#[test]
fn broken_promises_are_named() {
    assert_eq!(scene().validate(), Ok(()));
    type Change = fn(&mut Scene, &mut World);
    let changes: [(&str, Change); 22] = [
        ("view.camera.world_from_camera", |scene, _| {
            scene.view.camera.world_from_camera = Transform::translate(DVec3::NAN);
        }),
        ("view.camera", |scene, _| scene.view.camera.lens.as_mut().unwrap().radius = 0.0),
        ("view.film", |scene, _| scene.view.film.crop.x1 = 100_000),
        ("view.filter", |scene, _| scene.view.filter.radius.x = f64::NAN),
        ("view.filter", |scene, _| scene.view.filter.kind = FilterKind::Sinc { tau: 1e-12 }),
        ("view.sampler", |scene, _| scene.view.sampler.samples_per_pixel = 0),
        ("view.sampler", |scene, _| {
            scene.view.sampler.kind = SamplerKind::Stratified { cells: [0, 1], jitter: true };
        }),
        ("view.integrator", |scene, _| {
            scene.view.integrator = Integrator::AmbientOcclusion { cosine: true, samples: 0 };
        }),
        ("world.primitives[0].material", |_, world| {
            let matte = Matte { kd: Texture::Constant(Vec3::ONE), sigma: Texture::Constant(f64::NAN) };
            world.primitives[0].material = Arc::new(Material::new(MaterialKind::Matte(matte), None));
        }),
        ("world.primitives[1].shape", |_, world| {
            let Shape::Curve(curve) = &mut world.primitives[1].shape else { panic!() };
            Arc::make_mut(curve).kind = CurveKind::Ribbon(vec![DVec3::Z]);
        }),
        ("world.primitives[1].shape", |_, world| {
            let Shape::Curve(curve) = &mut world.primitives[1].shape else { panic!() };
            Arc::make_mut(curve).segments.clear();
        }),
        ("world.primitives[0].shape", |_, world| {
            let Shape::Quadric(quadric) = &mut world.primitives[0].shape else { panic!() };
            quadric.phi_max = 7.0;
        }),
        ("world.primitives[0].material", |_, world| {
            let kd = Texture::Constant(Vec3::NEG_ONE);
            let matte = Matte { kd, sigma: Texture::Constant(0.0) };
            world.primitives[0].material = Arc::new(Material::new(MaterialKind::Matte(matte), None));
        }),
        ("world.instances[0]", |_, world| {
            let small = Transform::scale(DVec3::splat(1e-200)).unwrap();
            world.instances[0].world_from_object = small * small;
        }),
        ("world.primitives[0].material", |_, world| {
            set_color(world, Varying::Bilerp(Bilerp { mapping: PLAIN, corners: [[Vec3::NAN; 2]; 2] }));
        }),
        ("world.primitives[0].material", |_, world| {
            set_color(world, Varying::Uv(Mapping::Uv { scale: DVec2::NAN, offset: DVec2::ZERO }));
        }),
        ("world.primitives[0].material", |_, world| {
            let amount = Texture::Constant(f64::INFINITY);
            let mix = Varying::Mix {
                textures: [Texture::Constant(Vec3::ONE), Texture::Constant(Vec3::ZERO)],
                amount,
            };
            set_color(world, Varying::Scale([Texture::Constant(Vec3::ONE), Texture::varying(mix)]));
        }),
        ("world.primitives[0].material", |_, world| {
            let octaves = Octaves { texture_from_world: Transform::IDENTITY, count: 8, roughness: f64::NAN };
            set_color(world, Varying::Fbm(octaves));
        }),
        ("world.primitives[0].material", |_, world| {
            let map = Arc::new(MipMap::new(1, 1, vec![Vec3::INFINITY], Wrap::Repeat));
            let (mapping, filter) = (PLAIN, ImageFilter::Trilinear);
            set_color(world, Varying::ImageMap(Box::new(ImageMap { map, mapping, filter })));
        }),
        ("world.primitives[0].cutout", |_, world| {
            let alpha = Some(Texture::Constant(f64::NAN));
            world.primitives[0].cutout = Some(Cutout { alpha, shadow_alpha: None });
        }),
        ("world.instances[0]", |_, world| {
            Arc::make_mut(&mut world.instances[0].object).primitives.clear();
        }),
        ("world.lights[0]", |_, world| {
            world.lights[0] = Light::Distant { direction: DVec3::ONE, radiance: Vec3::ONE };
        }),
    ];
    for (field, change) in changes {
        let mut scene = scene();
        let mut world = World::clone(&scene.world);
        change(&mut scene, &mut world);
        scene.world = Arc::new(world);
        let found: Vec<String> = scene.validate().unwrap_err().into_iter().map(|it| it.field).collect();
        assert_eq!(found, [field]);
    }
}
