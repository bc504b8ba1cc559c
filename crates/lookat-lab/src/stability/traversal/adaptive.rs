//! Pixels that are sampled until they are exact: V11 to V13.

use lookat_render::TargetError;

use crate::coverage::{Known, STRATA, Stratum, edges, fireflies, judge};
use crate::stability::prelude::*;

/// What is asked for. Ten thousand pixels take some seconds.
const TARGET: TargetError = TargetError { relative: 0.1, confidence: 0.95 };

/// Pixels on a side.
const SIDE: u32 = 100;

/// Stratum by stratum.
pub(super) fn against(known: fn(u32) -> Known) -> Found {
    let (pixels, _) = judge(&known(SIDE), TARGET, 0);
    // The pixels that an edge cuts.
    let strata = STRATA.map(|[from, to]| Stratum::count(&pixels, |p| p.value > from && p.value < to));
    let strata = || strata.iter().filter(|stratum| stratum.promised() > 0);
    let worst = strata().map(|stratum| 1.0 - stratum.coverage()[1]).fold(0.0, f64::max);
    let shares: Vec<String> = strata().map(|stratum| format!("{:.3}", stratum.coverage()[0])).collect();
    let samples = pixels.iter().map(|pixel| f64::from(pixel.samples)).sum::<f64>() / pixels.len() as f64;
    let capped = strata().map(|stratum| stratum.at_cap).sum::<u64>();
    let remark = format!(
        "{LOOKAT}: shares within the target, from dark to bright, {}; {capped} pixels at the cap; {samples:.0} samples on average",
        shares.join(", ")
    );
    let tried = strata().map(Stratum::promised).sum();
    Found { remarks: vec![remark], ..Found::own(None, Tally { tried, failed: 0, worst: Some(worst) }) }
}

pub(super) fn rare(_: &Effort) -> Found {
    let mut found = Found::default();
    // So small that a pixel that has missed the bright samples is beyond it.
    let target = TargetError { relative: 0.05, ..TARGET };
    let (pixels, reached) = judge(&fireflies(40), target, 0);
    found.check(reached.outliers > 0, || "a thousandth of very bright samples is not told of".into());
    let stratum = Stratum::count(&pixels, |_| true);
    found.remarks.push(format!(
        "{:.3} of the pixels are within the target, which is not promised: {} of {} have outliers",
        stratum.coverage()[0],
        reached.outliers,
        stratum.pixels
    ));
    let (_, reached) = judge(&edges(40), TARGET, 0);
    found.check(reached.outliers == 0, || format!("{} pixels at edges count as outliers", reached.outliers));
    found
}
