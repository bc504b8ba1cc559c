//! A system of lenses, and what paraxial optics says about it: the thick lens approximation, the pupil, and where the film is for a
//! distance in focus (PBR 6.4).

use crate::schema::number;

/// A system of lenses in front of a film. Lengths are in units of camera space; a lens file has millimeters, of which 1000 are a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct LensSystem {
    /// The surfaces from the scene to the film, at least one.
    pub elements: Vec<LensElement>,
    /// How samples are weighed.
    pub weighting: Weighting,
}

/// A millimeter of a lens file or of a film's diagonal in units of camera space.
pub const MILLIMETER: f64 = 1e-3;

/// A surface between two media, or the aperture stop. It is centered on the optical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensElement {
    /// The radius of its sphere, positive if the center is on the side of the film. 0 is the aperture stop, a plane.
    pub curvature_radius: f64,
    /// The distance to the next surface along the axis, at least 0. The last one has no meaning.
    pub thickness: f64,
    /// The index of refraction on the side of the film.
    pub eta: f64,
    /// The radius of the opening, above 0.
    pub aperture_radius: f64,
}

/// How the radiance that comes through the lens is weighed (parameter `simpleweighting`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Weighting {
    /// By the fourth power of the cosine and the area of the exit pupil, relative to a rectangle around the pupil seen from the middle of
    /// the film: the picture has nearly the brightness of other cameras (`true`, the default).
    Simple,
    /// By the exposure of the film: irradiance times the time that the shutter is open (`false`).
    Exposure {
        /// The time (`shutterclose` minus `shutteropen`, default 1).
        time: f64,
    },
}

/// The thick lens approximation: rays near the axis bend at two principal planes. Depths are along the axis toward the scene, from the
/// vertex of the rear surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThickLens {
    /// The effective focal length.
    pub focal_length: f64,
    /// The principal plane of light from the scene. Parallel light meets in focus one focal length behind it.
    pub rear_plane: f64,
    /// The principal plane of light from the film.
    pub front_plane: f64,
}

/// A pupil: an image of the opening that limits light from the axis. The entrance pupil is seen from the scene, the exit pupil from the
/// film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pupil {
    /// Its depth toward the scene, from the vertex of the rear surface.
    pub depth: f64,
    /// Its radius.
    pub radius: f64,
}

/// A perspective view that has the angles and the depth of field of a lens system: from the entrance pupil, with a thin lens there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquivalentView {
    /// The depth of the entrance pupil in camera space.
    pub depth: f64,
    /// The size of the film at distance 1 from the entrance pupil, per size of the film.
    pub scale: f64,
}

impl LensElement {
    /// True for the aperture stop, which does not refract.
    pub fn is_stop(&self) -> bool {
        self.curvature_radius == 0.0
    }

    /// How much a ray near the axis turns, per distance from the axis.
    fn power(&self, eta_before: f64) -> f64 {
        if self.is_stop() { 0.0 } else { (self.eta - eta_before) / self.curvature_radius }
    }
}

impl LensSystem {
    /// The index of refraction on the side of the scene of an element.
    pub fn eta_before(&self, element: usize) -> f64 {
        element.checked_sub(1).map_or(1.0, |before| self.elements[before].eta)
    }

    /// The distance from the vertex of the rear surface to that of the front surface.
    pub fn length(&self) -> f64 {
        self.elements.split_last().map_or(0.0, |(_, others)| others.iter().map(|it| it.thickness).sum())
    }

    /// The thick lens approximation. `None` for a lens that does not make parallel light converge.
    pub fn thick_lens(&self) -> Option<ThickLens> {
        let Paraxial { height, slope, .. } = self.ray_of_scene();
        let focal_length = -1.0 / slope;
        let rear_plane = focal_length + height / slope;
        let Paraxial { height, slope, .. } = self.ray_of_film();
        let front_plane = self.length() - height / slope - focal_length;
        let lens = ThickLens { focal_length, rear_plane, front_plane };
        let is_lens =
            focal_length > 0.0 && [focal_length, rear_plane, front_plane].iter().all(|it| it.is_finite());
        is_lens.then_some(lens)
    }

    /// A ray from the scene, parallel to the axis at height 1, behind the rear surface.
    fn ray_of_scene(&self) -> Paraxial {
        let mut ray = Paraxial { height: 1.0, slope: 0.0, eta: 1.0 };
        for (at, element) in self.elements.iter().enumerate() {
            ray.refract(element.power(ray.eta), element.eta);
            if at + 1 < self.elements.len() {
                ray.height += ray.slope * element.thickness;
            }
        }
        ray
    }

    /// A ray from the film, parallel to the axis at height 1, before the front surface. Its slope is along its own way.
    fn ray_of_film(&self) -> Paraxial {
        let last = self.elements.len() - 1;
        let ray = Paraxial { height: 1.0, slope: 0.0, eta: self.elements[last].eta };
        self.toward_scene(ray, last + 1)
    }

    /// A ray from before an element on through those that are nearer to the scene.
    fn toward_scene(&self, mut ray: Paraxial, from: usize) -> Paraxial {
        for at in (0..from).rev() {
            if at + 1 < self.elements.len() {
                ray.height += ray.slope * self.elements[at].thickness;
            }
            let eta = self.eta_before(at);
            ray.refract(self.elements[at].power(eta), eta);
        }
        ray
    }

    /// The entrance pupil for things far away.
    pub fn entrance_pupil(&self) -> Pupil {
        let (radius, stop) = self.limiting_element();
        let ray = Paraxial { height: 0.0, slope: 1.0, eta: self.eta_before(stop) };
        let Paraxial { height, slope, .. } = self.toward_scene(ray, stop);
        let depth = self.length() - height / slope;
        // Telecentric lenses have it at infinity; then any place gives nearly the same view.
        let depth = if depth.abs() < 1e3 * (self.length() + radius) { depth } else { self.length() };
        Pupil { depth, radius }
    }

    /// The exit pupil for things far away. `None` if it is at infinity.
    pub fn exit_pupil(&self) -> Option<Pupil> {
        let (radius, stop) = self.limiting_element();
        let mut ray = Paraxial { height: 0.0, slope: 1.0, eta: self.elements[stop].eta };
        for at in stop + 1..self.elements.len() {
            ray.height += ray.slope * self.elements[at - 1].thickness;
            ray.refract(self.elements[at].power(ray.eta), self.elements[at].eta);
        }
        let depth = ray.height / ray.slope;
        // The ray through the edge of the entrance pupil goes through the edge of this one.
        let edge = self.ray_of_scene();
        let pupil = Pupil { depth, radius: radius * (edge.height - edge.slope * depth).abs() };
        depth.is_finite().then_some(pupil)
    }

    /// The radius of the entrance pupil, and the number of the element that it is an image of.
    fn limiting_element(&self) -> (f64, usize) {
        let mut ray = Paraxial { height: 1.0, slope: 0.0, eta: 1.0 };
        let mut least = (f64::INFINITY, 0);
        for (at, element) in self.elements.iter().enumerate() {
            let radius = element.aperture_radius / ray.height.abs();
            if radius < least.0 {
                least = (radius, at);
            }
            ray.refract(element.power(ray.eta), element.eta);
            ray.height += ray.slope * element.thickness;
        }
        least
    }

    /// The least distance from the film that the lens can focus on.
    pub fn nearest_focus(&self) -> Option<f64> {
        let ThickLens { focal_length, rear_plane, front_plane } = self.thick_lens()?;
        Some(4.0 * focal_length + front_plane - rear_plane)
    }

    /// The distance from the film to the rear surface that focuses the thick lens on a distance from the film, as in pbrt-v3. `None` if it
    /// is too small.
    pub fn film_distance(&self, focus_distance: f64) -> Option<f64> {
        let ThickLens { focal_length, rear_plane, front_plane } = self.thick_lens()?;
        // Film to rear plane plus front plane to what is in focus.
        let both = focus_distance - front_plane + rear_plane;
        let square = both * (both - 4.0 * focal_length);
        if both <= 0.0 || square < 0.0 {
            return None;
        }
        let image = 2.0 * focal_length * both / (both + square.sqrt());
        Some(image - rear_plane).filter(|distance| *distance > 0.0 && distance.is_finite())
    }

    /// Why the lens cannot focus on a distance from the film. `None` if it can.
    pub fn refused_focus(&self, focus_distance: f64) -> Option<String> {
        if self.film_distance(focus_distance).is_some() {
            return None;
        }
        let nearest = self
            .nearest_focus()
            .map_or(String::new(), |nearest| format!("; the nearest distance is {}", round_up(nearest)));
        Some(format!("the lens cannot focus on a distance of {}{nearest}", number(focus_distance)))
    }

    /// The perspective view like this one. `None` if the lens cannot focus on this distance.
    pub fn equivalent_view(&self, focus_distance: f64) -> Option<EquivalentView> {
        let film_distance = self.film_distance(focus_distance)?;
        let ThickLens { rear_plane, front_plane, .. } = self.thick_lens()?;
        let magnification = (film_distance + rear_plane) / (focus_distance - film_distance - front_plane);
        let depth = film_distance + self.entrance_pupil().depth;
        Some(EquivalentView { depth, scale: 1.0 / (magnification * (focus_distance - depth)) })
    }

    /// The focal length divided by the diameter of the entrance pupil.
    pub fn f_number(&self) -> Option<f64> {
        Some(self.thick_lens()?.focal_length / (2.0 * self.entrance_pupil().radius))
    }

    /// True if the numbers are in the range of computation, and the lens can focus on this distance.
    pub(crate) fn is_valid(&self, focus_distance: f64) -> bool {
        let is_element = |element: &LensElement| {
            let LensElement { curvature_radius, thickness, eta, aperture_radius } = *element;
            (element.is_stop() || (1e-10..=2e6).contains(&curvature_radius.abs()))
                && (0.0..=2e6).contains(&thickness)
                && (1.0..=10.0).contains(&eta)
                && (1e-10..=2e6).contains(&aperture_radius)
        };
        let has_weights = match self.weighting {
            Weighting::Simple => true,
            Weighting::Exposure { time } => time.is_finite() && time >= 0.0,
        };
        self.elements.last().is_some_and(|last| last.eta == 1.0)
            && self.elements.len() <= 256
            && self.elements.iter().all(is_element)
            && has_weights
            && self.film_distance(focus_distance).is_some()
    }
}

/// A positive number with three digits, not below `least`.
pub(super) fn round_up(least: f64) -> String {
    let decimals = (2.0 - libm::log10(least).floor()).clamp(0.0, 12.0) as usize;
    let unit = libm::pow(10.0, -(decimals as f64));
    format!("{:.decimals$}", (least / unit).ceil() * unit)
}

/// A ray so near the axis that angles are slopes.
#[derive(Clone, Copy)]
struct Paraxial {
    height: f64,
    /// Height per distance along its way.
    slope: f64,
    eta: f64,
}

impl Paraxial {
    fn refract(&mut self, power: f64, eta: f64) {
        self.slope = (self.eta * self.slope - self.height * power) / eta;
        self.eta = eta;
    }
}
