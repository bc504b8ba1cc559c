//! Infinite lights with a picture (PBR 14.2.4), sampled where the picture is brighter than its mean.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use fearless_simd::{Simd, f32x8, f64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_image::MipMap;
use lookat_scene::Transform;
use rayon::prelude::*;

use super::lune::Lunes;
use crate::number::{LANES, V3, Vec3fx8, Vec3x8, bits, luminance, narrow, splat_f32, to_f32, vectorized};
use crate::texture::trilinear::bilinear;
use crate::warp::{angle, at_turn, longitude_latitude, sample_discrete};

/// An infinite light with a picture.
pub(super) struct Environment {
    map: Arc<MipMap<Vec3>>,
    /// Factor of the picture.
    scale: Vec3,
    world_from_light: DMat3,
    light_from_world: DMat3,
    /// The factor of volumes from light space to the world.
    growth: f64,
    table: DirectionTable,
    pub samples: u32,
}

/// Directions of the world that have been sampled.
pub(super) struct EnvironmentSample<S: Simd> {
    /// The directions, of length one.
    pub wi: Vec3x8<S>,
    /// The radiance from these directions.
    pub radiance: Vec3fx8<S>,
    /// Densities by solid angle; 0 where there is no sample.
    pub pdf: f32x8<S>,
}

impl Environment {
    pub fn new(map: &Arc<MipMap<Vec3>>, scale: Vec3, world_from_light: &Transform, samples: u32) -> Self {
        let [matrix, inverse] = [world_from_light.matrix(), world_from_light.inverse_matrix()];
        let [world_from_light, light_from_world] = [matrix, inverse].map(DMat3::from_mat4);
        Environment {
            map: map.clone(),
            scale,
            world_from_light,
            light_from_world,
            growth: world_from_light.determinant().abs(),
            table: DirectionTable::new(map, scale),
            samples,
        }
    }

    /// The radiance from directions of the world.
    #[inline(never)]
    pub fn radiance<S: Simd>(&self, simd: S, wi: Vec3x8<S>) -> Vec3fx8<S> {
        vectorized!(simd, self.shown(simd, longitude_latitude(wi.by(&self.light_from_world))))
    }

    /// The radiance from places on the picture.
    #[inline(always)]
    fn shown<S: Simd>(&self, simd: S, st: [f64x8<S>; 2]) -> Vec3fx8<S> {
        Vec3fx8::splat(simd, self.scale) * bilinear::<S, Vec3>(&self.map, st, bits(simd, 0xff))
    }

    /// Directions, about in proportion to how much brighter it is than the mean, or of the lunes.
    #[inline(never)]
    pub fn sample<S: Simd>(
        &self,
        simd: S,
        lunes: Option<&Lunes<S>>,
        [u, v]: [f64x8<S>; 2],
    ) -> EnvironmentSample<S> {
        vectorized!(simd, {
            let Some(lunes) = lunes else { return self.sample_bright(simd, [u, v]) };
            let share = self.lune_share(lunes);
            let in_lune = u.simd_lt(share);
            let rest = in_lune.select(u / share, (u - share) / (1.0 - share));
            let bright = self.sample_bright(simd, [rest, v]);
            let wi = lunes.sample([rest, v]).keep_where(in_lune, bright.wi);
            // Directions of the table keep what it says of them: rounding may take them across the border of a cell.
            let (mut radiance, mut own) = (bright.radiance, bright.pdf);
            if in_lune.any_true() {
                let evaluated = self.evaluate(simd, None, wi);
                radiance = evaluated.0.keep_where_wide(in_lune, radiance);
                own = narrow(in_lune).select(evaluated.1, own);
            }
            let is_valid = narrow(in_lune) | bright.pdf.simd_gt(0.0);
            let pdf = mixed(to_f32(share), lunes.pdf(wi), own);
            EnvironmentSample { wi, radiance, pdf: is_valid.select(pdf, splat_f32(simd, 0.0)) }
        })
    }

    #[inline(always)]
    fn sample_bright<S: Simd>(&self, simd: S, u: [f64x8<S>; 2]) -> EnvironmentSample<S> {
        if self.is_even() {
            let wi = Vec3x8::splat(simd, DVec3::Z);
            return EnvironmentSample {
                wi,
                radiance: Vec3fx8::splat(simd, Vec3::ZERO),
                pdf: splat_f32(simd, 0.0),
            };
        }
        let TableSample { d, st, pdf } = self.table.sample(simd, u);
        let in_world = d.by(&self.world_from_light);
        let (wi, is_valid) = in_world.try_normalize();
        // In light space, `wi` is `d` over that length.
        let pdf = to_f32(pdf / self.stretch(1.0 / in_world.length_squared().sqrt()));
        let pdf = narrow(is_valid).select(pdf, splat_f32(simd, 0.0));
        EnvironmentSample { wi, radiance: self.shown(simd, st), pdf }
    }

    /// The radiance from directions of length one, and the densities of [`Environment::sample`] by solid angle there.
    #[inline(never)]
    pub fn evaluate<S: Simd>(
        &self,
        simd: S,
        lunes: Option<&Lunes<S>>,
        wi: Vec3x8<S>,
    ) -> (Vec3fx8<S>, f32x8<S>) {
        vectorized!(simd, {
            let in_light = wi.by(&self.light_from_world);
            let st = longitude_latitude(in_light);
            let bright = to_f32(self.table.pdf(simd, st) / self.stretch(in_light.length_squared().sqrt()));
            let pdf = match lunes {
                Some(lunes) => mixed(to_f32(self.lune_share(lunes)), lunes.pdf(wi), bright),
                None => bright,
            };
            (self.shown(simd, st), pdf)
        })
    }

    /// The shares of lunes in the samples: those in the light which they are for.
    #[inline(always)]
    fn lune_share<S: Simd>(&self, lunes: &Lunes<S>) -> f64x8<S> {
        let share = lunes.share();
        let none = 0.0.simd_into(share.token());
        lunes.is_valid.select(share / (share + self.share_above()), none)
    }

    /// The solid angles that directions of light space cover in the world, given the lengths of the world's there.
    #[inline(always)]
    fn stretch<S: Simd>(&self, length_in_light: f64x8<S>) -> f64x8<S> {
        length_in_light * length_in_light * length_in_light * self.growth
    }

    /// True if the sky is constant or nearly so, and therefore sampled only in a lune.
    pub fn is_even(&self) -> bool {
        self.table.mean_above() <= 0.0
    }

    /// The share of its light that is brighter than the mean.
    pub fn share_above(&self) -> f64 {
        if self.is_even() { 0.0 } else { self.table.mean_above() / self.table.mean }
    }

    /// The mean luminance over all directions of light space.
    pub fn brightness(&self) -> f64 {
        self.table.mean
    }
}

/// The density where a share of all samples has the density `a`, and the others have `b`.
#[inline(always)]
fn mixed<S: Simd>(share: f32x8<S>, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    share * a + (1.0 - share) * b
}

/// A density over the sphere that is the same within each cell of a grid over longitude and latitude: in proportion to
/// what is brighter there than the mean. What is not is left to BSDF samples (Karlik et al., "MIS Compensation",
/// ACM TOG 38(6), 2019).
///
/// A cell is half a texel wide and high, so the picture is bilinear in it, its mean is the value at its middle, and no
/// value is more than four times the mean: no sample counts for more than four times its share, once it is weighed against
/// the BSDF. Of large pictures a cell is more than that.
struct DirectionTable {
    columns: usize,
    rows: usize,
    /// In each row, what is to be sampled of the luminance of the cells up to each.
    sums: Vec<f64>,
    /// The cumulative sums of rows, weighted by solid angle.
    row_sums: Vec<f64>,
    /// The cosines of the latitudes that bound the rows.
    cosines: Vec<f64>,
    /// The mean luminance over the sphere.
    pub mean: f64,
}

/// Directions that have been sampled.
struct TableSample<S: Simd> {
    /// The directions, of length one.
    pub d: Vec3x8<S>,
    /// The longitudes and latitudes of the directions, from 0 to 1.
    pub st: [f64x8<S>; 2],
    /// Densities by solid angle.
    pub pdf: f64x8<S>,
}

/// A sky that is nowhere brighter than this times its mean counts as everywhere alike: directions of the BSDF find it with a
/// relative variance of less than 0.08, so samples would add more noise than they save.
const EVEN_BRIGHTNESS: f64 = 1.08;

/// The most cells: 64 MiB.
const MOST_CELLS: usize = 1 << 23;

impl DirectionTable {
    pub fn new(map: &MipMap<Vec3>, scale: Vec3) -> Self {
        let fine = [2 * map.width(), 2 * map.height()];
        let mut merged = 1;
        while (fine[0] / merged).max(1) * (fine[1] / merged).max(1) > MOST_CELLS {
            merged *= 2;
        }
        let [columns, rows] = fine.map(|side| (side / merged).max(1));
        let mut sums = vec![0.0; columns * rows];
        sums.par_chunks_mut(columns).enumerate().for_each(|(row, sums)| {
            for (column, cell) in sums.iter_mut().enumerate() {
                *cell = cell_mean(map, scale, [column, row], [columns, rows], fine);
            }
        });
        let cosines = (0..=rows).map(|edge| libm::cos(PI * edge as f64 / rows as f64)).collect();
        let mut table = DirectionTable { columns, rows, sums, row_sums: Vec::new(), cosines, mean: 0.0 };
        let of_row = |row| table.row(row).iter().sum::<f64>() * table.cell_angle(row);
        table.mean = (0..rows).map(of_row).sum::<f64>() / (4.0 * PI);
        let brightest = table.sums.iter().copied().fold(0.0, f64::max);
        table.sum_up(if brightest > table.mean * EVEN_BRIGHTNESS { table.mean } else { brightest });
        table
    }

    /// From the luminance of the cells to the sums of what is above a level.
    fn sum_up(&mut self, level: f64) {
        let columns = self.columns;
        self.sums.par_chunks_mut(columns).for_each(|row| {
            let mut sum = 0.0;
            for cell in row {
                sum += (*cell - level).max(0.0);
                *cell = sum;
            }
        });
        let mut sum = 0.0;
        for row in 0..self.rows {
            sum += self.row(row)[columns - 1] * self.cell_angle(row);
            self.row_sums.push(sum);
        }
    }

    /// Directions; of no use if nothing is brighter than the rest.
    #[inline(always)]
    pub fn sample<S: Simd>(&self, simd: S, [u, v]: [f64x8<S>; 2]) -> TableSample<S> {
        let (rows, down) = sample_discrete(simd, [&self.row_sums; LANES], v);
        let (columns, along) = sample_discrete(simd, rows.map(|row| self.row(row)), u);
        let edge = |next: usize| -> f64x8<S> { f64x8::from_fn(simd, |lane| self.cosines[rows[lane] + next]) };
        let (top, bottom) = (edge(0), edge(1));
        let cos = top + (bottom - top) * down;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let column: f64x8<S> = f64x8::from_fn(simd, |lane| columns[lane] as f64);
        let longitude = (column + along) / self.columns as f64;
        let [x, y] = at_turn(longitude);
        TableSample {
            d: V3 { x: x * sin, y: y * sin, z: cos },
            st: [longitude, angle(sin, cos) * (1.0 / PI)],
            pdf: f64x8::from_fn(simd, |lane| self.cell_pdf(columns[lane], rows[lane])),
        }
    }

    /// Densities by solid angle of the directions at `st`, longitude and latitude from 0 to 1.
    #[inline(always)]
    pub fn pdf<S: Simd>(&self, simd: S, [s, t]: [f64x8<S>; 2]) -> f64x8<S> {
        let index = |x: f64, count: usize| ((x * count as f64) as usize).min(count - 1);
        f64x8::from_fn(simd, |lane| self.cell_pdf(index(s[lane], self.columns), index(t[lane], self.rows)))
    }

    #[inline(always)]
    fn cell_pdf(&self, column: usize, row: usize) -> f64 {
        let row = self.row(row);
        let before = if column == 0 { 0.0 } else { row[column - 1] };
        let total = self.total();
        if total > 0.0 { (row[column] - before) / total } else { 0.0 }
    }

    /// The mean of how much brighter it is than that, where it is brighter.
    pub fn mean_above(&self) -> f64 {
        self.total() / (4.0 * PI)
    }

    fn total(&self) -> f64 {
        self.row_sums[self.rows - 1]
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.sums[row * self.columns..][..self.columns]
    }

    /// The solid angle of a cell.
    fn cell_angle(&self, row: usize) -> f64 {
        (self.cosines[row] - self.cosines[row + 1]) * TAU / self.columns as f64
    }
}

/// The mean luminance of a cell: of the middles of the half texels in it.
fn cell_mean(map: &MipMap<Vec3>, scale: Vec3, cell: [usize; 2], cells: [usize; 2], fine: [usize; 2]) -> f64 {
    let [wide, high] = [fine[0] / cells[0], fine[1] / cells[1]];
    let mut sum = 0.0;
    for y in cell[1] * high..(cell[1] + 1) * high {
        for x in cell[0] * wide..(cell[0] + 1) * wide {
            let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let st = middle / DVec2::new(fine[0] as f64, fine[1] as f64);
            sum += luminance(scale * map.bilinear(st)).max(0.0);
        }
    }
    sum / (wide * high) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Domain;
    use crate::number::{Vec3fx8, bits, luminance};
    use crate::testing::baseline;
    use fearless_simd::mask32x8;
    use glam::DMat4;
    use glam::DVec2;
    use lookat_image::Wrap;
    use std::f64::consts::PI;
    use std::f64::consts::TAU;

    /// The radiance from a direction and its density.
    fn evaluated(light: &Environment, lune: Option<[DVec3; 2]>, wi: DVec3) -> (Vec3, f64) {
        baseline!(simd => {
            let lunes = lune.map(|normals| lunes(simd, normals));
            let (radiance, pdf) = light.evaluate(simd, lunes.as_ref(), Vec3x8::splat(simd, wi));
            (radiance.lane(0), f64::from(pdf[0]))
        })
    }

    /// A sample, its radiance and its density, if there is one.
    fn sampled(light: &Environment, lune: Option<[DVec3; 2]>, u: DVec2) -> Option<(DVec3, Vec3, f64)> {
        baseline!(simd => {
            let lunes = lune.map(|normals| lunes(simd, normals));
            let sample = light.sample(simd, lunes.as_ref(), [u.x.simd_into(simd), u.y.simd_into(simd)]);
            let pdf = f64::from(sample.pdf[0]);
            (pdf > 0.0).then(|| (sample.wi.lane(0), sample.radiance.lane(0), pdf))
        })
    }

    /// Between two normals.
    fn lunes<S: Simd>(simd: S, [n, ns]: [DVec3; 2]) -> Lunes<S> {
        let ([n, ns], none) =
            ([n, ns].map(|n| Vec3fx8::splat(simd, n.as_vec3())), mask32x8::splat(simd, false));
        Lunes::new(&Domain { n, ns, is_two_sided: none, is_diffuse: none }, bits(simd, 0xff)).unwrap()
    }

    /// Turns, shears and mirrors.
    fn skewed() -> Transform {
        let skew = DMat3::from_cols_array(&[0.3, 1.2, 0.0, -0.5, 0.4, 0.9, 0.8, 0.1, 0.7]);
        Transform::from_matrix(DMat4::from_mat3(skew)).expect("it has an inverse")
    }

    /// A sky with a small sun.
    fn with<R>(world_from_light: Transform, check: impl Fn(&Environment) -> R) -> R {
        let mut texels: Vec<Vec3> = (0..32 * 16).map(|i| Vec3::splat((i * 37 % 11) as f32 * 0.1)).collect();
        texels[5 * 32 + 7] = Vec3::new(300.0, 200.0, 100.0);
        let map = MipMap::new(32, 16, texels, Wrap::Repeat);
        check(&Environment::new(&Arc::new(map), Vec3::new(1.0, 0.5, 2.0), &world_from_light, 1))
    }

    fn grid(side: u32) -> impl Iterator<Item = DVec2> {
        let cell = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        (0..side * side).map(move |i| DVec2::new(cell(i % side), cell(i / side)))
    }

    fn place(d: DVec3) -> DVec2 {
        baseline!(simd => longitude_latitude(Vec3x8::splat(simd, d)).map(|x| x[0])).into()
    }

    fn on_sphere(u: DVec2) -> DVec3 {
        let z = 1.0 - 2.0 * u.y;
        DVec2::from_angle(TAU * u.x).extend(0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
    }

    #[test]
    fn the_density_has_an_integral_of_one() {
        with(skewed(), |light| {
            let sum: f64 = grid(1500).map(|u| evaluated(light, None, on_sphere(u)).1).sum();
            let integral = sum * 4.0 * PI / (1500.0 * 1500.0);
            assert!((integral - 1.0).abs() < 0.01, "{integral}");
        });
    }

    /// Chi-square: as many samples fall into each part of the sphere as the density says.
    #[test]
    fn samples_follow_the_density() {
        let part = |d: DVec3| {
            let st = place(d);
            ((st.y * 8.0) as usize).min(7) * 16 + ((st.x * 16.0) as usize).min(15)
        };
        with(skewed(), |light| {
            let (mut expected, mut found) = (vec![0.0_f64; 128], vec![0.0_f64; 128]);
            let (side, samples) = (2000, 300);
            let each = 4.0 * PI / f64::from(side * side) * f64::from(samples * samples);
            for u in grid(side) {
                let d = on_sphere(u);
                expected[part(d)] += evaluated(light, None, d).1 * each;
            }
            for u in grid(samples) {
                let (wi, _, pdf) = sampled(light, None, u).expect("it is not dark");
                found[part(wi)] += 1.0;
                // No sample of this grid is so near to the border of a cell that rounding takes it across.
                assert!((pdf / evaluated(light, None, wi).1 - 1.0).abs() <= f64::from(f32::EPSILON), "{wi}");
            }
            let chi: f64 = expected.iter().zip(&found).map(|(e, f)| (f - e).powi(2) / e.max(5.0)).sum();
            // Of 127 random degrees of freedom one in a million is beyond 215; a grid is nearer.
            assert!(chi < 215.0, "{chi}");
        });
    }

    /// No sample counts for more than four times its share: there are no fireflies. As weighed against directions that are
    /// all alike, which find what is not brighter than the mean.
    #[test]
    fn weights_are_bounded() {
        with(Transform::from_matrix(DMat4::from_rotation_y(1.0)).expect("a rotation"), |light| {
            let radiance_from = |d| evaluated(light, None, d).0;
            let shown = |d| luminance(radiance_from(d));
            let mean = grid(1500).map(|u| shown(on_sphere(u))).sum::<f64>() / (1500.0 * 1500.0);
            assert!((light.brightness() / mean - 1.0).abs() < 0.01);
            for u in grid(300) {
                let (wi, radiance, pdf) = sampled(light, None, u).expect("it is not dark");
                // What is told with the sample is what is told of its direction.
                assert!((radiance - radiance_from(wi)).abs().max_element() < 1e-3 * radiance.max_element());
                let all_alike = 1.0 / (4.0 * PI);
                assert!(shown(wi) / (pdf + all_alike) < 4.01 * 4.0 * PI * light.brightness());
            }
        });
    }

    /// With a lune the density is that of the samples too, also where the sky is everywhere alike.
    #[test]
    fn samples_in_a_lune_have_the_density_of_both() {
        let normals = [DVec3::new(0.6, 0.0, 0.8), DVec3::Z];
        let lune_pdf = |wi: DVec3| -> (f64, f64) {
            baseline!(simd => {
                let lunes = lunes(simd, normals);
                [lunes.pdf(Vec3x8::splat(simd, wi)), lunes.inside_pdf()].map(|pdf| f64::from(pdf[0])).into()
            })
        };
        // A number and a size with which sums are rounded.
        let even = MipMap::new(63, 31, vec![Vec3::splat(0.2); 63 * 31], Wrap::Repeat);
        let light = Environment::new(&Arc::new(even), Vec3::ONE, &skewed(), 1);
        assert!(light.is_even() && sampled(&light, None, DVec2::splat(0.5)).is_none());
        let share = |light: &Environment| {
            let (mut inside, side) = (0, 200);
            for u in grid(side) {
                let (wi, _, pdf) = sampled(light, Some(normals), u).unwrap();
                assert!(
                    (pdf / evaluated(light, Some(normals), wi).1 - 1.0).abs() <= f64::from(f32::EPSILON),
                    "{wi}"
                );
                inside += u32::from(lune_pdf(wi).0 > 0.0);
            }
            f64::from(inside) / f64::from(side * side)
        };
        assert_eq!(share(&light), 1.0);
        with(skewed(), |light| {
            let sum: f64 = grid(1500).map(|u| evaluated(light, Some(normals), on_sphere(u)).1).sum();
            let integral = sum * 4.0 * PI / (1500.0 * 1500.0);
            assert!((integral - 1.0).abs() < 0.01, "{integral}");
            let within = |u| lune_pdf(on_sphere(u)).0 / lune_pdf(DVec3::Z).1;
            let expected: f64 =
                grid(1500).map(|u| evaluated(light, Some(normals), on_sphere(u)).1 * within(u)).sum::<f64>()
                    * 4.0
                    * PI
                    / (1500.0 * 1500.0);
            assert!((share(light) / expected - 1.0).abs() < 0.02, "{} {expected}", share(light));
        });
    }

    #[test]
    fn places_are_those_of_pbrt() {
        assert_eq!(place(DVec3::Z), DVec2::ZERO);
        assert_eq!(place(DVec3::Y * 3.0), DVec2::new(0.25, 0.5));
        assert_eq!(place(-DVec3::Y), DVec2::new(0.75, 0.5));
        assert_eq!(place(-DVec3::Z).y, 1.0);
    }

    #[test]
    fn darkness_is_not_sampled() {
        let map = MipMap::new(4, 2, vec![Vec3::ZERO; 8], Wrap::Repeat);
        let light = Environment::new(&Arc::new(map), Vec3::ONE, &Transform::IDENTITY, 1);
        assert!(sampled(&light, None, DVec2::splat(0.5)).is_none());
        assert_eq!((evaluated(&light, None, DVec3::X).1, light.brightness()), (0.0, 0.0));
    }
}
