//! `Shape "heightfield"`: heights over a grid of the unit square.

use lookat_syntax::ParamType;

use crate::Transform;
use crate::mesh::{Mesh, finish, grid};
use crate::params::Params;
use crate::schema::{Floats, Key, Kind, Needed, Range};

const NU: Key<Needed> = Key::needed("nu", "the number of heights along u").within(Range::at_least(2.0));
const NV: Key<Needed> = Key::needed("nv", "the number of heights along v").within(Range::at_least(2.0));
const HEIGHTS: Key<Floats> =
    Key::new("Pz", ParamType::Float, Floats, "nu times nv heights, in rows along x").required();

pub(super) const KIND: Kind = Kind::new(
    "Shape",
    "heightfield",
    "flat triangles over a grid of the unit square",
    &[&[&NU, &NV, &HEIGHTS]],
);

/// pbrt-v3's CreateHeightfield: `Pz` has `nv` rows along y, each with `nu` heights along x.
pub(crate) fn heightfield(params: &mut Params, world_from_object: Transform) -> Option<Mesh> {
    let size = [&NU, &NV].map(|key| params.take(key));
    let Some(heights) = params.take(&HEIGHTS) else {
        params.missing(
            "Pz",
            "a heightfield needs heights",
            "add \"float Pz\" [...] with nu times nv heights",
        );
        return None;
    };
    let [nu, nv] = size.map(|count| count.unwrap_or_default() as usize);
    if nu.checked_mul(nv) != Some(heights.len()) && params.usable() {
        let message = format!("nu times nv is {nu} times {nv}, but there are {} heights", heights.len());
        params.reject("Pz", message, None);
    }
    if !params.usable() {
        return None;
    }
    // A position, coordinates, and the corners of two triangles.
    drop(params.reserve("Pz", (nu * nv).saturating_mul(24 + 16 + 2 * 12))?);
    let uvs: Vec<[f64; 2]> =
        (0..nv).flat_map(|v| (0..nu).map(move |u| [share(u, nu), share(v, nv)])).collect();
    let positions = uvs.iter().zip(heights).map(|([x, y], z)| [*x, *y, z]).collect();
    let mesh = Mesh { positions, indices: grid(nu, nv), uvs, ..Mesh::default() };
    finish(params, mesh, world_from_object)
}

/// The position of a point along its side, from 0 to 1.
fn share(at: usize, of: usize) -> f64 {
    at as f64 / (of - 1) as f64
}
