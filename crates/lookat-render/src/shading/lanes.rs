//! Surfaces where rays have hit them side by side, and their lobes.

use fearless_simd::{Simd, mask64x8, prelude::*};
use lookat_scene::{Scene, Shape};

use crate::bsdf::lanes::{Coat, Coats};
use crate::lanes::{LANES, bits, those};
use crate::prefetch::prefetch;
use crate::prepare::Traceable;
use crate::ray::{ElementId, Hit};
use crate::surface::Surface;
use crate::surface::lanes::{Sheet, Surfaces, Triangles, Turned};
use crate::trace::lanes::{Hits, List, Rays, Tree};

/// What elements of a list are made of.
pub(crate) struct ListShading<'s> {
    elements: Vec<(Sheet<'s>, Coat)>,
    pub is_lambert: bool,
}

impl<'s> ListShading<'s> {
    /// `None` where any has normals of its own, or other lobes than [`Coat`] has.
    pub fn new(traceable: &'s Traceable, list: &List<'s>) -> Option<Self> {
        let elements = list.elements.iter().map(|element| {
            let primitive = traceable.primitives[element.id.primitive as usize];
            Some((Sheet::new(element, primitive)?, Coat::new(&primitive.material)?))
        });
        let elements = elements.collect::<Option<Vec<_>>>()?;
        Some(ListShading { is_lambert: elements.iter().all(|(_, coat)| coat.is_lambert), elements })
    }

    /// Where the rays have hit something, and the lobes there; `None` if there is no hit.
    #[inline(always)]
    pub fn at<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        hits: &Hits<S>,
        active: mask64x8<S>,
    ) -> Option<(Surfaces<S>, Coats<S>)> {
        let mut all: Option<(Surfaces<S>, Coats<S>)> = None;
        let mut rest = hits.is_hit() & active;
        // Mostly it is one element.
        while rest.any_true() {
            let first = rest.to_bitmask().trailing_zeros() as usize;
            let is_same = hits.element.simd_eq(hits.element[first]);
            let (sheet, coat) = &self.elements[hits.element[first] as usize];
            let own = (sheet.points(simd, rays, hits), Coats::splat(simd, coat));
            all = Some(match all {
                Some(others) => (own.0.or(is_same, others.0), own.1.or(is_same, others.1)),
                None => own,
            });
            rest &= !is_same;
        }
        all
    }
}

/// What the primitives of a world with a tree are made of.
pub(crate) struct TreeShading<'s> {
    scene: &'s Traceable<'s>,
    primitives: Vec<(Turned, Coat)>,
    pub is_lambert: bool,
    pub has_normals: bool,
}

impl<'s> TreeShading<'s> {
    /// `None` where any has other lobes than [`Coat`] has.
    pub fn new(scene: &Scene, traceable: &'s Traceable<'s>) -> Option<Self> {
        let primitives = scene.primitives.iter();
        let primitives =
            primitives.map(|primitive| Some((Turned::new(primitive), Coat::new(&primitive.material)?)));
        let primitives = primitives.collect::<Option<Vec<_>>>()?;
        let has_normals =
            |shape: &Shape| matches!(shape, Shape::TriangleMesh(mesh) if !mesh.normals.is_empty());
        Some(TreeShading {
            scene: traceable,
            is_lambert: primitives.iter().all(|(_, coat)| coat.is_lambert),
            has_normals: scene.primitives.iter().any(|primitive| has_normals(&primitive.shape)),
            primitives,
        })
    }

    /// Where the rays have hit something, and the lobes there; `None` if there is no hit.
    #[inline(always)]
    pub fn at<S: Simd>(
        &self,
        simd: S,
        tree: &Tree,
        rays: &Rays<S>,
        hits: &Hits<S>,
        active: mask64x8<S>,
    ) -> Option<(Surfaces<S>, Coats<S>)> {
        let is_hit = hits.is_hit() & active;
        if !is_hit.any_true() {
            return None;
        }
        // What is far in memory is asked for before any of it is needed.
        let mut elements = [ElementId::NONE; LANES];
        for lane in those(is_hit) {
            elements[lane] = tree.element(hits.element[lane]);
            if let Shape::TriangleMesh(mesh) = &self.scene.primitives[elements[lane].primitive as usize].shape
                && !mesh.normals.is_empty()
            {
                for vertex in mesh.triangle(elements[lane].index as usize) {
                    prefetch(&mesh.normals[vertex], 0..1);
                }
            }
        }
        let (mut primitives, mut there) = ([0; LANES], 0);
        let mut triangles = Triangles::new();
        for lane in those(is_hit) {
            let (element, place) = (elements[lane], tree.place(hits.element[lane]));
            primitives[lane] = element.primitive;
            match &self.scene.primitives[element.primitive as usize].shape {
                Shape::TriangleMesh(mesh) if place != Hit::NO_PLACE => {
                    let corners = self.scene.world.triangle(place).in_order();
                    let (turned, _) = self.primitives[element.primitive as usize];
                    triangles.put(lane, corners, mesh, element.index as usize, turned);
                    there |= 1 << lane;
                }
                _ => {}
            }
        }
        let points = triangles.points(simd, hits.sides, bits(simd, there));
        let others = is_hit.to_bitmask() & !there;
        let mut surfaces = Surfaces {
            p: points.p,
            n: points.n,
            ns: points.ns,
            magnitude: points.magnitude,
            element: hits.element,
        };
        if others != 0 {
            self.put_others(tree, rays, hits, others, &mut surfaces);
        }
        Some((surfaces, self.coats(simd, &primitives, is_hit)))
    }

    /// Those that are no triangles.
    #[inline(never)]
    fn put_others<S: Simd>(
        &self,
        tree: &Tree,
        rays: &Rays<S>,
        hits: &Hits<S>,
        others: u64,
        surfaces: &mut Surfaces<S>,
    ) {
        for lane in (0..LANES).filter(|lane| others >> lane & 1 == 1) {
            surfaces.put(lane, &Surface::new(self.scene, &tree.ray(rays, lane), &tree.hit(hits, lane)));
        }
    }

    #[inline(always)]
    fn coats<S: Simd>(&self, simd: S, primitives: &[u32; LANES], is_hit: mask64x8<S>) -> Coats<S> {
        let mut rest = is_hit.to_bitmask();
        let mut all: Option<Coats<S>> = None;
        while rest != 0 {
            let first = primitives[rest.trailing_zeros() as usize];
            let mut is_same = 0;
            for (lane, primitive) in primitives.iter().enumerate() {
                is_same |= u64::from(*primitive == first) << lane;
            }
            let own = Coats::splat(simd, &self.primitives[first as usize].1);
            all = Some(match all {
                Some(others) => own.or(bits(simd, is_same), others),
                None => own,
            });
            rest &= !is_same;
        }
        match all {
            Some(all) => all,
            None => Coats::splat(simd, &self.primitives[0].1),
        }
    }
}
