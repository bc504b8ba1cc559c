//! The answers of other methods, measured once: see the head of `others.tsv`.

use super::case::{Found, LOOKAT, Row};

const TABLE: &str = include_str!("others.tsv");

/// Adds the rows and remarks of other methods to a case. In each place they follow the row of lookat.
pub(super) fn added(case: &str, mut found: Found) -> Found {
    let (own, parts) = found.rows.into_iter().partition(|row| row.method == LOOKAT);
    found.rows = own;
    for line in TABLE.lines() {
        let mut fields = line.split('\t');
        if fields.next() != Some(case) {
            continue;
        }
        let method = fields.next().unwrap_or_default();
        match method {
            "remark" => found.remarks.extend(fields.map(String::from)),
            _ => found.rows.extend(fields.filter_map(|cell| row(method, cell))),
        }
    }
    found.rows.extend::<Vec<Row>>(parts);
    let places = found.places();
    found.rows.sort_by_key(|row| places.iter().position(|at| *at == row.at));
    found
}

/// A cell: place, wrong/tried, largest error.
fn row(method: &'static str, cell: &str) -> Option<Row> {
    let [at, counts, worst] = cell.split(' ').collect::<Vec<_>>()[..] else { return None };
    let (failed, tried) = counts.split_once('/')?;
    let number = |text: &str| if text == "-" { Some(None) } else { text.parse().ok().map(Some) };
    Some(Row {
        method,
        at: number(at)?,
        tried: tried.parse().ok()?,
        failed: failed.parse().ok()?,
        worst: number(worst)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_a_row_of_a_case() {
        let ids: Vec<&str> = super::super::cases().iter().map(|case| case.id).collect();
        for line in TABLE.lines().filter(|line| !line.starts_with('#')) {
            let fields: Vec<&str> = line.split('\t').collect();
            assert!(ids.contains(&fields[0]) && fields.len() > 2, "{line}");
            if fields[1] != "remark" {
                let rows: Vec<Row> = fields[2..].iter().map(|cell| row("", cell).expect(cell)).collect();
                assert!(rows.iter().all(|row| row.failed <= row.tried && row.tried > 0), "{line}");
            }
        }
    }

    #[test]
    fn rows_are_sorted_by_place_and_own_parts_come_last() {
        let mut found = Found::default();
        for at in [1.0, 100.0] {
            for method in ["lookat", "lookat, instances"] {
                found.add(method, Some(at), Default::default());
            }
        }
        let found = added("T1", found);
        let methods = found.methods();
        assert_eq!((methods[0], methods[11]), ("lookat", "lookat, instances"));
        assert!(found.rows[..12].iter().all(|row| row.at == Some(1.0)));
        let woop = |row: &&Row| row.method == "Woop f32" && row.at == Some(1e8);
        assert_eq!(found.rows.iter().find(woop).map(|row| row.failed == row.tried), Some(true));
    }
}
