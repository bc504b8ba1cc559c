//! Boundaries of media that are the wrong way round.

use std::collections::BTreeMap;

use lookat_render::{Prepared, Ray, ShapeId, Surface};
use lookat_scene::MaterialKind;
use lookat_scene::syntax::{Diagnostic, Span};

use crate::Sight;

/// The least share of the picture in which a boundary that is the wrong way round counts.
const LEAST: f64 = 0.01;

/// A boundary that camera rays come to through another medium than the one on its side.
#[derive(Clone)]
pub struct WrongSide {
    span: Option<Span>,
    /// The share of the picture.
    share: f64,
}

impl WrongSide {
    /// The boundary that most of the camera rays come to first on a wrong side, of those that all of them do. `rays`: what each camera ray
    /// passes through, with the ray that hits it.
    pub fn find<'p, R: Iterator<Item = (Ray, Surface<'p>)>>(
        prepared: &Prepared,
        rays: impl ExactSizeIterator<Item = R>,
    ) -> Option<WrongSide> {
        let world = prepared.world();
        if world.media.is_empty() {
            return None;
        }
        // By boundary: the rays that come to it first, and those of them that do on a wrong side.
        let mut counts: BTreeMap<ShapeId, [usize; 2]> = BTreeMap::new();
        let all_rays = rays.len();
        for surfaces in rays {
            // Up to a surface that may hide what is behind it.
            let mut is_hidden = false;
            let mut surfaces = surfaces.take_while(|(_, surface)| {
                let is_shown = !is_hidden;
                is_hidden = !matches!(surface.primitive.material.kind(), MaterialKind::None);
                is_shown
            });
            let first = surfaces.find_map(|(ray, surface)| {
                let Surface { n, element, primitive, .. } = surface;
                let sides = primitive.medium?;
                let own = if n.dot(ray.d) < 0.0 { sides.outside } else { sides.inside };
                Some((element.shape(), own != world.camera_medium))
            });
            if let Some((shape, is_wrong)) = first {
                let [all, wrong] = counts.entry(shape).or_default();
                (*all, *wrong) = (*all + 1, *wrong + usize::from(is_wrong));
            }
        }
        let always = counts.into_iter().filter(|(_, [all, wrong])| all == wrong);
        let (shape, [count, _]) = always.max_by_key(|(_, [count, _])| *count)?;
        let share = count as f64 / all_rays as f64;
        Some(WrongSide { span: prepared.primitive(shape).span, share }).filter(|it| it.share >= LEAST)
    }
}

/// A boundary with the wrong side towards the camera.
pub fn wrong_side(sight: &Sight) -> Option<Diagnostic> {
    let WrongSide { span, .. } = sight.facts.wrong_side.as_ref()?;
    let world = &sight.scene.world;
    let own = world.camera_medium.and_then(|it| world.media.get(it as usize)?.name.as_deref());
    let message = match (world.camera_medium, own) {
        (None, _) => "this shape has a medium on the side of the camera, which is in empty space".into(),
        (Some(_), None) => {
            "this shape has another medium on the side of the camera than the camera is in".into()
        }
        (Some(_), Some(name)) => {
            format!(
                "this shape has another medium on the side of the camera than the camera is in: it is in \"{}\"",
                name
            )
        }
    };
    let help = "exchange the media of its MediumInterface, or turn it over with ReverseOrientation; or give the camera the medium, by \
                MediumInterface before Camera";
    Some(
        Diagnostic::warning((*span)?, message)
            .note("inside and outside are the sides of the normal's back and front")
            .help(help),
    )
}
