//! What the reader promises, whatever it reads.

use glam::Vec3;
use lookat_scene::syntax::{Diagnostic, Directive, FileId, Severity, Span, parse};
use lookat_scene::{
    Camera, Curve, CurveKind, Film, FilterKind, Integrator, Lens, Light, Loaded, Material, MaterialKind,
    Primitive, Projection, Quadric, QuadricForm, Scene, Shape, Texture, Transform,
};

/// Prints and reads again what a text says; `None` where the text has faults.
pub fn round_trip(text: &[u8]) -> Option<()> {
    let parsed = parse(FileId(0), text);
    check_spans(&parsed.diagnostics, &[text.len()]);
    if !parsed.diagnostics.is_empty() {
        return None;
    }
    let directives: Vec<Directive> = parsed.statements.into_iter().map(|s| s.directive).collect();
    check_printed(&directives);
    Some(())
}

/// Directives read back from their print as they are.
pub fn check_printed(directives: &[Directive]) {
    let text: String = directives.iter().map(|directive| format!("{directive}\n")).collect();
    let again = parse(FileId(0), text.as_bytes());
    assert_eq!(again.diagnostics, [], "{text}");
    let again: Vec<Directive> = again.statements.into_iter().map(|s| s.directive).collect();
    // Printed, because 0 and -0 are equal.
    let printed: String = again.iter().map(|directive| format!("{directive}\n")).collect();
    assert!(again == directives && printed == text, "{text}\nreads back as\n{printed}");
}

/// Places lie in their files, a scene is there when nothing is in error and what is asked for fits it, and it keeps its
/// promises.
pub fn check(loaded: &Loaded) {
    let sizes: Vec<usize> = loaded.sources.files.iter().map(|file| file.text.len()).collect();
    check_spans(&loaded.diagnostics, &sizes);
    let errors =
        loaded.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
    assert_eq!(loaded.scene.is_some(), errors == 0 && loaded.misfit.is_none(), "{errors} errors");
    loaded.scene.iter().for_each(check_scene);
}

fn check_spans(diagnostics: &[Diagnostic], sizes: &[usize]) {
    let inside = |span: Span| span.start <= span.end && span.end as usize <= sizes[span.file.0 as usize];
    for diagnostic in diagnostics {
        let fix = diagnostic.fix.iter().map(|fix| fix.span);
        assert!(diagnostic.labels.iter().map(|label| label.span).chain(fix).all(inside), "{diagnostic:?}");
        assert!(!diagnostic.labels.is_empty() && !diagnostic.message.is_empty(), "{diagnostic:?}");
    }
}

/// A scene is one that can be rendered.
pub fn check_scene(scene: &Scene) {
    check_camera(&scene.view.camera);
    check_film(&scene.view.film);
    let filter = &scene.view.filter;
    assert!(filter.radius.min_element() > 0.0 && filter.radius.is_finite(), "{filter:?}");
    assert!(
        match filter.kind {
            FilterKind::Box | FilterKind::Triangle => true,
            FilterKind::Gaussian { alpha } => alpha > 0.0 && alpha.is_finite(),
            FilterKind::Mitchell { b, c } => b.is_finite() && c.is_finite(),
            FilterKind::Sinc { tau } => tau > 0.0 && tau.is_finite(),
        },
        "{filter:?}"
    );
    assert!(scene.view.sampler.samples_per_pixel > 0);
    if let Integrator::Path { roulette_threshold, .. } = scene.view.integrator {
        assert!(roulette_threshold.is_finite());
    }
    scene.world.primitives.iter().for_each(check_primitive);
    for instance in &scene.world.instances {
        check_transform(&instance.world_from_object);
        assert!(!instance.object.primitives.is_empty());
        instance.object.primitives.iter().for_each(check_primitive);
    }
    scene.world.lights.iter().for_each(check_light);
}

fn check_transform(transform: &Transform) {
    let Transform { m, inv } = transform;
    assert!(m.is_finite() && inv.is_finite(), "{transform:?}");
    for m in [m, inv] {
        assert_eq!(m.row(3).to_array(), [0.0, 0.0, 0.0, 1.0], "{transform:?}");
        assert!((0..3).all(|axis| m.col(axis).to_array() != [0.0; 4]), "{transform:?}");
    }
}

fn check_camera(camera: &Camera) {
    check_transform(&camera.world_from_camera);
    if let Projection::Perspective { fov } = camera.projection {
        assert!(fov > 0.0 && fov < 180.0, "{fov}");
    }
    let size = camera.screen.max - camera.screen.min;
    assert!(size.is_finite() && size.x != 0.0 && size.y != 0.0, "{camera:?}");
    if let Some(Lens { radius, focal_distance }) = camera.lens {
        assert!(radius > 0.0 && radius.is_finite() && focal_distance > 0.0 && focal_distance.is_finite());
    }
}

fn check_film(film: &Film) {
    let crop = film.crop;
    assert!(crop.x0 < crop.x1 && crop.x1 <= film.resolution[0], "{film:?}");
    assert!(crop.y0 < crop.y1 && crop.y1 <= film.resolution[1], "{film:?}");
    assert!(film.scale.is_finite() && film.max_sample_luminance > 0.0, "{film:?}");
}

fn check_primitive(primitive: &Primitive) {
    match &primitive.shape {
        Shape::Quadric(quadric) => check_quadric(quadric),
        Shape::Curve(curve) => check_curve(curve),
        Shape::TriangleMesh(mesh) => {
            let count = mesh.positions.len();
            assert!(mesh.indices.len().is_multiple_of(3));
            assert!(mesh.indices.iter().all(|index| (*index as u32 as usize) < count));
            assert!(mesh.normals.is_empty() || mesh.normals.len() == count);
            assert!(mesh.tangents.is_empty() || mesh.tangents.len() == count);
            assert!(mesh.uvs.is_empty() || mesh.uvs.len() >= count);
            for values in [&mesh.positions, &mesh.normals, &mesh.tangents] {
                assert!(values.as_flattened().iter().all(|x| x.is_finite()), "{mesh:?}");
            }
            assert!(mesh.uvs.as_flattened().iter().all(|x| x.is_finite()));
        }
    }
    check_material(&primitive.material);
    if let Some(emission) = primitive.emission {
        assert!(emission.radiance.is_finite() && emission.samples > 0, "{emission:?}");
    }
}

fn check_material(material: &Material) {
    let share = |texture: &Texture<Vec3>| {
        texture.constant().is_none_or(|color| color.is_finite() && color.min_element() >= 0.0)
    };
    let is_right = match &material.kind {
        MaterialKind::Matte(m) => share(&m.kd),
        MaterialKind::Plastic(m) => share(&m.kd) && share(&m.ks),
        MaterialKind::Translucent(m) => [&m.kd, &m.ks, &m.reflect, &m.transmit].into_iter().all(share),
        MaterialKind::Glass(m) => {
            share(&m.kr) && share(&m.kt) && m.eta.constant().is_none_or(|eta| eta > 0.0)
        }
        MaterialKind::Mirror(m) => share(&m.kr),
        MaterialKind::Metal(m) => m.eta.constant().is_none_or(|eta| eta.is_finite()),
        MaterialKind::Substrate(m) => share(&m.kd) && share(&m.ks),
        MaterialKind::Uber(m) => [&m.kd, &m.ks, &m.kr, &m.kt, &m.opacity].into_iter().all(share),
        MaterialKind::Mix(m) => {
            m.materials.iter().for_each(|part| check_material(part));
            !m.materials.iter().any(|part| matches!(part.kind, MaterialKind::None))
        }
        MaterialKind::None => true,
    };
    assert!(is_right, "{material:?}");
}

fn check_curve(curve: &Curve) {
    assert!(!curve.segments.is_empty());
    assert!(curve.segments.as_flattened().iter().all(|p| p.is_finite()), "{curve:?}");
    let [first, last] = curve.widths;
    assert!(first >= 0.0 && last >= 0.0 && first + last > 0.0 && (first + last).is_finite(), "{curve:?}");
    if let CurveKind::Ribbon(normals) = &curve.kind {
        assert_eq!(normals.len(), curve.segments.len() + 1);
        assert!(normals.iter().all(|n| n.is_normalized()), "{curve:?}");
    }
    check_transform(&curve.world_from_object);
}

fn check_quadric(quadric: &Quadric) {
    let Quadric { form, phi_max, world_from_object } = *quadric;
    assert!(phi_max > 0.0 && phi_max <= std::f64::consts::TAU, "{quadric:?}");
    check_transform(&world_from_object);
    let is_right = match form {
        QuadricForm::Sphere(f) => -f.radius <= f.z_min && f.z_min < f.z_max && f.z_max <= f.radius,
        QuadricForm::Disk(f) => f.height.is_finite() && 0.0 <= f.inner_radius && f.inner_radius < f.radius,
        QuadricForm::Cylinder(f) => f.radius > 0.0 && f.z_min < f.z_max,
        QuadricForm::Cone(f) => f.radius > 0.0 && f.height > 0.0,
        QuadricForm::Paraboloid(f) => f.radius > 0.0 && f.z_min < f.z_max && f.z_max > 0.0,
        QuadricForm::Hyperboloid(f) => f.p1.z != f.p2.z && f.p2.z != 0.0,
    };
    let (low, high) = quadric.corners();
    assert!(is_right && low.is_finite() && high.is_finite() && high.x > 0.0, "{quadric:?}");
}

fn check_light(light: &Light) {
    let finite = match *light {
        Light::Point { position, intensity } => position.is_finite() && intensity.is_finite(),
        Light::Spot { position, light_from_world, intensity, cos_total_width, cos_falloff_start } => {
            position.is_finite()
                && light_from_world.is_finite()
                && intensity.is_finite()
                && cos_total_width.is_finite()
                && cos_falloff_start.is_finite()
        }
        Light::Distant { direction, radiance } => {
            (direction.length() - 1.0).abs() < 1e-9 && radiance.is_finite()
        }
        Light::Infinite { radiance, samples } => radiance.is_finite() && samples > 0,
        Light::Environment { ref map, scale, world_from_light, light_from_world, samples } => {
            map.mean().is_finite()
                && scale.is_finite()
                && world_from_light.is_finite()
                && light_from_world.is_finite()
                && samples > 0
        }
        Light::Goniometric { position, light_from_world, intensity, ref map } => {
            position.is_finite()
                && light_from_world.is_finite()
                && intensity.is_finite()
                && map.mean().is_finite()
        }
        Light::Projection { position, light_from_world, intensity, ref map, half_size } => {
            position.is_finite()
                && light_from_world.is_finite()
                && intensity.is_finite()
                && map.as_ref().is_none_or(|map| map.mean().is_finite())
                && half_size.min_element() > 0.0
                && half_size.is_finite()
        }
    };
    assert!(finite, "{light:?}");
}
