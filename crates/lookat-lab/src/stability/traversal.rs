//! Trees, secondary rays, samples and whole pictures: V1 to V15.

mod adaptive;
mod boxes;
mod brute_force;
mod crowds;
mod gaps;
mod lens;
mod offsets;
mod pictures;
mod samples;
mod shadows;

use super::case::{Axis, Case, Effort, Family, Found};

pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, error, limit, run: fn(&Effort) -> Found| Case {
        id,
        name,
        family: Family::Traversal,
        claim,
        axis,
        error,
        limit,
        run,
    };
    let offset = "offset of the origin / largest of coordinates and size";
    let beyond = "share of pixels beyond the target, 99 % bound of the worst stratum";
    vec![
        case(
            "V1",
            "box-faces",
            "no ray in the plane of a box loses its hit",
            Axis::None,
            "",
            0.0,
            boxes::faces,
        ),
        case(
            "V2",
            "brute-force",
            "a BVH gives the same element and distance, to the bit, as testing every element",
            Axis::None,
            "",
            0.0,
            brute_force::agreement,
        ),
        case(
            "V3",
            "one-place",
            "a BVH of elements at one place is built and correct",
            Axis::None,
            "",
            0.0,
            crowds::one_place,
        ),
        case("V4", "giant", "one huge element does not hide small ones", Axis::None, "", 0.0, crowds::giant),
        case(
            "V5",
            "acne",
            "a ray that leaves a convex body outward hits nothing, and inward the other side",
            Axis::Of("size"),
            offset,
            offsets::LIMIT,
            offsets::by_size,
        ),
        case(
            "V5b",
            "acne-far",
            "the same for a body far from the origin of the world",
            Axis::Of("distance from the origin / size"),
            offset,
            offsets::LIMIT,
            offsets::by_distance,
        ),
        case(
            "V6",
            "thin-gap",
            "a ray that leaves a surface hits the next one at any distance",
            Axis::Of("gap / size"),
            "",
            0.0,
            gaps::thin,
        ),
        case(
            "V7",
            "blocked-light",
            "a shape close to a light blocks it, and a shape in its plane does not",
            Axis::Of("gap / distance of the light"),
            "relative error of the light that arrives",
            1e-3,
            shadows::close_to_light,
        ),
        case(
            "V8",
            "lens-edge",
            "an edge out of focus converges as fast as four well distributed dimensions allow",
            Axis::None,
            "slope of the error over samples, log-log",
            -0.6,
            samples::slopes,
        ),
        case(
            "V9",
            "thousand",
            "error of 1000 samples relative to 1024 samples; a measurement without a limit",
            Axis::None,
            "RMSE of 1000 samples / RMSE of 1024",
            f64::INFINITY,
            samples::thousand,
        ),
        case(
            "V10",
            "neighbors",
            "errors of neighboring pixels are uncorrelated",
            Axis::None,
            "correlation of errors",
            0.05,
            samples::neighbors,
        ),
        case(
            "V11",
            "few-first-samples",
            "with a target error, pixels at sharp edges reach it at any brightness",
            Axis::None,
            beyond,
            adaptive::LIMIT,
            adaptive::sharp,
        ),
        case(
            "V12",
            "half-buffers",
            "the same at edges out of focus",
            Axis::None,
            beyond,
            adaptive::LIMIT,
            adaptive::out_of_focus,
        ),
        case(
            "V13",
            "fireflies",
            "rare light that a target error cannot cover is reported, and edges are not mistaken for it",
            Axis::None,
            "",
            0.0,
            adaptive::rare,
        ),
        case(
            "V14",
            "edge-pictures",
            "a picture without pixels or samples is an error with a place; any other picture is finite",
            Axis::None,
            "",
            0.0,
            pictures::degenerate,
        ),
        case(
            "V15",
            "threads",
            "1, 2 and 7 threads give the same bits",
            Axis::None,
            "",
            0.0,
            pictures::threads,
        ),
    ]
}
