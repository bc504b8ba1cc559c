//! The tree gives each light a probability, and chooses by it.

use glam::Vec3;

use super::*;
use crate::number::{baseline, side_by_side};
use crate::testing::{levels, noise, surfaces_at};

/// Numbers without a pattern.
struct Numbers(usize);

impl Numbers {
    /// From -1 to 1.
    fn next(&mut self) -> f64 {
        self.0 += 1;
        noise(self.0, 1.37)
    }

    fn share(&mut self) -> f64 {
        self.next().abs()
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> DVec3 {
        self.vector().normalize_or(DVec3::X)
    }

    fn of(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count - 1)
    }
}

/// A light, and what it emits.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Point,
    Cone { axis: DVec3, least_cosine: f64 },
    Disk { normal: DVec3, radius: f64, two_sided: bool },
    Ball { radius: f64 },
}

#[derive(Debug, Clone, Copy)]
struct Lamp {
    center: DVec3,
    intensity: f64,
    kind: Kind,
}

impl Lamp {
    /// With a size of about `size`, as far as it has one.
    fn new(numbers: &mut Numbers, (place, size): (f64, f64)) -> Self {
        let (normal, two_sided, radius) = (numbers.direction(), numbers.next() > 0.0, size * numbers.share());
        let kind = match numbers.of(4) {
            0 => Kind::Point,
            1 => Kind::Cone { axis: normal, least_cosine: numbers.next() },
            2 => Kind::Disk { normal, radius, two_sided },
            _ => Kind::Ball { radius },
        };
        Lamp { center: numbers.vector() * place, intensity: numbers.share() + 1e-3, kind }
    }

    fn emitter(&self) -> Emitter {
        let Lamp { center, intensity, kind } = *self;
        match kind {
            Kind::Point => Emitter::point(center, intensity),
            Kind::Cone { axis, least_cosine } => Emitter::cone(center, intensity, axis, least_cosine),
            Kind::Disk { normal, radius, two_sided } => {
                let area = radius * radius * 3.0;
                Emitter::surface((center, radius), (intensity, area), normal, (true, two_sided))
            }
            Kind::Ball { radius } => {
                let area = radius * radius * 12.0;
                Emitter::surface((center, radius), (intensity, area), DVec3::ZERO, (false, false))
            }
        }
    }

    /// A point of it, and whether light leaves it in a direction.
    fn point(&self, numbers: &mut Numbers) -> (DVec3, Box<dyn Fn(DVec3) -> bool>) {
        let center = self.center;
        match self.kind {
            Kind::Point => (center, Box::new(|_| true)),
            Kind::Cone { axis, least_cosine } => (center, Box::new(move |d| d.dot(axis) > least_cosine)),
            Kind::Disk { normal, radius, two_sided } => {
                let [u, v] = [normal.any_orthonormal_vector(), normal.cross(normal.any_orthonormal_vector())];
                let (turn, far) = (numbers.next() * 3.2, radius * numbers.share());
                let p = center + (u * turn.cos() + v * turn.sin()) * far;
                (p, Box::new(move |d| two_sided && d.dot(normal) != 0.0 || d.dot(normal) > 0.0))
            }
            Kind::Ball { radius } => {
                let n = numbers.direction();
                (center + n * radius, Box::new(move |d| d.dot(n) > 0.0))
            }
        }
    }
}

impl Receiver {
    fn new(numbers: &mut Numbers, p: DVec3) -> Self {
        let n = numbers.direction();
        let ns = (n + numbers.vector() * 0.3).normalize();
        let [is_two_sided, is_diffuse] = [numbers.next() > 0.0, numbers.next() > 0.0];
        Receiver { p, n: n.as_vec3(), ns: ns.as_vec3(), is_two_sided, is_diffuse }
    }
}

fn tree(lamps: &[Lamp]) -> LightTree {
    LightTree::new(lamps.len(), lamps.iter().map(|lamp| Some(lamp.emitter())))
}

/// The probabilities of all leaves, and the leaves and probabilities that some numbers choose.
fn asked<S: Simd>(
    simd: S,
    tree: &LightTree,
    place: Receiver,
    numbers: &[f64],
) -> (Vec<f64>, Vec<(usize, f64)>) {
    let receivers =
        Receivers { surfaces: surfaces_at(simd, place.p), domain: place.domain(simd), lunes: None };
    let mut estimates = Vec::new();
    tree.estimates(simd, &receivers, |estimate| estimates.push(estimate[0]));
    let total: f64 = estimates.iter().sum();
    let probability = |leaf: usize| {
        let (entry, below) = tree.find(simd, &place, leaf).unwrap();
        if total > 0.0 { estimates[entry] * below / total } else { 0.0 }
    };
    let choose = |u: &f64| {
        let mut rest = u * total;
        let passed = estimates.iter().position(|estimate| {
            rest -= estimate;
            rest < 0.0
        });
        let entry = passed.unwrap();
        let mut step = tree.begin(entry, 1.0 + rest / estimates[entry]);
        while !step.is_done() {
            tree.descend(simd, &place, &mut step);
        }
        (step.leaf().unwrap(), step.probability * estimates[entry] / total)
    };
    let chosen = if total > 0.0 { numbers.iter().map(choose).collect() } else { Vec::new() };
    ((0..tree.places.len()).map(probability).collect(), chosen)
}

/// All that may light a point has a probability, and all of them together 1. Lamps of many sizes, and points between, inside and far away.
#[test]
fn all_lights_that_contribute_may_be_chosen() {
    let mut numbers = Numbers(0);
    let (mut lit, mut dark) = (0, 0);
    for count in [1, 2, 7, 8, 9, 30, 100, 700] {
        for (place, size) in [(1.0, 0.3), (1.0, 1e-6), (1e-3, 3.0), (1e6, 1.0), (0.0, 1.0)] {
            let lamps: Vec<Lamp> = (0..count).map(|_| Lamp::new(&mut numbers, (place, size))).collect();
            let tree = tree(&lamps);
            for _ in 0..60 {
                let near = lamps[numbers.of(count)].center;
                let p = match numbers.of(4) {
                    0 => near,
                    1 => near + numbers.vector() * size,
                    2 => numbers.vector() * place,
                    _ => numbers.vector() * (place + size) * 100.0,
                };
                let at = Receiver::new(&mut numbers, p);
                let (shares, _) = baseline!(simd => asked(simd, &tree, at, &[]));
                let sum: f64 = shares.iter().sum();
                assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-12, "{sum} {at:?}");
                for (lamp, share) in lamps.iter().zip(shares) {
                    let (q, shines) = lamp.point(&mut numbers);
                    let (n, way) = (at.n.as_dvec3(), q - p);
                    let is_seen = at.is_two_sided || way.dot(n) > 1e-6 * way.length();
                    if way != DVec3::ZERO && shines(-way.normalize()) && is_seen {
                        assert!(share > 0.0, "{lamp:?} {at:?}");
                        lit += 1;
                    } else {
                        dark += u32::from(share == 0.0);
                    }
                }
            }
        }
    }
    assert!(lit > 10_000 && dark > 10_000, "{lit} {dark}");
}

/// Of evenly spread numbers, a leaf gets the share that the tree gives as its probability afterwards.
#[test]
fn probabilities_are_those_of_choices() {
    const NUMBERS: usize = 1 << 14;
    let mut numbers = Numbers(1);
    for count in [1, 8, 40, 300] {
        let lamps: Vec<Lamp> = (0..count).map(|_| Lamp::new(&mut numbers, (1.0, 0.2))).collect();
        let tree = tree(&lamps);
        let even: Vec<f64> = (0..NUMBERS).map(|at| (at as f64 + 0.5) / NUMBERS as f64).collect();
        for _ in 0..10 {
            let p = numbers.vector();
            let at = Receiver::new(&mut numbers, p);
            let (said, chosen) = baseline!(simd => asked(simd, &tree, at, &even));
            let mut found = vec![0.0; count];
            for (leaf, probability) in chosen {
                assert!((probability / said[leaf] - 1.0).abs() < 1e-12);
                found[leaf] += 1.0 / NUMBERS as f64;
            }
            let most = found.iter().zip(&said).map(|(found, said)| (found - said).abs()).fold(0.0, f64::max);
            assert!(said.iter().sum::<f64>() == 0.0 || most < 2.0 / NUMBERS as f64, "{most}");
        }
    }
}

/// The same bits with any instructions.
#[test]
fn choices_are_the_same_at_every_level() {
    let mut numbers = Numbers(2);
    let lamps: Vec<Lamp> = (0..200).map(|_| Lamp::new(&mut numbers, (1.0, 0.2))).collect();
    let tree = tree(&lamps);
    let us: Vec<f64> = (0..64).map(|_| numbers.share()).collect();
    for _ in 0..50 {
        let p = numbers.vector();
        let at = Receiver::new(&mut numbers, p);
        let all = levels().into_iter().map(|level| side_by_side!(level, simd => asked(simd, &tree, at, &us)));
        let all: Vec<_> = all.collect();
        assert!(all.windows(2).all(|pair| pair[0] == pair[1]), "{at:?}");
    }
}

/// A lamp of 1e-9 among lamps of 1e8: it may be chosen, and takes nothing from the others where it adds little.
#[test]
fn sizes_may_differ_by_any_factor() {
    let disk = |center: DVec3, radius: f64| Lamp {
        center,
        intensity: 1.0,
        kind: Kind::Disk { normal: -DVec3::Y, radius, two_sided: false },
    };
    let small = DVec3::new(0.3, 1e-9, 0.2);
    let lamps: Vec<Lamp> = (0..40).map(|i| disk(DVec3::new(f64::from(i), 5e9, 0.0), 1e9 / 7.0)).collect();
    let lamps = [&[disk(small, 1e-9)], &lamps[..]].concat();
    let tree = tree(&lamps);
    let n = Vec3::Y;
    let share = |p: DVec3| {
        let at = Receiver { p, n, ns: n, is_two_sided: false, is_diffuse: true };
        baseline!(simd => asked(simd, &tree, at, &[])).0[0]
    };
    // Below it, beside it, and far away.
    let shares = [0.3, 1.0, 1e9].map(|x| share(DVec3::new(x, 0.0, 0.2)));
    assert!(shares.iter().all(|share| *share > 0.0 && *share < 1e-3), "{shares:?}");
}

/// A million lamps that are alike, at one place and on a lattice: no share is lost, and the tree is not deep.
#[test]
fn a_million_lamps_that_are_alike() {
    let lattice = |i: usize| DVec3::new((i % 100) as f64, (i / 100 % 100) as f64, (i / 10_000) as f64);
    for is_lattice in [false, true] {
        let lamps = (0..1_000_000).map(|i| if is_lattice { lattice(i) } else { DVec3::ONE });
        let tree = LightTree::new(1_000_000, lamps.map(|center| Some(Emitter::point(center, 1.0))));
        let depth = |leaf: usize| {
            let parent =
                |place: &u32| Some(tree.nodes[*place as usize / WIDTH].parent).filter(|place| *place != NONE);
            std::iter::successors(Some(tree.places[leaf]), parent).count()
        };
        let far = DVec3::new(-1e6, 2e6, 3e6);
        let at = Receiver { p: far, n: Vec3::NEG_Y, ns: Vec3::NEG_Y, is_two_sided: true, is_diffuse: false };
        let (mut least, mut most) = (f64::MAX, 0.0_f64);
        let (shares, _) = baseline!(simd => asked(simd, &tree, at, &[]));
        for leaf in (0..1_000_000).step_by(97) {
            assert!(depth(leaf) <= 20, "{}", depth(leaf));
            (least, most) = (least.min(shares[leaf] * 1e6), most.max(shares[leaf] * 1e6));
        }
        assert!(least > 0.99 && most < 1.01, "{least} {most}");
    }
}

/// The place of a scene and its size change no choice, but for rounding.
#[test]
fn choices_do_not_depend_on_place_and_size() {
    let mut numbers = Numbers(3);
    let lamps: Vec<Lamp> = (0..100).map(|_| Lamp::new(&mut numbers, (1.0, 0.2))).collect();
    let p = numbers.vector();
    let at = Receiver::new(&mut numbers, p);

    let (expected, _) = baseline!(simd => asked(simd, &tree(&lamps), at, &[]));
    for (scale, offset) in [(1e-6, DVec3::ZERO), (1e6, DVec3::ONE * 7e6), (1.0, DVec3::new(1e3, -2e3, 5.0))] {
        let moved = |p: DVec3| p * scale + offset;
        let place = |lamp: &Lamp| Lamp {
            center: moved(lamp.center),
            intensity: match lamp.kind {
                Kind::Point | Kind::Cone { .. } => lamp.intensity * scale * scale,
                Kind::Disk { .. } | Kind::Ball { .. } => lamp.intensity,
            },
            kind: match lamp.kind {
                Kind::Disk { normal, radius, two_sided } => {
                    Kind::Disk { normal, radius: radius * scale, two_sided }
                }
                Kind::Ball { radius } => Kind::Ball { radius: radius * scale },
                Kind::Cone { axis, least_cosine } => Kind::Cone { axis, least_cosine },
                Kind::Point => Kind::Point,
            },
        };
        let lamps: Vec<Lamp> = lamps.iter().map(place).collect();
        let at = Receiver { p: moved(at.p), ..at };
        let (found, _) = baseline!(simd => asked(simd, &tree(&lamps), at, &[]));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-3, "{scale} {offset}: {found} {expected}");
        }
    }
}
