//! What media cost the rays that go through them.

use lookat_scene::{Density, Medium};
use serde::Serialize;

use super::majorants::Majorants;

/// What a medium costs the rays that go through it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MediumCost {
    /// Its name in `MakeNamedMedium`.
    pub name: Option<String>,
    /// The mean free path where the medium is densest, in units of the world. `None` for a medium that light goes through unhindered.
    pub mean_free_path: Option<f64>,
    /// `None` for a homogeneous medium, whose distances and transmittances have a closed form.
    pub grid: Option<GridCost>,
}

/// What a medium whose density is a grid costs the rays that go through it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GridCost {
    /// The number of cells along x, y and z.
    pub resolution: [usize; 3],
    /// The mean optical depth across the grid, along its axes: the number of collisions that a ray has there.
    pub optical_depth: f64,
    /// The mean optical depth of the majorants: the number of densities that are looked up for a ray across.
    pub lookups: f64,
}

impl MediumCost {
    pub(crate) fn of(medium: &Medium, majorants: Option<&Majorants>) -> Self {
        let name = medium.name.clone();
        let extinction = f64::from((medium.absorption + medium.scattering).max_element());
        let free_path = |most: f32| Some(1.0 / (extinction * f64::from(most))).filter(|it| it.is_finite());
        let (Density::Grid(grid), Some(majorants)) = (&medium.density, majorants) else {
            return MediumCost { name, mean_free_path: free_path(1.0), grid: None };
        };
        // The axes of the grid, in the world.
        let axes = grid.grid_from_world.inverse_linear();
        let length =
            [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length()).iter().sum::<f64>() / 3.0;
        let across = |densities: &[f32]| {
            let sum: f64 = densities.iter().map(|density| f64::from(*density)).sum();
            sum / densities.len() as f64 * extinction * length
        };
        MediumCost {
            name,
            mean_free_path: free_path(grid.values.iter().fold(0.0, |most: f32, density| most.max(*density))),
            grid: Some(GridCost {
                resolution: grid.resolution,
                optical_depth: across(&grid.values),
                lookups: across(&majorants.values),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::prepare::Prepared;
    use crate::testing::scene;

    use super::*;

    fn cost(medium: &str) -> MediumCost {
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"volpath\" WorldBegin
             MakeNamedMedium \"m\" {medium} MediumInterface \"m\" \"\" Material \"\" Shape \"sphere\" WorldEnd"
        ));
        crate::inspect(&Prepared::new(&scene), &scene.view).media.swap_remove(0)
    }

    #[test]
    fn a_medium_costs_what_its_coefficients_and_densities_say() {
        let even = cost("\"string type\" \"homogeneous\" \"rgb sigma_a\" [0 .1 0] \"rgb sigma_s\" [1 .4 .2]");
        assert!(even.grid.is_none() && (even.mean_free_path.unwrap() - 1.0).abs() < 1e-6);
        let none = cost("\"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0 0 0]");
        assert_eq!(none.mean_free_path, None);
        // Of 8 x 8 x 8 cells those in a half of the box, along x, have density 2. Majorants of cells beside them are 2, too.
        let densities: Vec<&str> = (0..512).map(|at| if at % 8 < 4 { "2" } else { "0" }).collect();
        let cost = cost(&format!(
            "\"string type\" \"heterogeneous\" \"rgb sigma_a\" [.5 .5 .5] \"rgb sigma_s\" [1 1 1] \"integer nx\" 8
             \"integer ny\" 8 \"integer nz\" 8 \"point p1\" [3 3 6] \"float density\" [{}]",
            densities.join(" ")
        ));
        let grid = cost.grid.unwrap();
        assert!((cost.mean_free_path.unwrap() - 1.0 / 3.0).abs() < 1e-6);
        assert_eq!(grid.resolution, [8; 3]);
        assert!((grid.optical_depth - 6.0).abs() < 1e-5 && (grid.lookups - 12.0).abs() < 1e-5, "{grid:?}");
    }
}
