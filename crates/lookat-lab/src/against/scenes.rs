//! The rows of the table: scenes by what public files use.

use glam::DVec3;
use lookat_image::{Image, Window};

use super::worlds::{bumps, corridor, mesh_light, points, sphere_lamps, spheres};
use crate::text_scene::{film, quad};

/// A scene of the table.
#[derive(Debug, Clone)]
pub struct Row {
    /// Its name in the table and on the command line: letters, digits, dots and hyphens. Unique.
    pub name: String,
    filter: &'static str,
    /// The scene file without `PixelFilter`, `Film` and `Sampler`.
    scene: String,
}

impl Row {
    /// The text of the scene file with so many samples per pixel.
    pub fn text(&self, samples: u32) -> String {
        format!(
            "PixelFilter {}\n{}\nSampler \"sobol\" \"integer pixelsamples\" {samples}\n{}",
            self.filter,
            film([SIDE; 2]),
            self.scene
        )
    }
}

/// Width and height of a row's picture in pixels.
pub const SIDE: u32 = 100;

const BOX: &str = "\"box\"";
const FILTERS: [(&str, &str); 5] = [
    ("box", BOX),
    ("triangle", "\"triangle\" \"float xwidth\" 1 \"float ywidth\" 1"),
    ("gaussian", "\"gaussian\""),
    ("mitchell", "\"mitchell\""),
    ("sinc", "\"sinc\""),
];
const FILTERED: [(&str, &str); 4] = [
    ("cornell-matte", include_str!("../bench/scenes/cornell-matte.pbrt")),
    ("cornell-glossy", include_str!("../bench/scenes/cornell-glossy.pbrt")),
    ("delta-lights", include_str!("../bench/scenes/delta-lights.pbrt")),
    ("thin-lens", include_str!("../bench/scenes/seed-thin-lens.pbrt")),
];

/// The other scenes. The first lines of the table explain it.
const TABLE: &str = include_str!("rows.tsv");

/// The pictures that the scenes read, by file name.
pub fn pictures() -> [(&'static str, Image); 2] {
    let picture = |color: fn(u32, u32) -> [f32; 3]| {
        let window = Window { x: 0, y: 0, width: 64, height: 32 };
        let pixels: Vec<[f32; 3]> = (0..32).flat_map(|y| (0..64).map(move |x| color(x, y))).collect();
        Image::from_rgb(window, window, &pixels)
    };
    let sky = picture(|x, y| match (x, y) {
        (14..16, 5..7) => [400.0, 350.0, 250.0],
        (_, 0..16) => [0.3, 0.5, 0.6 + y as f32 / 40.0],
        _ => [0.1, 0.08, 0.06],
    });
    let tiles = picture(|x, y| match (x / 4 + y / 4) % 3 {
        0 => [0.7, 0.2, 0.1],
        1 => [0.1, 0.3, 0.6],
        _ => [0.8, 0.8, 0.7],
    });
    [("sky.pfm", sky), ("tiles.pfm", tiles)]
}

/// All rows, in the order of the table.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (scene, text) in FILTERED {
        let kept = |line: &&str| !line.starts_with("Film") && !line.starts_with("Sampler");
        let text = text.lines().filter(kept).collect::<Vec<_>>().join("\n");
        for (name, filter) in FILTERS {
            rows.push(Row { name: format!("{scene}-{name}"), filter, scene: text.clone() });
        }
    }
    for line in TABLE.lines().filter(|line| !line.starts_with(['#', '='])) {
        let [name, view, world] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("not three fields: {line}")
        };
        let [view, world] = [view, world].map(expanded);
        let scene = format!("{view}\nWorldBegin\n{world}\nWorldEnd\n");
        rows.push(Row { name: name.into(), filter: BOX, scene });
    }
    rows
}

/// Replaces the names in braces by their texts.
fn expanded(text: &str) -> String {
    let parts = text.split(['{', '}']).enumerate();
    parts.map(|(i, part)| if i % 2 == 0 { part.into() } else { named(part) }).collect()
}

/// The text of a name with its numbers.
///
/// # Panics
///
/// If neither the table nor `worlds` has the name.
fn named(part: &str) -> String {
    let (name, numbers) = part.split_once(' ').unwrap_or((part, ""));
    let numbers: Vec<f64> = numbers
        .split_whitespace()
        .map(|number| number.parse().expect("numbers follow the name of a shape"))
        .collect();
    match (name, &numbers[..]) {
        ("spheres", []) => spheres(),
        ("corridor", []) => corridor(),
        ("bumps", []) => bumps(),
        ("points", [count]) => points(*count as usize),
        ("mesh-light", [count]) => mesh_light(*count as usize),
        ("sphere-lamps", [count, radius]) => sphere_lamps(*count as usize, *radius),
        ("quad", [_, _, _, _, _, _, _, _, _]) => {
            let [middle, across, up] = [0, 3, 6].map(|first| DVec3::from_slice(&numbers[first..]));
            quad(middle, across, up)
        }
        _ => {
            let definition =
                |line: &'static str| line.strip_prefix('=')?.strip_prefix(name)?.strip_prefix('\t');
            expanded(TABLE.lines().find_map(definition).unwrap_or_else(|| panic!("nothing is called {part}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Error, ErrorKind};
    use std::path::Path;

    use super::*;

    #[test]
    fn rows_have_names_of_their_own_and_no_errors() {
        let rows = rows();
        let names: std::collections::BTreeSet<_> = rows.iter().map(|row| &row.name).collect();
        assert_eq!(names.len(), rows.len());
        let pictures = pictures();
        for row in &rows {
            let read = |path: &Path| match pictures.iter().find(|(name, _)| path == Path::new(name)) {
                Some((_, picture)) => picture.to_bytes(path).map_err(Error::other),
                None if path == Path::new("row.pbrt") => Ok(row.text(1).into()),
                None => Err(ErrorKind::NotFound.into()),
            };
            let loaded = lookat_scene::load(Path::new("row.pbrt"), &read, &Default::default());
            assert!(loaded.scene.is_some(), "{}: {:?}", row.name, loaded.diagnostics);
        }
    }
}
