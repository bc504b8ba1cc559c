//! The albedo of a sphere and of a sheet under a white sky.

use std::io;
use std::ops::ControlFlow;
use std::path::Path;

use lookat_render::{Settings, render};
use lookat_scene::{LoadOptions, load};

/// The mean color of a picture by parallel rays along z, from -1 to 1 in x and y.
fn mean_color(world: &str, file: &(dyn Fn(&Path) -> io::Result<Vec<u8>> + Sync)) -> [f64; 3] {
    let text = format!(
        r#"LookAt 0 0 -4  0 0 0  0 1 0
        Camera "orthographic"
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Sampler "sobol" "integer pixelsamples" 256
        Integrator "path" "integer maxdepth" 100
        WorldBegin
        LightSource "infinite"
        Texture "half" "spectrum" "bilerp"
            "rgb v00" [.5 .5 .5] "rgb v01" [.5 .5 .5] "rgb v10" [.5 .5 .5] "rgb v11" [.501 .501 .501]
        {world}
        WorldEnd"#
    );
    let read = |path: &Path| if path.ends_with("a.pbrt") { Ok(text.clone().into()) } else { file(path) };
    let loaded = load(Path::new("a.pbrt"), &read, &LoadOptions::default());
    let rendered = render(&loaded.scene.unwrap(), &Settings::default(), &|_| ControlFlow::Continue(()));
    let pixels = rendered.image.rgb().unwrap();
    [0, 1, 2].map(|at| pixels.iter().map(|pixel| f64::from(pixel[at])).sum::<f64>() / pixels.len() as f64)
}

/// The share of diffuse light that a sphere of a material reflects. Parallel rays meet it at all angles, by the cosine.
pub fn of_sphere(material: &str) -> [f64; 3] {
    // The sphere covers pi/4 of the picture. The sky around it is 1.
    let mean = mean_color(&format!("Material {material} Shape \"sphere\""), &no_file);
    mean.map(|mean| 1.0 - (1.0 - mean) * 4.0 / std::f64::consts::PI)
}

/// The share of light that a sheet reflects or lets through, at normal incidence.
pub fn of_sheet(material: &str) -> [f64; 3] {
    of_sheet_with(material, &no_file)
}

/// The same, with a file.
pub fn of_sheet_with(material: &str, file: &(dyn Fn(&Path) -> io::Result<Vec<u8>> + Sync)) -> [f64; 3] {
    let world = format!(
        r#"Material {material} Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
        "point P" [-2 -2 0  -2 2 0  2 2 0  2 -2 0]"#
    );
    mean_color(&world, file)
}

fn no_file(_: &Path) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::NotFound.into())
}

#[track_caller]
pub fn near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < tolerance);
    assert!(is_near, "{found:?} is not {expected:?}");
}
