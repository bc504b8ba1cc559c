//! Loads a scene from text, renders it with progress, stops after two seconds, and writes the picture.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use lookat_render::{Progress, Settings, render};
use lookat_scene::{Overrides, load};

const SCENE: &str = r#"
    LookAt 0 1 -5  0 0 0  0 1 0
    Camera "perspective" "float fov" 35
    Film "image" "integer xresolution" 320 "integer yresolution" 200
    Sampler "sobol" "integer pixelsamples" 256
    Integrator "path"
    WorldBegin
      LightSource "infinite" "rgb L" [0.4 0.5 0.6]
      LightSource "distant" "point from" [2 4 -3] "rgb L" [2 2 2]
      Material "matte" "rgb Kd" [0.7 0.3 0.2]
      Shape "sphere"
      Translate 0 -1 0
      Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 0 -9 -9 0 9 9 0 9 9 0 -9]
    WorldEnd
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let loaded = load(Path::new("library.pbrt"), &|_| Ok(SCENE.into()), &Overrides::default());
    for diagnostic in &loaded.diagnostics {
        let place = loaded.sources.location(diagnostic.span());
        eprintln!("{}:{}: {}", place.line, place.column, diagnostic.message);
    }
    let scene = loaded.scene.ok_or("the scene has errors")?;

    let started = Instant::now();
    let progress = |progress: Progress| {
        if started.elapsed() > Duration::from_secs(2) {
            eprintln!("stopped at {} of {} samples", progress.done, progress.total);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    };
    let rendered = render(&scene, &Settings::default(), &progress);
    rendered.image.write(&std::env::temp_dir().join("library.png"))?;
    println!("{} rays, complete: {}", rendered.statistics.rays, rendered.complete);
    Ok(())
}
