//! The text output: one line per part of the scene.

use lookat_image::byte_words;
use lookat_render::{Choice, Elements, SampleDimensions, Surfaces};
use lookat_scene::LightChoice;

use super::{Inspected, filter_name, integrator_name, projection_name, view};

impl Inspected<'_> {
    pub fn text(&self, name: &str) -> String {
        let mut lines = vec![
            ("film", self.film()),
            ("camera", self.camera()),
            ("integrator", self.integrator()),
            ("dimensions", self.dimensions()),
            ("shapes", self.shapes()),
            ("tree", self.tree()),
            ("materials", self.inspection.surfaces.as_ref().map_or("not used".into(), materials)),
            ("textures", self.inspection.surfaces.as_ref().map_or("not used".into(), textures)),
            ("lights", self.lights()),
            ("memory", self.memory()),
            ("arithmetic", self.arithmetic()),
            ("not used", listed(&self.not_paid_for())),
        ];
        lines.extend(view::lines(&self.sight, self.sources));
        let line = |(title, text): &(&str, String)| format!("  {title:14}{}\n", wrapped(text));
        format!("{name}\n") + &lines.iter().map(line).collect::<String>()
    }

    fn film(&self) -> String {
        let (film, samples) = (&self.scene.view.film, self.scene.view.sampler.samples_per_pixel);
        let [width, height] = film.resolution;
        let size = format!("{} x {}", film.crop.width(), film.crop.height());
        let whole = if film.crop.area() == u64::from(width) * u64::from(height) {
            String::new()
        } else {
            format!(" of {width} x {height}")
        };
        let all = thousands(film.crop.area() * u64::from(samples));
        let each = count(u64::from(samples), "sample");
        format!("{size}{whole} pixels, {each} each, {all} in total; {} filter", filter_name(self.scene))
    }

    fn camera(&self) -> String {
        let lens = match self.scene.view.camera.lens {
            Some(lens) => {
                format!("thin lens of radius {}, focused at distance {}", lens.radius, lens.focal_distance)
            }
            None => "pinhole".into(),
        };
        match projection_name(self.scene) {
            "environment" => "environment".into(),
            projection => format!("{projection}, {lens}"),
        }
    }

    fn integrator(&self) -> String {
        let surfaces = match self.inspection.depth {
            0 => "emitted light only".into(),
            1 => "at most 1 surface".into(),
            depth => format!("at most {depth} surfaces"),
        };
        format!("{}, {surfaces}", integrator_name(self.scene))
    }

    fn dimensions(&self) -> String {
        let lens = if self.inspection.has_lens { ", lens 2" } else { "" };
        let drawn = |draw: &SampleDimensions| match draw.surfaces.start {
            0 => format!("{} {}", draw.purpose, thousands(draw.count.into())),
            from => format!("{} {} from surface {} on", draw.purpose, draw.count, from + 1),
        };
        let draws = self.inspection.dimensions.iter().filter(|draw| !draw.surfaces.is_empty());
        let at_surface: Vec<String> = draws.map(drawn).collect();
        let at_surface = match at_surface[..] {
            [] => String::new(),
            _ => format!("; per bounce: {}", listed(&at_surface)),
        };
        format!("film 2{lens}{at_surface}; at most {} per sample", thousands(self.most_numbers()))
    }

    fn shapes(&self) -> String {
        let world = &self.inspection.world;
        let mut parts = elements(world);
        if world.instances > 0 {
            let objects = self.inspection.objects.iter().fold(Elements::default(), |sum, object| Elements {
                triangles: sum.triangles + object.triangles,
                quadrics: sum.quadrics + object.quadrics,
                curve_pieces: sum.curve_pieces + object.curve_pieces,
                ..sum
            });
            parts.push(format!(
                "{} of {} ({})",
                plural(world.instances as u64, "copy", "copies"),
                count(self.inspection.objects.len() as u64, "object"),
                listed(&elements(&objects)),
            ));
        }
        let holes = if self.inspection.has_cutouts { "; meshes with holes" } else { "" };
        listed(&parts) + holes
    }

    fn tree(&self) -> String {
        if !self.inspection.uses_bvh {
            return "no BVH: with so few shapes, testing each one directly is faster".into();
        }
        let tree = |of: &str, elements: &Elements| match elements.nodes {
            0 => format!("{of}a list"),
            nodes => format!("{of}{}, {} deep", count(nodes as u64, "node"), elements.depth),
        };
        let world = tree("", &self.inspection.world);
        let deepest = self.inspection.objects.iter().max_by_key(|object| object.depth);
        match deepest {
            Some(object) => format!("{world}; {}", tree("in the deepest object ", object)),
            None => world,
        }
    }

    fn lights(&self) -> String {
        let it = &self.inspection;
        let how = match it.choice {
            Choice::Unused => return "not used".into(),
            Choice::Nothing => "",
            Choice::All => "; all are sampled at each surface",
            Choice::One(LightChoice::Uniform) => "; one is chosen at each surface, with equal probabilities",
            Choice::One(LightChoice::Power) => "; one is chosen at each surface, by power",
            Choice::One(LightChoice::Spatial) => {
                "; one is chosen at each surface, by the light it sends there"
            }
        };
        let (how, but) = match it.constant_skies {
            0 => (how, ""),
            skies if skies == it.lights.len() => ("; constant, so BSDF samples find it", ""),
            _ => (how, ", except constant infinite lights, which BSDF samples find"),
        };
        format!("{}{how}{but}", tallied(&it.lights))
    }

    fn arithmetic(&self) -> String {
        let by = lookat_render::simd();
        match self.inspection.uses_bvh {
            false => format!("f64, eight samples at a time, {by}"),
            true => {
                format!("f32, eight boxes or triangles at a time; f64 decides; eight samples at a time, {by}")
            }
        }
    }

    fn memory(&self) -> String {
        let trees = self.trees().map(|tree| tree.bytes as u64).sum();
        let film = self.inspection.film_bytes;
        let mut parts = vec![format!("film {}", byte_words(film)), format!("trees {}", byte_words(trees))];
        let memory = &self.memory;
        let others = [("shapes", memory.shapes), ("instances", memory.instances), ("meshes", memory.meshes)];
        let others = others.into_iter().filter(|(_, bytes)| *bytes > 0);
        parts.extend(others.map(|(name, bytes)| format!("{name} {}", byte_words(bytes as u64))));
        if self.memory.pictures > 0 {
            let pictures = count(self.memory.pictures as u64, "picture");
            parts.push(format!("{pictures} {}", byte_words(self.memory.picture_bytes as u64)));
        }
        parts.push(format!("text {}", byte_words(self.text_bytes())));
        format!("{}; rendering needs {}", listed(&parts), byte_words(self.render_bytes))
    }
}

/// The elements, without instances.
fn elements(elements: &Elements) -> Vec<String> {
    let Elements { triangles, quadrics, curve_pieces, .. } = *elements;
    let all = [(triangles, "triangle"), (quadrics, "quadric"), (curve_pieces, "piece of curves")];
    let there = all.into_iter().filter(|(number, _)| *number > 0);
    there
        .map(|(number, name)| match name {
            "piece of curves" => plural(number as u64, name, "pieces of curves"),
            _ => count(number as u64, name),
        })
        .collect()
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

fn count(number: u64, name: &str) -> String {
    plural(number, name, &format!("{name}s"))
}

fn plural(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", thousands(number), if number == 1 { one } else { many })
}

/// A number with commas.
fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| str::from_utf8(group).ok()).collect();
    groups.join(",")
}
