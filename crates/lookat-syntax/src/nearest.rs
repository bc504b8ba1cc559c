//! Finds the known name nearest to a misspelled one.

/// The name in `known` nearest to `name`, by the optimal string alignment distance without case. `None` if more than a
/// third of its letters are changed, missing, added or swapped with a neighbor.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let (lower, letters) = (name.to_lowercase(), name.chars().count());
    let slips = |candidate: &str| candidate.chars().count().max(2) / 3;
    known
        .into_iter()
        .filter(|candidate| *candidate != name && !candidate.is_empty())
        .filter(|candidate| candidate.chars().count().abs_diff(letters) <= slips(candidate))
        .map(|candidate| (distance(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(edits, candidate)| *edits <= slips(candidate))
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// The only name in `known` that starts with `name`, without case. `None` if several names do, or if `name` has fewer
/// than three letters.
pub fn begun<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const FEWEST: usize = 3;
    let begins = |candidate: &&str| {
        candidate.len() > name.len()
            && candidate.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name))
    };
    let mut longer = known.into_iter().filter(begins);
    longer.next().filter(|_| name.chars().count() >= FEWEST && longer.next().is_none())
}

/// The optimal string alignment distance: edits and swaps of neighbors. Compares at most 64 characters.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i + j;
                continue;
            }
            let change = usize::from(a[i - 1] != b[j - 1]);
            let mut best = (rows[i - 1][j] + 1).min(rows[i][j - 1] + 1).min(rows[i - 1][j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

/// True if two names have the same digits in the same order. `wood1` is not a misspelling of `wood2`.
pub fn same_digits(a: &str, b: &str) -> bool {
    let digits = |name: &str| name.bytes().filter(u8::is_ascii_digit).collect::<Vec<u8>>();
    digits(a) == digits(b)
}

#[cfg(test)]
mod tests {
    use super::{begun, nearest};

    #[test]
    fn finds_slips_and_refuses_strangers() {
        let known = ["sphere", "trianglemesh", "plymesh", "disk", "cone"];
        let check = |name, expected| assert_eq!(nearest(name, known), expected, "{name}");
        check("sphrere", Some("sphere"));
        check("Sphere", Some("sphere"));
        check("triangelmesh", Some("trianglemesh"));
        check("plymehs", Some("plymesh"));
        check("dsik", Some("disk"));
        check("teapot", None);
        check("", None);
    }

    #[test]
    fn finds_the_only_name_that_is_begun() {
        let known = ["perspective", "orthographic", "orbit", "environment"];
        let check = |name, expected| assert_eq!(begun(name, known), expected, "{name}");
        check("persp", Some("perspective"));
        check("Ortho", Some("orthographic"));
        check("or", None);
        check("orb", Some("orbit"));
        check("pe", None);
        check("environment", None);
        check("\u{e9}\u{e9}\u{e9}", None);
        assert_eq!(begun("ort", ["orthographic", "ortho"]), None);
    }
}
