//! Renders a scene file with progress, for two seconds at most, and writes the picture.
//!
//! ```text
//! cargo run --release -p lookat-render --example render_file -- SCENE PICTURE
//! ```

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use lookat_render::scene::load;
use lookat_render::{Progress, Settings, render};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (scene, picture) =
        arguments.next().zip(arguments.next()).ok_or("usage: render_file SCENE PICTURE")?;
    let loaded = load(Path::new(&scene), &|path| std::fs::read(path), &Default::default());
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
    rendered.image.write(Path::new(&picture))?;
    println!("{picture}: {} rays, complete: {}", rendered.statistics.rays, rendered.complete);
    Ok(())
}
