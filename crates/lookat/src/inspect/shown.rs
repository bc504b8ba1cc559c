//! What the picture shows, in words and as JSON.

use lookat_render::LightPlace;
use lookat_scene::syntax::{FileId, Span, Values};
use lookat_scene::{Location, Sources};
use serde::Serialize;

use crate::readable::{percent, visible};
use crate::report;
use lookat_scene::DirectiveText;
use lookat_sight::{LightFacts, ShapeFacts, Sight, short};

/// The most shapes and lights that are listed.
const MOST_LISTED: usize = 8;

/// What the picture shows.
#[derive(Serialize)]
pub struct View {
    /// Position of the eye.
    eye: [f64; 3],
    /// Two opposite corners of the box around all shapes, or null.
    bounds: Option<[[f64; 3]; 2]>,
    /// File of the closed shape around the eye, or null.
    inside_file: Option<String>,
    /// Its line, or null.
    inside_line: Option<usize>,
    /// Shares of the picture: `shapes`, `lights` with a shape, `nothing`.
    shares: Shares,
    /// Least and largest depth in view, or null.
    depths: [Option<f64>; 2],
    /// The median depth, or null.
    median_depth: Option<f64>,
    /// Depth at the middle of the picture, or null.
    center_depth: Option<f64>,
    /// With a lens: the sharp range of depths, or null. A null depth is infinite.
    sharp: Option<[f64; 2]>,
    /// Hyperfocal distance, or null.
    hyperfocal: Option<f64>,
    /// Shapes in view.
    shapes: Vec<Shape>,
    /// All lights.
    lights: Vec<Light>,
    #[serde(skip)]
    is_inside: bool,
    /// The distance of the eye from the box around all shapes that are no lights.
    #[serde(skip)]
    distance: Option<f64>,
}

#[derive(Serialize)]
struct Shares {
    shapes: f64,
    lights: f64,
    nothing: f64,
}

/// A shape or a light in the text of the scene.
#[derive(Default, Serialize)]
struct ShownPlace {
    /// What it is and its place, such as `plymesh tree.ply (part.pbrt, line 7)`. The scene file is not named.
    #[serde(skip)]
    name: String,
    /// File of its directive, or null.
    file: Option<String>,
    /// Its line, or null.
    line: Option<usize>,
    /// Its mesh or picture file, or null.
    data: Option<String>,
}

#[derive(Serialize)]
struct Shape {
    #[serde(flatten)]
    place: ShownPlace,
    /// Its share of the picture.
    share: f64,
    /// Least, median and largest depth.
    depths: Option<[f64; 3]>,
    /// Blur at these depths, in pixels.
    blur: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct Light {
    /// `LightSource`, or `Shape` for an emissive shape.
    directive: &'static str,
    #[serde(flatten)]
    place: ShownPlace,
    /// Mean direct irradiance on the surfaces in view, as luminance.
    irradiance: f64,
    /// True if it lights a surface in view.
    reaches: bool,
}

impl View {
    pub fn new(sight: &Sight, sources: &Sources) -> View {
        let facts = &sight.facts;
        let inside = ShownPlace::new(facts.inside.and_then(|it| facts.shapes[it].span), sources);
        let light = |light: &LightFacts| Light {
            directive: if matches!(light.irradiance.light, LightPlace::Light(_)) {
                "LightSource"
            } else {
                "Shape"
            },
            place: ShownPlace::new(sight.light_place(light), sources),
            irradiance: light.irradiance.mean,
            reaches: light.irradiance.reaches,
        };
        let shape = |shape: &ShapeFacts| Shape {
            place: ShownPlace::new(shape.span, sources),
            share: shape.share,
            depths: shape.depths,
            blur: sight.focus.zip(shape.depths).map(|(focus, depths)| depths.map(|depth| focus.blur(depth))),
        };
        View {
            eye: facts.eye.to_array(),
            bounds: facts.bounds.map(|corners| corners.map(|corner| corner.to_array())),
            inside_file: inside.file,
            inside_line: inside.line,
            shares: Shares {
                shapes: facts.shape_share,
                lights: facts.emitter_share,
                nothing: facts.sky_share,
            },
            depths: [facts.depths.first(), facts.depths.last()].map(Option::<&f64>::copied),
            median_depth: facts.median_depth(),
            center_depth: facts.center_depth,
            sharp: sight.focus.map(|focus| focus.sharp()),
            hyperfocal: sight.focus.and_then(|focus| focus.hyperfocal()),
            shapes: facts.shapes.iter().filter(|shape| shape.share > 0.0).map(shape).collect(),
            lights: facts.lights.iter().map(light).collect(),
            is_inside: facts.inside.is_some(),
            distance: sight.distance(),
        }
    }

    /// Titles and texts of the lines about the view.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = vec![("eye", self.eye()), ("in view", self.in_view())];
        lines.extend(self.depth().map(|text| ("depth", text)));
        lines.extend(self.sharp().map(|text| ("sharp", text)));
        lines.extend(self.light().map(|text| ("light", text)));
        lines
    }

    fn eye(&self) -> String {
        let place = format!("at {}", self.eye.map(short).join(" "));
        match self.distance {
            _ if self.is_inside => format!("{place}, inside a closed shape"),
            Some(distance) if distance > 0.0 => {
                format!("{place}, {} from the box around all shapes", short(distance))
            }
            Some(_) => format!("{place}, within the box around all shapes"),
            None => place,
        }
    }

    fn in_view(&self) -> String {
        let Shares { shapes, lights, nothing } = self.shares;
        let parts = [(shapes, "shapes"), (lights, "lights"), (nothing, "nothing")];
        let shown = parts.iter().filter(|(share, _)| *share > 0.0);
        shown.map(|(share, what)| format!("{} {what}", percent(*share, 1))).collect::<Vec<_>>().join(", ")
    }

    fn depth(&self) -> Option<String> {
        let [least, most] = self.depths;
        let [least, median, most] = [least?, self.median_depth?, most?].map(short);
        let center = self.center_depth.map_or("nothing".into(), short);
        Some(format!("{least} to {most}, median {median}; at the center {center}"))
    }

    fn sharp(&self) -> Option<String> {
        let [near, far] = self.sharp?;
        let far = if far.is_finite() { format!("to {}", short(far)) } else { "on".into() };
        let hyperfocal =
            self.hyperfocal.map_or(String::new(), |it| format!("; hyperfocal distance {}", short(it)));
        let mut seen: Vec<&Shape> = self.shapes.iter().collect();
        seen.sort_by(|a, b| b.share.total_cmp(&a.share));
        let blur = |shape: &&Shape| {
            let [near, _, far] = shape.blur?;
            Some(format!("{} {} to {}", shape.place.name, short(near.min(far)), short(near.max(far))))
        };
        let blurs: Vec<String> = seen.iter().filter_map(blur).take(MOST_LISTED).collect();
        Some(format!(
            "within a pixel from {} {far}{hyperfocal}; blur in pixels: {}",
            short(near),
            blurs.join(", ")
        ))
    }

    fn light(&self) -> Option<String> {
        let mut lights: Vec<&Light> = self.lights.iter().collect();
        let all: f64 = lights.iter().map(|light| light.irradiance).sum();
        lights.sort_by(|a, b| b.irradiance.total_cmp(&a.irradiance));
        let share = |light: &Light| if all > 0.0 { light.irradiance / all } else { 0.0 };
        let part = |light: &&Light| format!("{} {}", light.place.name, percent(share(light), 1));
        let parts: Vec<String> = lights.iter().take(MOST_LISTED).map(part).collect();
        (!parts.is_empty()).then(|| format!("direct, on the surfaces in view: {}", parts.join(", ")))
    }
}

impl ShownPlace {
    fn new(span: Option<Span>, sources: &Sources) -> ShownPlace {
        let Some(span) = span else { return ShownPlace { name: "a shape".into(), ..ShownPlace::default() } };
        let Location { path, line, .. } = sources.location(span);
        let data = data_file(span, sources);
        let data_words = data.as_ref().map_or(String::new(), |data| format!(" {}", visible(data)));
        let file = match span.file {
            FileId(0) => String::new(),
            _ => format!("{}, ", report::shown_path(path)),
        };
        ShownPlace {
            name: format!("{}{data_words} ({file}line {line})", sources.word(span)),
            file: Some(path.display().to_string()),
            line: Some(line),
            data,
        }
    }
}

/// The mesh or the picture that a shape or a light names.
fn data_file(span: Span, sources: &Sources) -> Option<String> {
    let parameter = match &sources.word(span)[..] {
        "plymesh" => "filename",
        "infinite" | "exinfinite" | "goniometric" | "projection" => "mapname",
        _ => return None,
    };
    let directive = DirectiveText::at(sources, span)?;
    let Values::Strings(names) = &directive.param(parameter)?.values.value else { return None };
    names.first().map(|name| name.value.clone())
}
