//! What the picture shows, in words and as JSON.

use lookat_render::{LightPlace, ShapeFacts};
use lookat_scene::glam::DVec3;
use lookat_scene::syntax::{FileId, Span, Values};
use lookat_scene::{Location, Sources};
use serde_json::{Value, json};

use crate::directive_text::DirectiveText;
use crate::report;
use crate::sight::{Sight, short};
use crate::visible::visible;

/// The most shapes and lights that are listed.
const MOST_LISTED: usize = 8;

/// Titles and texts of the lines about the view.
pub fn lines(sight: &Sight, sources: &Sources) -> Vec<(&'static str, String)> {
    let mut lines = vec![("eye", eye(sight)), ("in view", in_view(sight))];
    if !sight.facts.depths.is_empty() {
        lines.push(("depth", depth(sight)));
    }
    lines.extend(sharp(sight, sources).map(|text| ("sharp", text)));
    lines.extend(light(sight, sources).map(|text| ("light", text)));
    lines
}

fn eye(sight: &Sight) -> String {
    let DVec3 { x, y, z } = sight.facts.eye;
    let place = format!("at {} {} {}", short(x), short(y), short(z));
    match (sight.distance(), sight.facts.inside) {
        (_, Some(_)) => format!("{place}, inside a closed shape"),
        (Some(distance), _) if distance > 0.0 => {
            format!("{place}, {} from the box around all shapes", short(distance))
        }
        (Some(_), _) => format!("{place}, within the box around all shapes"),
        (None, _) => place,
    }
}

fn in_view(sight: &Sight) -> String {
    let facts = &sight.facts;
    let of_picture =
        [(facts.shape_share, "shapes"), (facts.emitter_share, "lights"), (facts.sky_share, "nothing")];
    let parts: Vec<String> = of_picture
        .iter()
        .filter(|(share, _)| *share > 0.0)
        .map(|(share, what)| format!("{} {what}", percent(*share)))
        .collect();
    parts.join(", ")
}

fn depth(sight: &Sight) -> String {
    let depths = &sight.facts.depths;
    let [least, median, most] = [0, depths.len() / 2, depths.len() - 1].map(|at| short(depths[at]));
    let center = sight.facts.center_depth.map_or("nothing".into(), short);
    format!("{least} to {most}, median {median}; at the center {center}")
}

fn sharp(sight: &Sight, sources: &Sources) -> Option<String> {
    let focus = sight.focus?;
    let [near, far] = focus.sharp();
    let far = if far.is_finite() { format!("to {}", short(far)) } else { "on".into() };
    let hyperfocal =
        focus.hyperfocal().map_or(String::new(), |it| format!("; hyperfocal distance {}", short(it)));
    let blur = |shape: &ShapeFacts| {
        let [near, _, far] = shape.depths?.map(|depth| focus.blur(depth));
        let (least, most) = (near.min(far), near.max(far));
        Some(format!("{} {} to {}", name(shape.span, sources), short(least), short(most)))
    };
    let mut seen: Vec<&ShapeFacts> = sight.facts.shapes.iter().filter(|shape| shape.share > 0.0).collect();
    seen.sort_by(|a, b| b.share.total_cmp(&a.share));
    let blurs: Vec<String> = seen.into_iter().filter_map(blur).take(MOST_LISTED).collect();
    Some(format!(
        "within a pixel from {} {far}{hyperfocal}; blur in pixels: {}",
        short(near),
        blurs.join(", ")
    ))
}

fn light(sight: &Sight, sources: &Sources) -> Option<String> {
    let mut lights: Vec<_> = sight.facts.lights.iter().collect();
    let all: f64 = lights.iter().map(|light| light.irradiance).sum();
    lights.sort_by(|a, b| b.irradiance.total_cmp(&a.irradiance));
    let share = |irradiance: f64| percent(if all > 0.0 { irradiance / all } else { 0.0 });
    let parts: Vec<String> = lights
        .iter()
        .take(MOST_LISTED)
        .map(|light| format!("{} {}", name(sight.light_place(light), sources), share(light.irradiance)))
        .collect();
    (!parts.is_empty()).then(|| format!("direct, on the surfaces in view: {}", parts.join(", ")))
}

/// What a shape or a light is and its place, such as `plymesh tree.ply (part.pbrt, line 7)`. The scene file is not named.
fn name(span: Option<Span>, sources: &Sources) -> String {
    let Some(span) = span else { return "a shape".into() };
    let Location { path, line, .. } = sources.location(span);
    let data = data_file(span, sources).map_or(String::new(), |data| format!(" {}", visible(&data)));
    let file = match span.file {
        FileId(0) => String::new(),
        _ => format!("{}, ", report::shown_path(path)),
    };
    format!("{}{data} ({file}line {line})", report::word(span, sources))
}

/// The mesh or the picture that a shape or a light names.
fn data_file(span: Span, sources: &Sources) -> Option<String> {
    let parameter = match &report::word(span, sources)[..] {
        "plymesh" => "filename",
        "infinite" | "exinfinite" | "goniometric" | "projection" => "mapname",
        _ => return None,
    };
    let directive = DirectiveText::at(sources, span)?;
    let Values::Strings(names) = &directive.param(parameter)?.values.value else { return None };
    names.first().map(|name| name.value.clone())
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".into(),
        percent if percent < 0.1 => "under 0.1 %".into(),
        percent if percent < 10.0 => format!("{percent:.1} %"),
        percent => format!("{percent:.0} %"),
    }
}

pub fn json(sight: &Sight, sources: &Sources) -> Value {
    let facts = &sight.facts;
    let line = |span: Option<Span>| span.map(|span| sources.location(span).line);
    let data = |span: Option<Span>| span.and_then(|span| data_file(span, sources));
    let file = |span: Option<Span>| span.map(|span| sources.location(span).path.display().to_string());
    let light = |light: &lookat_render::LightFacts| {
        let kind = if matches!(light.place, LightPlace::Light(_)) { "LightSource" } else { "Shape" };
        let at = sight.light_place(light);
        json!({
            "directive": kind, "file": file(at), "line": line(at), "data": data(at),
            "irradiance": light.irradiance, "reaches": light.reaches,
        })
    };
    let shape = |shape: &ShapeFacts| {
        let at = shape.span;
        let blur = sight.focus.zip(shape.depths).map(|(focus, depths)| depths.map(|depth| focus.blur(depth)));
        json!({
            "file": file(at), "line": line(at), "data": data(at),
            "share": shape.share, "depths": shape.depths, "blur": blur,
        })
    };
    let seen = facts.shapes.iter().filter(|shape| shape.share > 0.0);
    let inside = facts.inside.and_then(|it| facts.shapes[it].span);
    json!({
        "eye": facts.eye.to_array(),
        "bounds": facts.bounds.map(|corners| corners.map(|corner| corner.to_array())),
        "inside_file": file(inside), "inside_line": line(inside),
        "shares": { "shapes": facts.shape_share, "lights": facts.emitter_share, "nothing": facts.sky_share },
        "median_depth": facts.median_depth(), "center_depth": facts.center_depth,
        "depths": [facts.depths.first(), facts.depths.last()],
        "sharp": sight.focus.map(|focus| focus.sharp()),
        "hyperfocal": sight.focus.and_then(|focus| focus.hyperfocal()),
        "shapes": seen.map(shape).collect::<Vec<_>>(),
        "lights": facts.lights.iter().map(light).collect::<Vec<_>>(),
    })
}
