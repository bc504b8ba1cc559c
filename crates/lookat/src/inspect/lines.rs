//! The text output: one line per part of the scene.

use lookat_image::byte_words;
use lookat_render::{Elements, GridCost, MediumCost, Surfaces};

use crate::inspect::needs::{AtSurface, LensSystem, Needs};
use crate::readable::{count, grouped, plural, visible};
use lookat_sight::short;

impl Needs {
    pub fn text(&self, name: &str) -> String {
        let of_surfaces =
            |text: fn(&Surfaces) -> String| self.surfaces.as_ref().map_or("not used".into(), text);
        let lines = [
            ("film", self.film()),
            ("camera", self.camera()),
            ("integrator", self.integrator()),
            ("dimensions", self.dimensions()),
            ("shapes", self.shapes()),
            ("tree", self.tree()),
            ("materials", of_surfaces(materials)),
            ("textures", of_surfaces(textures)),
            ("media", media(&self.media)),
            ("lights", self.lights()),
            ("memory", self.memory()),
            ("arithmetic", self.arithmetic()),
            ("not used", listed(&self.unused)),
        ];
        let is_there = |(title, _): &(&str, String)| *title != "media" || !self.media.is_empty();
        let lines = lines.into_iter().filter(is_there).chain(self.view.lines());
        let line = |(title, text): (&str, String)| format!("  {title:14}{}\n", wrapped(&text));
        format!("{name}\n") + &lines.map(line).collect::<String>()
    }

    fn film(&self) -> String {
        let [width, height] = self.film.resolution;
        let [columns, rows] = self.film.crop;
        let whole = if self.film.crop == self.film.resolution {
            String::new()
        } else {
            format!(" of {width} x {height}")
        };
        let each = count(self.film.samples_per_pixel.into(), "sample");
        let (all, filter) = (grouped(self.film.samples), self.film.filter);
        format!("{columns} x {rows}{whole} pixels, {each} each, {all} in total; {filter} filter")
    }

    fn camera(&self) -> String {
        let lens = match &self.camera.lens {
            Some(lens) => {
                format!("thin lens of radius {}, focused at distance {}", lens.radius, lens.focal_distance)
            }
            None => "pinhole".into(),
        };
        if let Some(LensSystem { surfaces, focal_length, f_number, .. }) = &self.camera.lens_system {
            let focus = self.camera.lens.map_or(0.0, |lens| lens.focal_distance);
            let (surfaces, length) = (count(*surfaces as u64, "surface"), short(focal_length * 1e3));
            let f_number = short(*f_number);
            return format!(
                "realistic, a lens of {surfaces}, {length} mm f/{f_number}, focused at distance {focus}"
            );
        }
        match self.camera.projection {
            "environment" => "environment".into(),
            projection => format!("{projection}, {lens}"),
        }
    }

    fn integrator(&self) -> String {
        let surfaces = match self.integrator.depth {
            0 => "emitted light only".into(),
            depth => format!("at most {}", count(depth.into(), "surface")),
        };
        format!("{}, {surfaces}", self.integrator.name)
    }

    fn dimensions(&self) -> String {
        let lens = if self.camera.has_lens { ", lens 2" } else { "" };
        let time = if self.numbers.time > 0 { ", time 1" } else { "" };
        let drawn = |draw: &AtSurface| match draw.from {
            0 => format!("{} {}", draw.of, grouped(draw.numbers.into())),
            from => format!("{} {} from surface {} on", draw.of, draw.numbers, from + 1),
        };
        let draws = self.numbers.surface.iter().filter(|draw| draw.from < draw.to);
        let at_surface: Vec<String> = draws.map(drawn).collect();
        let at_surface = match at_surface[..] {
            [] => String::new(),
            _ => format!("; per bounce: {}", listed(&at_surface)),
        };
        format!("film 2{lens}{time}{at_surface}; at most {} per sample", grouped(self.numbers.most))
    }

    fn shapes(&self) -> String {
        let mut parts = elements(&self.world);
        if self.world.instances > 0 {
            let objects = self.objects.iter().fold(Elements::default(), |sum, object| Elements {
                triangles: sum.triangles + object.triangles,
                quadrics: sum.quadrics + object.quadrics,
                curve_pieces: sum.curve_pieces + object.curve_pieces,
                ..sum
            });
            parts.push(format!(
                "{} of {} ({})",
                plural(self.world.instances as u64, "copy", "copies"),
                count(self.objects.len() as u64, "object"),
                listed(&elements(&objects)),
            ));
        }
        let holes = if self.has_cutouts { "; meshes with holes" } else { "" };
        listed(&parts) + holes
    }

    fn tree(&self) -> String {
        if !self.asks_tree {
            return "no BVH: with so few shapes, testing each one directly is faster".into();
        }
        let tree = |of: &str, elements: &Elements| match elements.nodes {
            0 => format!("{of}a list"),
            nodes => format!("{of}{}, {} deep", count(nodes as u64, "node"), elements.depth),
        };
        let world = tree("", &self.world);
        match self.objects.iter().max_by_key(|object| object.depth) {
            Some(object) => format!("{world}; {}", tree("in the deepest object ", object)),
            None => world,
        }
    }

    fn lights(&self) -> String {
        let choice = match self.light_choice {
            "unused" => return "not used".into(),
            "all" => "; all are sampled at each surface",
            "uniform" => "; one is chosen at each surface, with equal probabilities",
            "power" => "; one is chosen at each surface, by power",
            "spatial" => "; one is chosen at each surface, by the light it sends there",
            _ => "",
        };
        let (how, but) = match self.constant_skies {
            0 => (choice, ""),
            skies if skies == self.lights.len() => ("; constant, so BSDF samples find it", ""),
            _ => (choice, ", except constant infinite lights, which BSDF samples find"),
        };
        format!("{}{how}{but}", tallied(&self.lights))
    }

    fn arithmetic(&self) -> String {
        let tree =
            if self.asks_tree { "f32, eight boxes or triangles at a time; f64 decides; " } else { "f64, " };
        format!("{tree}eight samples at a time, {}", self.simd)
    }

    fn memory(&self) -> String {
        let memory = &self.memory;
        let mut parts =
            vec![format!("film {}", byte_words(memory.film)), format!("trees {}", byte_words(memory.trees))];
        let others = [
            ("shapes", memory.shapes),
            ("instances", memory.instances),
            ("meshes", memory.meshes),
            ("media", memory.media),
            ("tables", memory.tables),
        ];
        let others = others.into_iter().filter(|(_, bytes)| *bytes > 0);
        parts.extend(others.map(|(name, bytes)| format!("{name} {}", byte_words(bytes as u64))));
        if memory.pictures > 0 {
            let pictures = count(memory.pictures as u64, "picture");
            parts.push(format!("{pictures} {}", byte_words(memory.picture_bytes as u64)));
        }
        parts.push(format!("text {}", byte_words(memory.text)));
        format!("{}; rendering needs {}", listed(&parts), byte_words(memory.render))
    }
}

/// The elements, without instances.
fn elements(elements: &Elements) -> Vec<String> {
    let Elements { triangles, quadrics, curve_pieces, .. } = *elements;
    let all = [
        (triangles, "triangle", "triangles"),
        (quadrics, "quadric", "quadrics"),
        (curve_pieces, "piece of curves", "pieces of curves"),
    ];
    let there = all.into_iter().filter(|(number, ..)| *number > 0);
    there.map(|(number, one, many)| plural(number as u64, one, many)).collect()
}

fn materials(surfaces: &Surfaces) -> String {
    let kinds = tallied(&surfaces.kinds);
    match surfaces.most_lobes {
        0 => kinds,
        most => format!("{kinds}; up to {}", count(most as u64, "lobe")),
    }
}

fn textures(surfaces: &Surfaces) -> String {
    let Surfaces { coordinates, footprints, bumps, .. } = *surfaces;
    let all = [(coordinates, "coordinates"), (footprints, "footprints"), (bumps, "bumps")];
    let needs: Vec<String> = all
        .into_iter()
        .filter(|(materials, _)| *materials > 0)
        .map(|(materials, what)| format!("{what} for {}", count(materials as u64, "material")))
        .collect();
    listed(&needs)
}

fn media(media: &[MediumCost]) -> String {
    let one = |medium: &MediumCost| {
        let path = medium
            .mean_free_path
            .map_or("no collisions".into(), |it| format!("mean free path {}", short(it)));
        let name = medium.name.as_deref().map_or("a medium".into(), |name| visible(&format!("\"{name}\"")));
        let Some(GridCost { resolution: [x, y, z], optical_depth, lookups }) = medium.grid else {
            return format!("{name} homogeneous, {path}");
        };
        let [depth, lookups] = [optical_depth, lookups].map(short);
        format!(
            "{name} a grid of {x} x {y} x {z}, {path} at its densest; across it optical depth {depth}, {lookups} densities looked up"
        )
    };
    media.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// Wraps text, indented below its first line.
fn wrapped(text: &str) -> String {
    let (mut lines, mut column) = (String::new(), 0);
    for word in text.split(' ') {
        let width = word.chars().count();
        if column > 0 && column + 1 + width > WIDTH {
            lines += "\n                ";
            column = 0;
        } else if column > 0 {
            lines.push(' ');
            column += 1;
        }
        lines += word;
        column += width;
    }
    lines
}

/// The width of the text beside the titles, in columns.
const WIDTH: usize = 84;

/// Counts equal names.
fn tallied(names: &[&str]) -> String {
    let mut tally: Vec<(&str, usize)> = Vec::new();
    for name in names {
        match tally.iter_mut().find(|(known, _)| known == name) {
            Some((_, number)) => *number += 1,
            None => tally.push((name, 1)),
        }
    }
    let texts: Vec<String> = tally.iter().map(|(name, number)| format!("{number} {name}")).collect();
    listed(&texts)
}

fn listed<T: AsRef<str>>(texts: &[T]) -> String {
    let texts: Vec<&str> = texts.iter().map(AsRef::as_ref).collect();
    if texts.is_empty() { "none".into() } else { texts.join(", ") }
}
