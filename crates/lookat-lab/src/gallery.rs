//! The pictures of the gallery, and the page that shows them.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use lookat_scene::Overrides;

use crate::pictures::{render_plainly, says, scene};

/// What to render.
#[derive(Debug, Args)]
pub struct Options {
    /// Render these scenes alone, such as gallery/glass; the page still shows all
    scenes: Vec<String>,
    /// Samples per pixel, in place of the scene's
    #[arg(long)]
    spp: Option<u32>,
    /// Folder for gallery.md and the folder of pictures
    #[arg(short, long, default_value = "docs", value_name = "DIR")]
    output: PathBuf,
}

/// The scenes, in the order of the page.
const SCENES: [&str; 12] = [
    "gallery/shallow-focus",
    "gallery/glass",
    "gallery/metal",
    "gallery/still-life",
    "gallery/instances",
    "gallery/orthographic",
    "gallery/paper",
    "gallery/ringed-planet",
    "gallery/dandelion",
    "gallery/clockwork",
    "first",
    "shapes/subdivided",
];

/// Renders the pictures, and writes the page.
pub fn run(options: &Options) {
    let pictures = options.output.join("gallery");
    std::fs::create_dir_all(&pictures).expect("the folder can be made");
    for name in SCENES {
        if options.scenes.is_empty() || options.scenes.iter().any(|only| only == name) {
            let file = pictures.join(picture(name));
            let image = render_plainly(&scene(name, &overrides(name, options.spp), &|text| text), 0, 0);
            image.write(&file).expect("the picture can be written");
            println!("{}", file.display());
        }
    }
    std::fs::write(options.output.join("gallery.md"), page()).expect("the page can be written");
}

/// What differs from the scene: scenes of the tests are small and noisy, so they are larger here, with more samples.
fn overrides(name: &str, spp: Option<u32>) -> Overrides {
    let mut overrides = Overrides { samples_per_pixel: spp, ..Overrides::default() };
    let film = scene(name, &overrides, &|text| text).view.film;
    if film.resolution[0] < 400 {
        overrides.samples_per_pixel = spp.or(Some(144));
        overrides.resolution = Some(film.resolution.map(|length| 2 * length));
    }
    overrides
}

/// The file of a picture.
fn picture(name: &str) -> String {
    format!("{}.png", name.rsplit('/').next().unwrap_or(name))
}

fn page() -> String {
    let mut text = String::from(
        "# Gallery\n\nEach picture links to its scene, which is commented. `pbrt-scenes/gallery/generate.py` writes the geometry. \
         One command\nrenders all pictures and writes this page:\n\n\
         ```sh\ncargo run --release -p lookat-lab -- gallery\n```\n",
    );
    for name in SCENES {
        let (says, file) = (says(name), picture(name));
        let _ = write!(text, "\n{says}\n\n[![{says}](gallery/{file})](../pbrt-scenes/{name}.pbrt)\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{SCENES, page, picture};
    use crate::pictures::folder;

    #[test]
    fn the_page_in_docs_shows_every_scene_of_the_gallery() {
        let docs = folder().join("../docs");
        assert_eq!(std::fs::read_to_string(docs.join("gallery.md")).unwrap(), page());
        for name in SCENES {
            assert!(docs.join("gallery").join(picture(name)).is_file(), "no picture of {name}");
        }
        for entry in std::fs::read_dir(folder().join("gallery")).unwrap() {
            let path = entry.unwrap().path();
            let name = format!("gallery/{}", path.file_stem().unwrap().to_string_lossy());
            if path.extension().is_some_and(|ending| ending == "pbrt") {
                assert!(SCENES.contains(&name.as_str()), "{name} is not in the gallery");
            }
        }
    }
}
