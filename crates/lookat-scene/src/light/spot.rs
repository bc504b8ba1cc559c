//! `LightSource "spot"`: a point light within a cone.

use glam::{DMat3, DVec3};

use super::{FROM, INTENSITY, Light, SCALE, TO, check_placed, point_in_range, same_points, scaled};
use crate::Transform;
use crate::params::Params;
use crate::schema::{Key, Keys, Range, Unit};

const CONE_ANGLE: Key<f64> =
    Key::float("coneangle", 30.0, "the angle between the axis and the edge of the cone")
        .within(Range::above_to(0.0, 180.0))
        .unit(Unit::Degrees);
const CONE_DELTA_ANGLE: Key<f64> =
    Key::float("conedeltaangle", 5.0, "the width of the falloff inside the edge, from 0 to coneangle")
        .unit(Unit::Degrees);

pub(super) const KEYS: Keys = &[&INTENSITY, &FROM, &TO, &CONE_ANGLE, &CONE_DELTA_ANGLE, &SCALE];

/// pbrt-v3's CreateSpotLight.
pub(super) fn spot(params: &mut Params, world_from_light: Transform) -> Option<Light> {
    let intensity = scaled(params, &INTENSITY);
    let (cone, delta) = (params.take(&CONE_ANGLE), params.take(&CONE_DELTA_ANGLE));
    if params.usable() && !(0.0..=cone).contains(&delta) {
        let start = (cone - delta).abs();
        let message = match start < cone {
            true => format!(
                "conedeltaangle is out of range: the falloff starts at {start} degrees, as in pbrt-v3"
            ),
            false => {
                "conedeltaangle is out of range: the light has no falloff inside its cone, as in pbrt-v3"
                    .into()
            }
        };
        params.warn("conedeltaangle", &message, "write a conedeltaangle from 0 to coneangle");
    }
    let from = point_in_range(params, &FROM);
    let to = point_in_range(params, &TO);
    let Some(axis) = (to - from).try_normalize() else { return same_points(params) };
    // A non-uniform scale makes the choice of the frame visible, so this is pbrt's frame.
    let (x, y) = coordinate_system(axis);
    let frame = Transform::to_frame(DMat3::from_cols(x, y, axis));
    let world_from_light = world_from_light * Transform::translate(from) * frame;
    check_placed(params, world_from_light.in_range());
    Some(Light::Spot {
        world_from_light,
        intensity,
        cos_total_width: libm::cos(cone.to_radians()),
        cos_falloff_start: libm::cos((cone - delta).to_radians()),
    })
}

/// Two unit vectors that form a frame with the unit vector `v` (pbrt-v3's CoordinateSystem).
fn coordinate_system(v: DVec3) -> (DVec3, DVec3) {
    let x = if v.x.abs() > v.y.abs() { DVec3::new(-v.z, 0.0, v.x) } else { DVec3::new(0.0, v.z, -v.y) }
        .normalize();
    (x, v.cross(x))
}
