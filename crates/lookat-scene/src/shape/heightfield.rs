//! `Shape "heightfield"`: heights over a grid of the unit square.

use crate::Transform;
use crate::mesh::{Mesh, finish, grid};
use crate::params::Params;

/// pbrt-v3's CreateHeightfield: `Pz` has `nv` rows along y, each with `nu` heights along x.
pub(crate) fn heightfield(params: &mut Params, world_from_object: Transform) -> Option<Mesh> {
    let size = [count(params, "nu"), count(params, "nv")];
    let Some(heights) = params.floats("Pz") else {
        params.missing(
            "Pz",
            "a heightfield needs heights",
            "add \"float Pz\" [...] with nu times nv heights",
        );
        return None;
    };
    let [nu, nv] = size.map(Option::unwrap_or_default);
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

/// The number of heights along one side.
fn count(params: &mut Params, name: &'static str) -> Option<usize> {
    let meaning = format!("the number of heights along {}", &name[1..]);
    let count = params.needed_integer(name, &meaning)?;
    if count < 2 {
        params.reject(name, format!("a heightfield needs at least 2 heights along {}", &name[1..]), None);
    }
    usize::try_from(count).ok()
}

/// The position of a point along its side, from 0 to 1.
fn share(at: usize, of: usize) -> f64 {
    at as f64 / (of - 1) as f64
}
