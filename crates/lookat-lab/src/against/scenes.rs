//! The rows of the table: scenes by what public files use.

use glam::DVec3;
use lookat_image::{Image, Window};

use super::worlds::{
    MATTE, bumps, corridor, disk, floor, lamp, mesh_light, points, room, sphere_lamps, spheres,
};
use crate::text_scene::{at, quad, sphere};

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
            "PixelFilter {}\nFilm \"image\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}\n\
             Sampler \"sobol\" \"integer pixelsamples\" {samples}\n{}",
            self.filter, self.scene
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

const FLOOR_VIEW: &str = "LookAt 0 6 -11  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 45";
/// A small part of the floor: pbrt-v3 prepares its choice of lights for each voxel that paths visit, which takes hours for all.
const CLOSE_VIEW: &str = "LookAt 0 2.5 -4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 25";
const ROOM_VIEW: &str = "LookAt 0 0 -3.9  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 38";
const INSIDE_VIEW: &str = "LookAt 0 0 -0.95  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 80";
const CORRIDOR_VIEW: &str = "LookAt 0 1.2 0.3  0 1 9  0 1 0 Camera \"perspective\" \"float fov\" 60";
const LENS_VIEW: &str = "LookAt 0 2 -8  0 1 0  0 1 0 \
     Camera \"perspective\" \"float fov\" 50 \"float lensradius\" 0.15 \"float focaldistance\" 4";

const PATH: &str = "Integrator \"path\" \"integer maxdepth\" 5";
const SHORT_PATH: &str = "Integrator \"path\" \"integer maxdepth\" 1";
const DEEP_PATH: &str = "Integrator \"path\" \"integer maxdepth\" 40";

const SKY: &str = "sky.pfm";
const TILES: &str = "tiles.pfm";

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
    [(SKY, sky), (TILES, tiles)]
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
    let mut add = |name: &str, view: &str, integrator: &str, world: String| {
        let scene = format!("{view}\n{integrator}\nWorldBegin\n{world}WorldEnd\n");
        rows.push(Row { name: name.into(), filter: BOX, scene });
    };

    let shadows = floor(MATTE) + &spheres();
    let view = |count| if count < 1_000 { [FLOOR_VIEW, PATH] } else { [CLOSE_VIEW, SHORT_PATH] };
    for count in [1, 20, 32, 40, 200, 1_000, 10_000] {
        let [view, integrator] = view(count);
        add(&format!("points-{count}"), view, integrator, shadows.clone() + &points(count));
    }
    for count in [20, 200, 1_000] {
        let [view, integrator] = view(count);
        add(&format!("sphere-lamps-{count}"), view, integrator, shadows.clone() + &sphere_lamps(count, 0.05));
    }
    for count in [10, 100, 1_000, 100_000] {
        let [view, integrator] = view(count);
        add(&format!("mesh-light-{count}"), view, integrator, shadows.clone() + &mesh_light(count));
    }
    add("corridor", CORRIDOR_VIEW, PATH, corridor());

    let ceiling_lamp = |height| lamp(DVec3::Y * height, [0.25, 0.25], [14, 12, 9]);
    let with_sphere = |material: &str| room(MATTE, material) + &ceiling_lamp(0.99);
    add("lamp-at-ceiling", ROOM_VIEW, PATH, room(MATTE, MATTE) + &ceiling_lamp(0.9999));
    add("long-lamp", FLOOR_VIEW, PATH, floor(MATTE) + &lamp(DVec3::Y * 0.3, [6.0, 0.05], [20; 3]));
    add("disk-lamp", ROOM_VIEW, PATH, room(MATTE, MATTE) + &disk(0.99));
    let sky = |parameter: &str| shadows.clone() + &format!("LightSource \"infinite\" {parameter}\n");
    add("sky-constant", FLOOR_VIEW, PATH, sky("\"rgb L\" [.6 .8 1]"));
    // The pole of the sky is up.
    let up = "AttributeBegin Rotate -90 1 0 0\nLightSource \"infinite\" \"string mapname\"";
    add("sky-picture", FLOOR_VIEW, PATH, shadows.clone() + &format!("{up} \"{SKY}\" AttributeEnd\n"));

    let over = |floor: String| floor + &lamp(DVec3::Y * 5.0, [1.5, 1.5], [20; 3]);
    for (name, material) in [
        ("mesh-matte", MATTE),
        ("mesh-metal-0.2", "Material \"metal\" \"float roughness\" 0.2\n"),
        ("mesh-metal-0.05", "Material \"metal\" \"float roughness\" 0.05\n"),
        ("mesh-glass", "Material \"glass\"\n"),
    ] {
        add(name, FLOOR_VIEW, PATH, over(floor(MATTE)) + material + &bumps());
    }
    for (name, material) in [
        (
            "plastic",
            "Material \"plastic\" \"rgb Kd\" [.1 .2 .5] \"rgb Ks\" [.4 .4 .4] \"float roughness\" 0.05\n",
        ),
        ("rough-glass", "Material \"glass\" \"float uroughness\" 0.1 \"float vroughness\" 0.1\n"),
        ("mirror", "Material \"mirror\"\n"),
    ] {
        add(name, ROOM_VIEW, PATH, with_sphere(material));
    }
    let mirror = at(DVec3::new(0.45, -0.65, 0.3), &format!("Material \"mirror\" {}", sphere(0.35)));
    let whitted = "Integrator \"whitted\" \"integer maxdepth\" 5";
    add("whitted", ROOM_VIEW, whitted, with_sphere("Material \"glass\"\n") + &mirror);
    let second = lamp(DVec3::new(0.5, 0.8, 0.0), [0.1, 0.1], [10, 20, 30]);
    let directlighting = "Integrator \"directlighting\"";
    add("directlighting", ROOM_VIEW, directlighting, with_sphere(MATTE) + &second);
    // pbrt-v3's `sobol` has too few dimensions for each triangle of 100 quads with `directlighting`.
    for (name, integrator, count) in [
        ("whitted", whitted, 10),
        ("whitted", whitted, 100),
        ("directlighting", directlighting, 10),
        ("directlighting-one", "Integrator \"directlighting\" \"string strategy\" \"one\"", 10),
    ] {
        let world = shadows.clone() + &mesh_light(count);
        add(&format!("{name}-mesh-light-{count}"), FLOOR_VIEW, integrator, world);
    }

    for (name, texture) in [
        ("trilinear", format!("\"imagemap\" \"string filename\" \"{TILES}\" \"bool trilinear\" \"true\"")),
        ("checkerboard", "\"checkerboard\"".into()),
    ] {
        let scale = "\"float uscale\" 12 \"float vscale\" 12";
        let material =
            format!("Texture \"t\" \"color\" {texture} {scale}\nMaterial \"matte\" \"texture Kd\" \"t\"\n");
        add(&format!("texture-{name}"), FLOOR_VIEW, PATH, over(floor(&material)));
    }
    let white = "Material \"matte\" \"rgb Kd\" [.9 .9 .9]\n";
    let closed = room(white, white) + &quad(DVec3::NEG_Z, DVec3::X, DVec3::Y) + &ceiling_lamp(0.99);
    add("white-room", INSIDE_VIEW, DEEP_PATH, closed);
    add("lens-small-lamps", LENS_VIEW, PATH, shadows + &sphere_lamps(100, 0.02));
    rows
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
