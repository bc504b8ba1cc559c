//! How bright the lights of a world are.

use glam::Vec3;
use lookat_scene::{Light, World};

/// The largest numbers of a world's lights, in any channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Brightest {
    /// The most radiance of what a ray can hit.
    pub emitted: f64,
    /// The most intensity of a light that is a point, or irradiance of one that is a direction.
    pub intensity: f64,
}

impl Brightest {
    pub fn new(world: &World) -> Brightest {
        let surfaces = world.shapes().filter_map(|shape| shape.emission).map(|emission| emission.radiance);
        let mut brightest = Brightest { emitted: surfaces.map(most).fold(0.0, f64::max), intensity: 0.0 };
        for light in &world.lights {
            match light {
                Light::Infinite { radiance, .. } => {
                    brightest.emitted = brightest.emitted.max(most(*radiance))
                }
                Light::Environment { map, scale, .. } => {
                    // As if one texel had all the light.
                    let texels = (map.width() * map.height()) as f64;
                    brightest.emitted = brightest.emitted.max(most(*scale) * most(map.mean()) * texels);
                }
                Light::Point { intensity, .. }
                | Light::Spot { intensity, .. }
                | Light::Distant { radiance: intensity, .. }
                | Light::Goniometric { intensity, .. }
                | Light::Projection { intensity, .. } => {
                    brightest.intensity = brightest.intensity.max(most(*intensity));
                }
            }
        }
        brightest
    }
}

fn most(color: Vec3) -> f64 {
    f64::from(color.abs().max_element())
}
