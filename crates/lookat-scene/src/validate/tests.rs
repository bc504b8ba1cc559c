//! Broken promises are found.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};

use crate::validate::is_quadric;
use crate::{
    Bilerp, Cone, CurveKind, Cutout, Cylinder, Density, DensityGrid, DirectStrategy, Disk, Emission,
    FilterKind, Hyperboloid, ImageFilter, ImageMap, Integrator, Light, Mapping, Material, MaterialKind,
    Matte, Medium, MediumInterface, Mesh, MeshError, Mix, Octaves, Paraboloid, Quadric, QuadricForm,
    SamplerKind, Scene, Shape, Texture, Transform, Varying, World, load_str,
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
    assert_eq!(mesh(&[0, 1]), Err(MeshError::OddIndices));
    assert_eq!(mesh(&[0, 1, 3]), Err(MeshError::IndexOutOfRange));
    assert_eq!(mesh(&[0, 1, -1]), Err(MeshError::IndexOutOfRange));
    for number in [f64::NAN, 1e200] {
        assert_eq!(Mesh::new(vec![[number; 3]], vec![]), Err(MeshError::NotFinite));
    }
    let whole = mesh(&[0, 1, 2]).unwrap();
    assert_eq!(whole.clone().with_normals(vec![[0.0; 3]]), Err(MeshError::WrongLength));
    assert_eq!(whole.clone().with_normals(vec![[1e200; 3]; 3]), Err(MeshError::NotFinite));
    assert_eq!(whole.clone().with_tangents(vec![[f64::NAN; 3]; 3]), Err(MeshError::NotFinite));
    assert_eq!(whole.clone().with_uvs(vec![[f64::INFINITY; 2]; 3]), Err(MeshError::NotFinite));
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
    let changes: &[(&str, Change)] = &[
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
            Arc::make_mut(quadric).phi_max = 7.0;
        }),
        ("world.primitives[0].material", |_, world| {
            let kd = Texture::Constant(Vec3::NEG_ONE);
            let matte = Matte { kd, sigma: Texture::Constant(0.0) };
            world.primitives[0].material = Arc::new(Material::new(MaterialKind::Matte(matte), None));
        }),
        ("world.instances[0]", |_, world| {
            let small = Transform::scale(DVec3::splat(1e-200)).unwrap();
            world.instances[0].world_from_object = Arc::new(small * small);
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
            world.primitives[0].cutout = Some(Box::new(Cutout { alpha, shadow_alpha: None }));
        }),
        ("view.film", |scene, _| scene.view.film.resolution[0] = u32::MAX),
        ("view.film", |scene, _| scene.view.film.scale = -2e18),
        ("view.sampler", |scene, _| scene.view.sampler.samples_per_pixel = (1 << 30) + 1),
        ("view.integrator", |scene, _| {
            scene.view.integrator = Integrator::AmbientOcclusion { cosine: true, samples: u32::MAX };
        }),
        ("view.integrator", |scene, _| {
            let strategy = DirectStrategy::All;
            scene.view.integrator = Integrator::DirectLighting { strategy, max_depth: u32::MAX };
        }),
        ("view.camera.world_from_camera", |scene, _| {
            scene.view.camera.world_from_camera = Transform::translate(DVec3::splat(1e200));
        }),
        ("world.primitives[0].shape", |_, world| {
            let sphere = Quadric::sphere(1e30, Transform::scale(DVec3::splat(1e30)).unwrap());
            world.primitives[0].shape = Shape::Quadric(Arc::new(sphere));
        }),
        ("world.primitives[1].shape", |_, world| {
            let Shape::Curve(curve) = &mut world.primitives[1].shape else { panic!() };
            Arc::make_mut(curve).segments[0][1].y = 1e200;
        }),
        ("world.primitives[0].mirrored", |_, world| world.primitives[0].mirrored = true),
        ("world.primitives[0].emission", |_, world| {
            world.primitives[0].emission = Some(Arc::new(Emission::new(Vec3::splat(1e19))));
        }),
        ("world.primitives[0].emission", |_, world| {
            let emission = Emission { samples: u32::MAX, ..Emission::new(Vec3::ONE) };
            world.primitives[0].emission = Some(Arc::new(emission));
        }),
        // Once, although there are two instances.
        ("world.instances[0].object.primitives[0].mirrored", |_, world| {
            Arc::make_mut(&mut world.instances[0].object).primitives[0].mirrored = true;
            world.instances.push(world.instances[0].clone());
        }),
        ("world.instances[0]", |_, world| {
            Arc::make_mut(&mut world.instances[0].object).primitives.clear();
        }),
        ("world.media[0]", |_, world| {
            let density = Density::Grid(Box::new(DensityGrid {
                resolution: [2, 1, 1],
                values: vec![1.0],
                grid_from_world: Transform::IDENTITY,
            }));
            world.media.push(Medium {
                name: None,
                absorption: Vec3::ONE,
                scattering: Vec3::ONE,
                asymmetry: 0.0,
                density,
            });
        }),
        ("world.camera_medium", |_, world| world.camera_medium = Some(0)),
        ("world.primitives[0].medium", |_, world| {
            world.primitives[0].medium = Some(MediumInterface { inside: Some(3), outside: None });
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
        let found: Vec<String> = scene.validate().unwrap_err().0.into_iter().map(|it| it.field).collect();
        assert_eq!(found, [*field]);
    }
}

fn with_lights(lights: Vec<Light>) -> Scene {
    let mut scene = scene();
    Arc::make_mut(&mut scene.world).lights = lights;
    scene
}

/// A map of two texels.
fn map(texels: [f32; 2]) -> Arc<MipMap<Vec3>> {
    Arc::new(MipMap::new(2, 1, texels.map(Vec3::splat).to_vec(), Wrap::Repeat))
}

#[test]
fn lights_are_in_range() {
    let (here, one) = (Transform::IDENTITY, Vec3::ONE);
    let far = Transform::translate(DVec3::splat(1e200));
    let spot = |world_from_light, intensity| Light::Spot {
        world_from_light,
        intensity,
        cos_total_width: 0.5,
        cos_falloff_start: 0.6,
    };
    let sky = |map, samples| Light::Environment { map, scale: one, world_from_light: here, samples };
    let slide = |texels, half_size| Light::Projection {
        world_from_light: here,
        intensity: one,
        map: Some(map(texels)),
        half_size,
    };
    let lamp = |world_from_light, map| Light::Goniometric { world_from_light, intensity: one, map };
    let right = with_lights(vec![
        Light::Point { position: DVec3::splat(1e50), intensity: Vec3::splat(1e18) },
        spot(here, one),
        sky(map([0.0, 1.0]), 1 << 16),
        slide([0.0, 1.0], DVec2::ONE),
        lamp(here, map([0.0, 1.0])),
    ]);
    assert_eq!(right.validate(), Ok(()));
    let wrong = with_lights(vec![
        Light::Point { position: DVec3::splat(1e200), intensity: one },
        Light::Point { position: DVec3::ZERO, intensity: Vec3::new(0.0, f32::NAN, 0.0) },
        Light::Infinite { radiance: Vec3::splat(1e19), samples: 1 },
        spot(far, one),
        spot(here, Vec3::splat(-1e19)),
        sky(map([-0.5, 1.0]), 1),
        sky(map([0.0, 1.0]), u32::MAX),
        slide([-0.5, 1.0], DVec2::ONE),
        slide([0.0, 1.0], DVec2::ZERO),
        lamp(far, map([0.0, 1.0])),
        lamp(here, map([-0.5, 1.0])),
    ]);
    let found: Vec<String> = wrong.validate().unwrap_err().0.into_iter().map(|it| it.field).collect();
    assert_eq!(found, (0..11).map(|index| format!("world.lights[{index}]")).collect::<Vec<_>>());
}

#[test]
fn each_number_of_a_quadric_is_checked() {
    let is_right = |form| is_quadric(&Quadric { form, phi_max: 1.0, world_from_object: Transform::IDENTITY });
    let cone = |radius, height| is_right(QuadricForm::Cone(Cone { radius, height }));
    let disk =
        |height, radius, inner_radius| is_right(QuadricForm::Disk(Disk { height, radius, inner_radius }));
    let cylinder = |radius, z_min, z_max| is_right(QuadricForm::Cylinder(Cylinder { radius, z_min, z_max }));
    let paraboloid =
        |radius, z_min, z_max| is_right(QuadricForm::Paraboloid(Paraboloid { radius, z_min, z_max }));
    let hyperboloid = |p1, p2| is_right(QuadricForm::Hyperboloid(Box::new(Hyperboloid { p1, p2 })));
    let sphere = |radius| is_quadric(&Quadric::sphere(radius, Transform::IDENTITY));
    assert!(cone(1.0, 1.0) && disk(0.0, 1.0, 0.0) && cylinder(1.0, -1.0, 1.0) && paraboloid(1.0, 0.0, 1.0));
    assert!(hyperboloid(DVec3::X, DVec3::ONE) && hyperboloid(DVec3::ZERO, DVec3::ONE) && sphere(1e50));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, -1e200] {
        assert!(!cone(x, 1.0) && !cone(1.0, x) && !sphere(x), "{x}");
        assert!(!disk(x, 1.0, 0.0) && !disk(0.0, x, 0.0) && !disk(0.0, 1.0, x), "{x}");
        assert!(!cylinder(x, -1.0, 1.0) && !cylinder(1.0, x, 1.0) && !cylinder(1.0, -1.0, x), "{x}");
        assert!(!paraboloid(x, 0.0, 1.0) && !paraboloid(1.0, x, 1.0) && !paraboloid(1.0, 0.0, x), "{x}");
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let (p1, p2) = (DVec3::X + x * axis, DVec3::ONE + x * axis);
            assert!(!hyperboloid(p1, DVec3::ONE) && !hyperboloid(DVec3::X, p2), "{x} {axis}");
        }
    }
    assert!(!hyperboloid(DVec3::ZERO, DVec3::Z) && !paraboloid(1e40, 0.0, 1e-40));
}

/// Nested too deeply to be visited.
#[test]
fn mixes_and_textures_have_a_limit() {
    let nested = |levels| {
        (0..levels).fold(Arc::new(Material::DEFAULT), |part, _| {
            let mix = Mix { materials: [part.clone(), part], amount: Texture::Constant(Vec3::ONE) };
            Arc::new(Material::new(MaterialKind::Mix(mix), None))
        })
    };
    let scaled = |levels| {
        (0..levels).fold(Texture::varying(Varying::Uv(PLAIN)), |part, _| {
            Texture::varying(Varying::Scale([part.clone(), part]))
        })
    };
    let chain = |length| {
        (0..length).fold(Texture::varying(Varying::Uv(PLAIN)), |part, _| {
            Texture::varying(Varying::Scale([part, Texture::Constant(Vec3::ONE)]))
        })
    };
    let is_right = |change: &dyn Fn(&mut World)| {
        let mut scene = scene();
        change(Arc::make_mut(&mut scene.world));
        scene.validate().is_ok()
    };
    let with_material =
        |material: Arc<Material>| is_right(&|world| world.primitives[0].material = material.clone());
    assert!(with_material(nested(6)) && !with_material(nested(7)) && !with_material(nested(40)));
    let with_texture = |texture: &Texture<Vec3>| {
        let Texture::Varying(node) = texture else { panic!("it varies") };
        is_right(&|world| set_color(world, node.texture().clone()))
    };
    assert!(with_texture(&scaled(8)) && !with_texture(&scaled(10)) && !with_texture(&scaled(40)));
    assert!(with_texture(&chain(999)) && !with_texture(&chain(1000)));
    let long = chain(100_000);
    assert!(!with_texture(&long));
    // Each texture drops the next: that takes more than the stack.
    std::mem::forget(long);
}
