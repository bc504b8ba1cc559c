//! A figure of a lens system, as in books on optics: light comes from the left, and the film is on the right.

use std::f64::consts::PI;
use std::fmt::Write;

use lookat_render::LensRays;
use lookat_scene::{LensElement, LensSystem, MILLIMETER, Pupil, ThickLens, View};

use lookat_sight::short;

/// Width and height of the figure, and the margin around what is drawn.
const SIZE: [f64; 2] = [1000.0, 560.0];
const MARGIN: f64 = 40.0;
/// Room for the labels above and below.
const LABELS: [f64; 2] = [70.0, 74.0];

/// The places on the film that send rays, as shares of half its diagonal, and their colors.
const BUNDLES: [(f64, &str); 3] = [(0.0, "#33658a"), (-0.6, "#3f8f5b"), (-1.0, "#c8553d")];

/// Draws the lenses of a view. `None` without a lens system.
pub fn draw(view: &View) -> Option<String> {
    let (camera, film) = (&view.camera, &view.film);
    let lenses = camera.lens_system()?;
    let focus = camera.lens?.focal_distance;
    let film_distance = lenses.film_distance(focus)?;
    let thick = lenses.thick_lens()?;
    let rays = LensRays::new(camera, film, &BUNDLES.map(|(share, _)| share))?;
    let figure = Figure::new(lenses, film_distance, &thick, 0.5 * film.diagonal * MILLIMETER);
    let mut svg = figure.start();
    svg += &figure.title(lenses, &thick, focus)?;
    for (bundle, (_, color)) in rays.iter().zip(BUNDLES) {
        svg += &figure.rays(bundle, color);
    }
    svg += &figure.axis();
    svg += &figure.glass(lenses, film_distance);
    svg += &figure.thick_lens(&thick, film_distance);
    if let Some(pupil) = lenses.exit_pupil() {
        svg += &figure.pupil(&pupil, film_distance);
    }
    svg += &figure.film(0.5 * film.diagonal * MILLIMETER);
    Some(svg + "</svg>\n")
}

/// The scale and the middle of a figure. Depths are in camera space: the film is at 0.
struct Figure {
    /// Pixels per unit of camera space.
    scale: f64,
    /// The depth at the right edge, and the height of the axis in pixels.
    right: f64,
    axis: f64,
    /// The depth at the left edge.
    left: f64,
    /// The radius of the largest opening.
    radius: f64,
}

impl Figure {
    fn new(lenses: &LensSystem, film_distance: f64, thick: &ThickLens, half_film: f64) -> Figure {
        let radius = lenses.elements.iter().map(|element| element.aperture_radius).fold(0.0, f64::max);
        let front = film_distance + lenses.length();
        let focal_point = film_distance + thick.front_plane + thick.focal_length;
        // The focal point in front is shown if it is near.
        let near = front + 0.6 * (front + radius);
        let focal_point = if focal_point < 2.0 * near { focal_point } else { 0.0 };
        let left = near.max(focal_point + 0.06 * front);
        let half_height = (1.15 * radius).max(half_film);
        let height = SIZE[1] - LABELS[0] - LABELS[1];
        let scale = ((SIZE[0] - 2.0 * MARGIN) / left).min(height / (2.0 * half_height));
        // In the middle, if height is what limits the scale.
        let right = -0.5 * ((SIZE[0] - 2.0 * MARGIN) / scale - left) - MARGIN / scale;
        Figure { scale, right, axis: LABELS[0] + height / 2.0, left, radius }
    }

    fn x(&self, depth: f64) -> f64 {
        SIZE[0] - (depth - self.right) * self.scale
    }

    fn y(&self, height: f64) -> f64 {
        self.axis - height * self.scale
    }

    fn start(&self) -> String {
        let [width, height] = SIZE;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, sans-serif\" \
            font-size=\"15\" fill=\"#333\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
        )
    }

    /// What the lens is, and a scale.
    fn title(&self, lenses: &LensSystem, thick: &ThickLens, focus: f64) -> Option<String> {
        let millimeters = short(thick.focal_length / MILLIMETER);
        let text = format!("{millimeters} mm f/{}, focused at {}", short(lenses.f_number()?), short(focus));
        let mut bar = 10.0_f64.powf((self.left / MILLIMETER / 4.0).log10().floor());
        if bar * MILLIMETER * self.scale < 60.0 {
            bar *= 2.0;
        }
        let (x, width) = (SIZE[0] - MARGIN, bar * MILLIMETER * self.scale);
        Some(format!(
            "<text x=\"{MARGIN}\" y=\"{}\" font-size=\"18\">{text}</text>\n\
            <path d=\"M{:.1} 20v8h{width:.1}v-8\" fill=\"none\" stroke=\"#333\"/>\n\
            <text x=\"{:.1}\" y=\"44\" text-anchor=\"middle\">{bar} mm</text>\n",
            SIZE[1] - 20.0,
            x - width,
            x - width / 2.0,
        ))
    }

    /// The paths of rays from the film to the left edge, or as far as there is room.
    fn rays(&self, rays: &LensRays, color: &str) -> String {
        let mut paths = String::new();
        for (points, [dz, dx]) in rays.points.iter().zip(&rays.directions) {
            let Some([z, x]) = points.last() else { continue };
            let room = ((self.axis - MARGIN / 2.0) / self.scale - x.abs()).max(0.0);
            let length = (self.left - z).min(room * dz / dx.abs());
            let end = [z + length, x + length * dx / dz];
            let all: Vec<String> = points.iter().chain([&end]).map(|[z, x]| self.point(*z, *x)).collect();
            let _ = writeln!(paths, "<polyline points=\"{}\"/>", all.join(" "));
        }
        format!(
            "<g fill=\"none\" stroke=\"{color}\" stroke-width=\"1.2\" stroke-opacity=\"0.8\">\n{paths}</g>\n"
        )
    }

    fn point(&self, depth: f64, height: f64) -> String {
        format!("{:.2},{:.2}", self.x(depth), self.y(height))
    }

    fn axis(&self) -> String {
        format!(
            "<path d=\"M{:.1} {y:.1}H{:.1}\" stroke=\"#777\" stroke-dasharray=\"12 4 2 4\"/>\n",
            self.x(self.left),
            SIZE[0] - MARGIN / 2.0,
            y = self.axis,
        )
    }

    /// The glass between surfaces, and stops.
    fn glass(&self, lenses: &LensSystem, film_distance: f64) -> String {
        let mut drawn = String::new();
        let mut depth = film_distance + lenses.length();
        for (at, element) in lenses.elements.iter().enumerate() {
            let next = lenses.elements.get(at + 1);
            if element.is_stop() {
                drawn += &self.stop(depth, element.aperture_radius);
            } else if let Some(next) = next.filter(|_| element.eta > 1.0) {
                drawn += &self.lens([(depth, element), (depth - element.thickness, next)], element.eta);
            }
            depth -= element.thickness;
        }
        drawn
    }

    /// Glass between two surfaces, given with their depths.
    fn lens(&self, surfaces: [(f64, &LensElement); 2], eta: f64) -> String {
        // Denser glass is darker.
        let opacity = (0.25 + 0.6 * (eta - 1.45)).clamp(0.2, 0.7);
        let height = surfaces[0].1.aperture_radius.max(surfaces[1].1.aperture_radius);
        let profile = surfaces.map(|(depth, element)| self.profile(depth, element, height));
        let [front, rear] =
            profile.map(|points| points.iter().map(|[z, x]| self.point(*z, *x)).collect::<Vec<_>>());
        let rear: Vec<String> = rear.into_iter().rev().collect();
        format!(
            "<polygon points=\"{} {}\" fill=\"#8ab6d6\" fill-opacity=\"{opacity:.2}\" stroke=\"#3d6680\" stroke-width=\"1.4\" \
            stroke-linejoin=\"round\"/>\n",
            front.join(" "),
            rear.join(" "),
        )
    }

    /// Points of a surface from top to bottom, with a flat rim up to a height.
    fn profile(&self, vertex: f64, element: &LensElement, height: f64) -> Vec<[f64; 2]> {
        const STEPS: i32 = 24;
        let LensElement { curvature_radius: radius, aperture_radius, .. } = *element;
        let opening = if element.is_stop() { aperture_radius } else { aperture_radius.min(radius.abs()) };
        let sag = |x: f64| match element.is_stop() {
            true => 0.0,
            false => (radius.abs() - (radius * radius - x * x).max(0.0).sqrt()) * radius.signum(),
        };
        let at = |step: i32| {
            let x = opening * (PI / 2.0 * f64::from(step) / f64::from(STEPS)).sin();
            [vertex - sag(x), x]
        };
        let rim = vertex - sag(opening);
        let curve = (-STEPS..=STEPS).rev().map(at);
        [[rim, height]].into_iter().chain(curve).chain([[rim, -height]]).collect()
    }

    fn stop(&self, depth: f64, radius: f64) -> String {
        let (x, rim) = (self.x(depth), 1.05 * self.radius.max(1.2 * radius));
        let bar = |from: f64, to: f64| format!("M{x:.1} {:.1}V{:.1}", self.y(from), self.y(to));
        format!(
            "<path d=\"{}{}\" stroke=\"#222\" stroke-width=\"4\"/>\n<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">stop</text>\n",
            bar(radius, rim),
            bar(-radius, -rim),
            self.y(rim) - 7.0,
        )
    }

    /// Principal planes and focal points.
    fn thick_lens(&self, thick: &ThickLens, film_distance: f64) -> String {
        let ThickLens { focal_length, rear_plane, front_plane } = *thick;
        let [front, rear] = [front_plane, rear_plane].map(|plane| plane + film_distance);
        let (foot, top) = (self.y(-1.15 * self.radius), self.y(1.0 * self.radius));
        let mut drawn = String::new();
        // The labels of planes that are close stand on both sides.
        let sides = if front >= rear { ["end", "start"] } else { ["start", "end"] };
        for ((name, depth), side) in [("P", front), ("P\u{2032}", rear)].into_iter().zip(sides) {
            let (x, off) = (self.x(depth), if side == "end" { -4.0 } else { 4.0 });
            let _ = writeln!(
                drawn,
                "<path d=\"M{x:.1} {top:.1}V{foot:.1}\" stroke=\"#7a4b9c\" stroke-dasharray=\"5 4\"/>\
                <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{side}\" fill=\"#7a4b9c\">{name}</text>",
                x + off,
                foot + 14.0,
            );
        }
        for (name, depth) in [("F", front + focal_length), ("F\u{2032}", rear - focal_length)] {
            if depth > self.left || self.x(depth) > SIZE[0] {
                continue;
            }
            let x = self.x(depth);
            let _ = writeln!(
                drawn,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#7a4b9c\"/>\
                <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#7a4b9c\">{name}</text>",
                self.axis + 22.0,
                y = self.axis,
            );
        }
        drawn
    }

    /// The edges of the exit pupil, if it is near.
    fn pupil(&self, pupil: &Pupil, film_distance: f64) -> String {
        let depth = film_distance + pupil.depth;
        if !(0.0..self.left).contains(&depth) {
            return String::new();
        }
        let (x, r) = (self.x(depth), pupil.radius * self.scale);
        let (top, bottom) = (self.axis - r, self.axis + r);
        format!(
            "<path d=\"M{a:.1} {top:.1}h14m-7 0v-16M{a:.1} {bottom:.1}h14m-7 0v16\" fill=\"none\" stroke=\"#b8860b\" stroke-width=\"2.5\"/>\n\
            <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#8a6508\">exit pupil</text>\n",
            bottom + 34.0,
            a = x - 7.0,
        )
    }

    fn film(&self, half: f64) -> String {
        let x = self.x(0.0);
        format!(
            "<path d=\"M{x:.1} {:.1}V{bottom:.1}\" stroke=\"#222\" stroke-width=\"4\"/>\n\
            <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">film</text>\n",
            self.y(half),
            self.y(-half) + 18.0,
            bottom = self.y(-half),
        )
    }
}
