//! The Pareto front: the least error that anything reaches within each time.

use super::equal::Curve;

/// Times that are looked at, from the first to the last: to about 1 % over five decades.
const TIMES: u32 = 1000;

/// A method or another renderer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry<'a> {
    pub curve: &'a Curve,
    /// Half a 95 % interval of the logarithm of its errors.
    pub of_errors: f64,
    /// The same of its times.
    pub of_times: f64,
}

impl Entry<'_> {
    /// The least error within so many seconds; infinite before the first.
    fn reached(&self, seconds: f64) -> f64 {
        self.curve.reached(seconds).unwrap_or(f64::INFINITY)
    }

    /// Half a 95 % interval of the logarithm of that. An interval of time is one of error as the curve has it: from what is
    /// reached so much earlier to what is reached so much later.
    fn uncertainty(&self, seconds: f64) -> f64 {
        let now = self.reached(seconds);
        let (early, late) = (seconds / self.of_times.exp(), seconds * self.of_times.exp());
        let half = match self.curve.reached(early) {
            Some(before) => 0.5 * (before / self.reached(late)).ln(),
            None if now.is_finite() => (now / self.reached(late)).ln(),
            None => 0.0,
        };
        self.of_errors.hypot(half)
    }
}

/// A stretch of time in which one of them is on the front.
#[derive(Debug, Clone, PartialEq)]
pub struct Reign {
    /// The method or, counting on, the other renderer.
    pub who: usize,
    /// The least error of all meanwhile: seconds and error where the line bends, the first and the last.
    pub points: Vec<(f64, f64)>,
    /// When another takes over, in seconds; `None` for the last one.
    pub until: Option<f64>,
    /// Who else is as good by the end of it, within uncertainty.
    pub ties: Vec<usize>,
}

/// Who reaches the least error, by time. Another takes over only where it is better by more than the uncertainty of both; so
/// each stretch is of several who are as good, and goes by the name of the one that is the best for most of it. Someone who
/// stops early keeps the error that was reached.
pub(super) fn front(entries: &[Entry]) -> Vec<Reign> {
    let mut front: Vec<(Reign, Vec<u32>)> = Vec::new();
    for seconds in times(entries) {
        let reached = |who: usize| entries[who].reached(seconds);
        let Some(best) = (0..entries.len()).min_by(|a, b| reached(*a).total_cmp(&reached(*b))) else { break };
        let is_worse = |who: usize, than: usize| {
            let uncertainty = entries[who].uncertainty(seconds).hypot(entries[than].uncertainty(seconds));
            who != than && (reached(who) / reached(than)).ln() > uncertainty
        };
        if front.last().is_none_or(|(last, _)| is_worse(last.who, best)) {
            let reign = Reign { who: best, points: Vec::new(), until: None, ties: Vec::new() };
            front.push((reign, vec![0; entries.len()]));
        }
        let Some((last, best_at)) = front.last_mut() else { break };
        last.points.push((seconds, reached(best)));
        best_at[best] += 1;
        let who = last.who;
        last.ties = (0..entries.len()).filter(|other| *other != who && !is_worse(*other, who)).collect();
    }
    joined(front.into_iter().map(|(reign, best_at)| reign.named(&best_at)))
}

/// Makes one of stretches that have the same name.
fn joined(reigns: impl Iterator<Item = Reign>) -> Vec<Reign> {
    let mut front: Vec<Reign> = Vec::new();
    for mut reign in reigns {
        match front.last_mut().filter(|last| last.who == reign.who) {
            Some(last) => {
                last.points.append(&mut reign.points);
                last.ties = reign.ties;
            }
            None => front.push(reign),
        }
    }
    let mut until = None;
    for reign in front.iter_mut().rev() {
        reign.points = bends(&reign.points);
        reign.until = until.replace(reign.points[0].0);
    }
    front
}

impl Reign {
    /// Under the name of the one that is the best at most of the times.
    fn named(mut self, best_at: &[u32]) -> Reign {
        let most = best_at.iter().max();
        let is_first = |who: usize| Some(&best_at[who]) == most;
        if !is_first(self.who)
            && let Some(tie) = self.ties.iter_mut().find(|tie| is_first(**tie))
        {
            std::mem::swap(&mut self.who, tie);
            self.ties.sort_unstable();
        }
        self
    }
}

/// Evenly on a logarithmic scale, and all points of the curves.
fn times(entries: &[Entry]) -> Vec<f64> {
    let own = entries.iter().flat_map(|entry| entry.curve.0.iter().map(|point| point.0));
    let mut times: Vec<f64> = own.collect();
    times.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (times.first().copied(), times.last().copied()) else { return times };
    let share = |i: u32| f64::from(i) / f64::from(TIMES);
    times.extend((1..TIMES).map(|i| first * (last / first).powf(share(i))));
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// The points of a line, straight on logarithmic axes, without those that it does not need.
fn bends(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (i, point) in points.iter().enumerate() {
        let (Some(from), Some(to)) = (kept.last(), points.get(i + 1)) else {
            kept.push(*point);
            continue;
        };
        let share = (point.0 / from.0).ln() / (to.0 / from.0).ln();
        let straight = (from.1.ln() + share * (to.1 / from.1).ln()).exp();
        if (point.1 / straight - 1.0).abs() > 1e-9 {
            kept.push(*point);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// error = a seconds^slope at 1, 2, 4, ... times `start`.
    fn power(a: f64, slope: f64, start: f64) -> Curve {
        let seconds = (0..6).map(|i| start * 2.0_f64.powi(i));
        Curve(seconds.map(|seconds| (seconds, a * seconds.powf(slope))).collect())
    }

    fn found(curves: &[Curve], of_errors: f64) -> Vec<Reign> {
        uncertain(curves, of_errors, 0.0)
    }

    fn uncertain(curves: &[Curve], of_errors: f64, of_times: f64) -> Vec<Reign> {
        let entry = |curve| Entry { curve, of_errors, of_times };
        front(&curves.iter().map(entry).collect::<Vec<_>>())
    }

    #[test]
    fn the_front_changes_hands_where_lines_cross() {
        // t^-1/2 and 2 t^-1 cross at 4 s.
        let curves = [power(1.0, -0.5, 1.0), power(2.0, -1.0, 1.0), power(3.0, -0.5, 1.0)];
        let front = found(&curves, 0.0);
        assert_eq!(front.iter().map(|reign| reign.who).collect::<Vec<_>>(), [0, 1]);
        let until = front[0].until.unwrap();
        assert!((4.0..4.05).contains(&until), "{until}");
        assert_eq!(front[1].points.last(), Some(&(32.0, 2.0 / 32.0)));
        // Straight lines have no bends, up to rounding.
        assert_eq!([front[0].points.len(), front[1].points.len(), front[1].points.len()], [2; 3]);
        assert!(front.iter().all(|reign| reign.ties.is_empty()), "{front:?}");
        // With 10 % of uncertainty each, the second must be better by 1 / exp(0.1414): from 4 exp(0.2828) s on.
        let late = found(&curves, 0.1)[0].until.unwrap();
        assert!((late / (4.0 * (2.0 * 0.02_f64.sqrt()).exp()) - 1.0).abs() < 0.01, "{late}");
    }

    #[test]
    fn uncertain_times_count_by_the_slope() {
        // t^-1/2 and 2 t^-1: 10 % of time are 5 % of the error of the first, 10 % of that of the second.
        let curves = [power(1.0, -0.5, 1.0), power(2.0, -1.0, 1.0)];
        let until = |of_errors, of_times| uncertain(&curves, of_errors, of_times)[0].until.unwrap();
        let expected = |uncertainty: f64| 4.0 * (2.0 * uncertainty).exp();
        let close = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}")
        };
        close(until(0.0, 0.1), expected(0.05_f64.hypot(0.1)));
        close(until(0.1, 0.1), expected(0.05_f64.hypot(0.1).hypot(0.02_f64.sqrt())));
        // Where a line is flat, times do not matter; before its first point there is nothing to compare.
        let flat = [Curve(vec![(1.0, 1.0), (32.0, 1.0)]), Curve(vec![(8.0, 0.9), (32.0, 0.9)])];
        close(uncertain(&flat, 0.0, 1.0)[0].until.unwrap(), 8.0);
    }

    #[test]
    fn a_stretch_has_the_name_of_the_one_that_is_best_for_most_of_it() {
        // The first begins earlier; the second is soon better, but by no more than the uncertainty of both.
        let curves = [power(1.0, -0.5, 0.9), power(0.97, -0.5, 1.0)];
        let found = found(&curves, 0.1);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].who, found[0].ties.as_slice()), (1, [0].as_slice()));
        // What is drawn is the least of both.
        assert_eq!(found[0].points[0], (0.9, 0.9_f64.powf(-0.5)));
        assert_eq!(found[0].points.last(), Some(&(32.0, 0.97 * 32.0_f64.powf(-0.5))));
    }

    #[test]
    fn single_points_count_from_their_time_on() {
        let point = |seconds, error| Curve(vec![(seconds, error)]);
        // 0.5 is worse than the line at 16 s, 0.2 is better, and 0.2 later is too late.
        let front =
            found(&[power(1.0, -0.5, 1.0), point(16.0, 0.5), point(16.0, 0.2), point(20.0, 0.2)], 0.0);
        let who: Vec<_> = front.iter().map(|reign| (reign.who, reign.until)).collect();
        assert_eq!(who[0], (0, Some(16.0)));
        // 1 / sqrt(t) is 0.2 at 25 s.
        assert!(who[1].0 == 2 && (25.0..25.2).contains(&who[1].1.unwrap()), "{who:?}");
        assert_eq!(who[2], (0, None));
        assert_eq!(found(&[], 0.0), []);
        assert_eq!(
            found(&[point(1.0, 0.5)], 0.0),
            [Reign { who: 0, points: vec![(1.0, 0.5)], until: None, ties: Vec::new() }]
        );
    }

    #[test]
    fn ties_are_named() {
        let curves = [power(1.0, -0.5, 1.0), power(1.05, -0.5, 1.0), power(1.5, -0.5, 1.0)];
        let front = found(&curves, 0.05);
        assert_eq!((front.len(), front[0].who, front[0].ties.as_slice()), (1, 0, [1].as_slice()));
    }

    #[test]
    fn what_was_reached_is_kept() {
        let stops = Curve(vec![(1.0, 0.5), (2.0, 0.1), (4.0, 0.3)]);
        let front = found(&[stops, power(1.0, -0.5, 1.0)], 0.0);
        assert_eq!(front.len(), 1);
        assert_eq!(front[0].points.last(), Some(&(32.0, 0.1)));
    }
}
