//! Finds the directive at a place.

use crate::grammar::parse_from;
use crate::{Span, Statement};

/// How many bytes are read on each side of the place; more only for a long directive.
const REACHES: [usize; 4] = [1 << 12, 1 << 16, 1 << 20, u32::MAX as usize];

/// The directive at a place of a text. Reads the lines around it alone. `None` where there is none, and for one that
/// cannot be read in full.
pub fn statement_at(text: &[u8], at: Span) -> Option<Statement> {
    REACHES.iter().find_map(|reach| {
        let before = text.get(..(at.start as usize).saturating_sub(*reach))?;
        // No comment goes on in another line.
        let start = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let end = (at.end as usize).saturating_add(*reach).min(text.len());
        let statements = parse_from(at.file, &text[..end], start).statements;
        let holds = |found: &Statement| found.span.start <= at.start && at.end <= found.span.end;
        let number = statements.iter().position(holds)?;
        // The last one may go on behind the end.
        let is_whole = number + 1 < statements.len() || end == text.len();
        statements.into_iter().nth(number).filter(|found| is_whole && !found.faulty)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FileId, parse};

    #[test]
    fn a_part_of_the_text_gives_the_same_directives_as_all_of_it() {
        let numbers = "0.25 1 ".repeat(3000);
        let mesh = format!("Shape \"trianglemesh\" \"point P\" [ {numbers}\n{numbers} ]");
        let text = format!(
            "\u{feff}LookAt 0 0 1 0 0 0 0 1 0 # Material \"no\n{mesh}\n\
             Material \"matte\" # plain\n  \"rgb Kd\" [1 0 0] {mesh} Shape \"sphere\"\n\
             MakeNamedMaterial \"a\" \"string type\" \"glass\" {}LightSource \"point\"",
            "# more\n".repeat(100_000),
        );
        let parsed = parse(FileId(3), text.as_bytes());
        assert!(parsed.diagnostics.is_empty() && parsed.statements.len() == 7);
        for statement in &parsed.statements {
            for at in [statement.keyword, statement.span] {
                let found = statement_at(text.as_bytes(), at).unwrap();
                assert_eq!((&found, found.span), (statement, statement.span));
            }
        }
        let comment = text.find("Material \"no").unwrap() as u32;
        assert_eq!(
            statement_at(text.as_bytes(), Span { file: FileId(3), start: comment, end: comment + 1 }),
            None
        );
        let faulty = b"Material \"matte\" \"rgb Kd\" [1 0 LightSource \"point\"";
        assert_eq!(statement_at(faulty, Span { file: FileId(0), start: 0, end: 4 }), None);
        assert_eq!(statement_at(b"", Span { file: FileId(0), start: 7, end: 9 }), None);
    }
}
